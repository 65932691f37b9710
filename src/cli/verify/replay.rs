//! `fragloom replay`: replay a token's interleaving.

use std::path::{Path, PathBuf};

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::Output;
use crate::cli::terminal::interrupt::Interrupt;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::explore::Subject;
use crate::explore::program::controls;
use crate::explore::replay::slabs::slabs;
use crate::explore::replay::timeline::{Timeline, timeline_of};
use crate::explore::replay::token::{LitmusToken, SceneToken};
use crate::explore::replay::{Replay, replay};
use crate::explore::sample::minimise::{minimise_litmus, minimise_scene};
use crate::explore::sample::{SceneReplay, replay_scene};
use crate::explore::{Limits, Token};
use crate::image::{Image, png};
use crate::report::text::{Align, columns};
use crate::report::{files, json, table, timeline};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A token printed by `fragloom check` or `crosscheck --litmus`: a value that begins with fl2-
    #[arg(value_name = "TOKEN")]
    token: String,

    /// Print the interleaving: one column per invocation, the words, and the step from which on every continuation is
    /// wrong
    #[arg(long)]
    trace: bool,

    /// Minimise it: a scene to one pixel; a pixel first by fragments, then by switches between invocations; print the
    /// token
    #[arg(long)]
    minimise: bool,

    /// Write the timeline of a pixel's token, by the ending: .svg or .png draws it, .html is a page to step through,
    /// .json is its data. Any other name is a folder, which gets the trace, or the picture of a scene's token; of a method
    /// that merges, the slabs as well, and what they become in every order of arrival. May be given several times
    /// [default: not written]
    #[arg(short = 'o', value_name = "FILE|DIR")]
    out: Vec<PathBuf>,

    #[command(flatten)]
    output: Output,
}

/// Replay the token. Exit code 1 if the replay shows a violation.
///
/// # Errors
/// A token that is damaged, of another version, or for something that has changed since.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let token: Token = args.token.parse()?;
    check_outputs(args, &token)?;
    let interrupt = Interrupt::watch();
    let cancelled = || interrupt.pressed();
    let limits = Limits { states: 2_000_000, cancelled: &cancelled };
    match token {
        Token::Litmus(token) => litmus(catalogue, args, &token, &limits),
        Token::Scene(token) => scene(catalogue, args, &token, &limits),
    }
}

fn litmus(
    catalogue: &Catalogue,
    args: &Args,
    token: &LitmusToken,
    limits: &Limits<'_>,
) -> Result<Verdict> {
    let mut token = token.clone();
    if args.minimise {
        let smaller = || minimise_litmus(catalogue, &token, limits);
        token = wait::during(args.output.quiet, "minimising", smaller)?;
    }
    let replayed = wait::during(args.output.quiet, "replaying", || replay(catalogue, &token))?;
    let text = if args.output.json {
        json::document(&document(&token, &replayed))?
    } else {
        story(args, &token, &replayed)
    };
    say::result(&text)?;
    let subject = controls::find(catalogue, "TOKEN", &token.method)?;
    for path in &args.out {
        match Ending::of(path) {
            Some(ending) if !path.is_dir() => {
                let timeline = timeline_of(&subject, &token)?;
                files::write_bytes(path, &ending.bytes(&timeline, path)?)?;
            }
            _ => write_folder(path, &subject, &token, &replayed)?,
        }
    }
    let shown = replayed.run.violations().next().is_some() || replayed.cycle > 0;
    Ok(if shown { Verdict::Found } else { Verdict::Clean })
}

fn write_folder(
    folder: &Path,
    subject: &Subject,
    token: &LitmusToken,
    replayed: &Replay,
) -> Result<()> {
    files::write_bytes(&folder.join("trace.txt"), trace(replayed).as_bytes())?;
    if let Some(plot) = slabs(subject, &token.litmus) {
        files::write_bytes(&folder.join("slabs.svg"), plot.svg().as_bytes())?;
        write_picture(folder, "slabs.png", &plot.draw())?;
    }
    Ok(())
}

fn write_picture(folder: &Path, name: &str, image: &Image) -> Result<()> {
    let place = folder.join(name);
    let bytes = png::encode(image)
        .map_err(|error| Error::new(place.display().to_string(), error.to_string()))?;
    files::write_bytes(&place, &bytes)
}

fn story(args: &Args, token: &LitmusToken, replayed: &Replay) -> String {
    let conditions = token.conditions();
    let warp = if conditions.warp.is_some() { ", lanes of one warp" } else { "" };
    let made = match token.property.as_str() {
        LitmusToken::OUTCOME => "its outcome was seen on a device".to_owned(),
        property => format!("it was made from a violation of '{property}'"),
    };
    let mut text = format!(
        "{} on {}, memory {}{warp}: {} steps; {made}\n",
        token.method,
        token.litmus.describe(),
        conditions.memory,
        replayed.run.events.len(),
    );
    if args.minimise {
        text += &format!("{}\n", Token::Litmus(token.clone()));
    }
    if args.trace {
        text.push('\n');
        text += &trace(replayed);
        text.push('\n');
    }
    replayed.ending().iter().for_each(|line| text += &format!("{line}\n"));
    for (property, told) in replayed.run.events.iter().flat_map(|event| &event.wrong) {
        text += &format!("{}: {told}\n", property.name());
    }
    if let Some(steps) = replayed.doomed_after {
        text += &format!("from step {steps} on, every continuation is wrong\n");
    }
    if replayed.cycle > 0 {
        text += &format!("the last {} steps repeat forever\n", replayed.cycle);
    }
    text
}

