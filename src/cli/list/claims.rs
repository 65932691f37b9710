//! `fragloom claims`: what the papers say, as it is checked here.

use crate::cli::Verdict;
use crate::cli::terminal::say;
use crate::error::Result;
use crate::explore::verdict::claims::{CLAIMS, Claim};
use crate::report::json;
use crate::report::text::{Align, columns};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Print one JSON document instead of the table
    #[arg(long)]
    json: bool,
}

/// Print the list. Verdicts are not in it: `check --claim C1` computes them.
///
/// # Errors
/// stdout cannot be written.
pub(in crate::cli) fn run(args: &Args) -> Result<Verdict> {
    let text = if args.json { json::document(CLAIMS)? } else { table(CLAIMS) };
    say::result(&text)?;
    Ok(Verdict::Clean)
}

fn table(claims: &[Claim]) -> String {
    let mut rows = vec![["claim", "said in", "statement"].map(str::to_owned).to_vec()];
    for claim in claims {
        let place = format!("{}, {}", claim.paper, claim.section);
        rows.push(vec![claim.id.to_owned(), place, claim.statement.to_owned()]);
        let on = match claim.methods {
            [] => "  (needs a method that is not here yet)".to_owned(),
            methods => format!("  fragloom check --claim {}: {}", claim.id, methods.join(", ")),
        };
        rows.push(vec![String::new(), String::new(), on]);
    }
    columns(&[Align::Left; 3], &rows)
}
