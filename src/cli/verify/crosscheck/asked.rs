//! What a cross-check was asked for: scenes, sizes, and the settings that results depend on.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::Args;
use crate::cli::options::{settings, values};
use crate::cli::terminal::wait;
use crate::error::Result;
use crate::scene::{self, Overrides, Scene, Thickness};

/// Scenes that are compared if none is named.
const SCENES: [&str; 9] = [
    "synthetic:n=24",
    "synthetic:n=40,tessellation=9,density=80",
    "layers:count=12",
    "hairball:strands=300",
    "bottles",
    "gears",
    "cubes",
    "stack:count=48",
    "sphere:sides=96",
];

/// The size of `--quick`: not a multiple of anything.
const QUICK: [u32; 2] = [157, 101];

/// A picture to be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Subject {
    /// As it was typed.
    pub(super) asked: String,
    /// If one was typed.
    typed: Option<[u32; 2]>,
    /// The scene's name.
    pub(super) name: String,
    /// Pixels across and down.
    pub(super) size: [u32; 2],
    /// The files that it was read from.
    pub(super) files: Vec<PathBuf>,
}

impl Subject {
    /// Load it.
    pub(super) fn load(&self) -> Result<Scene> {
        load(&self.asked, self.typed)
    }
}

fn load(asked: &str, size: Option<[u32; 2]>) -> Result<Scene> {
    scene::load(asked, &Overrides { size, ..Overrides::default() })
}

/// The names of scenes, as typed.
pub(super) fn scenes(args: &Args) -> Vec<String> {
    match args.scenes.as_slice() {
        [] => SCENES.map(str::to_owned).to_vec(),
        named => named.to_vec(),
    }
}

/// All pictures. All are loaded once, so that unreadable files are reported before anything is drawn.
pub(super) fn subjects(args: &Args) -> Result<Vec<Subject>> {
    let sizes = sizes(args)?;
    let subject = |asked: String, &typed: &Option<[u32; 2]>| {
        let Scene { name, size, files, .. } = load(&asked, typed)?;
        Ok(Subject { asked, typed, name, size, files })
    };
    wait::during(args.output.quiet, "loading", || {
        let all = scenes(args).into_iter();
        let all = all.flat_map(|asked| sizes.iter().map(move |size| (asked.clone(), size)));
        all.map(|(asked, size)| subject(asked, size)).collect()
    })
}

/// The sizes to draw every scene in; its own if none is given.
fn sizes(args: &Args) -> Result<Vec<Option<[u32; 2]>>> {
    if args.quick {
        return Ok(vec![Some(QUICK)]);
    }
    if args.sizes.is_empty() {
        return Ok(vec![None]);
    }
    args.sizes.iter().map(|text| values::size(text).map(Some)).collect()
}

/// The thickness of surfaces that do not say so themselves.
pub(super) fn thickness(args: &Args) -> Result<Thickness> {
    settings::thickness(args.thickness.as_deref())
}

/// What the rows of a report depend on, besides what each says itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Settings {
    /// `-k`.
    k: Option<u32>,
    /// `shuffled` or `submission`.
    order: String,
    /// Of `shuffled`.
    seed: u64,
    /// `--thickness`, if given.
    thickness: Option<String>,
}

impl Settings {
    /// Those that were typed.
    pub(super) fn of(args: &Args) -> Self {
        let order = format!("{:?}", args.order).to_lowercase();
        Self { k: args.k, order, seed: args.seed, thickness: args.thickness.clone() }
    }
}
