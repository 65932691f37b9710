//! `fragloom render --frames N`: the camera circles the scene once.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::picture::Picture;
use crate::cli::Verdict;
use crate::cli::options::settings::Settings;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::render::{AnimatedFrame, Animation, Report, Resize, animate};
use crate::report::text::{Align, columns, thousands};
use crate::report::{files, json};
use crate::scene::Scene;

/// Options about several frames.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct Frames {
    /// Draw N frames, 1 to 100000, of a camera that circles its target once; pictures are FILE-0000.png and so on
    /// [default: one frame, from where the camera is]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) frames: Option<u32>,

    /// With `--frames`, when a hash table that is too full or too empty changes its size: at the beginning of the next
    /// frame, as published, or in addition at once, by redrawing a frame that lost fragments [default: latent]
    #[arg(long, value_enum, value_name = "WHEN")]
    pub(in crate::cli) resize: Option<When>,
}

/// `--resize`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum When {
    Latent,
    AtOnce,
}

/// One frame's row.
#[derive(Debug, Serialize)]
struct FrameLine {
    frame: u32,
    retries: u32,
    #[serde(flatten)]
    report: Report,
}

impl Frames {
    /// The requested sequence, if any. `single`: the given options that apply only to a single frame.
    ///
    /// # Errors
    /// An option without another option that it needs.
    pub(in crate::cli) fn complete(&self, single: &[&str]) -> Result<Option<Animation>> {
        let resize = match self.resize {
            None | Some(When::Latent) => Resize::Latent,
            Some(When::AtOnce) => Resize::AtOnce,
        };
        match (self.frames, self.resize, single.first()) {
            (None, Some(_), _) => Err(Error::new("--resize", "needs --frames")),
            (None, None, _) => Ok(None),
            (Some(_), _, Some(option)) => {
                Err(Error::new(*option, "is for a single frame, not --frames"))
            }
            (Some(frames), _, None) => Ok(Some(Animation { frames, resize })),
        }
    }
}

/// Draw all frames, write their pictures, and print a row for each.
///
/// # Errors
/// As for a single frame; pictures of earlier frames remain.
pub(in crate::cli) fn run(
    scene: &Scene,
    settings: &Settings,
    animation: &Animation,
    picture: &Picture,
    stats: Option<&Path>,
    [as_json, quiet]: [bool; 2],
) -> Result<Verdict> {
    let mut rows = Vec::new();
    let message = format!("drawing {} frames of {}", animation.frames, scene.name);
    wait::during(quiet, &message, || {
        animate(scene, &settings.options, animation, |frame| {
            let AnimatedFrame { number, retries, rendering } = frame;
            if let Some(path) = &picture.image {
                picture.write(&rendering, &numbered(path, number))?;
            }
            rows.push(FrameLine { frame: number, retries, report: rendering.report });
            Ok(())
        })
    })?;
    let document = json::document(&rows)?;
    if let Some(path) = stats {
        files::write_bytes(path, document.as_bytes())?;
    }
    let mut warnings: Vec<&String> = settings.warnings.iter().chain(&scene.warnings).collect();
    for warning in rows.iter().flat_map(|row| &row.report.warnings) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    warnings.iter().for_each(|warning| say::warning(warning));
    say::result(&if as_json { document } else { table(&rows) })?;
    for row in &rows {
        let frame = row.frame;
        let wrong = row.report.violations.iter();
        wrong.for_each(|violation| say::violation(&format!("frame {frame}: {violation}")));
    }
    let clean = rows.iter().all(|row| row.report.violations.is_empty());
    Ok(if clean { Verdict::Clean } else { Verdict::Found })
}

/// `picture.png` as `picture-0007.png`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}-{number:04}{ending}"))
}

fn table(rows: &[FrameLine]) -> String {
    let head =
        ["frame", "generated", "kept", "culled", "dropped", "cells", "load", "age", "retries"];
    let mut cells = vec![head.map(str::to_owned).to_vec()];
    for FrameLine { frame, retries, report } in rows {
        let dropped = report.dropped.iter().map(|(why, n)| format!("{} {why}", thousands(*n)));
        let dropped: Vec<String> = dropped.collect();
        let table = report.table.as_ref();
        let of_table = |text: &dyn Fn(&crate::render::TableReport) -> String| {
            table.map_or_else(|| "-".to_owned(), text)
        };
        cells.push(vec![
            frame.to_string(),
            thousands(report.generated),
            thousands(report.kept),
            thousands(report.culled),
            if dropped.is_empty() { "0".to_owned() } else { dropped.join(", ") },
            of_table(&|t| format!("{}x{}", t.width, t.height)),
            of_table(&|t| format!("{:.1} %", t.load)),
            of_table(&|t| t.max_age.to_string()),
            retries.to_string(),
        ]);
    }
    columns(&[Align::Right; 9], &cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_numbered() {
        assert_eq!(numbered(Path::new("a/b.png"), 7), Path::new("a/b-0007.png"));
        assert_eq!(numbered(Path::new("x.y.png"), 12_345), Path::new("x.y-12345.png"));
    }
}
