//! How a fragment went that is gone, as far as the frame's accounting tells. It counts fragments of the whole frame: if
//! all of them went in one way, so did this one.

use super::found::{Became, Fate};
use crate::render::{Options, Report};

/// What is known of a method's run.
pub(super) struct Facts<'a> {
    pub(super) options: &'a Options,
    pub(super) report: &'a Report,
}

impl Fate {
    pub(super) fn new(fate: Became, reason: Option<&str>) -> Self {
        Self { fate, reason: reason.map(str::to_owned), record: None }
    }

    pub(super) fn kept(record: Option<usize>) -> Self {
        Self { record, ..Self::new(Became::Kept, None) }
    }

    pub(super) fn merged(record: usize) -> Self {
        Self { record: Some(record), ..Self::new(Became::Merged, None) }
    }
}

impl Facts<'_> {
    /// It is gone, and the method does not promise it.
    pub(super) fn rejected(&self, reason: Option<&str>) -> Fate {
        let fate = match (self.report.culled, self.report.evicted) {
            (1.., 0) => Became::Culled,
            (0, 1..) => Became::Evicted,
            _ => Became::NotKept,
        };
        Fate::new(fate, reason)
    }

    /// It is gone, and the method promises it, where it has room.
    pub(super) fn missing(&self) -> Fate {
        let reasons: Vec<&str> = self.report.dropped.keys().map(String::as_str).collect();
        match reasons[..] {
            [] | ["lost"] => Fate::new(Became::Lost, None),
            [reason] => Fate::new(Became::Dropped, Some(reason)),
            _ if !reasons.contains(&"lost") => {
                Fate::new(Became::Dropped, Some(&reasons.join(" or ")))
            }
            _ => unknown(&reasons),
        }
    }

    /// It is gone, and the method does not say what it promises.
    pub(super) fn gone(&self) -> Fate {
        let report = self.report;
        let mut ways: Vec<&str> = report.dropped.keys().map(String::as_str).collect();
        ways.extend((report.culled > 0).then_some("culled"));
        ways.extend((report.evicted > 0).then_some("evicted"));
        match ways[..] {
            ["culled"] | ["evicted"] => self.rejected(None),
            _ if report.culled + report.evicted == 0 => self.missing(),
            _ => unknown(&ways),
        }
    }

    /// Whether no fragment of the frame is gone.
    pub(super) fn all_there(&self) -> bool {
        let report = self.report;
        report.dropped.is_empty() && report.culled == 0 && report.evicted == 0
    }
}

fn unknown(ways: &[&str]) -> Fate {
    let reason = format!("{}: which is not known", ways.join(" or "));
    Fate::new(Became::NotKept, Some(&reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fates(culled: u64, evicted: u64, dropped: &[&str]) -> [Became; 3] {
        let dropped = dropped.iter().map(|&reason| (reason.to_owned(), 1)).collect();
        let report = Report { culled, evicted, dropped, ..Report::default() };
        let facts = Facts { options: &Options::default(), report: &report };
        [facts.rejected(None), facts.missing(), facts.gone()].map(|fate| fate.fate)
    }

    #[test]
    fn one_way_is_told_and_several_are_not() {
        use Became::{Culled, Dropped, Evicted, Lost, NotKept};
        assert_eq!(fates(3, 0, &[]), [Culled, Lost, Culled]);
        assert_eq!(fates(0, 3, &[]), [Evicted, Lost, Evicted]);
        assert_eq!(fates(1, 1, &["lost"]), [NotKept, Lost, NotKept]);
        assert_eq!(fates(0, 0, &["pool"]), [NotKept, Dropped, Dropped]);
        assert_eq!(fates(0, 0, &["age", "pool"]), [NotKept, Dropped, Dropped]);
        assert_eq!(fates(0, 0, &["lost", "pool"]), [NotKept, NotKept, NotKept]);
        assert_eq!(fates(2, 0, &["lost"]), [Culled, Lost, NotKept]);
    }
}
