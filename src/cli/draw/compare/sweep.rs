//! `compare --sweep`: methods at several values of an option; memory and errors of each, as a table and a plot.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

use super::Args;
use super::session::{Session, culled, write};
use crate::cli::Verdict;
use crate::cli::options::measures::Printed;
use crate::cli::options::settings::complete;
use crate::cli::options::sweep::Sweep;
use crate::cli::terminal::say;
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::image::metrics::Metrics;
use crate::image::plot::{Curve, Plot, Stroke};
use crate::render::{Options, Report};
use crate::report::grid::{Cell, Column, Grid, Syntax};
use crate::report::{errors, files, json};

/// The most frames of a sweep.
const MOST_RUNS: usize = 512;

/// A method at a value; none where the option does nothing for it.
pub(super) struct Run {
    value: Option<f64>,
    options: Options,
}

/// What came out: a row of the table.
#[derive(Debug, Serialize)]
struct Point {
    method: String,
    scene: String,
    width: u32,
    height: u32,
    /// The swept option.
    parameter: &'static str,
    value: Option<f64>,
    /// Of the method's words, for the frame.
    bytes: u64,
    bytes_per_pixel: f64,
    #[serde(flatten)]
    metrics: Metrics,
    arrival_dependent: bool,
    image_hash: String,
    warnings: Vec<String>,
    violations: Vec<String>,
}

/// The frames to draw, their options checked.
///
/// # Errors
/// Too many, or what does not go with a sweep; or options that are wrong with one of the values.
pub(super) fn runs(sweep: &Sweep, methods: &[Method], args: &Args) -> Result<Vec<Run>> {
    if args.heat.is_some() {
        return Err(Error::new("--heat", "is not for --sweep: leave one of them out"));
    }
    let concerned = |method: &Method| (sweep.parameter.concerns)(method.contract());
    let (many, once): (Vec<Method>, Vec<Method>) = methods.iter().partition(|m| concerned(m));
    if many.is_empty() {
        let problem =
            format!("no method has the option {}: nothing to sweep", sweep.parameter.name);
        return Err(Error::new("--sweep", problem));
    }
    let count = many.len() * sweep.values.len() + once.len();
    if count > MOST_RUNS {
        let (methods, values) = (many.len(), sweep.values.len());
        let problem = format!(
            "{methods} methods at {values} values are {count} frames with the others: at most \
             {MOST_RUNS}; give fewer methods (-m) or values"
        );
        return Err(Error::new("--sweep", problem));
    }
    let mut runs = Vec::new();
    for &method in methods {
        let values = sweep.values.iter().map(|&value| Some(value));
        let values: Vec<_> = if concerned(&method) { values.collect() } else { vec![None] };
        for value in values {
            let typed = value.map_or_else(|| args.drawing.clone(), |v| sweep.at(&args.drawing, v));
            runs.push(Run { value, options: complete(&typed, method, false)?.options });
        }
    }
    Ok(runs)
}

/// Draw and measure them all, write the files, and print a row for each.
///
/// # Errors
/// What a method refuses, or a file that cannot be written.
pub(super) fn run(
    session: &mut Session,
    sweep: &Sweep,
    runs: &[Run],
    printed: Printed,
    folder: Option<&Path>,
) -> Result<Verdict> {
    let mut points = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        let depth_format = session.options.depth_format;
        let options = culled(Options { counters: false, depth_format, ..run.options.clone() });
        let drawn = session.draw(&options, &format!(" ({} of {})", i + 1, runs.len()))?;
        let metrics = session.measure(&drawn, options.record().data)?;
        points.push(Point::new(sweep, run, drawn.report, metrics));
    }
    let grid = grid(sweep, &points);
    if let Some(folder) = folder {
        let plot = plot(&session.scene.name, sweep, &points);
        let write_text =
            |name: &str, text: String| files::write_bytes(&folder.join(name), text.as_bytes());
        write_text("sweep.csv", grid.write(Syntax::Csv))?;
        write_text("sweep.svg", plot.svg())?;
        write(&folder.join("sweep.png"), &plot.draw())?;
    }
    say::result(&match printed {
        Printed::Tables => table(session, &grid),
        Printed::Document | Printed::ErrorDocument => json::document(&points)?,
        Printed::Errors(syntax) => grid.write(syntax),
    })?;
    complain(&points, &session.warnings);
    let clean = points.iter().all(|point| point.violations.is_empty());
    Ok(if clean { Verdict::Clean } else { Verdict::Found })
}

