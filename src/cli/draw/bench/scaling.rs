//! How time grows: with threads, fragments, triangles or pixels.

use super::plan::{Asked, Plan, grown};
use super::row::Timing;
use super::table::{Column, column, number, table};
use crate::cli::terminal::wait;
use crate::error::{Error, Result};
use crate::report::text::Align;
use crate::scene::MAX_SIZE;

/// `--scaling`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Scaling {
    Threads,
    Fragments,
    Triangles,
    Pixels,
}

impl Scaling {
    fn unit(self) -> &'static str {
        match self {
            Self::Threads => "threads",
            Self::Fragments => "fragments",
            Self::Triangles => "triangles",
            Self::Pixels => "pixels",
        }
    }
}

/// A step: what it is compared with is the step before it or, with threads, the first.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub(super) struct Step {
    method: String,
    /// As it was named.
    scene: String,
    exec: String,
    threads: usize,
    /// What grows, and how many of it there are.
    unit: &'static str,
    size: u64,
    /// Of clear, store and resolve; and of the whole frame, from set-up to hashes.
    draw_seconds: f64,
    frame_seconds: f64,
    /// With threads: how many times as fast as the first step, by how many times as many threads.
    #[serde(skip_serializing_if = "Option::is_none")]
    draw_efficiency: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame_efficiency: Option<f64>,
    /// Otherwise: nanoseconds by unit, and how that changed from the step before, 0.1 for 10 % more.
    #[serde(skip_serializing_if = "Option::is_none")]
    draw_ns_per_unit: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame_ns_per_unit: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    draw_change: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame_change: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_mib: Option<f64>,
}

/// The scenes of each scaling, from the first step to the last, before anything is timed.
///
/// # Errors
/// A scene cannot be read, or cannot be made larger.
pub(super) fn families(plan: &Plan, scaling: Scaling, steps: u32) -> Result<Vec<Vec<Larger>>> {
    let family = |name: &String| -> Result<Vec<Larger>> {
        let first = plan.load(name, plan.size)?.scene.size;
        let step = |i: u32| {
            Ok(match scaling {
                Scaling::Threads => Larger { name: name.clone(), size: plan.size },
                Scaling::Pixels => Larger { name: name.clone(), size: Some(doubled(first, i)?) },
                Scaling::Fragments | Scaling::Triangles => {
                    Larger { name: grown(name, 1 << i)?, size: plan.size }
                }
            })
        };
        let steps = if scaling == Scaling::Threads { 1 } else { steps };
        let all: Vec<Larger> = (0..steps).map(step).collect::<Result<_>>()?;
        all.iter().try_for_each(|larger| larger.load(plan).map(drop))?;
        Ok(all)
    };
    wait::during(plan.quiet, "loading", || plan.named.iter().map(family).collect())
}

/// A scene of some size.
pub(super) struct Larger {
    name: String,
    size: Option<[u32; 2]>,
}

impl Larger {
    pub(super) fn load(&self, plan: &Plan) -> Result<Asked> {
        plan.load(&self.name, self.size)
    }
}

/// A picture doubled so many times, across and down by turns.
fn doubled([width, height]: [u32; 2], times: u32) -> Result<[u32; 2]> {
    let size = [width << times.div_ceil(2), height << (times / 2)];
    if size.iter().any(|&edge| edge > MAX_SIZE) {
        let [width, height] = size;
        let problem = format!("leads to {width}x{height}, above {MAX_SIZE} pixels");
        return Err(Error::new("--steps", problem));
    }
    Ok(size)
}

