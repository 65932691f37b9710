//! One pixel for people: its fragments with what became of them, the methods' colours, and merged records.

use super::text::{Align, columns};
use crate::inspect::{Became, Fate, Inspected, Inspection};

/// The whole text: the same content as the JSON document, but for the absorbance.
#[must_use]
pub fn inspection(found: &Inspection) -> String {
    let [x, y] = found.pixel;
    let count = match found.fragments.len() {
        1 => "1 fragment".to_owned(),
        n => format!("{n} fragments"),
    };
    let mut text = format!(
        "{} at {}x{}, pixel {x},{y}: {count}, depth words {}\n",
        found.scene,
        found.width,
        found.height,
        found.depth_format.name()
    );
    if !found.fragments.is_empty() {
        text += &format!("\n{}", fragments(found));
    }
    text += &format!("\n{}", methods(found));
    for method in found.methods.iter().filter(|method| !method.records.is_empty()) {
        text += &format!("\nrecords of {}\n{}", method.title(), records(method));
    }
    for method in found.methods.iter().filter(|method| !method.extra.is_empty()) {
        text +=
            &format!("\nnot generated, but in the list of {}\n{}", method.title(), extra(method));
    }
    let notes = notes(found);
    if !notes.is_empty() {
        text += &format!("\n{notes}");
    }
    text
}

fn cells<const N: usize>(heading: [&str; N]) -> Vec<String> {
    heading.map(str::to_owned).to_vec()
}

/// In world units.
fn distance(z: f64) -> String {
    format!("{z:.6}")
}

fn fragments(found: &Inspection) -> String {
    let mut heading = cells(["#", "object", "triangle", "depth", "distance", "r", "g", "b", "a"]);
    heading.push("opacity".to_owned());
    heading.extend(found.methods.iter().map(Inspected::title));
    let mut rows = vec![heading];
    for fragment in &found.fragments {
        let mut row = vec![
            fragment.index.to_string(),
            fragment.object.clone().unwrap_or_else(|| "-".to_owned()),
            fragment.triangle.to_string(),
            fragment.depth.to_string(),
            distance(fragment.distance),
        ];
        row.extend(fragment.rgba.map(|channel| channel.to_string()));
        row.push(format!("{:.4}", f64::from(fragment.rgba[3]) / 255.0));
        row.extend(found.methods.iter().map(|method| fate(&method.fates[fragment.index], method)));
        rows.push(row);
    }
    let mut aligned = vec![Align::Right; 10];
    aligned[1] = Align::Left;
    aligned.resize(10 + found.methods.len(), Align::Left);
    columns(&aligned, &rows)
}

/// A fate in a cell: with its record, `?` if that is not known.
fn fate(fate: &Fate, method: &Inspected) -> String {
    let name = fate.fate.name();
    match (fate.fate, fate.record, &fate.reason) {
        (Became::Dropped, _, Some(reason)) => format!("{name}: {reason}"),
        (_, Some(record), None) => format!("{name} {record}"),
        (_, Some(record), Some(_)) => format!("{name} {record}?"),
        (Became::Merged, None, _) if !method.records.is_empty() => format!("{name} ?"),
        _ => name.to_owned(),
    }
}

fn methods(found: &Inspection) -> String {
    let mut rows = vec![cells(["method", "r", "g", "b", "by at most", "absorbed", "fates"])];
    let row = |name: String, color: [u8; 4], difference: String, absorbed: f64, fates: String| {
        let mut row = vec![name];
        row.extend(color[..3].iter().map(ToString::to_string));
        row.extend([difference, format!("{absorbed:.6}"), fates]);
        row
    };
    let exact = &found.exact;
    let none = String::new;
    rows.push(row("all fragments".to_owned(), exact.color, none(), exact.absorbed, none()));
    for method in &found.methods {
        let difference = method.difference.to_string();
        let sums = sums(method);
        rows.push(row(method.title(), method.color, difference, method.absorbed, sums));
    }
    let mut aligned = [Align::Right; 7];
    aligned[0] = Align::Left;
    aligned[6] = Align::Left;
    columns(&aligned, &rows)
}

/// `3 kept, 2 evicted`.
fn sums(method: &Inspected) -> String {
    let mut names: Vec<Became> = method.fates.iter().map(|fate| fate.fate).collect();
    names.sort_unstable();
    let sum = |run: &[Became]| format!("{} {}", run.len(), run[0].name());
    names.chunk_by(|a, b| a == b).map(sum).collect::<Vec<_>>().join(", ")
}

fn records(method: &Inspected) -> String {
    let mut rows =
        vec![cells(["#", "depth", "distance", "thickness", "r", "g", "b", "opacity", "weight"])];
    for (place, record) in method.records.iter().enumerate() {
        let mut row = vec![
            place.to_string(),
            record.depth.to_string(),
            distance(record.distance),
            distance(record.thickness),
        ];
        row.extend(record.rgba.map(|channel| format!("{channel:.6}")));
        row.push(record.weight.to_string());
        rows.push(row);
    }
    columns(&[Align::Right; 9], &rows)
}

fn extra(method: &Inspected) -> String {
    let mut rows = vec![cells(["", "depth", "distance", "data"])];
    for entry in &method.extra {
        let data = format!("{:08x}", entry.data);
        rows.push(vec![entry.what.into(), entry.depth.to_string(), distance(entry.distance), data]);
    }
    columns(&[Align::Left, Align::Right, Align::Right, Align::Right], &rows)
}

/// What is known of fates besides their names, once for each method.
fn notes(found: &Inspection) -> String {
    let mut notes: Vec<String> = Vec::new();
    for method in &found.methods {
        for fate in &method.fates {
            let Some(reason) = &fate.reason else { continue };
            let record = fate.record.map_or_else(String::new, |record| format!(" {record}"));
            let name = fate.fate.name();
            let note = format!("{}, {name}{record}: {reason}\n", method.title());
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    notes.concat()
}
