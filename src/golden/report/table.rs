//! A report for people.

use super::{Report, Status};
use crate::report::text::{Align, columns, thousands};

/// The statuses as they are counted.
const COUNTED: [(Status, &str); 7] = [
    (Status::Same, "same"),
    (Status::Blessed, "blessed"),
    (Status::InputChanged, "with changed files"),
    (Status::ProgramChanged, "of another version"),
    (Status::Different, "different"),
    (Status::Missing, "missing"),
    (Status::Error, "in error"),
];

/// A line for every entry that is not as recorded, those that were not run, and how many there are of each kind.
#[must_use]
pub fn table(report: &Report) -> String {
    let told = report.outcomes.iter().filter(|outcome| outcome.status != Status::Same);
    let mut rows: Vec<Vec<String>> =
        told.map(|o| vec![o.name.clone(), o.status.name().to_owned(), o.why.clone()]).collect();
    rows.extend(report.not_run.iter().map(|name| vec![name.clone(), "not run".to_owned()]));
    let mut text = columns(&[Align::Left; 3], &rows);
    if !rows.is_empty() {
        text.push('\n');
    }
    let mut counts: Vec<String> = COUNTED
        .iter()
        .map(|(status, word)| (report.count(*status), word))
        .filter(|(count, _)| *count > 0)
        .map(|(count, word)| format!("{} {word}", thousands(count as u64)))
        .collect();
    if !report.not_run.is_empty() {
        counts.push(format!("{} not run", thousands(report.not_run.len() as u64)));
    }
    let entries = match report.entries.len() {
        1 => "1 entry".to_owned(),
        all => format!("{} entries", thousands(all as u64)),
    };
    let counts = if counts.is_empty() { "none chosen".to_owned() } else { counts.join(", ") };
    text + &format!("{}: {entries}: {counts}\n", report.manifest)
}

#[cfg(test)]
mod tests {
    use super::super::{Outcome, junit};
    use super::*;

    fn report() -> Report {
        let outcomes = vec![
            Outcome::new("a", Status::Same, ""),
            Outcome::new("b", Status::Different, "3 of 9 pixels <differ> & \"more\""),
            Outcome::new("c", Status::Error, "no such method"),
        ];
        Report {
            format: 1,
            program: "1".to_owned(),
            manifest: "golden.toml".to_owned(),
            manifest_sha256: "x".to_owned(),
            entries: ["a", "b", "c", "d"].map(str::to_owned).to_vec(),
            filter: None,
            partition: None,
            outcomes,
            not_run: vec!["d".to_owned()],
        }
    }

    #[test]
    fn what_is_not_the_same_has_a_line() {
        let text = table(&report());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "b  different  3 of 9 pixels <differ> & \"more\"");
        assert_eq!(lines[1], "c  error      no such method");
        assert_eq!(lines[2], "d  not run");
        let last = "golden.toml: 4 entries: 1 same, 1 different, 1 in error, 1 not run";
        assert_eq!(lines[3..], ["", last]);
        let clean = Report { outcomes: Vec::new(), not_run: Vec::new(), ..report() };
        assert_eq!(table(&clean), "golden.toml: 4 entries: none chosen\n");
    }

    #[test]
    fn a_report_is_read_as_it_was_written() {
        let text = crate::report::json::document(&report()).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report());
        assert!(
            serde_json::from_str::<Report>(&text.replace("\"different\"", "\"other\"")).is_err()
        );
    }

    #[test]
    fn junit_has_a_case_for_every_entry() {
        let text = junit(&report()).unwrap();
        let read = quick_junit::Report::deserialize_from_str(&text).unwrap();
        let suite = &read.test_suites[0];
        assert_eq!((suite.tests, suite.failures, suite.errors, suite.skipped), (4, 1, 1, 1));
        let names: Vec<&str> = suite.test_cases.iter().map(|case| case.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c", "d"]);
        let quick_junit::TestCaseStatus::NonSuccess { message, .. } = &suite.test_cases[1].status
        else {
            panic!("a failure");
        };
        assert_eq!(
            message.as_ref().map(quick_junit::XmlString::as_str),
            Some("3 of 9 pixels <differ> & \"more\"")
        );
    }
}