/// The steps of one family, from its rows in the order of the steps.
pub(super) fn steps(scaling: Scaling, rows: &[Timing], pixels: &[u64]) -> Vec<Step> {
    let is_same = |a: &Timing, b: &Timing| {
        let threads = scaling == Scaling::Threads || a.threads == b.threads;
        (&a.method, &a.exec, threads) == (&b.method, &b.exec, true)
    };
    let mut all: Vec<Step> = Vec::new();
    let mut done: Vec<&Timing> = Vec::new();
    for row in rows {
        if done.iter().any(|other| is_same(row, other)) {
            continue;
        }
        done.push(row);
        let same = rows.iter().zip(pixels).filter(|(other, _)| is_same(row, other));
        let sized = same.map(|(row, &pixels)| (row, size(scaling, row, pixels)));
        all.extend(compared(scaling, &sized.collect::<Vec<_>>()));
    }
    all
}

fn size(scaling: Scaling, row: &Timing, pixels: u64) -> u64 {
    match scaling {
        Scaling::Threads => row.threads as u64,
        Scaling::Fragments => row.fragments,
        Scaling::Triangles => row.triangles,
        Scaling::Pixels => pixels,
    }
}

fn compared(scaling: Scaling, rows: &[(&Timing, u64)]) -> Vec<Step> {
    let draw = |row: &Timing| row.phase("draw");
    let per_unit = |(row, size): (&Timing, u64), seconds: fn(&Timing) -> f64| {
        seconds(row) * 1e9 / size.max(1) as f64
    };
    let step = |i: usize| {
        let (row, size) = rows[i];
        let step = Step {
            method: row.method.clone(),
            scene: row.asked.clone(),
            exec: row.exec.clone(),
            threads: row.threads,
            unit: scaling.unit(),
            size,
            draw_seconds: draw(row),
            frame_seconds: row.frame(),
            peak_mib: row.peak_mib,
            ..Step::default()
        };
        if scaling == Scaling::Threads {
            let (first, threads) = rows[0];
            let efficiency = |first: f64, own: f64| {
                (own > 0.0).then(|| first * threads as f64 / (own * size as f64))
            };
            return Step {
                draw_efficiency: efficiency(draw(first), draw(row)),
                frame_efficiency: efficiency(first.frame(), row.frame()),
                ..step
            };
        }
        let change = |seconds: fn(&Timing) -> f64| {
            let before = per_unit(rows[i.checked_sub(1)?], seconds);
            (before > 0.0).then(|| per_unit(rows[i], seconds) / before - 1.0)
        };
        let draw: fn(&Timing) -> f64 = |row| row.phase("draw");
        Step {
            draw_ns_per_unit: Some(per_unit(rows[i], draw)),
            frame_ns_per_unit: Some(per_unit(rows[i], Timing::frame)),
            draw_change: change(draw),
            frame_change: change(Timing::frame),
            ..step
        }
    };
    (0..rows.len()).map(step).collect()
}

/// As a table for people.
pub(super) fn text(steps: &[Step]) -> String {
    table(
        &[
            column!("method", Left, |step: &Step| step.method.clone()),
            column!("scene", Left, |step| step.scene.clone()),
            column!("exec", Left, |step| step.exec.clone()),
            column!("threads", Right, |step| step.threads.to_string()),
            column!("grows", Left, |step| step.unit.to_owned()),
            column!("to", Right, |step| step.size.to_string()),
            column!("draw s", Right, |step| number(Some(step.draw_seconds), 4)),
            column!("efficiency", Right, |step| share(step.draw_efficiency)),
            column!("ns/unit", Right, |step| number(step.draw_ns_per_unit, 2)),
            column!("change", Right, |step| change(step.draw_change)),
            column!("frame s", Right, |step| number(Some(step.frame_seconds), 4)),
            column!("efficiency", Right, |step| share(step.frame_efficiency)),
            column!("ns/unit", Right, |step| number(step.frame_ns_per_unit, 2)),
            column!("change", Right, |step| change(step.frame_change)),
            column!("MiB", Right, |step| number(step.peak_mib, 0)),
        ],
        steps,
    )
}

fn share(part: Option<f64>) -> String {
    part.map_or(String::new(), |part| format!("{:.0} %", part * 100.0))
}

