//! The command line: one file per command. A command takes what was typed (`options::flags`), checks and completes it
//! (`options::settings`), runs, and reports what it found.
//!
//! A module uses only modules that come before it in this order:
//!
//! `options` → `terminal` → `list` → `verify` → `draw` → `golden`
//!
//! Exit codes: 0, done and nothing wrong; 1, a difference or a violation was found; 2, an error. Results go to
//! stdout, everything else to stderr, one line each.

mod draw;
mod golden;
mod list;
mod options;
mod terminal;
mod verify;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser};

use crate::catalogue::{Catalogue, nearest};
use crate::error::Result;
use draw::{bench, compare, export, inspect, judge, render, report};
pub use golden::CommandLine;
#[cfg(feature = "gpu")]
use list::adapters;
use list::{claims, completions, info, man, methods, mutations, scenes};
use terminal::say;
#[cfg(feature = "gpu")]
use verify::crosscheck;
use verify::{check, replay, reproduce};

/// A bit-exact CPU rasterizer that runs multi-fragment shaders as concurrent programs.
#[derive(Debug, Parser)]
#[command(name = "fragloom", version, arg_required_else_help = false)]
#[command(after_help = "Exit codes: 0 nothing wrong; 1 a difference or a violation; 2 an error.")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Draw a scene with one method; print the accounting of its fragments.
    Render(Box<render::Args>),
    /// Say what is in a scene: objects, materials, bounds, camera, and how many fragments it gives.
    Info(info::Args),
    /// Draw a scene with several methods and compare each with the exact reference.
    Compare(Box<compare::Args>),
    /// Draw a scene with some methods and show one pixel: its fragments, what became of each, and the absorbance.
    Inspect(Box<inspect::Args>),
    /// Draw a scene with some methods and write a page for browsers: pictures, errors, and the fragments of every pixel.
    Report(Box<report::Args>),
    /// Write a scene as glTF for other renderers, with what they should draw, and where they may differ.
    Export(Box<export::Args>),
    /// Judge another renderer's picture or fragments against the exact answer, and say why they differ.
    Judge(Box<judge::Args>),
    /// Explore interleavings; say what is verified, violated or unknown.
    Check(Box<check::Args>),
    /// Replay a failing schedule.
    Replay(replay::Args),
    /// Time methods by phase, next to the same schemes on GPUs and Vulkan drivers.
    Bench(Box<bench::Args>),
    /// Pictures that must not change: record them, draw them again, and say what changed.
    Golden(golden::Args),
    /// Run the same schemes on GPUs and Vulkan drivers, and compare bit for bit.
    #[cfg(feature = "gpu")]
    Crosscheck(Box<crosscheck::Args>),
    /// List the available GPUs and Vulkan drivers.
    #[cfg(feature = "gpu")]
    Adapters(adapters::Args),
    /// Compute the papers' tables and figures, ours next to theirs.
    Reproduce(reproduce::Args),
    /// List the papers' claims, as they are checked.
    Claims(claims::Args),
    /// List the methods, from their contracts.
    Methods(methods::Args),
    /// List the built-in faults, and the methods that have them.
    Mutations(mutations::Args),
    /// List the built-in procedural scenes.
    Scenes(scenes::Args),
    /// Print the script by which a shell completes this command line.
    Completions(completions::Args),
    /// Print the manual page, or write the pages of all commands.
    Man(man::Args),
}

/// What a command found; errors are returned separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// Nothing wrong.
    Clean,
    /// A difference or a violation.
    Found,
}

