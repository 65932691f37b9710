//! Statements: lines, one of which may go on in the next.

use std::borrow::Cow;

use super::super::parts::first_line;

/// The first statement of a text, how many lines it has, and what follows, if there is an end of line. A line that ends
/// in a backslash goes on in the next, unless it is a comment.
pub(super) fn statement(text: &str) -> (Cow<'_, str>, usize, Option<&str>) {
    let (first, mut rest) = first_line(text);
    let continued = |line: &str| line.trim_end().strip_suffix('\\').map(str::to_owned);
    let Some(mut whole) = continued(first).filter(|_| !first.trim_start().starts_with('#')) else {
        return (first.into(), 1, rest);
    };
    let mut lines = 1;
    while let Some(more) = rest {
        let (line, after) = first_line(more);
        (rest, lines) = (after, lines + 1);
        whole.push(' ');
        match continued(line) {
            Some(more) => whole.push_str(&more),
            None => {
                whole.push_str(line);
                break;
            }
        }
    }
    (whole.into(), lines, rest)
}

/// All statements, each with the number of its first line.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let (mut left, mut next) = (Some(text), 1);
    std::iter::from_fn(move || {
        let (whole, lines, rest) = statement(left?);
        let number = next;
        (left, next) = (rest, next + lines);
        Some((number, whole))
    })
}

/// The first word and the rest of a line, both trimmed; numbers lose the comment behind them.
pub(super) fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let bare = rest.split_once('#').map_or(rest, |(bare, _)| bare);
    let numeric = matches!(keyword, "v" | "vn" | "vt" | "f" | "fo" | "Kd" | "d" | "Tr");
    (keyword, if numeric { bare.trim() } else { rest.trim() })
}

/// A word for a message.
pub(super) fn clipped(word: &str) -> String {
    word.chars().take(40).collect()
}

/// A finite number.
pub(super) fn number(word: &str) -> std::result::Result<f64, String> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("{:?} is not a finite number", clipped(word))),
    }
}
