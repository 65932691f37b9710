//! `fragloom crosscheck --tabulate`: what reports say, as a page: which devices, and for each twin what the checker
//! expects of it beside what each device showed.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

use super::report;
use crate::cli::Verdict;
use crate::cli::terminal::say;
use crate::error::Result;
use crate::explore::{Expects, Prediction};
use crate::gpu::check::crosscheck::{Agreement, Path, Status};
use crate::report::text::thousands;

/// What comes before the tables.
const HEAD: &str = "\
# What devices showed

<!-- Written by `fragloom crosscheck --tabulate`: change the reports, not this page. -->

The same schemes, as twins in WGSL, on devices. *Expected* is computed: what `fragloom check` says of the method where \
every atomic is relaxed, as WGSL has it, with at most so many fragments. *Equal* is bit for bit: which triangles cover a \
pixel, depths, lists and colours.

To add a device: `fragloom crosscheck --report FILE`, and send the file.
";

/// A device, as a report names it.
type Device = (String, String);

/// Print the page.
///
/// # Errors
/// A report cannot be read.
pub(super) fn run(paths: &[PathBuf]) -> Result<Verdict> {
    let mut rows = Vec::new();
    for path in paths {
        rows.extend(report::read("--tabulate", path)?);
    }
    say::result(&page(&rows))?;
    Ok(Verdict::Clean)
}

fn page(rows: &[(report::Header, Agreement)]) -> String {
    let mut text = HEAD.to_owned();
    let mut devices: Vec<Device> = Vec::new();
    for (_, row) in rows {
        let device = (row.adapter.clone(), row.driver.clone());
        if !devices.contains(&device) {
            devices.push(device);
        }
    }
    text += "\n## Devices\n\n";
    text += "| | device | driver | fragloom | date | rows | fragments compared | of methods that must be equal | differences there |\n";
    text += "|---|---|---|---|---|---|---|---|---|\n";
    for (number, device) in devices.iter().enumerate() {
        let own: Vec<&(report::Header, Agreement)> =
            rows.iter().filter(|(_, row)| is_of(row, device)).collect();
        let list = |of: &dyn Fn(&report::Header) -> &String| {
            let mut all: Vec<&str> = own.iter().map(|(header, _)| of(header).as_str()).collect();
            all.sort_unstable();
            all.dedup();
            all.join(", ")
        };
        let [versions, dates] = [list(&|header| &header.fragloom), list(&|header| &header.date)];
        let sum = |must: bool, of: &dyn Fn(&Agreement) -> u64| -> u64 {
            let own = own.iter().filter(|(_, row)| !must || must_be_equal(row));
            own.map(|(_, row)| of(row)).sum()
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {versions} | {dates} | {} | {} | {} | {} |",
            letter(number),
            device.0,
            device.1,
            own.len(),
            thousands(sum(false, &|row| row.differences.fragments)),
            thousands(sum(true, &|row| row.differences.fragments)),
            thousands(sum(true, &differing)),
        );
    }
    text += "\n## Expected and observed\n\n";
    text += "`=` equal, with the fragments compared; `≠` the fragments that differ, of all, and in how many rows.\n\n";
    text += "| method | expected | steps |";
    let columns: Vec<(usize, Path)> = (0..devices.len())
        .flat_map(|device| [Path::Compute, Path::Raster].map(|path| (device, path)))
        .filter(|&(device, path)| {
            rows.iter().any(|(_, row)| row.path == path && is_of(row, &devices[device]))
        })
        .collect();
    columns.iter().for_each(|&(device, path)| {
        let _ = write!(text, " {} {path} |", letter(device));
    });
    text += "\n|---|---|---|";
    text += &"---|".repeat(columns.len());
    text.push('\n');
    let mut methods: BTreeMap<&str, Option<&Prediction>> = BTreeMap::new();
    for (_, row) in rows {
        let known = methods.entry(&row.method).or_default();
        *known = row.expected.as_ref().or(*known);
    }
    for (method, prediction) in &methods {
        let (expected, steps) = expected(*prediction);
        let _ = write!(text, "| `{method}` | {expected} | {steps} |");
        for &(device, path) in &columns {
            let own = rows.iter().map(|(_, row)| row);
            let own = own.filter(|row| row.method == *method && row.path == path);
            let own: Vec<&Agreement> = own.filter(|row| is_of(row, &devices[device])).collect();
            let _ = write!(text, " {} |", cell(&own));
        }
        text.push('\n');
    }
    text += "\n## The shortest ways to a difference\n\n";
    text += "`fragloom replay TOKEN --trace` shows each step.\n\n";
    text += "| method | what | token |\n|---|---|---|\n";
    for (method, prediction) in &methods {
        if let Some(Prediction { token: Some(token), message, .. }) = prediction {
            let _ = writeln!(text, "| `{method}` | {message} | `{token}` |");
        }
    }
    text
}

fn is_of(row: &Agreement, (adapter, driver): &Device) -> bool {
    row.adapter == *adapter && row.driver == *driver
}

fn must_be_equal(row: &Agreement) -> bool {
    row.expected.as_ref().is_some_and(|expected| expected.expects == Expects::Equal)
}

/// A device's name in the table.
fn letter(number: usize) -> char {
    char::from(b'A' + (number % 26) as u8)
}

/// Fragments that are missing, wrong or too many.
fn differing(row: &Agreement) -> u64 {
    let sum = &row.differences;
    (sum.coverage_differences + sum.depth_differences).max(sum.list_differences)
}

fn expected(prediction: Option<&Prediction>) -> (String, String) {
    let Some(prediction) = prediction else { return Default::default() };
    let says = prediction.expects.says();
    let steps = if prediction.token.is_some() { prediction.steps.to_string() } else { "".into() };
    (format!("{says} (n <= {})", prediction.fragments), steps)
}

/// What a device showed of a method on a path.
fn cell(rows: &[&Agreement]) -> String {
    let with = |status| rows.iter().filter(|row| row.status == status).count();
    let mut told = Vec::new();
    let compared: Vec<&&Agreement> = rows.iter().filter(|row| row.is_compared()).collect();
    let fragments = thousands(compared.iter().map(|row| row.differences.fragments).sum());
    let different = with(Status::Different);
    if different > 0 {
        let wrong = thousands(compared.iter().map(|row| differing(row)).sum());
        told.push(format!("≠ {wrong} of {fragments}, {different}/{}", compared.len()));
    } else if !compared.is_empty() {
        told.push(format!("= {fragments}"));
    }
    for status in [Status::Failed, Status::Hung, Status::Lost] {
        match with(status) {
            0 => {}
            n => told.push(format!("**{status}** {n}/{}", rows.len())),
        }
    }
    if told.is_empty() && with(Status::Unsupported) > 0 {
        told.push("unsupported".to_owned());
    }
    if compared.iter().any(|row| row.is_finding) {
        told.push("**not expected**".to_owned());
    }
    told.join("; ")
}
