//! `fragloom crosscheck --litmus`: litmus pixels on devices, one invocation at a time, and then many copies at once.

use std::time::Duration;

use super::process::{Line, Litmus, Process};
use super::worker;
use super::{Args, devices, status};
use crate::cli::Verdict;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::gpu::check::conform;
use crate::gpu::check::crosscheck::Options;
use crate::gpu::check::open;
use crate::gpu::check::pressure::Pressure;
use crate::gpu::check::stress::{self, Stressed};
use crate::gpu::driver::device::{AdapterName, Device};
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::source::Twin;
use crate::report::json;
use crate::report::text::{Align, columns};

/// Seconds that litmus pixels are explored without a submission, at most, before their process is taken for dead.
const EXPLORING: u64 = 900;

/// Litmus pixels on every device, each method in a process of its own.
///
/// # Errors
/// `--repeats 0`, or there is no adapter.
pub(in crate::cli) fn run(args: &Args, options: &Options) -> Result<Verdict> {
    if args.repeats == 0 {
        return Err(Error::new("--repeats", "is 0, but must be at least 1"));
    }
    pressure(args)?;
    let (mut all, mut failures) = (Litmus::default(), Vec::new());
    let mut add = |adapter: &AdapterName, method: &str, ran: Ran| match ran {
        Ok(ran) => {
            all.conformance.extend(ran.conformance);
            all.stress.extend(ran.stress);
        }
        Err(failure) => failures.push(format!("{}: {method}: {failure}", adapter.name)),
    };
    let names = if args.in_process {
        let devices = devices(args.adapter.as_deref())?;
        for opened in &devices {
            for &twin in &options.twins {
                let name = &opened.device.name;
                let message = doing(name, twin);
                let ran = || one(args, &opened.device, twin).map_err(|e| e.to_string());
                add(name, &twin.name(), wait::during(args.output.quiet, &message, ran));
            }
        }
        devices.iter().map(|opened| opened.device.name.clone()).collect()
    } else {
        let names = open::names(args.adapter.as_deref())?;
        for name in &names {
            for &twin in &options.twins {
                let ran = wait::during(args.output.quiet, &doing(name, twin), || {
                    apart(args, name, twin)
                })?;
                add(name, &twin.name(), ran);
            }
        }
        names
    };
    let text = if args.output.json { json::document(&all)? } else { table(&all, names.iter()) };
    say::result(&text)?;
    let mut found = failures;
    found.extend(all.conformance.iter().filter_map(|row| {
        let difference = row.difference.as_ref()?;
        Some(format!("{}: {}: {difference}", row.adapter, row.method))
    }));
    let outside = all.stress.iter().filter(|row| row.outside > 0);
    found.extend(outside.map(|row| format!("{}: {}: {}", row.adapter, row.method, row.reason)));
    // An unsupported row does not count as a pass.
    if found.is_empty() && all.conformance.iter().all(|row| row.steps == 0) {
        found.push("nothing was compared".to_owned());
    }
    found.iter().for_each(|line| say::violation(line));
    Ok(if found.is_empty() { Verdict::Clean } else { Verdict::Found })
}

/// What a method showed, or why it showed nothing.
type Ran = std::result::Result<Litmus, String>;

fn doing(adapter: &AdapterName, twin: Twin) -> String {
    format!("litmus pixels of {} on {}", twin.name(), adapter.name)
}

/// The contention that was typed.
fn pressure(args: &Args) -> Result<Option<Pressure>> {
    args.stress.as_deref().map(|text| Pressure::parse("--stress", text)).transpose()
}

/// One method on one device.
fn one(args: &Args, device: &Device, twin: Twin) -> std::result::Result<Litmus, Failure> {
    let (repeats, pressure) = (args.repeats, pressure(args)?);
    let extent = stress::Extent { repeats, pressure, ..stress::Extent::default() };
    let conformance = vec![conform::conform(device, twin, conform::Extent::default())?];
    Ok(Litmus { conformance, stress: vec![stress::stress(device, twin, extent)?] })
}

