//! `fragloom crosscheck --litmus --tune N`: which contention shows a race most often. `kb` races, and a device that never
//! shows it says nothing about others; so settings are tried at random, and the best ones can be given to `--stress`.

use super::{Args, devices};
use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::gpu::check::crosscheck;
use crate::gpu::check::pressure::Pressure;
use crate::gpu::check::stress::{Extent, Stressed, stress};
use crate::gpu::twin::source::Twin;
use crate::num::random::Random;
use crate::report::json;
use crate::report::text::{Align, columns};

/// The method that races.
const RACY: &str = "kb";

/// Settings of a search, at most.
const MOST: u32 = 10_000;

/// What some settings showed.
#[derive(Debug, serde::Serialize)]
struct Tried {
    adapter: String,
    /// None: the three fixed orders.
    pressure: Option<Pressure>,
    runs: u64,
    /// Pixels that did not hold what they must.
    wrong: u64,
    runs_per_second: f64,
}

impl Tried {
    fn new(found: Stressed, pressure: Option<Pressure>) -> Self {
        let Stressed { adapter, runs, wrong, runs_per_second, .. } = found;
        Self { adapter, pressure, runs, wrong, runs_per_second }
    }

    fn settings(&self) -> String {
        self.pressure.map_or_else(|| "three fixed orders".to_owned(), |one| one.to_string())
    }
}

/// Search on every device.
///
/// # Errors
/// N is out of range, or there is no adapter.
pub(super) fn run(catalogue: &Catalogue, args: &Args, count: u32) -> Result<Verdict> {
    if !(1..=MOST).contains(&count) {
        return Err(Error::new("--tune", format!("is {count}, and must be 1 to {MOST}")));
    }
    let twin = crosscheck::find(catalogue.find("--tune", RACY)?)?;
    let mut all = Vec::new();
    for opened in &devices(args.adapter.as_deref())? {
        let mut random = Random::new(args.seed, 0);
        let settings = (0..count).map(|_| Some(Pressure::random(&mut random)));
        for pressure in std::iter::once(None).chain(settings) {
            let name = &opened.device.name.name;
            let message = format!("trying contention on {name}: {} of {count}", all.len());
            let ran = wait::during(args.output.quiet, &message, || {
                stress(&opened.device, twin, extent(args, pressure))
            });
            match ran {
                Ok(found) => all.push(Tried::new(found, pressure)),
                Err(failure) => {
                    say::violation(&format!("{name}: {failure}"));
                    return Ok(Verdict::Found);
                }
            }
        }
    }
    say::result(&if args.output.json { json::document(&all)? } else { table(twin, &all) })?;
    Ok(Verdict::Clean)
}

/// Pixels with two fragments: enough to lose one.
fn extent(args: &Args, pressure: Option<Pressure>) -> Extent {
    Extent { fragments: 2, repeats: args.repeats, instances: 2, pressure }
}

fn table(twin: Twin, all: &[Tried]) -> String {
    use Align::{Left, Right};
    let heading = ["adapter", "contention", "runs", "wrong", "rate", "runs/s"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(all.iter().map(|one| {
        let rate = format!("{:.2e}", one.wrong as f64 / one.runs.max(1) as f64);
        let speed = format!("{:.0}", one.runs_per_second);
        let (runs, wrong) = (one.runs.to_string(), one.wrong.to_string());
        vec![one.adapter.clone(), one.settings(), runs, wrong, rate, speed]
    }));
    let mut text = columns(&[Left, Left, Right, Right, Right, Right], &lines);
    let mut adapters: Vec<&str> = all.iter().map(|one| one.adapter.as_str()).collect();
    adapters.dedup();
    for adapter in adapters {
        let own = all.iter().filter(|one| one.adapter == adapter && one.wrong > 0);
        // Of equal ones the first.
        let best = own.rev().max_by_key(|one| one.wrong);
        text += &match best {
            None => format!("{adapter}: no settings show that {} races\n", twin.method),
            Some(best) => match best.pressure {
                None => format!("{adapter}: best without --stress\n"),
                Some(pressure) => format!("{adapter}: best with --stress {pressure}\n"),
            },
        };
    }
    text
}
