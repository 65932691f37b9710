//! `fragloom scenes`: the built-in procedural scenes and their keys.

use serde::Serialize;

use crate::cli::Verdict;
use crate::cli::terminal::say;
use crate::error::Result;
use crate::report::json;
use crate::report::text::{Align, columns};
use crate::scene::{Builtin, builtin};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Print one JSON document instead of the table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Entry {
    name: String,
    description: String,
    keys: Vec<KeyEntry>,
}

#[derive(Serialize)]
struct KeyEntry {
    name: String,
    default: String,
    help: String,
}

/// Print the list.
///
/// # Errors
/// stdout cannot be written.
pub(in crate::cli) fn run(args: &Args) -> Result<Verdict> {
    let entries: Vec<Entry> = builtin().iter().map(entry).collect();
    let text = if args.json { json::document(&entries)? } else { table(&entries) };
    say::result(&text)?;
    Ok(Verdict::Clean)
}

fn entry(scene: &Builtin) -> Entry {
    let keys = scene.keys.iter().map(|key| KeyEntry {
        name: key.name.to_string(),
        default: key.default.to_string(),
        help: key.about.to_string(),
    });
    Entry {
        name: scene.name.to_string(),
        description: scene.about.to_string(),
        keys: keys.collect(),
    }
}

/// A line per scene, and one per key under it, as it is typed: `layers:count=4`.
fn table(entries: &[Entry]) -> String {
    let mut rows = vec![["scene", "what it is"].map(str::to_owned).to_vec()];
    for entry in entries {
        rows.push(vec![entry.name.clone(), entry.description.clone()]);
        for key in &entry.keys {
            rows.push(vec![format!("  :{}={}", key.name, key.default), key.help.clone()]);
        }
    }
    columns(&[Align::Left, Align::Left], &rows)
}
