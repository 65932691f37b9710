//! Numbers and columns for people.

/// `1234567` as `1,234,567`.
#[must_use]
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let first = digits.len() % 3;
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && i % 3 == first {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A part of a whole in per cent with two decimals, rounded to nearest, but never to 0 or 100 unless exact.
#[must_use]
pub fn percent(part: u64, whole: u64) -> String {
    if whole == 0 {
        return "0 %".to_owned();
    }
    let (part, whole) = (u128::from(part), u128::from(whole));
    match (part * 10_000 + whole / 2) / whole {
        _ if part == 0 => "0 %".to_owned(),
        _ if part == whole => "100 %".to_owned(),
        0 => "<0.01 %".to_owned(),
        10_000 => ">99.99 %".to_owned(),
        hundredths => format!("{}.{:02} %", hundredths / 100, hundredths % 100),
    }
}

/// How a column is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// Rows of cells, the first row being the heading, as aligned columns two spaces apart.
///
/// Rows shorter than `columns` are filled up with empty cells; longer ones are cut.
#[must_use]
pub fn columns(columns: &[Align], rows: &[Vec<String>]) -> String {
    let cell = |row: &Vec<String>, c: usize| row.get(c).cloned().unwrap_or_default();
    let width = |c| rows.iter().map(|row| cell(row, c).chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns.len()).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (c, (align, width)) in columns.iter().zip(&widths).enumerate() {
            let cell = cell(row, c);
            line += &match align {
                Align::Left => format!("{cell:<width$}  "),
                Align::Right => format!("{cell:>width$}  "),
            };
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_set_apart() {
        let expected = [(0, "0"), (999, "999"), (1_000, "1,000"), (12_345_678, "12,345,678")];
        assert!(expected.iter().all(|&(number, text)| thousands(number) == text));
        assert_eq!(thousands(u64::MAX), "18,446,744,073,709,551,615");
    }

    #[test]
    fn percentages_never_hide_a_rest() {
        let cases = [
            (0, 7, "0 %"),
            (7, 7, "100 %"),
            (1, 1_000_000, "<0.01 %"),
            (999_999, 1_000_000, ">99.99 %"),
            (1, 3, "33.33 %"),
            (0, 0, "0 %"),
        ];
        assert!(cases.iter().all(|&(part, whole, text)| percent(part, whole) == text));
    }

    #[test]
    fn columns_are_aligned_without_trailing_blanks() {
        let row = |cells: &[&str]| cells.iter().map(|&cell| cell.to_owned()).collect();
        let rows = [row(&["name", "n"]), row(&["a", "10"]), row(&["longer"])];
        let text = columns(&[Align::Left, Align::Right], &rows);
        assert_eq!(text, "name     n\na       10\nlonger\n");
    }
}
