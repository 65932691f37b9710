//! Rows as text for people, and as CSV.

use std::collections::BTreeSet;

use serde::Serialize;
use serde_json::Value;

use super::machine::Constants;
use super::row::Timing;
use super::stats::Mean;
use crate::error::{Error, Result};
use crate::report::grid;
use crate::report::text::{Align, columns};

/// A column of a table.
pub(super) struct Column<T> {
    pub(super) heading: &'static str,
    pub(super) align: Align,
    pub(super) cell: fn(&T) -> String,
}

/// A number, or nothing where there is none.
pub(super) fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or(String::new(), |value| format!("{value:.digits$}"))
}

/// A table of these rows, without the columns in which no row has anything.
pub(super) fn table<T>(all: &[Column<T>], rows: &[T]) -> String {
    let cells = |column: &Column<T>| rows.iter().map(|row| (column.cell)(row)).collect();
    let filled: Vec<(&Column<T>, Vec<String>)> = all
        .iter()
        .map(|column| (column, cells(column)))
        .filter(|(_, cells): &(_, Vec<String>)| cells.iter().any(|cell| !cell.is_empty()))
        .collect();
    let align: Vec<Align> = filled.iter().map(|(column, _)| column.align).collect();
    let mut lines = vec![filled.iter().map(|(c, _)| c.heading.to_owned()).collect::<Vec<_>>()];
    let line = |row: usize| filled.iter().map(|(_, cells)| cells[row].clone()).collect();
    lines.extend((0..rows.len()).map(line));
    columns(&align, &lines)
}

macro_rules! column {
    ($heading:expr, $align:ident, $cell:expr) => {
        Column { heading: $heading, align: Align::$align, cell: $cell }
    };
}
pub(super) use column;

fn phase(row: &Timing, name: &str) -> String {
    number(row.seconds.get(name).copied(), 4)
}

/// The tables of a run: rows, the front end, the machine, and the means.
pub(super) fn tables(rows: &[Timing], machine: &[Constants], means: &[Mean]) -> String {
    let main = table(
        &[
            column!("method", Left, |row: &Timing| row.method.clone()),
            column!("scene", Left, |row| row.asked.clone()),
            column!("exec", Left, |row| row.exec.clone()),
            column!("threads", Right, |row| row.threads.to_string()),
            column!("fragments", Right, |row| row.fragments.to_string()),
            column!("setup s", Right, |row| phase(row, "setup")),
            column!("emit s", Right, |row| phase(row, "emit")),
            column!("draw s", Right, |row| phase(row, "draw")),
            column!("assemble s", Right, |row| phase(row, "assemble")),
            column!("hash s", Right, |row| phase(row, "hash")),
            column!("Mfrag/s", Right, |row| number(Some(row.mfrag_per_s), 1)),
            column!("Mops/s", Right, |row| number(row.mops_per_s, 1)),
            column!("MiB", Right, |row| number(row.peak_mib, 0)),
            column!("limit", Right, |row| number(row.limit_ratio, 2)),
            column!("by", Left, |row| row.limit_by.unwrap_or_default().to_owned()),
            column!("adapter", Left, |row| row.adapter.clone().unwrap_or_default()),
            column!("adapter s", Right, |row| number(row.gpu_seconds, 4)),
            column!("parts", Right, |row| row.parts.map_or(String::new(), |n| n.to_string())),
            column!("ratio", Right, |row| number(row.ratio, 2)),
            column!("spread", Left, beside),
            column!("culling", Left, culled),
        ],
        rows,
    );
    let mut seen = BTreeSet::new();
    let first = |row: &&Timing| seen.insert((row.asked.clone(), row.threads));
    let fronts: Vec<Timing> = rows.iter().filter(first).cloned().collect();
    let front = table(
        &[
            column!("scene", Left, |row: &Timing| row.asked.clone()),
            column!("threads", Right, |row| row.threads.to_string()),
            column!("triangles", Right, |row| row.triangles.to_string()),
            column!("load s", Right, |row| phase(row, "load")),
            column!("setup s", Right, |row| phase(row, "setup")),
            column!("Mtri/s/core", Right, |row| number(Some(row.setup_mtri_per_s), 2)),
            column!("coverage s", Right, |row| phase(row, "coverage")),
            column!("Gfrag/s/core", Right, |row| number(Some(row.coverage_gfrag_per_s), 3)),
        ],
        &fronts,
    );
    let machine = table(
        &[
            column!("machine: threads", Right, |c: &Constants| c.threads.to_string()),
            column!("exchange ns", Right, |c| number(Some(c.exchange_ns), 1)),
            column!("locked pair ns", Right, |c| number(Some(c.locked_pair_ns), 1)),
            column!("max ns", Right, |c| number(Some(c.compare_exchange_max_ns), 1)),
            column!("add ns", Right, |c| number(Some(c.add_ns), 1)),
            column!("cache GB/s", Right, |c| number(Some(c.cache_gb_per_s), 1)),
            column!("read GB/s", Right, |c| number(Some(c.read_gb_per_s), 1)),
            column!("write GB/s", Right, |c| number(Some(c.write_gb_per_s), 1)),
        ],
        machine,
    );
    let means: String = means.iter().map(Mean::line).collect();
    let parts = [main, front, machine, means];
    let parts: Vec<&str> = parts.iter().map(String::as_str).filter(|p| !p.is_empty()).collect();
    parts.join("\n")
}

