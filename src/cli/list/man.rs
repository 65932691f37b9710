//! `fragloom man`: the manual pages, from the command line's definition.

use std::path::PathBuf;

use clap_mangen::Man;

use crate::cli::Verdict;
use crate::cli::terminal::say;
use crate::error::{Error, Result};
use crate::report::files;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Write the pages of the program and of every command into this folder [default: the program's page, to stdout]
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// A page and the name of its file.
struct Page {
    name: String,
    text: Vec<u8>,
}

/// Print the program's page, or write all of them.
///
/// # Errors
/// A folder or a file that cannot be written.
pub(in crate::cli) fn run(args: &Args, definition: clap::Command) -> Result<Verdict> {
    let pages = pages(definition)?;
    match &args.folder {
        Some(folder) => {
            files::check_folder("DIR", folder)?;
            for Page { name, text } in &pages {
                files::write_bytes(&folder.join(name), text)?;
            }
        }
        None => pages.first().map_or(Ok(()), |page| say::bytes(&page.text))?,
    }
    Ok(Verdict::Clean)
}

/// The program's page first, then those of its commands.
fn pages(definition: clap::Command) -> Result<Vec<Page>> {
    // The help of a command is its page.
    let mut definition = definition.disable_help_subcommand(true);
    definition.build();
    let version = definition.get_version().unwrap_or_default();
    let source = format!("{} {version}", definition.get_name());
    let below = definition.get_subcommands();
    let below = below.flat_map(|command| std::iter::once(command).chain(command.get_subcommands()));
    let commands = std::iter::once(&definition).chain(below);
    let page = |command: &clap::Command| {
        let page = Man::new(command.clone()).source(&source);
        let mut text = Vec::new();
        page.render(&mut text).map_err(|error| Error::new("man", error.to_string()))?;
        Ok(Page { name: page.get_filename(), text })
    };
    commands.map(page).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_its_options() {
        let pages = pages(crate::cli::command()).unwrap();
        let names: Vec<&str> = pages.iter().map(|page| page.name.as_str()).collect();
        let definition = crate::cli::command();
        let subs = definition.get_subcommands();
        let expected: Vec<String> = std::iter::once("fragloom.1".to_owned())
            .chain(subs.flat_map(|sub| {
                let own = format!("fragloom-{}", sub.get_name());
                let below =
                    sub.get_subcommands().map(|below| format!("{own}-{}.1", below.get_name()));
                std::iter::once(format!("{own}.1")).chain(below.collect::<Vec<_>>())
            }))
            .collect();
        assert_eq!(names, expected);
        let text = |name: &str| {
            let page = pages.iter().find(|page| page.name == name).unwrap();
            // In these pages, a hyphen is escaped.
            String::from_utf8(page.text.clone()).unwrap().replace("\\-", "-")
        };
        assert!(text("fragloom.1").contains("fragloom-render(1)"));
        assert!(text("fragloom.1").contains("Exit codes: 0"));
        assert!(text("fragloom-render.1").contains("--transparent"));
        assert!(text("fragloom-golden-verify.1").contains("--bless"));
        assert!(text("fragloom-render.1").starts_with(".ie"), "{}", text("fragloom-render.1"));
        for page in &pages {
            let text = text(&page.name);
            let version = format!("\"fragloom {}\"", env!("CARGO_PKG_VERSION"));
            assert!(text.contains(&version) && !text.contains("help(1)"), "{}", page.name);
        }
    }
}
