//! `fragloom reproduce`: the papers' tables and figures, ours next to theirs.

use std::path::{Path, PathBuf};

use crate::cli::Verdict;
use crate::cli::options::flags::Output;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::image::png;
use crate::report::text::{Align, columns};
use crate::report::{files, json};
use crate::reproduce::{EXPERIMENTS, Experiment, Outcome, Scale, experiment};
use crate::scene::MAX_SIZE;

/// Edge of the papers' pictures.
const FULL: u32 = 1_024;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Experiments: ha-table1, ha-fig5, ha-fig8, varik-table1, varik-table2, varik-fig1 to varik-fig5, occupancy-fig1,
    /// merge-fig1 to merge-fig17
    /// [default: all]
    #[arg(value_name = "EXPERIMENT")]
    experiments: Vec<String>,

    /// A folder that exists, for EXPERIMENT.csv, EXPERIMENT.svg if there are curves, and EXPERIMENT-*.png if there are
    /// pictures [default: not written]
    #[arg(short = 'o', value_name = "DIR")]
    folder: Option<PathBuf>,

    /// Edge of the square picture of experiments that draw one, 16 to 16384 pixels; --full is 1024, as in most papers
    #[arg(long, value_name = "PIXELS", default_value_t = 512, allow_negative_numbers = true)]
    edge: u32,

    /// Pictures of the papers' size, 1024x1024, unless --edge says otherwise
    #[arg(long, conflicts_with = "edge")]
    full: bool,

    /// How often each point is timed, 1 to 1000; the median is reported
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true)]
    repeats: u32,

    #[command(flatten)]
    output: Output,
}

/// Run them, write the files, and print the tables.
///
/// # Errors
/// An unknown experiment, a scale out of range, or a file that cannot be written.
pub(in crate::cli) fn run(args: &Args) -> Result<Verdict> {
    let chosen: Vec<&Experiment> = if args.experiments.is_empty() {
        EXPERIMENTS.iter().collect()
    } else {
        args.experiments.iter().map(|name| experiment(name)).collect::<Result<_>>()?
    };
    let wrong = |option: &str, problem: String| Err(Error::new(option, problem));
    if !(16..=MAX_SIZE).contains(&args.edge) {
        return wrong("--edge", format!("is {}, but must be 16 to {MAX_SIZE} pixels", args.edge));
    }
    if !(1..=1_000).contains(&args.repeats) {
        return wrong("--repeats", format!("is {}, but must be 1 to 1000", args.repeats));
    }
    if let Some(folder) = &args.folder {
        files::check_folder("-o", folder)?;
    }
    let edge = if args.full { FULL } else { args.edge };
    let scale = Scale { edge, repeats: args.repeats };
    let mut outcomes = Vec::new();
    for experiment in chosen {
        let message = format!("running {}", experiment.name);
        let outcome = wait::during(args.output.quiet, &message, || experiment.run(&scale))?;
        if let Some(folder) = &args.folder {
            write(folder, &outcome)?;
        }
        outcomes.push(outcome);
    }
    if args.output.json {
        say::result(&json::document(&outcomes)?)?;
    } else {
        outcomes.iter().try_for_each(|outcome| say::result(&table(outcome)))?;
    }
    let differences = outcomes.iter().flat_map(|outcome| &outcome.differences);
    let found = differences.inspect(|difference| say::violation(difference)).count() > 0;
    Ok(if found { Verdict::Found } else { Verdict::Clean })
}

fn write(folder: &Path, outcome: &Outcome) -> Result<()> {
    let path = |ending: &str| folder.join(format!("{}.{ending}", outcome.experiment));
    files::write_bytes(&path("csv"), outcome.csv().as_bytes())?;
    for (name, picture) in &outcome.pictures {
        let path = folder.join(format!("{}-{name}.png", outcome.experiment));
        let bytes = png::encode(picture)
            .map_err(|error| Error::new(path.display().to_string(), error.to_string()))?;
        files::write_bytes(&path, &bytes)?;
    }
    match &outcome.plot {
        Some(plot) => files::write_bytes(&path("svg"), plot.svg().as_bytes()),
        None => Ok(()),
    }
}

fn table(outcome: &Outcome) -> String {
    let first = outcome.columns.iter().map(|column| (*column).to_owned()).collect();
    let rows: Vec<Vec<String>> = std::iter::once(first).chain(outcome.rows.clone()).collect();
    let numeric = |column: usize| rows[1..].iter().all(|row| row[column].parse::<f64>().is_ok());
    let align = |column| if numeric(column) { Align::Right } else { Align::Left };
    let aligned: Vec<Align> = (0..outcome.columns.len()).map(align).collect();
    let verdict = outcome.verdict.as_ref().map_or_else(String::new, |v| format!("{v}\n"));
    let table = columns(&aligned, &rows);
    format!("{}\n{table}{}\n{verdict}\n", outcome.experiment, outcome.summary)
}
