//! One row: a run that counts, then as many as are timed.

use std::collections::BTreeMap;

use super::front::Front;
use super::limit::Counted;
use super::machine::Constants;
use super::peak;
use super::row::Timing;
use super::stats::{median, medians};
use crate::error::Result;
use crate::exec::Kit;
use crate::raster::Grid;
use crate::render::{Exec, Options, Report, render, render_with};
use crate::scene::Scene;
use crate::scheme::Config;
use crate::scheme::hash_table::table::{DEFAULT_LOAD, TableSettings, size_for_load};

/// Counters that count no operations.
const NO_OPERATIONS: [&str; 5] = ["failed_exchanges", "spins", "bytes", "probes", "evictions"];

/// What a run with counters shows; it is not timed.
pub(super) struct First {
    report: Report,
    peak: Option<f64>,
}

impl First {
    /// Draw once.
    ///
    /// # Errors
    /// What drawing refuses.
    pub(super) fn new(scene: &Scene, options: &Options) -> Result<Self> {
        let options = Options { counters: true, ..options.clone() };
        let (drawn, peak) = peak::during(|| render(scene, &options).map(|drawn| drawn.report));
        Ok(Self { report: drawn?, peak })
    }

    fn counted(&self, options: &Options) -> Counted {
        let contract = options.method.contract();
        let is_shared = options.exec == Exec::Threads;
        let stays = is_shared || !contract.program.is_local();
        Counted {
            counters: self.report.counters.clone(),
            fragments: self.report.generated,
            is_shared,
            stored: if stays { self.report.bytes } else { 0 },
            takes: takes(&self.report, options),
        }
    }
}

/// Whether a method takes indices of pools, configured as in the run that this reports.
fn takes(report: &Report, options: &Options) -> bool {
    let size = [report.width, report.height];
    let grid = Grid { width: size[0], height: size[1], tile: options.tile };
    let size = size_for_load(report.generated, DEFAULT_LOAD, size);
    let table = TableSettings { size, ..TableSettings::default() };
    let config = Config {
        k: report.k,
        pixels: grid.storage_pixels() as u32,
        generated: report.generated,
        max_depth_complexity: report.max_depth_complexity,
        bounded: report.generated,
        pages: report.generated,
        grid,
        table,
        ..Config::default()
    };
    let instance = options.method.instance(&config);
    instance.is_some_and(|instance| !instance.layout().ahead().is_empty())
}

/// Runs that are timed.
pub(super) struct Runs<'a> {
    scene: &'a Scene,
    options: Options,
    front: Front,
    kit: Kit,
    /// Seconds by phase of each.
    seconds: Vec<BTreeMap<String, f64>>,
}

impl<'a> Runs<'a> {
    /// None yet. A frame that is not timed makes the system hand out pages, as on devices.
    ///
    /// # Errors
    /// What drawing refuses.
    pub(super) fn new(scene: &'a Scene, options: &Options) -> Result<Self> {
        let options = Options { counters: false, ..options.clone() };
        let (front, kit) = (Front::new(scene, &options)?, Kit::of_several());
        render_with(scene, &options, &kit)?;
        Ok(Self { scene, options, front, kit, seconds: Vec::new() })
    }

    /// Time the front end, and a frame.
    ///
    /// # Errors
    /// What drawing refuses.
    pub(super) fn once(&mut self) -> Result<()> {
        let (coverage, emit) = (self.front.coverage().0, self.front.emit().0);
        let mut seconds = render_with(self.scene, &self.options, &self.kit)?.report.seconds;
        seconds.insert("coverage".to_owned(), coverage);
        seconds.insert("emit".to_owned(), emit);
        self.seconds.push(seconds);
        Ok(())
    }

    /// Seconds of clear, store and resolve, with culling if there is any, of each run.
    pub(super) fn draws(&self) -> Vec<f64> {
        self.seconds.iter().map(draw).collect()
    }

    /// The row of the medians.
    pub(super) fn row(&self, first: &First, machine: &[Constants]) -> Timing {
        let counted = first.counted(&self.options);
        let row = row(&first.report, &self.seconds, &counted, machine);
        Timing { peak_mib: first.peak, ..row }
    }
}

fn draw(run: &BTreeMap<String, f64>) -> f64 {
    ["draw", "culling"].iter().filter_map(|phase| run.get(*phase)).sum()
}

