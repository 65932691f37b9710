//! `fragloom golden verify`: draw a manifest again.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use super::line::CommandLine;
use super::{Jobs, Told};
use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::page;
use crate::cli::terminal::interrupt::Interrupt;
use crate::cli::terminal::wait;
use crate::error::{Error, Result};
use crate::golden::{self, Manifest, Partition, Settings, Shown, Work};
use crate::report::files;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The folder of the manifest, golden.toml, or the manifest
    #[arg(value_name = "DIR")]
    manifest: PathBuf,

    /// Write what is different into the manifest, with its pictures, and only that; what was never recorded, too
    #[arg(long, conflicts_with = "partition")]
    bless: bool,

    /// The folder for pictures that differ, and their heat maps: NAME.drawn.png and NAME.difference.png
    /// [default: beside the golden picture]
    #[arg(short = 'o', value_name = "DIR")]
    maps: Option<PathBuf>,

    /// Only entries that have this in their names [default: all]
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,

    /// Only a part of the entries, by a hash of their names: hash:I/N is part I of N, counted from 1; auto reads the
    /// variables of a SLURM array, or of a CI service's parallel jobs [default: all]
    #[arg(long, value_name = "hash:I/N|auto")]
    partition: Option<String>,

    /// Write a page for browsers as well: all entries, and the pictures of those that differ, under a slider with their
    /// heat maps [default: not written]
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    #[command(flatten)]
    jobs: Jobs,

    #[command(flatten)]
    told: Told,
}

/// Draw every entry again, and print what is not as recorded.
///
/// # Errors
/// Wrong options, a manifest that is wrong, a file that cannot be written, or an entry that cannot be drawn.
pub(super) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let jobs = args.jobs.checked()?;
    let variable = |name: &str| std::env::var(name).ok();
    let partition = args.partition.as_deref().map(|text| Partition::parse(text, &variable));
    let partition = partition.transpose()?;
    args.maps.as_ref().map_or(Ok(()), |folder| files::check_folder("-o", folder))?;
    let mut manifest = Manifest::read(&args.manifest)?;
    let own = own(&manifest);
    args.told.check(&own)?;
    if let Some(path) = &args.report {
        page::check("--report", path)?;
        files::check_apart(&[("--report", path)], &own)?;
        let others = args.told.junit.as_ref().map(|junit| ("--junit", junit));
        let all: Vec<_> = others.into_iter().chain([("--report", path)]).collect();
        files::check_distinct(&all)?;
    }
    let settings = Settings {
        filter: args.filter.as_deref(),
        partition,
        bless: args.bless,
        maps: args.maps.as_deref(),
    };
    let count = manifest.entries().iter().filter(|entry| settings.chooses(entry)).count();
    if let Some(text) = args.filter.as_deref().filter(|_| count == 0 && partition.is_none()) {
        return Err(Error::new("--filter", format!("no entry has {text:?} in its name")));
    }
    let interrupt = Interrupt::watch();
    let draw = CommandLine { catalogue };
    let pictures = Mutex::new(BTreeMap::new());
    let shown = |name: &str, shown: Shown| {
        if args.report.is_some() {
            let mut pictures = pictures.lock().unwrap_or_else(PoisonError::into_inner);
            pictures.insert(name.to_owned(), shown);
        }
    };
    let report = wait::counting(args.told.output.quiet, "verifying", count, |done| {
        let work = Work { jobs, cancelled: &|| interrupt.pressed(), done, shown: &shown };
        golden::verify(&mut manifest, &draw, &settings, &work)
    })?;
    if let Some(path) = &args.report {
        let pictures = pictures.into_inner().unwrap_or_else(PoisonError::into_inner);
        page::write(path, &golden::page(&report, &pictures)?)?;
    }
    let verdict = args.told.tell(&report)?;
    match report.not_run.len() {
        0 => Ok(verdict),
        left => {
            let problem = format!("interrupted: {left} of {count} entries were not verified");
            Err(Error::new("verify", problem))
        }
    }
}

/// The manifest, its pictures, and the files that they were drawn from.
fn own(manifest: &Manifest) -> Vec<PathBuf> {
    let at = |file: &String| manifest.folder().join(file);
    let entries = manifest.entries().iter();
    let files = entries.flat_map(|e| e.inputs.iter().map(|input| &input.file).chain(&e.picture));
    std::iter::once(manifest.path().to_path_buf()).chain(files.map(at)).collect()
}