/// The spread of ratios, or why there is none.
fn beside(row: &Timing) -> String {
    match (&row.unsupported, row.ratio_spread) {
        (Some(why), _) => format!("unsupported: {why}"),
        (_, Some([low, high])) => format!("{low:.2}-{high:.2}"),
        _ => String::new(),
    }
}

/// What culling does to the time.
fn culled(row: &Timing) -> String {
    let (Some(intervals), Some(ratio)) = (row.cull_intervals, row.cull_ratio) else {
        return String::new();
    };
    let passes = row.phase("culling");
    let verdict = if ratio > 1.0 { "costs more than it saves" } else { "saves" };
    format!("{intervals} intervals, {passes:.4} s: {ratio:.2} times as long, {verdict}")
}

/// Columns that come first in CSV; the others follow in the order of their names.
const FIRST: [&str; 7] = ["method", "scene", "asked", "exec", "threads", "fragments", "triangles"];

/// Rows as CSV: one line each, with a cell for every field that any row has. Fields of fields are called `a.b`.
///
/// # Errors
/// A value that JSON cannot hold.
pub(super) fn csv<T: Serialize>(rows: &[T]) -> Result<String> {
    let mut flat = Vec::new();
    for row in rows {
        let value = serde_json::to_value(row);
        let value = value.map_err(|error| Error::new("--csv", error.to_string()))?;
        let mut cells = Vec::new();
        flatten("", &value, &mut cells);
        flat.push(cells);
    }
    let names: BTreeSet<&String> = flat.iter().flatten().map(|(name, _)| name).collect();
    let is_first = |name: &str| FIRST.contains(&name);
    let first = FIRST.iter().copied().filter(|&name| names.iter().any(|known| *known == name));
    let rest = names.iter().map(|name| name.as_str()).filter(|name| !is_first(name));
    let names: Vec<&str> = first.chain(rest).collect();
    let line = |cells: &Vec<(String, String)>| {
        let cell = |name: &&str| {
            let found = cells.iter().find(|(known, _)| known == name);
            found.map_or(String::new(), |(_, text)| text.clone())
        };
        names.iter().map(cell).collect()
    };
    let lines: Vec<Vec<String>> = flat.iter().map(line).collect();
    Ok(grid::csv(names.iter().copied(), &lines))
}

fn flatten(name: &str, value: &Value, cells: &mut Vec<(String, String)>) {
    let inside = |key: &str| if name.is_empty() { key.to_owned() } else { format!("{name}.{key}") };
    match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(key, value)| flatten(&inside(key), value, cells));
        }
        Value::Array(values) => {
            let numbered = values.iter().enumerate();
            numbered.for_each(|(i, value)| flatten(&inside(&i.to_string()), value, cells));
        }
        Value::Null => cells.push((name.to_owned(), String::new())),
        Value::String(text) => cells.push((name.to_owned(), text.clone())),
        other => cells.push((name.to_owned(), other.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Timing {
        Timing {
            method: "ab-ll".to_owned(),
            asked: "layers:count=2,alpha=0.5".to_owned(),
            threads: 2,
            seconds: [("draw".to_owned(), 0.5)].into(),
            ..Timing::default()
        }
    }

    #[test]
    fn columns_without_cells_are_left_out() {
        let plain = tables(&[row()], &[], &[]);
        assert!(plain.starts_with("method"), "{plain}");
        for heading in ["adapter", "parts", "ratio", "MiB", "limit", "Mops/s", "culling", "hash"] {
            assert!(!plain.contains(heading), "{heading}: {plain}");
        }
        let beside = Timing {
            adapter: Some("llvmpipe".to_owned()),
            ratio: Some(2.0),
            ratio_spread: Some([1.5, 2.5]),
            parts: Some(3),
            ..row()
        };
        let text = tables(&[row(), beside], &[], &[]);
        for word in ["adapter", "llvmpipe", "parts", "2.00", "1.50-2.50"] {
            assert!(text.contains(word), "{word}: {text}");
        }
    }

    #[test]
    fn every_line_of_csv_has_a_cell_for_every_field_of_any_row() {
        let spread = Timing { ratio_spread: Some([1.5, 2.5]), method: "kb".to_owned(), ..row() };
        let text = csv(&[row(), spread]).expect("plain values");
        let lines: Vec<&str> = text.lines().collect();
        let [names, first, second] = &lines[..] else { panic!("{text}") };
        assert!(
            names.starts_with("method,scene,asked,exec,threads,fragments,triangles,"),
            "{names}"
        );
        assert!(first.starts_with("ab-ll,,\"layers:count=2,alpha=0.5\",,2,0,0,"), "{first}");
        for name in ["seconds.draw", "ratio_spread.0", "ratio_spread.1", "limit_ratio"] {
            assert_eq!(names.split(',').filter(|known| *known == name).count(), 1, "{name}");
        }
        // The quoted cell has one comma of its own.
        let cells = |line: &str| line.split(',').count();
        assert_eq!([cells(first), cells(second)], [cells(names) + 1; 2]);
    }
}
