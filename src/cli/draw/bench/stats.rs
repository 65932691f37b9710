//! Medians, ratios and means.

use std::collections::BTreeMap;

use super::row::Timing;
use crate::exec::clock::Stopwatch;

/// Seconds that `work` takes, and what it gives.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let mut watch = Stopwatch::start();
    let done = work();
    watch.lap("work");
    (watch.seconds().values().sum(), done)
}

/// The middle one, or the mean of both; 0 of none.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => f64::midpoint(values[n / 2 - 1], values[n / 2]),
    }
}

/// The median by name, of runs that have a number for each.
pub(super) fn medians(runs: &[BTreeMap<String, f64>]) -> BTreeMap<String, f64> {
    let names = runs.first().map(|run| run.keys().cloned().collect::<Vec<_>>());
    let of = |name: String| {
        let values = runs.iter().filter_map(|run| run.get(&name).copied()).collect();
        let middle = median(values);
        (name, middle)
    };
    names.unwrap_or_default().into_iter().map(of).collect()
}

/// The smallest and the largest.
#[cfg(any(feature = "gpu", test))]
pub(super) fn spread(values: &[f64]) -> [f64; 2] {
    let ends = |[low, high]: [f64; 2], &value: &f64| [low.min(value), high.max(value)];
    values.iter().fold([f64::MAX, 0.0], ends)
}

/// How executors stand beside an adapter, over all rows that have a ratio.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(super) struct Mean {
    exec: String,
    threads: usize,
    adapter: String,
    /// Rows.
    rows: usize,
    /// The geometric mean of their ratios.
    geometric_mean: f64,
    /// The smallest, and whose it is.
    smallest: f64,
    smallest_method: String,
    smallest_scene: String,
}

impl Mean {
    /// As a line for people.
    pub(super) fn line(&self) -> String {
        let Self { exec, threads, adapter, rows, geometric_mean, smallest, .. } = self;
        let (method, scene) = (&self.smallest_method, &self.smallest_scene);
        format!(
            "{exec} with {threads} threads, beside {adapter}: geometric mean {geometric_mean:.2} of {rows} ratios; the \
             smallest is {smallest:.2}, {method} on {scene}\n"
        )
    }
}

/// An executor, its threads, and an adapter.
type Beside<'a> = (&'a str, usize, &'a str);

/// Ratios, and whose they are.
type Ratios<'a> = Vec<(f64, &'a Timing)>;

/// One for each executor, number of threads and adapter.
pub(super) fn means(rows: &[Timing]) -> Vec<Mean> {
    let mut groups: BTreeMap<Beside<'_>, Ratios<'_>> = BTreeMap::new();
    for row in rows {
        if let (Some(ratio), Some(adapter)) = (row.ratio, &row.adapter) {
            groups.entry((&row.exec, row.threads, adapter)).or_default().push((ratio, row));
        }
    }
    let mean = |((exec, threads, adapter), group): (Beside<'_>, Ratios<'_>)| {
        let ratios: Vec<f64> = group.iter().map(|(ratio, _)| *ratio).collect();
        let (smallest, of) = group.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Mean {
            exec: exec.to_owned(),
            threads,
            adapter: adapter.to_owned(),
            rows: ratios.len(),
            geometric_mean: geometric_mean(&ratios),
            smallest,
            smallest_method: of.method.clone(),
            smallest_scene: of.asked.clone(),
        })
    };
    groups.into_iter().filter_map(mean).collect()
}

/// Of positive numbers, at least one.
fn geometric_mean(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|&value| libm::log(value)).sum();
    libm::exp(sum / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_the_median() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]).to_bits(), 2.0f64.to_bits());
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]).to_bits(), 2.5f64.to_bits());
        assert_eq!(median(vec![9.0, 1.0, 1.0]).to_bits(), 1.0f64.to_bits(), "not the mean");
        assert_eq!(median(Vec::new()).to_bits(), 0);
        let run = |draw: f64| BTreeMap::from([("draw".to_owned(), draw), ("hash".to_owned(), 1.0)]);
        let found = medians(&[run(5.0), run(2.0), run(3.0)]);
        assert_eq!(found, run(3.0));
        assert_eq!(spread(&[2.0, 0.5, 3.0]), [0.5, 3.0]);
    }

    fn row(exec: &str, method: &str, ratio: Option<f64>) -> Timing {
        Timing {
            exec: exec.to_owned(),
            method: method.to_owned(),
            asked: "layers:count=2".to_owned(),
            threads: 2,
            adapter: Some("llvmpipe".to_owned()),
            ratio,
            ..Timing::default()
        }
    }

    /// The mean is the geometric one: neither the arithmetic, 5, nor the harmonic, 3.2, nor the median.
    #[test]
    fn means_are_geometric_and_by_executor() {
        let rows = [
            row("tile", "ab-ll", Some(8.0)),
            row("tile", "z-buffer", Some(2.0)),
            row("threads", "ab-ll", Some(0.5)),
            row("tile", "kb", None),
            Timing { adapter: None, ..row("tile", "ab-ll", None) },
        ];
        let found = means(&rows);
        let [threads, tile] = &found[..] else { panic!("{found:?}") };
        assert!((tile.geometric_mean - 4.0).abs() < 1e-12, "{tile:?}");
        assert_eq!((tile.rows, tile.smallest.to_bits()), (2, 2.0f64.to_bits()));
        assert_eq!(tile.smallest_method, "z-buffer");
        assert_eq!((threads.exec.as_str(), threads.rows), ("threads", 1));
        assert!((threads.geometric_mean - 0.5).abs() < 1e-12);
        let right = "tile with 2 threads, beside llvmpipe: geometric mean 4.00 of 2 ratios; the smallest is 2.00, \
                     z-buffer on layers:count=2\n";
        assert_eq!(tile.line(), right);
        assert!(means(&rows[3..]).is_empty());
    }
}
