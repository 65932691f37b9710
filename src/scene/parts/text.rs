//! Text as files really have it: with byte order marks, in other encodings than UTF-8, with any line ends.

use std::borrow::Cow;

/// The bytes after a byte order mark of UTF-8, if there is one.
pub(in crate::scene) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// The text of a file: UTF-8, or UTF-16 by its byte order mark. A byte that is not UTF-8 is taken for Latin-1, so that
/// a name stays the same name in two files.
pub(in crate::scene) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.as_chunks().0.iter().map(|&pair| unit(pair)).collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    match bytes {
        [0xFF, 0xFE, rest @ ..] => return wide(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => return wide(rest, u16::from_be_bytes),
        _ => {}
    }
    let bytes = without_mark(bytes);
    if let Ok(text) = std::str::from_utf8(bytes) {
        return Cow::Borrowed(text);
    }
    let mut text = String::with_capacity(bytes.len() + 16);
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        text.extend(chunk.invalid().iter().map(|&byte| char::from(byte)));
    }
    Cow::Owned(text)
}

/// Whether a byte ends a line. Within UTF-8, such a byte is always that character.
pub(in crate::scene) fn ends_line(byte: u8) -> bool {
    matches!(byte, b'\r' | b'\n')
}

/// The first line of a text, and what follows its end, if it has one. A line ends in LF, CR or both.
pub(in crate::scene) fn first_line(text: &str) -> (&str, Option<&str>) {
    let Some(end) = text.bytes().position(ends_line) else { return (text, None) };
    let (line, rest) = text.split_at(end);
    (line, Some(rest.strip_prefix("\r\n").unwrap_or(&rest[1..])))
}

/// The lines of a text with their numbers from 1.
pub(in crate::scene) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut left = Some(text);
    let next = move || {
        let (line, rest) = first_line(left?);
        left = rest;
        Some(line)
    };
    (1..).zip(std::iter::from_fn(next))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_any_way() {
        let found: Vec<_> = lines("a\r\nb\rc\n\nd").collect();
        assert_eq!(found, [(1, "a"), (2, "b"), (3, "c"), (4, ""), (5, "d")]);
    }

    #[test]
    fn text_of_any_encoding() {
        assert_eq!(decode(b"\xEF\xBB\xBFv 1"), "v 1");
        assert_eq!(decode(b"gr\xFCn"), "grün");
        assert_eq!(decode("grün".as_bytes()), "grün");
        assert_eq!(decode(b"\xFF\xFEv\0 \x001\0"), "v 1");
        assert_eq!(decode(b"\xFE\xFF\0v\0 \x001"), "v 1");
    }
}
