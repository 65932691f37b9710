//! What the TOML parser says of a scene file, without the words of its insides.

/// The message for what stands at a byte of a text: the line, the key if there is one, and what would be right.
pub(in crate::scene) fn plain(message: &str, text: &str, at: usize) -> String {
    let before = text.get(..at.min(text.len())).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let own = text.lines().nth(line - 1).unwrap_or_default();
    let key = own.split_once('=').map(|(key, _)| key.trim()).filter(|key| {
        !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.')
    });
    let message = message.replace('\n', "; ");
    let (about, problem) = match message.split_once(", expected ") {
        Some((what, right)) => (key, said(what, right)),
        None => (None, None),
    };
    let problem = problem.unwrap_or_else(|| match message.strip_prefix("missing field ") {
        Some(field) => format!("{} is missing", bare(field)),
        None => message.clone(),
    });
    match about {
        Some(key) if !problem.starts_with(key) => format!("line {line}: {key}: {problem}"),
        _ => format!("line {line}: {problem}"),
    }
}

/// What is there, and what must be.
fn said(what: &str, right: &str) -> Option<String> {
    if let Some(found) = what.strip_prefix("invalid type: ") {
        return Some(format!("is {}, and must be {}", value(found), kind(right)));
    }
    if let Some(count) = what.strip_prefix("invalid length ") {
        return Some(format!("is a list of {count}, and must be {}", kind(right)));
    }
    if let Some(found) = what.strip_prefix("invalid value: ") {
        return Some(format!("is {}, and must be {}", value(found), kind(right)));
    }
    if let Some(name) = what.strip_prefix("unknown field ") {
        return Some(format!("{} is no key here; there are {}", bare(name), names(right)));
    }
    if let Some(name) = what.strip_prefix("unknown variant ") {
        return Some(format!("is {}, and must be one of {}", bare(name), names(right)));
    }
    None
}

/// Without backticks.
fn bare(word: &str) -> String {
    word.replace('`', "")
}

fn names(list: &str) -> String {
    bare(list.trim_start_matches("one of "))
}

fn value(found: &str) -> String {
    let (kind, rest) = found.split_once(' ').unwrap_or((found, ""));
    match kind {
        "string" => format!("the text {rest}"),
        "integer" => format!("the number {}", bare(rest)),
        "floating" => format!("the number {}", bare(rest.trim_start_matches("point "))),
        "boolean" => bare(rest),
        "map" => "a table".to_owned(),
        "sequence" => "a list".to_owned(),
        _ => bare(found),
    }
}

fn kind(right: &str) -> String {
    let count = right.strip_prefix("an array of length ");
    if let Some(count) = count {
        return format!("a list of {count}");
    }
    match right {
        "f64" | "f32" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0".to_owned(),
        "a string" => "a text, in quotes".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        _ if right.starts_with("struct ") => "a table".to_owned(),
        _ => bare(right),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_key_and_what_would_be_right() {
        let text = "a = 1\nsize = \"a\"\n[[objec]]\nshading = \"x\"\n[camera]\n";
        let at = |part: &str| text.find(part).unwrap();
        for (message, part, expected) in [
            (
                "invalid type: string \"a\", expected an array of length 2",
                "\"a\"",
                "line 2: size: is the text \"a\", and must be a list of 2",
            ),
            (
                "unknown field `objec`, expected one of `size`, `object`",
                "objec",
                "line 3: objec is no key here; there are size, object",
            ),
            (
                "unknown variant `x`, expected one of `flat`, `lambert`",
                "\"x\"",
                "line 4: shading: is x, and must be one of flat, lambert",
            ),
            ("missing field `eye`", "[camera]", "line 5: eye is missing"),
            (
                "invalid length 1, expected an array of length 3",
                "1",
                "line 1: a: is a list of 1, and must be a list of 3",
            ),
            (
                "invalid type: floating point `1.5`, expected u32",
                "1",
                "line 1: a: is the number 1.5, and must be a whole number from 0",
            ),
            ("missing comma", "1", "line 1: missing comma"),
        ] {
            assert_eq!(plain(message, text, at(part)), expected);
        }
        assert_eq!(plain("x", "", 99), "line 1: x");
    }
}