/// The whole program, with the methods of a catalogue: reads the process's arguments and gives its exit code.
#[must_use]
pub fn main(catalogue: &Catalogue) -> ExitCode {
    let cli = match parse(std::env::args_os()) {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    match run(catalogue, &cli.command) {
        Ok(Verdict::Clean) => ExitCode::SUCCESS,
        Ok(Verdict::Found) => ExitCode::from(1),
        Err(error) => {
            say::error(&error.to_string());
            ExitCode::from(2)
        }
    }
}

/// The command line's definition, for help, completions and tests.
#[must_use]
pub fn command() -> clap::Command {
    Cli::command()
}

fn run(catalogue: &Catalogue, command: &Command) -> Result<Verdict> {
    match command {
        Command::Render(args) => render::run(catalogue, args),
        Command::Info(args) => info::run(args),
        Command::Compare(args) => compare::run(catalogue, args),
        Command::Inspect(args) => inspect::run(catalogue, args),
        Command::Report(args) => report::run(catalogue, args),
        Command::Export(args) => export::run(args),
        Command::Judge(args) => judge::run(args),
        Command::Check(args) => check::run(catalogue, args),
        Command::Replay(args) => replay::run(catalogue, args),
        Command::Bench(args) => bench::run(catalogue, args),
        Command::Golden(args) => golden::run(catalogue, args),
        #[cfg(feature = "gpu")]
        Command::Crosscheck(args) => crosscheck::run(catalogue, args),
        #[cfg(feature = "gpu")]
        Command::Adapters(args) => adapters::run(args),
        Command::Reproduce(args) => reproduce::run(args),
        Command::Claims(args) => claims::run(args),
        Command::Methods(args) => methods::run(catalogue, args),
        Command::Mutations(args) => mutations::run(args),
        Command::Scenes(args) => scenes::run(args),
        Command::Completions(args) => completions::run(args, self::command()),
        Command::Man(args) => man::run(args, self::command()),
    }
}

fn parse(arguments: impl IntoIterator<Item = OsString>) -> std::result::Result<Cli, ExitCode> {
    let matches = lenient(command()).try_get_matches_from(arguments);
    matches.and_then(|matches| Cli::from_arg_matches(&matches)).map_err(|error| {
        if !error.use_stderr() {
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        say::error(&unknown_command(&error).unwrap_or_else(|| one_line(&error)));
        ExitCode::from(2)
    })
}

/// Words that an option can be, in any case.
fn lenient(command: clap::Command) -> clap::Command {
    let ignores = |arg: clap::Arg| {
        let named = !arg.get_possible_values().is_empty() && arg.get_action().takes_values();
        arg.ignore_case(named)
    };
    command.mut_args(ignores).mut_subcommands(lenient)
}

/// What to say of a name that no command has, if that is the error.
fn unknown_command(error: &clap::Error) -> Option<String> {
    // A command that is missing has the same context, with the program's name.
    if error.kind() != ErrorKind::InvalidSubcommand {
        return None;
    }
    let Some(ContextValue::String(typed)) = error.get(ContextKind::InvalidSubcommand) else {
        return None;
    };
    let definition = command();
    let mut names: Vec<String> = vec!["help".to_owned()];
    // What is under a command is told with it.
    let mut below: Vec<String> = Vec::new();
    for sub in definition.get_subcommands() {
        names.push(sub.get_name().to_owned());
        let own = |below: &clap::Command| format!("{} {}", sub.get_name(), below.get_name());
        below.extend(sub.get_subcommands().map(own));
    }
    let last = |name: &String| name.rsplit(' ').next().unwrap_or_default().to_owned();
    let ends: Vec<String> = names.iter().chain(&below).map(last).collect();
    let ends: Vec<&str> = ends.iter().map(String::as_str).collect();
    let place = nearest(typed, &ends).and_then(|near| ends.iter().position(|end| *end == near));
    let right = match place.and_then(|place| names.iter().chain(&below).nth(place)) {
        Some(name) => format!("; did you mean {name}?"),
        None => {
            names.rotate_left(1);
            format!(". The commands are {}", names.join(", "))
        }
    };
    Some(format!("unknown command {typed:?}{right} (see --help)"))
}

/// clap's message without its colours, usage and line breaks.
fn one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let body =
        |line: &&str| !line.starts_with("Usage:") && !line.starts_with("For more information");
    let mut message = String::new();
    for paragraph in text.split("\n\n").filter(body) {
        let lines: Vec<&str> = paragraph.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
        if !message.is_empty() && !lines.is_empty() {
            message += "; ";
        }
        message += &lines.join(" ");
    }
    message + " (see --help)"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_holds_together() {
        command().debug_assert();
    }

    #[test]
    fn every_argument_has_a_help_text() {
        let definition = command();
        let all = definition.get_subcommands();
        for sub in all.flat_map(|sub| std::iter::once(sub).chain(sub.get_subcommands())) {
            assert!(sub.get_about().is_some(), "{}", sub.get_name());
            for argument in sub.get_arguments() {
                let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
                assert!(help.len() > 8, "{} {argument}", sub.get_name());
            }
        }
    }

    #[test]
    fn a_command_that_is_not_there_is_told_with_the_nearest() {
        let told = |line: &[&str]| {
            let line = std::iter::once(&"fragloom").chain(line);
            unknown_command(&Cli::try_parse_from(line).unwrap_err())
        };
        for (typed, meant) in [
            ("rendr", "render"),
            ("chek", "check"),
            ("hlep", "help"),
            ("completion", "completions"),
            ("recrod", "golden record"),
        ] {
            let expected =
                format!("unknown command \"{typed}\"; did you mean {meant}? (see --help)");
            assert_eq!(told(&[typed]), Some(expected.clone()));
            assert_eq!(told(&["help", typed]), Some(expected));
        }
        let all = told(&["nonsense"]).unwrap();
        assert!(command().get_subcommands().all(|sub| all.contains(sub.get_name())), "{all}");
        assert_eq!([told(&["render"]), told(&[])], [None, None], "other errors");
    }

    #[test]
    fn parse_errors_become_one_line() {
        for bad in [&["render"][..], &["rendr"], &["render", "x", "--sise", "4x4"], &[]] {
            let line = std::iter::once(&"fragloom").chain(bad);
            let text = one_line(&Cli::try_parse_from(line).unwrap_err());
            assert!(!text.contains('\n') && !text.contains("Usage"), "{text}");
        }
    }
}
