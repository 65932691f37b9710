//! `fragloom mutations`: the built-in faults, and the methods that have them.

use crate::catalogue::faults::{MUTATIONS, Mutation};
use crate::cli::Verdict;
use crate::cli::terminal::say;
use crate::error::Result;
use crate::explore::program::controls::CONTROLS;
use crate::report::json;
use crate::report::text::{Align, columns};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Print one JSON document instead of the table
    #[arg(long)]
    json: bool,
}

/// Print the list.
///
/// # Errors
/// stdout cannot be written.
pub(in crate::cli) fn run(args: &Args) -> Result<Verdict> {
    let all = [MUTATIONS, CONTROLS].concat();
    let text = if args.json { json::document(&all)? } else { table(&all) };
    say::result(&text)?;
    Ok(Verdict::Clean)
}

/// A line per mutation; under it, one per method that has it, or the reason why none does.
fn table(mutations: &[Mutation]) -> String {
    let mut rows = vec![["mutation", "what is wrong"].map(str::to_owned).to_vec()];
    for mutation in mutations {
        rows.push(vec![mutation.id.to_owned(), mutation.text.to_owned()]);
        let absent = mutation.absent.map(|why| format!("none: {why}"));
        let is_drawn = MUTATIONS.iter().any(|known| known.id == mutation.id);
        let how = if is_drawn { "-m" } else { "check" };
        let below = mutation.variants.iter().map(|name| format!("{how} {name}")).chain(absent);
        rows.extend(below.map(|line| vec![String::new(), format!("  {line}")]));
    }
    columns(&[Align::Left, Align::Left], &rows)
}
