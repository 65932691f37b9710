//! A process of its own for every method on every path of every adapter. What a driver does to it, hang, crash or lose
//! its device, costs the row that it was at; the next process goes on behind that row. An adapter that a process cannot
//! open any more is given up: each of its rows says so.

use std::time::Duration;

use super::asked::{self, Subject};
use super::process::{Line, Process};
use super::rows::Rows;
use super::worker;
use super::{Args, FragmentOrder};
use crate::cli::terminal::wait;
use crate::error::Result;
use crate::gpu::check::crosscheck::{Agreement, Options, Path, Status, blank};
use crate::gpu::driver::device::AdapterName;
use crate::gpu::twin::source::Twin;

/// A process.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    adapter: AdapterName,
    path: Path,
    twin: Twin,
}

/// All processes of a run, those that are known to be harmless first: a device that is lost for good then costs least.
pub(super) fn units(adapters: &[AdapterName], options: &Options) -> Vec<Unit> {
    let mut paths = options.paths.clone();
    paths.sort_by_key(|&path| path == Path::Raster);
    let mut units = Vec::new();
    for adapter in adapters {
        for waits in [false, true] {
            for &path in &paths {
                let own = options.twins.iter().filter(|twin| twin.waits() == waits);
                units.extend(own.map(|&twin| Unit { adapter: adapter.clone(), path, twin }));
            }
        }
    }
    units
}

impl Unit {
    fn blank(&self, subject: &Subject) -> Agreement {
        let row = blank(&self.adapter, &self.twin.name(), &subject.name, self.path, subject.size);
        Agreement { asked: subject.asked.clone(), ..row }
    }

    fn row(&self, subject: &Subject, status: Status, reason: String) -> Agreement {
        let is_finding = status != Status::Unsupported;
        Agreement { status, reason, is_finding, ..self.blank(subject) }
    }
}

/// Run all units; rows that are there already are passed over.
///
/// # Errors
/// No process can be started, or a row cannot be written.
pub(super) fn run(
    args: &Args,
    subjects: &[Subject],
    units: &[Unit],
    rows: &mut Rows<'_>,
) -> Result<()> {
    let mut given_up: Option<(AdapterName, Status, String)> = None;
    for unit in units {
        let mut at = 0;
        while at < subjects.len() {
            if rows.take_known(&unit.blank(&subjects[at])) {
                at += 1;
                continue;
            }
            match &given_up {
                Some((adapter, status, why)) if *adapter == unit.adapter => {
                    rows.add(unit.row(&subjects[at], *status, why.clone()))?;
                    at += 1;
                }
                _ => match process(args, subjects, unit, &mut at, rows)? {
                    Ended::Done => {}
                    Ended::Unopened(status, why) => {
                        given_up = Some((unit.adapter.clone(), status, why));
                    }
                },
            }
        }
    }
    Ok(())
}

/// How a process ended.
enum Ended {
    /// Every row up to `at` is finished.
    Done,
    /// It could not open the device.
    Unopened(Status, String),
}

/// One process, from row `at` of the unit on. `at` becomes that of the first row that is not finished.
fn process(
    args: &Args,
    subjects: &[Subject],
    unit: &Unit,
    at: &mut usize,
    rows: &mut Rows<'_>,
) -> Result<Ended> {
    let mut process = Process::start(&arguments(args, unit, *at))?;
    rows.ask(unit.twin)?;
    let silence = Duration::from_secs(2 * args.limit + 5);
    let mut is_open = false;
    loop {
        let subject = subjects.get(*at);
        let message = match subject {
            Some(subject) => rows.doing(&unit.blank(subject)),
            None => format!("ending {}", unit.twin.name()),
        };
        let line = wait::during(args.output.quiet, &message, || process.next(silence));
        let (status, why) = match line {
            Ok(Line::Alive | Line::Litmus(_)) => continue,
            Ok(Line::Opened) => {
                is_open = true;
                continue;
            }
            Ok(Line::Refused(why)) => return Ok(Ended::Unopened(Status::Unsupported, why)),
            Ok(Line::Row(row)) => {
                let is_over = matches!(row.status, Status::Hung | Status::Lost);
                rows.add(*row)?;
                *at += 1;
                if is_over {
                    return Ok(Ended::Done);
                }
                continue;
            }
            Err(silence) => silence,
        };
        drop(process);
        let Some(subject) = subject else { return Ok(Ended::Done) };
        if !is_open {
            let why = format!("the adapter cannot be opened: {why}");
            return Ok(Ended::Unopened(Status::Lost, why));
        }
        rows.add(unit.row(subject, status, why))?;
        *at += 1;
        return Ok(Ended::Done);
    }
}

/// The command line of a worker.
fn arguments(args: &Args, unit: &Unit, from: usize) -> Vec<String> {
    let mut all: Vec<String> = vec!["crosscheck".to_owned()];
    let mut option = |name: &str, value: String| all.extend([name.to_owned(), value]);
    option("--worker", worker::named(&unit.adapter));
    option("--from", from.to_string());
    option("--method", unit.twin.method.name().to_owned());
    option("--path", unit.path.to_string());
    option("--form", args.form.name().to_owned());
    option("--limit", args.limit.to_string());
    option("--seed", args.seed.to_string());
    let shuffled = args.order == FragmentOrder::Shuffled;
    option("--order", if shuffled { "shuffled" } else { "submission" }.to_owned());
    if let Some(k) = args.k {
        option("-k", k.to_string());
    }
    if let Some(thickness) = &args.thickness {
        option("--thickness", thickness.clone());
    }
    if let Some(faults) = &args.test_double {
        option("--test-double", faults.clone());
    }
    if !args.sizes.is_empty() {
        option("--size", args.sizes.join(","));
    }
    if args.quick {
        all.push("--quick".to_owned());
    }
    all.push("--".to_owned());
    all.extend(asked::scenes(args));
    all
}
