//! Scene files of the repository, inside the program.

use crate::error::{Error, Result};
use crate::scene::file::{self, Source};
use crate::scene::{Overrides, Scene, obj, procedural};

/// A scene file, with the meshes that it names.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bundled {
    /// Its name.
    pub(super) name: &'static str,
    /// Its text.
    pub(super) text: &'static str,
    /// Names and texts of OBJ files.
    pub(super) meshes: &'static [(&'static str, &'static str)],
}

macro_rules! bundled {
    ($name:literal $(, $mesh:literal)*) => {
        Bundled {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/", $name)),
            meshes: &[$(($mesh, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/", $mesh)))),*],
        }
    };
}
pub(super) use bundled;

impl Bundled {
    /// The scene, at a size in pixels.
    ///
    /// # Errors
    /// It names a file that is not bundled: a defect.
    pub(super) fn scene(self, size: [u32; 2]) -> Result<Scene> {
        let overrides = Overrides { size: Some(size), ..Overrides::default() };
        let missing = |path: &str| Error::new(self.name, format!("file: {path} is not bundled"));
        file::parse(self.text.as_bytes(), self.name)?.build(
            &overrides,
            &mut |source| match source {
                Source::Procedural { name, keys, size } => procedural::generate(name, keys, size),
                Source::File(path) | Source::Points { file: path, .. } => {
                    let mesh = self.meshes.iter().find(|(name, _)| *name == path);
                    let (_, text) = mesh.ok_or_else(|| missing(path))?;
                    obj::parse(text.as_bytes(), path, &mut |_| None)
                }
            },
            &mut |path| Err(missing(path)),
        )
    }
}
