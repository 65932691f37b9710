//! The whole numbers in a source text, to try as depths and data words: a branch that asks for one of them is reached by
//! no other value. What fuzzers call a dictionary.

/// Numbers, their neighbours, and shifts between literals, below 2^32; sorted, each once.
pub(super) fn constants(source: &str) -> Vec<u32> {
    let mut found = Vec::new();
    for line in source.lines().map(without_comment) {
        let numbers = literals(line);
        for (i, &(number, end)) in numbers.iter().enumerate() {
            found.push(number);
            if let Some(&(by, _)) = numbers.get(i + 1)
                && line[end..].trim_start().starts_with("<<")
                && by < 64
            {
                found.push(number << by);
            }
        }
    }
    let near = found.iter().flat_map(|&n| [n.wrapping_sub(1), n, n.wrapping_add(1)]);
    let mut all: Vec<u32> = near.filter_map(|n| u32::try_from(n).ok()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn without_comment(line: &str) -> &str {
    line.split("//").next().unwrap_or(line)
}

/// The literals of a line, each with its end. Parts of names are none, nor are numbers beyond 64 bits.
fn literals(line: &str) -> Vec<(u64, usize)> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(start) = line[at..].find(is_part) {
        let start = at + start;
        let end = line[start..].find(|c| !is_part(c)).map_or(line.len(), |length| start + length);
        found.extend(number(&line[start..end]).map(|n| (n, end)));
        at = end;
    }
    found
}

fn number(word: &str) -> Option<u64> {
    let word = word.replace('_', "").to_lowercase();
    if !word.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let word = ["u8", "u16", "u32", "u64", "usize"]
        .iter()
        .find_map(|s| word.strip_suffix(s))
        .unwrap_or(&word);
    let radix =
        |prefix, radix| word.strip_prefix(prefix).map(|digits| u64::from_str_radix(digits, radix));
    let parsed = radix("0x", 16).or_else(|| radix("0b", 2)).or_else(|| radix("0o", 8));
    parsed.unwrap_or_else(|| word.parse()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_however_they_are_written() {
        let source = "if depth == 12_345 && data != 0xFF_u32 { a1[7usize] } // 99
            else { 1  <<  4; x2 } 0b101";
        let found = constants(source);
        for number in [12_345, 255, 7, 16, 1, 4, 5, 12_344, 12_346] {
            assert!(found.contains(&number), "{number} in {found:?}");
        }
        assert!(!found.contains(&99), "a comment: {found:?}");
    }

    #[test]
    fn what_is_no_number_is_none() {
        assert!(constants("let a1 = b_2 + max; // 5").is_empty());
        assert_eq!(constants("0x1_0000_0000 99999999999999999999999"), [u32::MAX]);
        assert_eq!(constants("0"), [0, 1]);
    }
}
