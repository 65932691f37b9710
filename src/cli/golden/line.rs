//! Drawing what a manifest says: its words are the command line of `fragloom render`.

use std::path::{Path, PathBuf};

use clap::{CommandFactory, FromArgMatches, Parser};

use super::words::Look;
use crate::catalogue::Catalogue;
use crate::cli::options::settings::{Settings, complete};
use crate::cli::{lenient, one_line};
use crate::error::{Error, Result};
use crate::golden::{Asked, Draw, Drawn};
use crate::render::{Exec, Options, Report, Wanted, render};
use crate::scene::{self, FileFormat};

/// Draws what stands in a manifest, with the methods of a catalogue.
#[derive(Clone, Copy, Debug)]
pub struct CommandLine<'a> {
    /// Its methods.
    pub catalogue: &'a Catalogue,
}

/// What follows the scene.
#[derive(Debug, Parser)]
#[command(name = "options", no_binary_name = true, disable_help_flag = true)]
pub(super) struct Line {
    /// A method of the catalogue
    #[arg(short, long, default_value = "kplus-array")]
    method: String,

    #[command(flatten)]
    look: Look,
}

/// `--schedule` of a file.
const RECORDED: &str = "recorded:";

impl Line {
    /// Read the words.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(super) fn parse(words: &[String]) -> Result<Self> {
        let matches = lenient(Self::command()).try_get_matches_from(words);
        let line =
            matches.and_then(|matches| Self::from_arg_matches(&matches)).map_err(|error| {
                let text = one_line(&error);
                Error::new("options", text.trim_end_matches(" (see --help)"))
            })?;
        for (option, path) in
            [("--surfaces", &line.look.effects.surfaces), ("--ldi", &line.look.effects.ldi)]
        {
            if path.is_some() {
                let problem = "writes a file, and golden pictures write none but their own";
                return Err(Error::new(option, problem));
            }
        }
        Ok(line)
    }

    /// Whether a scene is a file, and no built-in one.
    pub(super) fn is_file(look: &Look, scene: &str) -> bool {
        look.drawing.scene.format().or_else(|| FileFormat::of(Path::new(scene))).is_some()
    }

    /// The paths in the options: what stands before each, and the path.
    pub(super) fn paths(look: &Look) -> Vec<(&'static str, PathBuf)> {
        let map = look.drawing.importance.importance_map.clone();
        let recorded = look.drawing.schedule.as_deref();
        let recorded = recorded.and_then(|text| text.strip_prefix(RECORDED)).map(PathBuf::from);
        [("", map), (RECORDED, recorded)]
            .into_iter()
            .filter_map(|(before, path)| Some((before, path?)))
            .collect()
    }

    /// Make paths relative to `folder` ones that can be opened.
    fn place(&mut self, folder: &Path) {
        let drawing = &mut self.look.drawing;
        if let Some(map) = &mut drawing.importance.importance_map {
            *map = folder.join(&map);
        }
        if let Some(schedule) = &mut drawing.schedule
            && let Some(file) = schedule.strip_prefix(RECORDED)
        {
            *schedule = format!("{RECORDED}{}", folder.join(file).display());
        }
    }

    /// All settings of the run.
    fn settings(&self, catalogue: &Catalogue) -> Result<Settings> {
        let Look { drawing, effects, transparent } = &self.look;
        let method = vec![catalogue.find("-m", &self.method)?];
        let method = drawing.approximation.with_tail(method)?[0];
        let mut settings = complete(drawing, method, false)?;
        effects.complete(drawing.data, &mut settings.options)?;
        settings.options.transparent = *transparent;
        settings.options.wanted = Wanted::Hash;
        Ok(settings)
    }
}

impl Draw for CommandLine<'_> {
    fn draw(&self, asked: &Asked<'_>) -> Result<Drawn> {
        let mut line = Line::parse(asked.options)?;
        line.place(asked.folder);
        let Settings { overrides, mut options, warnings } = line.settings(self.catalogue)?;
        if options.threads == 0 && options.exec == Exec::Tile {
            options.threads = asked.threads;
        }
        let source = match Line::is_file(&line.look, asked.scene) {
            true => asked.folder.join(asked.scene).display().to_string(),
            false => asked.scene.to_owned(),
        };
        let scene = scene::load(&source, &overrides)?;
        let rendering = render(&scene, &options)?;
        let named = Line::paths(&line.look).into_iter().map(|(_, path)| path);
        let report = rendering.report;
        Ok(Drawn {
            image: rendering.image,
            generated: report.generated,
            kept: report.kept,
            unsteady: unsteady(&options, &report),
            fragments_hash: report.fragments_hash,
            files: scene.files.into_iter().chain(named).collect(),
            warnings: [warnings, report.warnings].concat(),
            violations: report.violations,
        })
    }
}

/// Why another run may give another picture, if it may. The simulated device runs its schedule again; tiles do, unless
/// they share memory.
fn unsteady(options: &Options, report: &Report) -> Option<String> {
    let fixed = report.deterministic.iter().any(|field| field == "image_hash");
    let contract = options.method.contract();
    let open = match options.exec {
        Exec::Sim(_) => false,
        Exec::Tile => contract.crosses(),
        Exec::Threads => true,
    };
    (open && !fixed).then(|| {
        let (name, exec) = (contract.name, options.exec.name());
        format!("what {name} gives depends on the schedule, and with --exec {exec} that is no fixed one; use --exec sim")
    })
}
