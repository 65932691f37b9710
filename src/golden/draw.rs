//! Who draws, and what is asked of them.

use std::path::{Path, PathBuf};

use crate::error::Result;
use crate::image::Image;

/// A picture to draw.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// What paths in `scene` and `options` are relative to.
    pub folder: &'a Path,
    /// A file or a built-in scene.
    pub scene: &'a str,
    /// What follows the scene on the command line of `fragloom render`.
    pub options: &'a [String],
    /// Threads for a run whose result does not depend on them, if the options say nothing; 0 is one per core.
    pub threads: usize,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The picture.
    pub image: Image,
    /// Fragments of one geometry pass.
    pub generated: u64,
    /// Entries of the resolved lists.
    pub kept: u64,
    /// SHA-256 of what the pixels hold, hexadecimal; `None` where the method gives only colours.
    pub fragments_hash: Option<String>,
    /// The files that it was drawn from.
    pub files: Vec<PathBuf>,
    /// What was tolerated.
    pub warnings: Vec<String>,
    /// What the method promised and did not keep.
    pub violations: Vec<String>,
    /// Why the same may give something else the next time, if it may.
    pub unsteady: Option<String>,
}

/// Draws.
pub trait Draw: Sync {
    /// Draw it.
    ///
    /// # Errors
    /// Wrong options or scene, or a run that is refused.
    fn draw(&self, asked: &Asked<'_>) -> Result<Drawn>;
}
