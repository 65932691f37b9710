//! Verdicts and the kill matrix for people.

use std::fmt::Write as _;

use super::text::{Align, columns, thousands};
use crate::explore::verdict::matrix::{Kill, Line};
use crate::explore::{Finding, Token, Verdict};

/// One line per verdict; under a violation its message, its results where they differ, and its token.
#[must_use]
pub fn table(rows: &[Finding]) -> String {
    let heading = ["method", "property", "memory", "verdict", "explored", "states", "executions"];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    cells.extend(rows.iter().map(row));
    let [l, r] = [Align::Left, Align::Right];
    let lines = columns(&[l, l, l, l, l, r, r], &cells);
    let mut lines = lines.lines();
    let mut text = String::new();
    let _ = writeln!(text, "{}", lines.next().unwrap_or_default());
    let mut above = "";
    for (line, row) in lines.zip(rows) {
        let _ = writeln!(text, "{line}");
        let same = row.verdict == Verdict::Unknown && row.message == above;
        above = &row.message;
        if same && !row.message.is_empty() {
            let _ = writeln!(text, "    as above");
        } else if !row.message.is_empty() {
            let steps = row.steps.map(|n| format!("in {n} steps: ")).unwrap_or_default();
            let _ = writeln!(text, "    {steps}{}", row.message);
        }
        if !row.outcomes.is_empty() {
            let _ = writeln!(text, "    all results: {}", row.outcomes.join("  "));
        }
        if let Some(token) = &row.token {
            let of_scene = matches!(token.parse(), Ok(Token::Scene(_)));
            let how = if of_scene { "--minimise" } else { "--trace" };
            let _ = writeln!(text, "    fragloom replay {token} {how}");
        }
    }
    text + &bounds(rows)
}

/// The bounds, once each: verdicts hold within them.
fn bounds(rows: &[Finding]) -> String {
    let mut seen: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|row| !row.bound.is_empty()) {
        if !seen.contains(&row.bound.as_str()) {
            seen.push(&row.bound);
        }
    }
    let mut text = String::new();
    if !seen.is_empty() {
        text.push_str("\nexplored:\n");
        seen.iter().for_each(|bound| {
            let _ = writeln!(text, "    {bound}");
        });
    }
    text
}

fn row(row: &Finding) -> Vec<String> {
    let what = row.property.iter().chain(&row.claim).cloned().collect::<Vec<_>>().join(" of ");
    let under = [Some(row.memory.as_str()), row.profile.as_deref(), row.progress.as_deref()];
    let under: Vec<&str> = under.into_iter().flatten().filter(|name| !name.is_empty()).collect();
    let verdict = match row.verdict {
        Verdict::Violated => "VIOLATED",
        verdict => verdict.name(),
    };
    let count = |n: Option<u64>| n.map_or_else(|| "-".to_owned(), thousands);
    vec![
        row.method.clone(),
        what,
        under.join(" "),
        verdict.to_owned(),
        row.instance.clone(),
        if row.states == 0 { "-".to_owned() } else { thousands(row.states) },
        count(row.executions),
    ]
}

/// Every result of several instances.
#[must_use]
pub fn outcomes(rows: &[Finding]) -> String {
    let mut text = String::new();
    for row in rows {
        let under = [Some(row.memory.as_str()), row.profile.as_deref()];
        let under: Vec<&str> = under.into_iter().flatten().collect();
        let _ = writeln!(
            text,
            "{} ({}), {}: {}",
            row.method,
            under.join(" "),
            row.instance,
            row.message
        );
        for outcome in &row.outcomes {
            let _ = writeln!(text, "    {outcome}");
        }
    }
    text
}

/// The kill matrix.
#[must_use]
pub fn matrix(lines: &[Line]) -> String {
    const CHECKS: [&str; 6] = ["sc", "progress", "simt", "relaxed", "race", "random"];
    let mut heading = vec!["fault".to_owned(), "method".to_owned(), "fate".to_owned()];
    heading.extend(CHECKS.map(str::to_owned));
    let mut cells = vec![heading];
    for line in lines {
        let mut row = vec![line.mutation.clone(), line.method.clone(), line.fate.name().to_owned()];
        row.extend(CHECKS.map(|check| {
            let kill = line.kills.iter().find(|kill| kill.check == check);
            kill.map_or_else(|| "-".to_owned(), told)
        }));
        cells.push(row);
    }
    let mut text = columns(&[Align::Left; 9], &cells);
    text += "\na kill: the property, the steps of a shortest schedule, and the executions (or states) of its instance\n";
    if let Some(line) = lines.first() {
        let _ = writeln!(text, "explored where nothing was found earlier: {}", line.bound);
    }
    text
}

fn told(kill: &Kill) -> String {
    let size = match kill.executions {
        Some(n) => format!("{} ex", thousands(n)),
        None => format!("{} states", thousands(kill.states)),
    };
    format!("{} {}/{size}", kill.property, kill.steps)
}
