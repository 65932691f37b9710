//! `fragloom methods`: the catalogue, from the contracts.

use super::{Verdict, say};
use crate::error::Result;
use crate::report::json;
use crate::report::text::{Align, columns};
use crate::scheme::{Contract, Form, contracts};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Print the whole contracts of all methods as one JSON document instead of the table
    #[arg(long)]
    json: bool,
    /// List the built-in faults too
    #[arg(long)]
    all: bool,
}

/// Print the catalogue.
///
/// # Errors
/// stdout cannot be written.
pub(super) fn run(args: &Args) -> Result<Verdict> {
    let mut contracts = contracts();
    if !args.all && !args.json {
        contracts.retain(|contract| contract.form != Form::Mutation);
    }
    let text = if args.json { json::document(&contracts)? } else { table(&contracts) };
    say::result(&text)?;
    Ok(Verdict::Clean)
}

fn table(contracts: &[&Contract]) -> String {
    let heading =
        ["method", "form", "passes", "k", "words per pixel", "may depend on", "what it is"];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    rows.extend(contracts.iter().map(|contract| row(contract)));
    let [left, right] = [Align::Left, Align::Right];
    columns(&[left, left, right, right, left, left, left], &rows)
}

fn row(contract: &Contract) -> Vec<String> {
    let form = match contract.form {
        Form::Correct => "correct",
        Form::Published => "published",
        Form::Mutation => "mutation",
    };
    let depends = match (contract.racy, contract.arrival_dependent) {
        (true, _) => "races",
        (false, true) => "arrival",
        (false, false) => "nothing",
    };
    let k = contract.default_k.map_or_else(|| "-".to_owned(), |k| k.to_string());
    vec![
        contract.name.to_owned(),
        form.to_owned(),
        contract.program.geometry().to_string(),
        k,
        contract.words.to_owned(),
        depends.to_owned(),
        contract.title.to_owned(),
    ]
}
