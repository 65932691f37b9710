//! How a picture is drawn: options, and the words that they were typed as.

use clap::{ArgMatches, Args, Command, FromArgMatches};

use crate::cli::options::effects::Effects;
use crate::cli::options::flags::Drawing;

/// The options of a picture, but for its method.
#[derive(Clone, Debug, Args)]
pub(super) struct Look {
    #[command(flatten)]
    pub(super) drawing: Drawing,

    #[command(flatten)]
    pub(super) effects: Effects,

    /// Leave the background out: the picture keeps its opacity, 1 less the transmittance
    #[arg(long)]
    pub(super) transparent: bool,
}

/// The same, as words: those that were given, in the order of the definition.
#[derive(Clone, Debug)]
pub(super) struct Words {
    pub(super) look: Look,
    pub(super) words: Vec<String>,
}

impl Args for Words {
    fn augment_args(command: Command) -> Command {
        Look::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Look::augment_args_for_update(command)
    }
}

impl FromArgMatches for Words {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Self::from_arg_matches_mut(&mut matches.clone())
    }

    fn from_arg_matches_mut(matches: &mut ArgMatches) -> Result<Self, clap::Error> {
        let words = words(matches);
        Ok(Self { look: Look::from_arg_matches_mut(matches)?, words })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.words = words(matches);
        self.look.update_from_arg_matches(matches)
    }
}

/// The words that give these values again.
fn words(matches: &ArgMatches) -> Vec<String> {
    let definition = Look::augment_args(Command::new("look"));
    let mut words = Vec::new();
    for argument in definition.get_arguments() {
        let id = argument.get_id().as_str();
        if matches.value_source(id) != Some(clap::parser::ValueSource::CommandLine) {
            continue;
        }
        let name = match (argument.get_long(), argument.get_short()) {
            (Some(long), _) => format!("--{long}"),
            (None, short) => short.map(|short| format!("-{short}")).unwrap_or_default(),
        };
        if !argument.get_action().takes_values() {
            words.push(name);
            continue;
        }
        for occurrence in matches.get_raw_occurrences(id).into_iter().flatten() {
            words.push(name.clone());
            let values: Vec<String> =
                occurrence.map(|value| value.to_string_lossy().into_owned()).collect();
            match argument.get_value_delimiter() {
                Some(between) => words.push(values.join(&between.to_string())),
                None => words.extend(values),
            }
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    #[command(no_binary_name = true)]
    struct Line {
        #[command(flatten)]
        words: Words,
    }

    fn typed(words: &[&str]) -> Words {
        Line::try_parse_from(words).unwrap().words
    }

    #[test]
    fn words_are_those_that_were_given() {
        assert_eq!(typed(&[]).words, Vec::<String>::new());
        let given = ["--size", "64x48", "-k", "3", "--up", "-z", "--ortho", "--exec", "sim"];
        let found = typed(&given);
        assert_eq!(found.words.len(), given.len());
        assert!(given.iter().all(|word| found.words.iter().any(|own| own == word)), "{found:?}");
        let lists =
            typed(&["--importance=depth,noise", "--transparent", "--effect=csg=(a | b) - c"]);
        let expected =
            ["--importance", "depth,noise", "--effect", "csg=(a | b) - c", "--transparent"];
        assert_eq!(lists.words, expected);
    }

    /// Whatever is given, its words give the same again.
    #[test]
    fn words_give_the_same_again() {
        for given in [
            &["-k", "3", "--ortho", "--alpha", "0.25", "--eye", "-1,2,3"][..],
            &["--ortho", "2.5", "--cull-face", "back", "--gaze", "-4,5.5"],
            &["--shadows", "--effect", "csg=a - b", "--exec", "threads", "--threads", "3"],
            &["--thickness", "-1x", "--schedule", "recorded:a b.bin", "--importance", "map"],
        ] {
            let once = typed(given);
            let words: Vec<&str> = once.words.iter().map(String::as_str).collect();
            let again = typed(&words);
            assert_eq!(format!("{again:?}"), format!("{once:?}"));
        }
    }
}
