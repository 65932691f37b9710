//! The table: a heading, a line for every row as it finishes, and a summary at the end. Rows are printed before the later
//! ones are known, so that columns have the width of what is planned.

use std::collections::BTreeMap;

use super::asked::Subject;
use crate::catalogue::Catalogue;
use crate::explore::{Expects, Prediction};
use crate::gpu::check::compare::Differences;
use crate::gpu::check::crosscheck::{Agreement, Options, Status};
use crate::gpu::driver::device::AdapterName;
use crate::report::text::{Align, columns};

/// A column: its heading, how it is set, and its width.
type Column = (&'static str, Align, usize);

/// Columns of planned widths.
pub(super) struct Table {
    adapters: Vec<String>,
    columns: Vec<Column>,
}

impl Table {
    /// For these rows.
    pub(super) fn new(
        adapters: &[AdapterName],
        options: &Options,
        subjects: &[Subject],
        planned: usize,
    ) -> Self {
        use Align::{Left, Right};
        let adapters: Vec<String> = adapters.iter().map(|one| one.name.clone()).collect();
        let most = |texts: &mut dyn Iterator<Item = usize>| texts.max().unwrap_or(0);
        let adapter = most(&mut adapters.iter().map(|name| short(name, &adapters).len()));
        let method = most(&mut options.twins.iter().map(|twin| twin.name().len()));
        let scene = most(&mut subjects.iter().map(|subject| subject.asked.chars().count()));
        let size = most(&mut subjects.iter().map(|subject| size(subject.size).len()));
        let path = most(&mut options.paths.iter().map(|path| path.to_string().len()));
        let count = planned.to_string().len();
        let columns = vec![
            ("row", Right, 2 * count + 1),
            ("adapter", Left, adapter),
            ("method", Left, method),
            ("scene", Left, scene),
            ("size", Right, size),
            ("path", Left, path),
            ("fragments", Right, 11),
            ("coverage", Right, 8),
            ("depth", Right, 6),
            ("lists", Right, 6),
            ("pixels", Right, 6),
            ("expected", Left, Expects::Loss.says().len()),
            ("status", Left, 0),
        ];
        Self { adapters, columns }
    }

    fn set(&self, cells: &[String]) -> String {
        let mut line = String::new();
        for ((heading, align, width), cell) in self.columns.iter().zip(cells) {
            let width = (*width).max(heading.len());
            line += &match align {
                Align::Left => format!("{cell:<width$}  "),
                Align::Right => format!("{cell:>width$}  "),
            };
        }
        format!("{}\n", line.trim_end())
    }

    /// The first line.
    pub(super) fn heading(&self) -> String {
        let cells: Vec<String> = self.columns.iter().map(|column| column.0.to_owned()).collect();
        self.set(&cells)
    }

    /// A row's line.
    pub(super) fn line(&self, number: usize, planned: usize, row: &Agreement) -> String {
        let sum = &row.differences;
        let by_compute = match row.by_compute {
            0 => String::new(),
            n => format!(" ({n} fragments by compute)"),
        };
        let repeated = match row.repeated {
            0 => String::new(),
            n => format!(" (invocations rerun after waiting for a lock: {n})"),
        };
        let expected = row.expected.as_ref().map_or("", |expected| expected.expects.says());
        self.set(&[
            format!("{number}/{planned}"),
            short(&row.adapter, &self.adapters).to_owned(),
            row.method.clone(),
            row.asked.clone(),
            size(row.size),
            row.path.to_string(),
            sum.fragments.to_string(),
            sum.coverage_differences.to_string(),
            sum.depth_differences.to_string(),
            sum.list_differences.to_string(),
            sum.pixel_differences.to_string(),
            expected.to_owned(),
            status(row.status, &row.reason) + &by_compute + &repeated,
        ])
    }
}

fn size([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

/// A status with its reason.
pub(super) fn status(status: Status, reason: &str) -> String {
    if reason.is_empty() { status.to_string() } else { format!("{status}: {reason}") }
}

/// What the checker expects of methods of which not all must be equal, and how to see it.
pub(super) fn predictions<'a>(all: impl Iterator<Item = (&'a str, &'a Prediction)>) -> String {
    use Align::{Left, Right};
    let heading = ["method", "expected", "steps", "replay"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(all.filter_map(|(method, prediction)| {
        let token = prediction.token.clone()?;
        let says = prediction.expects.says().to_owned();
        Some(vec![method.to_owned(), says, prediction.steps.to_string(), token])
    }));
    if lines.len() == 1 {
        return String::new();
    }
    format!(
        "\nwhat may differ, under relaxed memory as WGSL has it: the shortest ways, for `fragloom replay`\n{}",
        columns(&[Left, Left, Right, Left], &lines)
    )
}

/// A summary of what was compared: by adapter and path, and whether the result may depend on the schedule.
pub(super) fn summary(catalogue: &Catalogue, rows: &[Agreement]) -> String {
    use Align::{Left, Right};
    let heading = [
        "adapter",
        "driver",
        "bits",
        "path",
        "methods",
        "equal",
        "different",
        "unsupported",
        "failed",
        "hung",
        "lost",
        "fragments",
        "coverage",
        "depth",
        "lists",
        "pixels",
        "findings",
    ];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    let group = |row: &Agreement| {
        let method = catalogue.find("-m", row.method.trim_end_matches("/vulkan"));
        let fixed = method.is_ok_and(|method| method.contract().order_independent());
        (row.adapter.clone(), row.driver.clone(), !fixed, row.path)
    };
    let mut groups: BTreeMap<_, Vec<&Agreement>> = BTreeMap::new();
    for row in rows {
        groups.entry(group(row)).or_default().push(row);
    }
    for ((adapter, driver, varies, path), own) in groups {
        // A row that was never drawn knows none.
        let bits = own.iter().map(|row| row.sub_pixel_bits).max().unwrap_or(0);
        let mut sum = Differences::default();
        own.iter().for_each(|row| sum.add(&row.differences));
        let with = |status| own.iter().filter(|row| row.status == status).count().to_string();
        let methods = if varies { "that may vary" } else { "with one result" };
        let mut line =
            vec![adapter, driver, bits.to_string(), path.to_string(), methods.to_owned()];
        line.extend(Status::ALL.map(with));
        let compared = own.iter().any(|row| row.is_compared());
        let findings = own.iter().filter(|row| row.is_finding).count();
        let counts = [
            sum.fragments,
            sum.coverage_differences,
            sum.depth_differences,
            sum.list_differences,
            sum.pixel_differences,
        ];
        line.extend(counts.map(|n| n.to_string()));
        line.push(if compared { findings.to_string() } else { "nothing compared".to_owned() });
        lines.push(line);
    }
    let mut align = vec![Left, Left, Right, Left, Left];
    align.resize(heading.len(), Right);
    format!("\n{}", columns(&align, &lines))
}

/// The first words of an adapter's name that distinguish it from the others: full names are long, and the summary has
/// them.
pub(super) fn short<'a>(name: &'a str, all: &[String]) -> &'a str {
    let ends = name.match_indices(' ').map(|(at, _)| at);
    let is_own = |start: &&str| all.iter().filter(|other| other.starts_with(*start)).count() < 2;
    ends.map(|end| &name[..end]).find(is_own).unwrap_or(name)
}
