//! Golden pictures: a manifest says what was drawn, from which files, and what came out; drawing it again must give the
//! same. What changed is told apart: the files that it was drawn from, the program, or, with both the same, what is drawn.
//!
//! Nothing here knows how a scene and its options become a picture: that is asked of [`Draw`], which
//! [`crate::cli::CommandLine`] answers for what stands in the manifests of `fragloom golden`.

mod crew;
mod draw;
mod manifest;
mod outcome;
mod partition;
mod record;
mod report;
mod save;
mod verify;

pub use draw::{Asked, Draw, Drawn};
pub use manifest::{Entry, Input, MANIFEST, Manifest, Results, relative};
pub use outcome::{Apart, Outcome, Status};
pub use partition::{Partition, share};
pub use record::{Plan, record};
pub use report::{Report, Shown, junit, merge, page, read, table};
pub use verify::{Settings, verify};

/// This program's version, as manifests and reports have it.
pub const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// How work is done, and who is told.
pub struct Work<'a> {
    /// Pictures drawn at once; 0 is one per core.
    pub jobs: usize,
    /// Asked before every picture: whether to stop.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Told after every picture.
    pub done: &'a dyn Fn(),
    /// Told of every picture that [`verify()`] finds to be another one, with its entry's name.
    pub shown: &'a (dyn Fn(&str, Shown) + Sync),
}

impl Work<'_> {
    /// All of it, one picture per core at once, and nobody is told.
    pub const SILENT: Work<'static> =
        Work { jobs: 0, cancelled: &|| false, done: &|| {}, shown: &|_, _| {} };
}
