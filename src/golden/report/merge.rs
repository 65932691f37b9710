//! One report of several parts.

use super::{Outcome, Report};
use crate::error::{Error, Result};

/// Join reports of parts of one manifest, each with the name that errors call it. What no part has run is among
/// `not_run`; of an entry that several have run, the worst outcome counts.
///
/// # Errors
/// No report, or reports of different manifests or programs.
pub fn merge(parts: &[(String, Report)]) -> Result<Report> {
    let Some((first, whole)) = parts.first() else {
        return Err(Error::new("REPORT", "at least one is needed"));
    };
    for (name, part) in parts {
        let same = |own: &str, its: &str, what: &str| match own == its {
            true => Ok(()),
            false => Err(Error::new(name, format!("has another {what} than {first}"))),
        };
        same(&whole.manifest_sha256, &part.manifest_sha256, "manifest")?;
        same(&whole.program, &part.program, "program version")?;
        let stranger = part.outcomes.iter().find(|outcome| !part.entries.contains(&outcome.name));
        if let Some(Outcome { name: entry, .. }) = stranger {
            return Err(Error::new(name, format!("outcomes: {entry:?} is not among its entries")));
        }
    }
    let worst = |name: &String| {
        let all = parts.iter().flat_map(|(_, part)| &part.outcomes);
        let mut own: Vec<&Outcome> = all.filter(|outcome| outcome.name == *name).collect();
        own.sort_by_key(|outcome| outcome.status);
        own.pop().cloned()
    };
    let outcomes: Vec<Outcome> = whole.entries.iter().filter_map(worst).collect();
    let run = |name: &&String| outcomes.iter().any(|outcome| outcome.name == **name);
    let not_run = whole.entries.iter().filter(|name| !run(name)).cloned().collect();
    Ok(Report { filter: None, partition: None, outcomes, not_run, ..whole.clone() })
}

#[cfg(test)]
mod tests {
    use super::super::Status;
    use super::*;

    fn report(outcomes: &[(&str, Status)]) -> Report {
        let outcome = |(name, status): &(&str, Status)| Outcome::new(name, *status, "");
        Report {
            format: 1,
            program: "1".to_owned(),
            manifest: "golden.toml".to_owned(),
            manifest_sha256: "x".to_owned(),
            entries: ["a", "b", "c"].map(str::to_owned).to_vec(),
            filter: None,
            partition: Some("hash:1/2".to_owned()),
            outcomes: outcomes.iter().map(outcome).collect(),
            not_run: Vec::new(),
        }
    }

    fn merged(parts: &[Report]) -> Result<Report> {
        let named = (1..).zip(parts).map(|(i, part)| (format!("{i}.json"), part.clone()));
        merge(&named.collect::<Vec<_>>())
    }

    #[test]
    fn what_no_part_has_run_is_said() {
        let parts = [report(&[("c", Status::Same)]), report(&[("a", Status::Same)])];
        let whole = merged(&parts).unwrap();
        let names: Vec<&str> = whole.outcomes.iter().map(|o| o.name.as_str()).collect();
        assert_eq!((names, &whole.not_run[..]), (vec!["a", "c"], &["b".to_owned()][..]));
        assert!(!whole.is_clean() && whole.partition.is_none());
        let rest = report(&[("b", Status::Same)]);
        assert!(merged(&[parts[0].clone(), parts[1].clone(), rest]).unwrap().is_clean());
    }

    #[test]
    fn of_several_outcomes_the_worst_counts() {
        let [same, other] = [Status::Same, Status::Different].map(|s| report(&[("a", s)]));
        for parts in [[same.clone(), other.clone()], [other, same]] {
            let whole = merged(&parts).unwrap();
            assert_eq!((whole.outcomes.len(), whole.outcomes[0].status), (1, Status::Different));
        }
    }

    #[test]
    fn parts_must_belong_together() {
        let good = report(&[]);
        let other = Report { manifest_sha256: "y".to_owned(), ..good.clone() };
        let newer = Report { program: "2".to_owned(), ..good.clone() };
        for (bad, word) in
            [(other, "manifest"), (newer, "program"), (report(&[("z", Status::Same)]), "\"z\"")]
        {
            let error = merged(&[good.clone(), bad]).unwrap_err();
            assert!(error.place() == "2.json" && error.problem().contains(word), "{error}");
        }
        assert!(merged(&[]).is_err());
    }
}
