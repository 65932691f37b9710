//! What a file's name says of its format.

use std::path::Path;

/// A format of files that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0, as JSON or GLB.
    Gltf,
    /// A mesh or a point set.
    Ply,
    /// Binary or text.
    Stl,
    /// A point set.
    Pcd,
    /// A scene file.
    Toml,
    /// An archive with one model.
    Zip,
}

impl FileFormat {
    const ENDINGS: [(&'static str, Self); 8] = [
        ("obj", Self::Obj),
        ("gltf", Self::Gltf),
        ("glb", Self::Gltf),
        ("ply", Self::Ply),
        ("stl", Self::Stl),
        ("pcd", Self::Pcd),
        ("toml", Self::Toml),
        ("zip", Self::Zip),
    ];

    /// By the ending of a file's name; of a compressed file, the one before `.gz`.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let own = match ending(path)? {
            packed if packed == "gz" => ending(&path.with_extension(""))?,
            own => own,
        };
        Self::ENDINGS.iter().find(|(known, _)| *known == own).map(|(_, format)| *format)
    }

    /// It has meshes or points, and no camera of its own.
    pub(in crate::scene) fn is_model(self) -> bool {
        self != Self::Toml
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_are_formats() {
        let of = |name: &str| FileFormat::of(Path::new(name));
        assert_eq!([of("a.obj"), of("b/c.GLB")], [Some(FileFormat::Obj), Some(FileFormat::Gltf)]);
        assert_eq!(
            [of("a.ply.gz"), of("a.gz.stl")],
            [Some(FileFormat::Ply), Some(FileFormat::Stl)]
        );
        for name in ["a", "a.gz", "obj", ".obj", "a.jpg", "a.obj.bz2", ""] {
            assert_eq!(of(name), None, "{name}");
        }
    }
}