/// Report what is not known yet, once for each method.
fn complain(points: &[Point], known: &[String]) {
    let mut told = BTreeSet::new();
    for point in points {
        let of = |text: &String| format!("{}: {text}", point.method);
        for warning in point.warnings.iter().filter(|warning| !known.contains(warning)).map(of) {
            if told.insert(warning.clone()) {
                say::warning(&warning);
            }
        }
        point.violations.iter().for_each(|violation| say::violation(&of(violation)));
    }
}

impl Point {
    fn new(sweep: &Sweep, run: &Run, report: Report, metrics: Metrics) -> Self {
        let pixels = u64::from(report.width) * u64::from(report.height);
        Self {
            method: report.method,
            scene: report.scene,
            width: report.width,
            height: report.height,
            parameter: sweep.parameter.name,
            value: run.value,
            bytes: report.bytes,
            bytes_per_pixel: report.bytes as f64 / pixels as f64,
            metrics,
            arrival_dependent: run.options.method.contract().is_arrival_dependent(),
            image_hash: report.image_hash,
            warnings: report.warnings,
            violations: report.violations,
        }
    }
}

fn grid(sweep: &Sweep, points: &[Point]) -> Grid {
    let threshold = points.first().map_or(0, |point| point.metrics.threshold);
    let mut columns = vec![
        Column::new("method", "method"),
        Column::new("value", sweep.parameter.name),
        Column::new("bytes", "bytes"),
        Column::new("bytes_per_pixel", "per pixel"),
    ];
    columns.extend(errors::columns(threshold));
    let row = |point: &Point| {
        let value = |value: f64| Cell::Number(value.to_string(), value.to_string());
        let mut cells = vec![
            Cell::Word(point.method.clone()),
            point.value.map_or(Cell::Absent("-"), value),
            Cell::whole(point.bytes),
            Cell::number(point.bytes_per_pixel, 2),
        ];
        let pixels = u64::from(point.width) * u64::from(point.height);
        cells.extend(errors::cells(&point.metrics, pixels));
        cells
    };
    Grid { columns, rows: points.iter().map(row).collect() }
}

fn table(session: &Session, grid: &Grid) -> String {
    let (scene, reference) = (&session.scene, session.options.method);
    let [width, height] = scene.size;
    format!(
        "{} at {width}x{height}, errors against all fragments of {reference}\n\n{}",
        scene.name,
        grid.write(Syntax::Text)
    )
}

/// FLIP against memory, a curve for each method.
fn plot(scene: &str, sweep: &Sweep, points: &[Point]) -> Plot {
    let mut curves: Vec<Curve> = Vec::new();
    for point in points {
        if curves.last().is_none_or(|curve| curve.name != point.method) {
            curves.push(Curve { stroke: Stroke::Marked, ..Curve::new(&point.method) });
        }
        if let Some(curve) = curves.last_mut() {
            curve.points.push([point.bytes_per_pixel, point.metrics.flip]);
        }
    }
    let (name, values) = (sweep.parameter.name, &sweep.values);
    let ends = [values[0], values[values.len() - 1]];
    let title = format!("{scene}: error against memory, {name} from {} to {}", ends[0], ends[1]);
    let (x, y) = ("bytes of the method's words per pixel", "mean FLIP (0: as the reference)");
    Plot { title, x, y, curves }
}
