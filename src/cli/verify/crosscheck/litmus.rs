//! `fragloom crosscheck --litmus`: litmus pixels on devices, one invocation at a time, and then many copies at once.

use super::{Args, devices, status};
use crate::cli::Verdict;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::gpu::check::conform::{self, Conformance};
use crate::gpu::check::crosscheck::Options;
use crate::gpu::check::stress::{self, Stressed};
use crate::gpu::driver::device::AdapterName;
use crate::gpu::driver::failure::Failure;
use crate::report::json;
use crate::report::text::{Align, columns};

/// What `--litmus` prints.
#[derive(Debug, Default, serde::Serialize)]
struct Litmus {
    conformance: Vec<Conformance>,
    stress: Vec<Stressed>,
}

/// Litmus pixels on every device.
///
/// # Errors
/// `--repeats 0`, or there is no adapter.
pub(in crate::cli) fn run(args: &Args, options: &Options) -> Result<Verdict> {
    if args.repeats == 0 {
        return Err(Error::new("--repeats", "is 0, but must be at least 1"));
    }
    let devices = devices(args.adapter.as_deref())?;
    let extent = stress::Extent { repeats: args.repeats, ..stress::Extent::default() };
    let mut all = Litmus::default();
    let mut failures = Vec::new();
    for opened in &devices {
        let device = &opened.device;
        for &twin in &options.twins {
            let method = twin.method;
            let message = format!("litmus pixels of {method} on {}", device.name.name);
            let both = wait::during(args.output.quiet, &message, || {
                let conformance = conform::conform(device, twin, conform::Extent::default())?;
                Ok((conformance, stress::stress(device, twin, extent)?))
            });
            match both {
                Ok((conformance, stressed)) => {
                    all.conformance.push(conformance);
                    all.stress.push(stressed);
                }
                Err(failure) => {
                    let failure: Failure = failure;
                    failures.push(format!("{}: {method}: {failure}", device.name.name));
                }
            }
        }
    }
    let names = devices.iter().map(|opened| &opened.device.name);
    let text = if args.output.json { json::document(&all)? } else { table(&all, names) };
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
