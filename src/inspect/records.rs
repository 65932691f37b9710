//! Which merged record a fragment went into, as far as it can be told: a record tells its far end, how far it reaches
//! from there towards the eye, and how many fragments it stands for.

use super::found::{Became, Fate, Generated};
use super::gone::Facts;
use crate::scheme::Record;

/// Weights are sums of shares, which were rounded.
const WEIGHT_ERROR: f64 = 1e-6;

/// A record's near end is a difference of distances: it may lie this part of the distance behind the fragment there.
const DISTANCE_ERROR: f64 = 1e-9;

const WHICH: &str = "which record is not known";

/// The fates of `generated`, front to back, in `records`, front to back.
pub(super) fn fates(
    facts: &Facts<'_>,
    generated: &[Generated],
    records: &[Record],
    distance: impl Fn(u32) -> f64,
) -> Vec<Fate> {
    let weight: f64 = records.iter().map(|record| record.weight).sum();
    let whole = (weight - generated.len() as f64).abs() <= WEIGHT_ERROR * generated.len() as f64;
    let mut puzzle = Puzzle { generated, records, fates: vec![None; generated.len()], whole };
    let free = puzzle.alone();
    let free = if whole { puzzle.by_count(free) } else { free };
    puzzle.by_span(&free, facts, distance);
    puzzle.fates.into_iter().map(|fate| fate.unwrap_or_else(|| facts.gone())).collect()
}

struct Puzzle<'a> {
    generated: &'a [Generated],
    records: &'a [Record],
    fates: Vec<Option<Fate>>,
    /// The records stand for all of the fragments.
    whole: bool,
}

impl Puzzle<'_> {
    fn open(&self) -> Vec<usize> {
        (0..self.fates.len()).filter(|&i| self.fates[i].is_none()).collect()
    }

    /// Records that are one fragment each, with its colour. The rest is returned.
    fn alone(&mut self) -> Vec<usize> {
        let mut rest = Vec::new();
        for (place, record) in self.records.iter().enumerate() {
            let is_alone = |i: &usize| {
                let Generated { depth, color, .. } = self.generated[*i];
                let surface = Record::surface(depth, color);
                let thickness = record.thickness;
                *record == Record { thickness, ..surface }
            };
            match self.open().into_iter().find(is_alone) {
                Some(i) => self.fates[i] = Some(Fate::kept(Some(place))),
                None => rest.push(place),
            }
        }
        rest
    }

    /// No fragment of a record lies behind its far end. If just as many fragments lie before that as the record stands
    /// for, and are in no nearer record, they are its own. The rest is returned.
    fn by_count(&mut self, records: Vec<usize>) -> Vec<usize> {
        let mut records = records.into_iter().peekable();
        while let Some(&place) = records.peek() {
            let record = &self.records[place];
            let mut before = self.open();
            before.retain(|&i| self.generated[i].depth <= record.depth);
            if before.len() as f64 != record.weight {
                break;
            }
            before.iter().for_each(|&i| self.fates[i] = Some(Fate::merged(place)));
            records.next();
        }
        records.collect()
    }

    /// By where the other fragments lie.
    fn by_span(&mut self, records: &[usize], facts: &Facts<'_>, distance: impl Fn(u32) -> f64) {
        let reaches = |i: usize, place: usize| {
            let (fragment, record) = (&self.generated[i], &self.records[place]);
            let (own, far) = (distance(fragment.depth), distance(record.depth));
            let near = far - record.thickness - DISTANCE_ERROR * far.abs();
            fragment.depth <= record.depth && own >= near
        };
        let open = self.open();
        let inside = |place: usize| open.iter().filter(|&&i| reaches(i, place)).count();
        let fate = |i: usize| {
            let around: Vec<usize> =
                records.iter().copied().filter(|&place| reaches(i, place)).collect();
            match around[..] {
                [place] if self.whole => Fate::merged(place),
                [place] => {
                    let (count, weight) = (inside(place), self.records[place].weight);
                    let crowded = count as f64 > weight + WEIGHT_ERROR;
                    let reason =
                        format!("one of {count} that lie there; the record stands for {weight}");
                    Fate { reason: crowded.then_some(reason), ..Fate::merged(place) }
                }
                _ if self.whole => Fate::new(Became::Merged, Some(WHICH)),
                [] => facts.gone(),
                _ => Fate::new(Became::Merged, Some(&format!("{WHICH}, if it is in one"))),
            }
        };
        let found: Vec<(usize, Fate)> = open.iter().map(|&i| (i, fate(i))).collect();
        found.into_iter().for_each(|(i, fate)| self.fates[i] = Some(fate));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Options, Report};

    /// Fragments at these depths, which are also their distances; records by far end, thickness and weight.
    fn told(depths: &[u32], records: &[(u32, f64, f64)]) -> Vec<String> {
        let one = |&depth: &u32| Generated { triangle: 0, depth, color: 0x8000_00FF };
        let generated: Vec<Generated> = depths.iter().map(one).collect();
        let rgba = [0.5, 0.0, 0.0, 0.75];
        let record = |&(depth, thickness, weight)| Record { depth, thickness, rgba, weight };
        let records: Vec<Record> = records.iter().map(record).collect();
        let report = Report { evicted: 1, ..Report::default() };
        let facts = Facts { options: &Options::default(), report: &report };
        let fates = fates(&facts, &generated, &records, f64::from);
        let text = |fate: Fate| match fate.record {
            Some(record) if fate.reason.is_some() => format!("{record}?"),
            Some(record) => record.to_string(),
            None => fate.fate.name().to_owned(),
        };
        fates.into_iter().map(text).collect()
    }

    #[test]
    fn counts_decide_where_nothing_says_how_far_a_record_reaches() {
        assert_eq!(told(&[1, 2, 5, 9], &[(2, 0.0, 2.0), (9, 0.0, 2.0)]), ["0", "0", "1", "1"]);
        // Either of the first two may be with the third.
        let either = told(&[1, 2, 5, 7], &[(5, 0.0, 2.0), (7, 0.0, 2.0)]);
        assert_eq!(either, ["merged", "merged", "0", "1"]);
    }

    #[test]
    fn spans_decide_where_weights_are_shares() {
        let records = [(4, 2.0, 2.5), (9, 3.0, 1.5)];
        assert_eq!(told(&[2, 3, 6, 9], &records), ["0", "0", "1", "1"]);
        let overlapping = [(6, 4.0, 2.5), (9, 4.0, 1.5)];
        assert_eq!(told(&[2, 3, 6, 9], &overlapping), ["0", "0", "merged", "1"]);
    }

    #[test]
    fn what_lies_in_no_record_is_gone_if_weights_lack_it() {
        assert_eq!(told(&[2, 3, 8], &[(3, 1.0, 2.0)]), ["0", "0", "evicted"]);
        assert_eq!(told(&[2, 3, 4], &[(4, 2.0, 2.0)]), ["0?", "0?", "0?"]);
        assert_eq!(told(&[2, 3, 8], &[(3, 1.0, 3.0)]), ["0", "0", "merged"]);
    }

    #[test]
    fn a_record_that_is_one_fragment_is_that_fragment() {
        let generated = [Generated { triangle: 3, depth: 5, color: 0x80FF_0000 }];
        let surface = Record { thickness: 2.0, ..Record::surface(5, 0x80FF_0000) };
        let report = Report::default();
        let facts = Facts { options: &Options::default(), report: &report };
        let found = fates(&facts, &generated, &[surface], f64::from);
        assert_eq!(found, [Fate::kept(Some(0))]);
    }
}
