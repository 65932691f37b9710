//! `fragloom methods`: the catalogue, from the contracts.

use std::path::{Path, PathBuf};

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::explore::sample::stability::{self, Stability};
use crate::image::png;
use crate::report::text::{Align, columns};
use crate::report::{files, json, stability as drawn};
use crate::scheme::program::Program;
use crate::scheme::{Contract, Form};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Print the whole contracts of all methods as one JSON document instead of the table
    #[arg(long)]
    json: bool,
    /// List the built-in faults too
    #[arg(long)]
    all: bool,
    /// Derive what every method's result depends on, by drawing scenes with permuted arrival and under many schedules
    #[arg(long, conflicts_with = "all")]
    stability: bool,
    /// With --stability: draw it, as PNG or SVG by the file's ending; may be given twice [default: not written]
    #[arg(short = 'o', value_name = "FILE.png|FILE.svg", requires = "stability")]
    out: Vec<PathBuf>,
}

/// Print the catalogue.
///
/// # Errors
/// stdout cannot be written.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    if args.stability {
        return stability(catalogue, args);
    }
    let mut contracts: Vec<&Contract> = catalogue.contracts().collect();
    if !args.all && !args.json {
        contracts.retain(|contract| contract.form != Form::Mutation);
    }
    let text = if args.json { json::document(&contracts)? } else { table(&contracts) };
    say::result(&text)?;
    Ok(Verdict::Clean)
}

/// Print the stability matrix. A contract that declares something other than what was observed is a finding.
fn stability(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    for path in &args.out {
        if is_svg(path).is_none() {
            let problem = format!("{} must end in .png or .svg", path.display());
            return Err(Error::new("-o", problem));
        }
        files::check_output("-o", path)?;
    }
    files::check_distinct(&args.out.iter().map(|path| ("-o", path)).collect::<Vec<_>>())?;
    let rows = wait::during(args.json, "drawing", || stability::derive(catalogue))?;
    for path in &args.out {
        let bytes = if is_svg(path) == Some(true) {
            drawn::svg(&rows).into_bytes()
        } else {
            png::encode(&drawn::picture(&rows))
                .map_err(|error| Error::new(path.display().to_string(), error.to_string()))?
        };
        files::write_bytes(path, &bytes)?;
    }
    let text = if args.json { json::document(&rows)? } else { matrix(&rows) };
    say::result(&text)?;
    Ok(if rows.iter().all(Stability::agrees) { Verdict::Clean } else { Verdict::Found })
}

fn is_svg(path: &Path) -> Option<bool> {
    match &path.extension()?.to_str()?.to_ascii_lowercase()[..] {
        "svg" => Some(true),
        "png" => Some(false),
        _ => None,
    }
}

fn matrix(rows: &[Stability]) -> String {
    let heading =
        ["method", "arrival", "at ties", "at overflow", "spread", "schedule", "declared", "runs"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    let word = |seen: bool| if seen { "depends" } else { "-" }.to_owned();
    for row in rows {
        let declared = match row.declared {
            [true, true] => "arrival, races",
            [true, false] => "arrival",
            [false, true] => "races",
            [false, false] => "nothing",
        };
        let agrees = if row.agrees() { "" } else { " (NOT AS OBSERVED)" };
        let overflow = match (row.arrival_at_overflow, row.pooled) {
            (true, true) => "depends (pool)".to_owned(),
            (seen, _) => word(seen),
        };
        lines.push(vec![
            row.method.to_owned(),
            word(row.arrival),
            word(row.arrival_at_ties),
            overflow,
            spread(row.spread),
            word(row.schedule),
            format!("{declared}{agrees}"),
            row.runs.to_string(),
        ]);
    }
    let [left, right] = [Align::Left, Align::Right];
    columns(&[left, left, left, left, right, left, left, right], &lines)
}

/// Two digits, also of what is very small.
fn spread(spread: f64) -> String {
    match spread {
        0.0 => "-".to_owned(),
        spread if spread < 0.01 => format!("{spread:.1e}"),
        spread => format!("{spread:.2}"),
    }
}

fn table(contracts: &[&Contract]) -> String {
    let heading = [
        "method",
        "form",
        "passes",
        "k",
        "words per pixel",
        "and for the frame",
        "may depend on",
        "exact when",
        "what it is",
    ];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    rows.extend(contracts.iter().map(|contract| row(contract)));
    let [left, right] = [Align::Left, Align::Right];
    columns(&[left, left, right, right, left, left, left, left, left], &rows)
}

fn row(contract: &Contract) -> Vec<String> {
    let form = match contract.form {
        Form::Correct => "correct",
        Form::Published => "published",
        Form::Mended => "mended",
        Form::Mutation => "mutation",
    };
    let depends = match (contract.is_racy(), contract.is_arrival_dependent()) {
        (true, _) => "races",
        (false, true) => "arrival",
        (false, false) => "nothing",
    };
    let k = contract.default_k.map_or_else(|| "-".to_owned(), |k| k.to_string());
    vec![
        contract.name.to_owned(),
        form.to_owned(),
        passes(contract),
        k,
        contract.words.to_owned(),
        contract.frame_words.to_owned(),
        depends.to_owned(),
        contract.exact_when.to_owned(),
        contract.title.to_owned(),
    ]
}

/// Geometry passes and full-screen passes; a plus where they are repeated.
fn passes(contract: &Contract) -> String {
    let Program { repeats, .. } = contract.program;
    let again = if repeats { "*" } else { "" };
    format!("{}+{}{again}", contract.program.geometry(), contract.program.full_screen())
}
