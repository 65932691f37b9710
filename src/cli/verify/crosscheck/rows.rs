//! The rows of a cross-check, as they finish: what the checker expects is put beside each, it is printed, and written
//! to the report.

use std::collections::BTreeMap;

use super::report::Report;
use super::table::Table;
use crate::cli::terminal::{say, wait};
use crate::error::Result;
use crate::explore::{Prediction, Subject, predict};
use crate::gpu::check::crosscheck::Agreement;
use crate::gpu::twin::source::Twin;

/// All rows so far.
pub(super) struct Rows<'a> {
    pub(super) all: Vec<Agreement>,
    /// How many there will be.
    planned: usize,
    /// By the twin's name.
    expected: BTreeMap<String, Prediction>,
    report: Option<&'a mut Report>,
    table: Option<Table>,
    quiet: bool,
}

impl<'a> Rows<'a> {
    /// None yet, or those of a report that is resumed.
    ///
    /// # Errors
    /// stdout cannot be written.
    pub(super) fn new(
        planned: usize,
        report: Option<&'a mut Report>,
        table: Option<Table>,
        quiet: bool,
    ) -> Result<Self> {
        if let Some(table) = &table {
            say::result(&table.heading())?;
        }
        let all = Vec::new();
        Ok(Self { all, planned, expected: BTreeMap::new(), report, table, quiet })
    }

    /// Take the row that this one stands for from the report that is resumed, if it is there. Whether it was.
    pub(super) fn take_known(&mut self, row: &Agreement) -> bool {
        let known = self.report.as_ref().and_then(|report| report.find(row)).cloned();
        self.all.extend(known.clone());
        known.is_some()
    }

    /// Ask the checker about a twin, once.
    ///
    /// # Errors
    /// The method cannot be explored.
    pub(super) fn ask(&mut self, twin: Twin) -> Result<()> {
        let name = twin.name();
        if !self.expected.contains_key(&name) {
            let subject = Subject::new(twin.method)?;
            let message = format!("asking the checker about {name}");
            let found = wait::during(self.quiet, &message, || predict(&subject, twin.profile()));
            self.expected.insert(name, found);
        }
        Ok(())
    }

    /// The row that is being worked on, in words.
    pub(super) fn doing(&self, row: &Agreement) -> String {
        let Agreement { adapter, method, asked, path, .. } = row;
        let number = self.all.len() + 1;
        format!("row {number} of {}: {method} on {asked}, {path} path, {adapter}", self.planned)
    }

    /// A row has finished.
    ///
    /// # Errors
    /// It cannot be printed or written.
    pub(super) fn add(&mut self, row: Agreement) -> Result<()> {
        let row = match self.expected.get(row.method.as_str()) {
            Some(prediction) => row.against(prediction),
            None => row,
        };
        if let Some(report) = &mut self.report {
            report.add(&row)?;
        }
        self.all.push(row);
        if let (Some(table), Some(row)) = (&self.table, self.all.last()) {
            say::result(&table.line(self.all.len(), self.planned, row))?;
        }
        Ok(())
    }

    /// What the checker expects, by method.
    pub(super) fn expected(&self) -> impl Iterator<Item = (&str, &Prediction)> {
        self.expected.iter().map(|(name, prediction)| (name.as_str(), prediction))
    }
}
