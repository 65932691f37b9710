//! The page of a check: its verdicts, and for each that is violated the interleaving that shows it.

use super::{Page, Section, Table};
use crate::error::Result;
use crate::explore::{Finding, Verdict};
use crate::report::grid::{Cell, Column, Grid};

/// The page of some verdicts. `timeline` gives the interleaving of a token as the page's script shows it, or nothing
/// where there is none, as for a whole scene.
///
/// # Errors
/// What `timeline` reports.
pub fn verdicts(
    rows: &[Finding],
    timeline: &dyn Fn(&str) -> Result<Option<serde_json::Value>>,
) -> Result<Page> {
    let mut methods: Vec<&str> = rows.iter().map(|row| row.method.as_str()).collect();
    methods.dedup();
    let mut page = Page::new(&format!("Verdicts: {}", methods.join(", ")));
    let (mut links, mut below) = (Vec::new(), Vec::new());
    for row in rows {
        let shown = row.token.as_deref().map(timeline).transpose()?.flatten();
        let violated = row.verdict == Verdict::Violated;
        links.push(violated.then(|| page.name(1 + below.len())));
        if !violated {
            continue;
        }
        below.push((format!("{}: {}", row.method, what(row)), facts(row)));
        if let Some(data) = shown {
            let title = format!("{}: the interleaving", row.method);
            below.push((title, Section::Other { kind: "timeline", data }));
        }
    }
    let mut bounds: Vec<String> = Vec::new();
    for row in rows.iter().filter(|row| !row.bound.is_empty()) {
        if !bounds.contains(&row.bound) {
            bounds.push(row.bound.clone());
        }
    }
    let notes = bounds.into_iter().map(|bound| format!("Explored: {bound}")).collect();
    page.add("Verdicts", Section::Table(Table::new(&grid(rows), &links, notes)));
    below.into_iter().for_each(|(title, section)| page.add(&title, section));
    Ok(page)
}

/// The property, of a claim if one was checked.
fn what(row: &Finding) -> String {
    row.property.iter().chain(&row.claim).cloned().collect::<Vec<_>>().join(" of ")
}

/// The memory model, with its profile and the progress model.
fn under(row: &Finding) -> String {
    let under = [Some(row.memory.as_str()), row.profile.as_deref(), row.progress.as_deref()];
    under.into_iter().flatten().filter(|name| !name.is_empty()).collect::<Vec<_>>().join(" ")
}

fn facts(row: &Finding) -> Section {
    let pair = |name: &str, value: String| [name.to_owned(), value];
    let mut rows = vec![
        pair("what is wrong", row.message.clone()),
        pair("instance", row.instance.clone()),
        pair("memory", under(row)),
    ];
    rows.extend(
        (!row.initial.is_empty()).then(|| pair("memory holds at first", row.initial.clone())),
    );
    rows.extend(row.steps.map(|steps| pair("steps", steps.to_string())));
    rows.extend((!row.outcomes.is_empty()).then(|| pair("all results", row.outcomes.join("  "))));
    let command = |token: &String| pair("again", format!("fragloom replay {token} --trace"));
    rows.extend(row.token.as_ref().map(command));
    Section::Facts { rows, notes: Vec::new() }
}

fn grid(rows: &[Finding]) -> Grid {
    let columns = [
        ("method", "method"),
        ("property", "property"),
        ("memory", "memory"),
        ("verdict", "verdict"),
        ("instance", "explored"),
        ("states", "states"),
        ("executions", "executions"),
        ("message", "message"),
    ]
    .map(|(name, heading)| Column::new(name, heading))
    .to_vec();
    let word = |text: &str| Cell::Word(text.to_owned());
    let cells = |row: &Finding| {
        vec![
            word(&row.method),
            word(&what(row)),
            word(&under(row)),
            word(row.verdict.name()),
            word(&row.instance),
            if row.states == 0 { Cell::Absent("-") } else { Cell::whole(row.states) },
            row.executions.map_or(Cell::Absent("-"), Cell::whole),
            word(&row.message),
        ]
    };
    Grid { columns, rows: rows.iter().map(cells).collect() }
}
