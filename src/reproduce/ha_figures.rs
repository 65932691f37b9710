//! Figures 5 and 8 of the HA-buffer paper: the cost of an insertion as the table fills up, and as lists grow.

use super::plot::{Curve, Plot};
use super::{Outcome, Scale, Verdict};
use crate::catalogue;
use crate::error::Result;
use crate::render::{Data, Options, Report, TableOptions, render};
use crate::scene::{self, Overrides, Scene};

/// Loads of Figure 5, in per cent: it begins at about 95, and the table grows.
const LOADS: [u32; 13] = [95, 93, 90, 87, 84, 80, 75, 70, 60, 50, 40, 30, 20];

/// Squares of Figure 8.
const SQUARES: u32 = 64;

/// Positions of Figure 8: how far squares are brought together.
const TOGETHER: [f64; 9] = [0.0, 0.25, 0.5, 0.65, 0.8, 0.9, 0.95, 0.98, 1.0];

/// One timed point.
struct Point {
    report: Report,
    /// Seconds of the frame without set-up, resolve and assembly included; the median of several.
    seconds: f64,
}

/// Draw several times.
fn measure(scene: &Scene, method: &str, table: &TableOptions, repeats: u32) -> Result<Point> {
    let chosen = catalogue::method(method)?;
    let options = |counters| Options {
        method: chosen,
        table: table.clone(),
        data: Data::Color,
        counters,
        ..Options::default()
    };
    let report = render(scene, &options(true))?.report;
    let mut seconds = Vec::new();
    for _ in 0..repeats.max(1) {
        let report = render(scene, &options(false))?.report;
        seconds.push(report.seconds.get("draw").copied().unwrap_or(0.0));
    }
    seconds.sort_by(f64::total_cmp);
    Ok(Point { report, seconds: seconds[seconds.len() / 2] })
}

impl Point {
    fn per_fragment(&self, counters: &[&str]) -> f64 {
        let sum: u64 = counters.iter().filter_map(|name| self.report.counters.get(*name)).sum();
        sum as f64 / self.report.generated.max(1) as f64
    }

    fn probes(&self) -> f64 {
        self.per_fragment(&["probes"])
    }

    /// The columns that both figures share.
    fn cells(&self) -> Vec<String> {
        let report = &self.report;
        let table = report.table.clone().unwrap_or_default();
        let dropped: u64 = report.dropped.values().sum();
        vec![
            report.method.clone(),
            report.generated.to_string(),
            format!("{:.1}", table.load),
            format!("{:.2}", self.probes()),
            format!("{:.2}", self.per_fragment(&["max"])),
            format!("{:.2}", self.per_fragment(&["evictions"])),
            table.max_age.to_string(),
            report.culled.to_string(),
            dropped.to_string(),
            format!("{:.4}", self.seconds),
            format!("{:.2}", report.generated as f64 / self.seconds / 1e6),
        ]
    }
}

