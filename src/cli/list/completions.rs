//! `fragloom completions`: what shells need to complete the command line.

use clap_complete::Shell;

use crate::cli::Verdict;
use crate::cli::terminal::say;
use crate::error::Result;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// The shell that the script is for
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

/// Print the script for a command line.
///
/// # Errors
/// stdout cannot be written.
pub(in crate::cli) fn run(args: &Args, mut definition: clap::Command) -> Result<Verdict> {
    say::bytes(&script(args.shell, &mut definition))?;
    Ok(Verdict::Clean)
}

fn script(shell: Shell, definition: &mut clap::Command) -> Vec<u8> {
    let name = definition.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(shell, definition, name, &mut script);
    script
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    #[test]
    fn every_shell_gets_every_command() {
        let mut definition = crate::cli::command();
        let names: Vec<String> =
            definition.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
        for shell in Shell::value_variants() {
            let script = String::from_utf8(script(*shell, &mut definition)).unwrap();
            for name in names.iter().map(String::as_str).chain(["transparent", "point-radius"]) {
                assert!(script.contains(name), "{shell} {name}");
            }
        }
    }
}
