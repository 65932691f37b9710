//! A report: a line of JSON that says what was run, then a line for every row as it finishes, and before the first row of
//! a method one for what the checker expects of it. So a run that was cut leaves all that it had, and can be resumed. `fragloom crosscheck --tabulate` makes a page of several.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::asked::Settings;
use crate::error::{Error, Result};
use crate::exec::clock::today;
use crate::explore::Prediction;
use crate::gpu::check::crosscheck::Agreement;
use crate::report::files;

/// The format of reports.
const FORMAT: u32 = 1;

/// A report's first line; a resumed one has another for each time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Header {
    /// The format.
    report: u32,
    /// The version of this program.
    pub(super) fragloom: String,
    /// The date in Greenwich.
    pub(super) date: String,
    /// What rows depend on.
    settings: Settings,
}

impl Header {
    /// Of a run that begins now.
    pub(super) fn new(settings: Settings) -> Self {
        let fragloom = env!("CARGO_PKG_VERSION").to_owned();
        Self { report: FORMAT, fragloom, date: today(), settings }
    }
}

/// What the checker expects of a method.
#[derive(Serialize, Deserialize)]
struct Expected {
    expected_of: String,
    #[serde(flatten)]
    prediction: Prediction,
}

/// A line of a report.
#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Header(Header),
    Expected(Expected),
    Row(Box<Agreement>),
}

/// The rows of a report, each with the header that it stands under.
pub(super) fn read(option: &str, path: &Path) -> Result<Vec<(Header, Agreement)>> {
    let place = || format!("{option}: {}", path.display());
    let text = std::fs::read_to_string(path)
        .map_err(|error| Error::new(place(), format!("cannot be read: {error}")))?;
    let mut rows = Vec::new();
    let mut header: Option<Header> = None;
    let mut expected: BTreeMap<String, Prediction> = BTreeMap::new();
    for (number, line) in text.lines().enumerate() {
        let wrong = |problem: &str| Error::new(place(), format!("line {}: {problem}", number + 1));
        match (serde_json::from_str(line), &header) {
            (Ok(Line::Header(found)), _) if found.report != FORMAT => {
                return Err(wrong(&format!("format {}, and must be {FORMAT}", found.report)));
            }
            (Ok(Line::Header(found)), _) => header = Some(found),
            (Ok(_), None) => return Err(wrong("a row before the first header")),
            (Ok(Line::Expected(of)), _) => drop(expected.insert(of.expected_of, of.prediction)),
            (Ok(Line::Row(row)), Some(header)) => {
                let expected = expected.get(&row.method).cloned();
                rows.push((header.clone(), Agreement { expected, ..*row }));
            }
            // A run that was cut while it wrote leaves half a line.
            (Err(_), Some(_)) if number + 1 == text.lines().count() && !text.ends_with('\n') => {}
            (Err(error), _) => {
                let problem = format!("must be a line of `crosscheck --report`: {error}");
                return Err(wrong(&problem));
            }
        }
    }
    if header.is_none() {
        return Err(Error::new(place(), "is empty, and must be a report of `crosscheck --report`"));
    }
    Ok(rows)
}

/// A report that is being written.
pub(super) struct Report {
    place: String,
    file: File,
    /// Rows that were there before.
    known: Vec<Agreement>,
    /// Methods of which it says what is expected.
    expected: BTreeSet<String>,
}

impl Report {
    /// A new one. A file that is there already is replaced.
    ///
    /// # Errors
    /// It cannot be written.
    pub(super) fn new(path: &Path, settings: Settings) -> Result<Self> {
        files::check_output("--report", path)?;
        Self::begin("--report", path, Vec::new(), &Header::new(settings))
    }

    /// One that goes on: its rows are not run again.
    ///
    /// # Errors
    /// It cannot be read or written, or was made with other settings.
    pub(super) fn resume(path: &Path, settings: Settings) -> Result<Self> {
        let known = read("--resume", path)?;
        let own = Header::new(settings);
        for (header, _) in &known {
            if header.settings != own.settings || header.fragloom != own.fragloom {
                let told = |header: &Header| {
                    let settings = serde_json::to_string(&header.settings).unwrap_or_default();
                    format!("{} {settings}", header.fragloom)
                };
                let problem =
                    format!("was made with {}, and not with {}", told(header), told(&own));
                return Err(Error::new(format!("--resume: {}", path.display()), problem));
            }
        }
        Self::begin("--resume", path, known, &own)
    }

    fn begin(
        option: &str,
        path: &Path,
        known: Vec<(Header, Agreement)>,
        own: &Header,
    ) -> Result<Self> {
        let place = format!("{option}: {}", path.display());
        let problem = |error: std::io::Error| {
            Error::new(place.clone(), format!("cannot be written: {error}"))
        };
        // Beside and renamed: half a line at the end of the old file goes away, and nothing else.
        let mut text = String::new();
        let mut expected = BTreeSet::new();
        let mut last: Option<&Header> = None;
        for (header, row) in &known {
            if last != Some(header) {
                text += &line(header);
                last = Some(header);
            }
            text += &lines(row, &mut expected);
        }
        if last != Some(own) {
            text += &line(own);
        }
        files::write_bytes(path, text.as_bytes())?;
        let file = OpenOptions::new().append(true).open(path).map_err(problem)?;
        let known = known.into_iter().map(|(_, row)| row).collect();
        Ok(Self { place, file, known, expected })
    }

    /// The row that this one stands for, if the report had it.
    pub(super) fn find(&self, row: &Agreement) -> Option<&Agreement> {
        let place = |row: &Agreement| {
            let Agreement { adapter, driver, method, asked, .. } = row.clone();
            (adapter, driver, method, asked, row.size, row.path)
        };
        self.known.iter().find(|known| place(known) == place(row))
    }

    /// Write a row.
    ///
    /// # Errors
    /// It cannot be written.
    pub(super) fn add(&mut self, row: &Agreement) -> Result<()> {
        let text = lines(row, &mut self.expected);
        let written = self.file.write_all(text.as_bytes()).and_then(|()| self.file.flush());
        written
            .map_err(|error| Error::new(self.place.clone(), format!("cannot be written: {error}")))
    }
}

/// A row, and what is expected of its method, unless that was said.
fn lines(row: &Agreement, said: &mut BTreeSet<String>) -> String {
    let mut text = String::new();
    if let Some(prediction) = row.expected.clone().filter(|_| said.insert(row.method.clone())) {
        text += &line(&Expected { expected_of: row.method.clone(), prediction });
    }
    text + &line(&Agreement { expected: None, ..row.clone() })
}

fn line(value: &impl Serialize) -> String {
    let mut text = serde_json::to_string(value).unwrap_or_default();
    text.push('\n');
    text
}