/// The same in a process of its own.
///
/// # Errors
/// It cannot be started.
fn apart(args: &Args, adapter: &AdapterName, twin: Twin) -> Result<Ran> {
    let option = |name: &str, value: String| [name.to_owned(), value];
    let mut arguments = vec!["crosscheck".to_owned(), "--litmus".to_owned()];
    arguments.extend(option("--worker", worker::named(adapter)));
    arguments.extend(option("--method", twin.method.name().to_owned()));
    arguments.extend(option("--form", args.form.name().to_owned()));
    arguments.extend(option("--repeats", args.repeats.to_string()));
    arguments.extend(option("--limit", args.limit.to_string()));
    if let Some(pressure) = &args.stress {
        arguments.extend(option("--stress", pressure.clone()));
    }
    let mut process = Process::start(&arguments)?;
    let silence = Duration::from_secs(2 * args.limit + EXPLORING);
    loop {
        match process.next(silence) {
            Ok(Line::Litmus(found)) => return Ok(Ok(*found)),
            Ok(Line::Refused(why)) => return Ok(Err(why)),
            Ok(_) => {}
            Err((status, why)) => return Ok(Err(format!("{status}: {why}"))),
        }
    }
}

/// Be such a process: the one method on the adapter of this name.
///
/// # Errors
/// The name is none.
pub(super) fn work(args: &Args, options: &Options, name: &str) -> Result<Verdict> {
    let opened = match worker::open(args, name)? {
        Ok(opened) => opened,
        Err(failure) => {
            worker::tell(&Line::Refused(failure.to_string()));
            return Ok(Verdict::Clean);
        }
    };
    for &twin in &options.twins {
        worker::tell(&match one(args, &opened.device, twin) {
            Ok(found) => Line::Litmus(Box::new(found)),
            Err(failure) => Line::Refused(failure.to_string()),
        });
    }
    // Nothing is dropped: that could wait for the device again.
    std::process::exit(0)
}

fn table<'a>(all: &Litmus, names: impl Iterator<Item = &'a AdapterName>) -> String {
    use Align::{Left, Right};
    let mut text: String =
        names.map(|name| format!("{}: driver {}\n", name.name, name.driver)).collect();
    let heading =
        ["adapter", "method", "litmus", "orders", "steps", "words", "device and simulator"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(all.conformance.iter().map(|row| {
        let found = match (&row.unsupported, &row.difference) {
            (Some(why), _) => format!("unsupported: {why}"),
            (_, Some(_)) => "DIFFER".to_owned(),
            _ => "equal after every step".to_owned(),
        };
        let counts = [row.instances, row.orders, row.steps, row.words].map(|n| n.to_string());
        [vec![row.adapter.clone(), row.method.clone()], counts.to_vec(), vec![found]].concat()
    }));
    text += "\nOne invocation at a time\n";
    text += &columns(&[Left, Left, Right, Right, Right, Right, Left], &lines);
    let heading = [
        "adapter",
        "method",
        "litmus",
        "runs",
        "possible",
        "seen",
        "sequential",
        "relaxed",
        "outside",
        "rate <=",
        "runs/s",
        "status",
    ];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(all.stress.iter().map(|row| {
        let outcomes = [row.instances, row.runs, row.possible, row.seen];
        let classes = [row.sequential, row.relaxed, row.outside];
        let counts = [&outcomes[..], &classes].concat();
        let mut counts: Vec<String> = counts.iter().map(u64::to_string).collect();
        counts.push(format!("{:.1e}", row.rate_at_most));
        counts.push(format!("{:.0}", row.runs_per_second));
        let status = status(row.status, &row.reason);
        [vec![row.adapter.clone(), row.method.clone()], counts, vec![status]].concat()
    }));
    text += "\nMany copies at once: outcomes that interleavings can give, and of these seen; runs by what explains \
             their outcome\n";
    let counted = [Right; 9];
    text += &columns(&[&[Left, Left], &counted[..], &[Left]].concat(), &lines);
    text + &weak(&all.stress)
}

/// Outcomes of no interleaving, one by one; nothing if there are none.
fn weak(stress: &[Stressed]) -> String {
    use Align::{Left, Right};
    let heading = ["adapter", "method", "litmus pixel", "outcome", "runs", "class", "token"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(stress.iter().flat_map(|row| {
        row.outcomes.iter().map(|outcome| {
            let class = match outcome.complete {
                true => outcome.class.name().to_owned(),
                false => format!("{}, not all explored", outcome.class.name()),
            };
            let token = outcome.token.clone().unwrap_or_default();
            let (adapter, method) = (row.adapter.clone(), row.method.clone());
            let (litmus, held) = (outcome.litmus.clone(), outcome.outcome.clone());
            vec![adapter, method, litmus, held, outcome.runs.to_string(), class, token]
        })
    }));
    if lines.len() == 1 {
        return String::new();
    }
    let rows = columns(&[Left, Left, Left, Left, Right, Left, Left], &lines);
    format!(
        "\nOutcomes of no interleaving; `fragloom replay TOKEN --trace` shows how relaxed memory gives one\n{rows}"
    )
}