fn columns(first: &'static str) -> Vec<&'static str> {
    vec![
        first,
        "method",
        "fragments",
        "load reached (%)",
        "probes per fragment",
        "atomics per fragment",
        "evictions per fragment",
        "largest age",
        "culled",
        "dropped",
        "seconds",
        "Mfragments/s",
    ]
}

/// Figure 5: 64 and 32 bits, by load.
pub(super) fn loads(scale: &Scale) -> Result<Outcome> {
    let size = Overrides { size: Some([scale.edge; 2]), ..Overrides::default() };
    let scene = scene::load("gears:count=32", &size)?;
    let mut rows = Vec::new();
    let mut curves = vec![Curve::new("probes, random"), Curve::new("probes, farthest-point")];
    for load in LOADS {
        for (method, offsets) in [
            ("ha64", crate::render::Offsets::Random),
            ("ha64", crate::render::Offsets::FarthestPoint),
            ("ha32", crate::render::Offsets::Random),
        ] {
            let hash = TableOptions { load: Some(load), offsets, ..TableOptions::default() };
            let point = measure(&scene, method, &hash, scale.repeats)?;
            let mut row = vec![load.to_string()];
            row.extend(point.cells());
            if offsets == crate::render::Offsets::FarthestPoint {
                row[1] += ", farthest-point";
            }
            let reached = point.report.table.as_ref().map_or(0.0, |table| table.load);
            if method == "ha64" {
                let curve = usize::from(offsets == crate::render::Offsets::FarthestPoint);
                curves[curve].points.push([reached, point.probes()]);
            }
            rows.push(row);
        }
    }
    let first = |row: &Vec<String>| row[4].clone();
    let summary = format!(
        "probes per fragment rise from {} at {} % to {} at {} %; the paper's rate falls abruptly after 80 %",
        rows.get(rows.len().saturating_sub(3)).map(first).unwrap_or_default(),
        LOADS[LOADS.len() - 1],
        rows.first().map(first).unwrap_or_default(),
        LOADS[0]
    );
    let plot = Plot {
        title: "Probes per fragment by load (HA-buffer, Figure 5)".to_owned(),
        x: "load factor (%)",
        y: "probes per fragment",
        curves,
    };
    let columns = columns("load asked for (%)");
    let verdict = Some(Verdict::of(&cliff(&plot.curves[0])));
    Ok(Outcome { columns, rows, plot: Some(plot), verdict, ..Outcome::new("ha-fig5", summary) })
}

/// Figure 8: with and without early culling, by how close the squares are.
pub(super) fn stack(scale: &Scale) -> Result<Outcome> {
    let size = Overrides { size: Some([scale.edge; 2]), ..Overrides::default() };
    let mut rows = Vec::new();
    let mut curves = vec![Curve::new("ha64"), Curve::new("ha64-cull")];
    for together in TOGETHER {
        let name = format!("stack:count={SQUARES},together={together},alpha=0.25");
        let scene = scene::load(&name, &size)?;
        for (curve, method) in curves.iter_mut().zip(["ha64", "ha64-cull"]) {
            let point = measure(&scene, method, &TableOptions::default(), scale.repeats)?;
            let mut row = vec![format!("{together:.2}")];
            row.extend(point.cells());
            curve.points.push([together, point.probes()]);
            rows.push(row);
        }
    }
    let last = rows.len().saturating_sub(2);
    let summary = format!(
        "with all squares on top of each other, an insertion makes {} probes; with early culling, {}",
        rows.get(last).map(|row| row[4].clone()).unwrap_or_default(),
        rows.get(last + 1).map(|row| row[4].clone()).unwrap_or_default()
    );
    let plot = Plot {
        title: "Probes per fragment of stacking squares (HA-buffer, Figure 8)".to_owned(),
        x: "together (0: apart, 1: on each other)",
        y: "probes per fragment",
        curves,
    };
    let columns = columns("together");
    let verdict = Some(Verdict::of(&bounded(&plot.curves)));
    Ok(Outcome { columns, rows, plot: Some(plot), verdict, ..Outcome::new("ha-fig8", summary) })
}

/// What does not hold of probes by load: they rise at least three times as fast after 80 % as before.
fn cliff(curve: &Curve) -> Vec<String> {
    let mut points = curve.points.clone();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let slope = |[a, b]: [[f64; 2]; 2]| (b[1] - a[1]) / (b[0] - a[0]).max(1e-9);
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return Vec::new() };
    let Some(&turn) = points.iter().rev().find(|point| point[0] <= 80.5) else { return Vec::new() };
    let [before, after] = [[first, turn], [turn, last]].map(slope);
    if after >= 3.0 * before {
        return Vec::new();
    }
    vec![format!("probes rise {:.1} times as fast after 80 % as before", after / before)]
}

/// What does not hold of stacking squares: probes rise with the stack, and culling keeps them lower.
fn bounded(curves: &[Curve]) -> Vec<String> {
    let ends = |curve: &Curve| {
        let at = |point: Option<&[f64; 2]>| point.map_or(0.0, |point| point[1]);
        [at(curve.points.first()), at(curve.points.last())]
    };
    let [apart, stacked] = ends(&curves[0]);
    let [_, culled] = ends(&curves[1]);
    if stacked > apart && culled < stacked {
        return Vec::new();
    }
    vec![format!("{apart:.1} probes apart, {stacked:.1} stacked, {culled:.1} with culling")]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Scale = Scale { edge: 48, repeats: 1 };

    fn column(outcome: &Outcome, name: &str) -> Vec<f64> {
        let at = outcome.columns.iter().position(|column| *column == name).unwrap();
        outcome.rows.iter().map(|row| row[at].parse().unwrap()).collect()
    }

    #[test]
    fn stacking_keeps_the_fragments_and_culling_helps() {
        let outcome = stack(&SMALL).unwrap();
        let fragments = column(&outcome, "fragments");
        assert!(fragments.iter().all(|&f| f == fragments[0] && f == f64::from(SQUARES * 12 * 12)));
        let probes = column(&outcome, "probes per fragment");
        let (apart, stacked) = (probes[0], probes[probes.len() - 2]);
        assert!(stacked > 2.0 * apart, "{probes:?}");
        assert!(probes[probes.len() - 1] < stacked, "with early culling");
        assert!(column(&outcome, "dropped").iter().all(|&d| d == 0.0));
    }

    #[test]
    fn fuller_tables_take_more_probes() {
        let outcome = loads(&SMALL).unwrap();
        let probes = column(&outcome, "probes per fragment");
        assert!(probes[0] > probes[probes.len() - 3], "{probes:?}");
        assert_eq!(outcome.rows.len(), 3 * LOADS.len());
    }
}