fn trace(replayed: &Replay) -> String {
    let rows = replayed.table();
    let width = rows.iter().map(Vec::len).max().unwrap_or(0);
    let mut align = vec![Align::Left; width];
    align[0] = Align::Right;
    columns(&align, &rows)
}

fn document(token: &LitmusToken, replayed: &Replay) -> serde_json::Value {
    let steps: Vec<Vec<String>> = replayed.table();
    let wrong = replayed.run.violations();
    let wrong: Vec<_> = wrong
        .map(|(property, told)| serde_json::json!({ "property": property.name(), "message": told }))
        .collect();
    serde_json::json!({
        "method": token.method,
        "property": token.property,
        "instance": token.litmus.describe(),
        "memory": token.conditions().memory.name(),
        "profile": token.conditions().memory.profile(),
        "token": Token::Litmus(token.clone()).to_string(),
        "steps": replayed.run.events.len(),
        "cycle": replayed.cycle,
        "doomed_after": replayed.doomed_after,
        "violations": wrong,
        "trace": steps,
    })
}

fn scene(
    catalogue: &Catalogue,
    args: &Args,
    token: &SceneToken,
    limits: &Limits<'_>,
) -> Result<Verdict> {
    let quiet = args.output.quiet;
    if args.trace && !args.minimise {
        let problem = "is for pixels: --minimise cuts a scene's token down to one";
        return Err(Error::new("--trace", problem));
    }
    let again = || replay_scene(catalogue, token);
    let replayed = wait::during(quiet, "replaying", again)?;
    for folder in args.out.iter().filter(|path| Ending::of(path).is_none()) {
        write_picture(folder, "replay.png", &replayed.rendering.image)?;
    }
    if args.minimise {
        let cut = || minimise_scene(&replayed.scene, &replayed.options, limits);
        let smaller = wait::during(quiet, "minimising", cut)?;
        let timelines = args.out.iter().filter(|path| Ending::of(path).is_some());
        let timelines = timelines.cloned().collect();
        return litmus(
            catalogue,
            &Args { token: String::new(), minimise: true, out: timelines, ..args.copy() },
            &smaller,
            limits,
        );
    }
    report(args, &replayed)
}

fn report(args: &Args, replayed: &SceneReplay) -> Result<Verdict> {
    let report = &replayed.rendering.report;
    let text = if args.output.json {
        json::document(report)?
    } else {
        let name = &replayed.scene.name;
        let same = if report.fragments_hash.is_some() { "fragments" } else { "picture" };
        format!("replayed {name}, with the same {same}\n{}", table::accounting(report))
    };
    say::result(&text)?;
    Ok(if replayed.is_wrong() { Verdict::Found } else { Verdict::Clean })
}

/// What a timeline is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    Svg,
    Png,
    Html,
    Json,
}

impl Ending {
    /// By a file's ending; `None` for a folder.
    fn of(path: &Path) -> Option<Self> {
        match &path.extension()?.to_str()?.to_ascii_lowercase()[..] {
            "svg" => Some(Self::Svg),
            "png" => Some(Self::Png),
            "html" | "htm" => Some(Self::Html),
            "json" => Some(Self::Json),
            _ => None,
        }
    }

    fn bytes(self, timeline: &Timeline, path: &Path) -> Result<Vec<u8>> {
        Ok(match self {
            Self::Svg => timeline::svg(timeline)?.into_bytes(),
            Self::Html => timeline::page(timeline)?.into_bytes(),
            Self::Json => json::document(timeline)?.into_bytes(),
            Self::Png => png::encode(&timeline::picture(timeline)?)
                .map_err(|error| Error::new(path.display().to_string(), error.to_string()))?,
        })
    }
}

/// Before anything runs: a name that cannot be meant, or cannot be written.
fn check_outputs(args: &Args, token: &Token) -> Result<()> {
    for path in &args.out {
        let ending = Ending::of(path).filter(|_| !path.is_dir());
        if ending.is_none() {
            continue;
        }
        if matches!(token, Token::Scene(_)) && !args.minimise {
            let problem = "a timeline is of a pixel: --minimise cuts a scene's token down to one";
            return Err(Error::new("-o", problem));
        }
        files::check_output("-o", path)?;
    }
    files::check_distinct(&args.out.iter().map(|path| ("-o", path)).collect::<Vec<_>>())
}

impl Args {
    fn copy(&self) -> Self {
        Self {
            token: self.token.clone(),
            trace: self.trace,
            minimise: self.minimise,
            out: self.out.clone(),
            output: self.output.clone(),
        }
    }
}