fn change(part: Option<f64>) -> String {
    part.map_or(String::new(), |part| format!("{:+.0} %", part * 100.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, threads: usize, fragments: u64, draw: f64, hash: f64) -> Timing {
        let seconds = [("draw", draw), ("hash", hash), ("emit", 9.0)];
        Timing {
            method: method.to_owned(),
            exec: "tile".to_owned(),
            threads,
            fragments,
            triangles: 2 * fragments,
            seconds: seconds.map(|(name, seconds)| (name.to_owned(), seconds)).into(),
            ..Timing::default()
        }
    }

    fn close(found: Option<f64>, right: f64) {
        let found = found.expect("a number");
        assert!((found - right).abs() < 1e-9, "{found} is not {right}");
    }

    /// Two threads in 6/8 of the time are 2/3 as efficient; four in a quarter of it are as efficient as one.
    #[test]
    fn efficiency_is_speed_by_threads() {
        let rows = [
            row("ab-ll", 1, 10, 8.0, 2.0),
            row("kb", 1, 10, 1.0, 0.0),
            row("ab-ll", 2, 10, 6.0, 2.0),
            row("ab-ll", 4, 10, 2.0, 2.0),
        ];
        let found = steps(Scaling::Threads, &rows, &[0; 4]);
        let ours: Vec<&Step> = found.iter().filter(|step| step.method == "ab-ll").collect();
        assert_eq!(ours.iter().map(|step| step.size).collect::<Vec<_>>(), [1, 2, 4]);
        for (step, [draw, frame]) in ours.iter().zip([[1.0, 1.0], [2.0 / 3.0, 0.625], [1.0, 0.625]])
        {
            close(step.draw_efficiency, draw);
            close(step.frame_efficiency, frame);
            assert_eq!((step.draw_change, step.draw_ns_per_unit), (None, None));
        }
        assert_eq!(found.len(), 4);
        close(found[3].draw_efficiency, 1.0);
        // Where the first step has two threads already, four are measured by these.
        let later = steps(Scaling::Threads, &rows[2..], &[0; 2]);
        close(later[1].draw_efficiency, 1.5);
    }

    /// Twice the fragments in three times the time: half as much again for each.
    #[test]
    fn change_is_in_time_by_unit_from_step_to_step() {
        let rows = [
            row("ab-ll", 2, 1_000, 1e-6, 0.0),
            row("ab-ll", 2, 2_000, 3e-6, 1e-6),
            row("ab-ll", 2, 4_000, 6e-6, 2e-6),
        ];
        let found = steps(Scaling::Fragments, &rows, &[0; 3]);
        close(found[0].draw_ns_per_unit, 1.0);
        assert_eq!(found[0].draw_change, None);
        close(found[1].draw_ns_per_unit, 1.5);
        close(found[1].draw_change, 0.5);
        close(found[1].frame_change, 1.0);
        close(found[2].draw_change, 0.0);
        let triangles = steps(Scaling::Triangles, &rows, &[0; 3]);
        assert_eq!((triangles[1].size, triangles[1].unit), (4_000, "triangles"));
        close(triangles[1].draw_ns_per_unit, 0.75);
        let pixels = steps(Scaling::Pixels, &rows, &[1, 3, 3]);
        close(pixels[1].draw_change, 0.0);
        close(pixels[2].draw_change, 1.0);
        let table = text(&found);
        assert!(table.contains("+50 %") && table.contains("+100 %"), "{table}");
    }

    #[test]
    fn pictures_double_across_and_down_by_turns() {
        let sizes: Vec<_> = (0..4).map(|i| doubled([100, 60], i).unwrap()).collect();
        assert_eq!(sizes, [[100, 60], [200, 60], [200, 120], [400, 120]]);
        let error = doubled([16_384, 16], 1).unwrap_err().to_string();
        assert_eq!(error, "--steps: leads to 32768x16, above 16384 pixels");
    }
}
