//! Stand-ins until the loaders are here.

use super::{Scene, Shading};
use crate::error::{Error, Result};

/// What the command line overrides.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Pixels.
    pub size: Option<[u32; 2]>,
    /// Opacity of every material.
    pub alpha: Option<f32>,
    /// Shading of every material.
    pub shading: Option<Shading>,
}

/// A procedural scene.
#[derive(Debug)]
pub struct Builtin {
    /// Its name.
    pub name: &'static str,
    /// One line.
    pub description: &'static str,
    /// Its parameters.
    pub keys: &'static [Key],
}

/// A parameter of a procedural scene.
#[derive(Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Its default.
    pub default: &'static str,
    /// One line.
    pub help: &'static str,
}

/// The procedural scenes.
#[must_use]
pub fn builtin() -> &'static [Builtin] {
    const COUNT: Key = Key { name: "count", default: "8", help: "layers" };
    &[Builtin { name: "layers", description: "full-screen layers", keys: &[COUNT] }]
}

/// Load a scene.
///
/// # Errors
/// Always.
pub fn load(source: &str, overrides: &Overrides) -> Result<Scene> {
    let _ = overrides;
    Err(Error::new(source, "not here yet"))
}
