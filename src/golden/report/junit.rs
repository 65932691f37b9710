//! A report in JUnit's XML, as CI services read it.

use std::time::Duration;

use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};

use super::{Outcome, Report, Status};
use crate::error::{Error, Result};

/// A test suite with a test for every entry. What is not as recorded is a failure, what cannot be drawn an error, and
/// what was not run is skipped.
///
/// # Errors
/// None that is known of.
pub fn junit(report: &Report) -> Result<String> {
    let mut suite = TestSuite::new(report.manifest.as_str());
    for outcome in &report.outcomes {
        let mut case = TestCase::new(outcome.name.as_str(), status(outcome));
        case.set_classname(report.manifest.as_str());
        // Of a report that was read, it may be any number.
        case.set_time(Duration::try_from_secs_f64(outcome.seconds).unwrap_or_default());
        suite.add_test_case(case);
    }
    for name in &report.not_run {
        let mut case = TestCase::new(name.as_str(), TestCaseStatus::skipped());
        case.set_classname(report.manifest.as_str());
        suite.add_test_case(case);
    }
    let mut all = quick_junit::Report::new("fragloom golden");
    all.add_test_suite(suite);
    all.to_string().map_err(|error| Error::new("--junit", error.to_string()))
}

fn status(outcome: &Outcome) -> TestCaseStatus {
    let kind = match outcome.status {
        Status::Same | Status::Blessed => return TestCaseStatus::success(),
        Status::Error => NonSuccessKind::Error,
        _ => NonSuccessKind::Failure,
    };
    let mut status = TestCaseStatus::non_success(kind);
    status.set_type(outcome.status.name());
    status.set_message(outcome.why.as_str());
    status
}