/// A row from what was counted and the seconds of each run.
fn row(
    report: &Report,
    runs: &[BTreeMap<String, f64>],
    counted: &Counted,
    machine: &[Constants],
) -> Timing {
    let frame = median(runs.iter().map(draw).collect());
    let mut seconds = medians(runs);
    let of = |name: &str| seconds.get(name).copied().unwrap_or_default();
    let (setup, coverage, emit, drawn) = (of("setup"), of("coverage"), of("emit"), of("draw"));
    let passes: f64 =
        seconds.iter().filter(|(name, _)| name.starts_with("draw.")).map(|(_, s)| s).sum();
    // Where passes are not timed one by one, what is not emission is store and resolve.
    if passes == 0.0 {
        seconds.insert("store_resolve".to_owned(), (drawn - emit).max(0.0));
    }
    let threads = report.threads.max(1) as f64;
    let simulated = report.exec == "sim";
    let operations = operations(&report.counters) as f64;
    let constants = machine.iter().find(|constants| constants.threads == report.threads);
    // What the machine can do is what it did at its best.
    let fastest =
        runs.iter().filter_map(|run| run.get("emit")).fold(f64::INFINITY, |a, &b| a.min(b));
    let limit = constants.filter(|_| !simulated).map(|machine| counted.limit(fastest, machine));
    let per = |amount: f64, seconds: f64| if seconds > 0.0 { amount / seconds } else { 0.0 };
    Timing {
        method: report.method.clone(),
        scene: report.scene.clone(),
        exec: report.exec.clone(),
        threads: report.threads,
        fragments: report.generated,
        triangles: report.triangles,
        mfrag_per_s: per(report.generated as f64 * 1e-6, frame),
        setup_mtri_per_s: per(report.triangles as f64 * 1e-6 / threads, setup),
        coverage_gfrag_per_s: per(report.generated as f64 * 1e-9 / threads, coverage),
        atomics_per_fragment: counted.atomics_per_fragment(),
        bytes_per_fragment: counted.bytes_per_fragment(),
        limit_seconds: limit.map(|limit| limit.seconds),
        limit_by: limit.map(|limit| limit.by),
        limit_ratio: limit.map(|limit| per(frame, limit.seconds)),
        mops_per_s: simulated.then(|| per(operations * 1e-6, passes)),
        seconds,
        ..Timing::default()
    }
}

/// Memory operations of all kinds.
fn operations(counters: &BTreeMap<String, u64>) -> u64 {
    let is_one = |name: &String| !NO_OPERATIONS.contains(&name.as_str());
    counters.iter().filter(|(name, _)| is_one(name)).map(|(_, count)| count).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(phases: &[(&str, f64)]) -> BTreeMap<String, f64> {
        phases.iter().map(|&(name, seconds)| (name.to_owned(), seconds)).collect()
    }

    fn report(exec: &str) -> Report {
        let counters = [("exchange", 40), ("plain_load", 60), ("bytes", 800), ("spins", 9)];
        Report {
            exec: exec.to_owned(),
            threads: 2,
            generated: 8_000_000,
            triangles: 2_000_000,
            counters: counters.iter().map(|&(name, n)| (name.to_owned(), n * 1_000_000)).collect(),
            ..Report::default()
        }
    }

    #[test]
    fn methods_with_pools_take_indices() {
        let of = |name: &str| {
            let method = crate::catalogue::method(name).expect("a built-in method");
            let report = Report { width: 64, height: 64, generated: 99, ..Report::default() };
            takes(&report, &Options { method, ..Options::default() })
        };
        let found = ["ab-ll", "ab-ll-paged", "s-buffer", "kplus-array", "ha64", "exact"].map(of);
        assert_eq!(found, [true, false, false, false, false, false], "pages come from a counter");
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    }

    const MACHINE: Constants = Constants {
        threads: 2,
        exchange_ns: 10.0,
        locked_pair_ns: 10.0,
        compare_exchange_max_ns: 10.0,
        add_ns: 10.0,
        cache_gb_per_s: 1e9,
        read_gb_per_s: 1e9,
        write_gb_per_s: 1e9,
    };

    #[test]
    fn a_row_has_the_medians_and_what_follows_from_them() {
        let of = |emit: f64, draw: f64| {
            run(&[("setup", 0.5), ("coverage", 0.004), ("emit", emit), ("draw", draw)])
        };
        let runs = [of(0.1, 0.9), of(0.2, 0.4), of(0.05, 0.5)];
        let counted = Counted { fragments: 8_000_000, ..Counted::default() };
        let row = row(&report("tile"), &runs, &counted, &[MACHINE]);
        close(row.phase("draw"), 0.5);
        close(row.phase("store_resolve"), 0.4);
        close(row.mfrag_per_s, 16.0);
        close(row.setup_mtri_per_s, 2.0);
        close(row.coverage_gfrag_per_s, 1.0);
        assert_eq!(row.limit_by, Some("emit"));
        // Emission counts as fast as it was once: 0.05.
        close(row.limit_ratio.unwrap(), 10.0);
        assert_eq!(row.mops_per_s, None);
    }

    #[test]
    fn contended_atomics_limit_a_row() {
        let runs = [run(&[("emit", 0.1), ("draw", 0.5), ("culling", 0.1), ("draw.store", 0.4)])];
        let report = report("threads");
        let counters = report.counters.clone();
        let counted =
            Counted { counters, fragments: 8_000_000, is_shared: true, ..Counted::default() };
        let found = row(&report, &runs, &counted, &[Constants { threads: 1, ..MACHINE }, MACHINE]);
        assert_eq!(found.limit_by, Some("atomics"));
        close(found.limit_seconds.unwrap(), 0.2);
        close(found.limit_ratio.unwrap(), 3.0);
        close(found.atomics_per_fragment, 5.0);
        close(found.bytes_per_fragment, 100.0);
        assert!(!found.seconds.contains_key("store_resolve"), "its passes are timed");
        // Without constants for so many threads there is no limit.
        assert_eq!(row(&report, &runs, &counted, &[]).limit_ratio, None);
    }

    #[test]
    fn the_simulated_device_is_measured_in_operations() {
        let runs = [run(&[("draw", 9.0), ("draw.clear", 1.0), ("draw.store", 4.0)])];
        let row = row(&report("sim"), &runs, &Counted::default(), &[MACHINE]);
        close(row.mops_per_s.unwrap(), 20.0);
        assert_eq!(row.limit_ratio, None);
    }
}
