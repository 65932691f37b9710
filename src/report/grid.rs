//! A table in several syntaxes: for people, as CSV and as LaTeX. Numbers are written the same on every machine.

use super::text::{Align, columns};

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Syntax {
    /// Aligned columns.
    Text,
    /// Comma-separated, with a line of names first; numbers in full.
    Csv,
    /// A `tabular` of LaTeX.
    Latex,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// For programs.
    pub name: &'static str,
    /// For people.
    pub heading: String,
}

impl Column {
    /// A column by its two names.
    #[must_use]
    pub fn new(name: &'static str, heading: impl Into<String>) -> Self {
        Self { name, heading: heading.into() }
    }
}

/// What stands in a column of a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cell {
    /// A word.
    Word(String),
    /// A number: in full, and as people read it.
    Number(String, String),
    /// No number, with what people read instead.
    Absent(&'static str),
}

impl Cell {
    /// A number with so many decimals for people, and as many as tell it from all others for programs.
    #[must_use]
    pub fn number(value: f64, decimals: usize) -> Self {
        Self::Number(value.to_string(), format!("{value:.decimals$}"))
    }

    /// A whole number.
    #[must_use]
    pub fn whole(value: impl Into<u64>) -> Self {
        let value = value.into();
        Self::Number(value.to_string(), super::text::thousands(value))
    }

    fn in_syntax(&self, syntax: Syntax) -> &str {
        match (self, syntax) {
            (Self::Word(text), _) | (Self::Number(text, _), Syntax::Csv) => text,
            (Self::Absent(_), Syntax::Csv) => "",
            (Self::Number(_, text), _) => text,
            (Self::Absent(text), _) => text,
        }
    }
}

/// A table: as many cells in every row as there are columns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grid {
    /// Its columns, from the left.
    pub columns: Vec<Column>,
    /// Its rows, from the top.
    pub rows: Vec<Vec<Cell>>,
}

/// A table in lines: what stands before the rows, the rows, and what comes after.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// Before the rows.
    pub head: String,
    /// Each with a line break at its end.
    pub rows: Vec<String>,
    /// Behind the rows.
    pub foot: String,
}

impl Grid {
    /// The table, with a line break at its end.
    #[must_use]
    pub fn write(&self, syntax: Syntax) -> String {
        let Lines { head, rows, foot } = self.lines(syntax);
        head + &rows.concat() + &foot
    }

    /// The table in lines, so that rows can change places.
    #[must_use]
    pub fn lines(&self, syntax: Syntax) -> Lines {
        let row = |row: &Vec<Cell>| -> Vec<String> {
            row.iter().map(|cell| cell.in_syntax(syntax).to_owned()).collect()
        };
        let rows: Vec<Vec<String>> = self.rows.iter().map(row).collect();
        let headings = || -> Vec<String> {
            self.columns.iter().map(|column| column.heading.clone()).collect()
        };
        match syntax {
            Syntax::Text => {
                let text = columns(&self.aligned(), &[vec![headings()], rows].concat());
                let mut lines = text.split_inclusive('\n').map(str::to_owned);
                let head = lines.next().unwrap_or_default();
                Lines { head, rows: lines.collect(), foot: String::new() }
            }
            Syntax::Csv => Lines {
                head: csv(self.columns.iter().map(|column| column.name), &[]),
                rows: rows.iter().map(|row| csv_line(row.iter().map(String::as_str))).collect(),
                foot: String::new(),
            },
            Syntax::Latex => self.latex(&headings(), &rows),
        }
    }

    /// Which columns hold words; the others hold numbers.
    #[must_use]
    pub fn words(&self) -> Vec<bool> {
        self.aligned().into_iter().map(|align| align == Align::Left).collect()
    }

    /// Columns of words stand left.
    fn aligned(&self) -> Vec<Align> {
        let is_word =
            |c: usize| self.rows.iter().any(|row| matches!(row.get(c), Some(Cell::Word(_))));
        (0..self.columns.len())
            .map(|c| if is_word(c) { Align::Left } else { Align::Right })
            .collect()
    }

    fn latex(&self, headings: &[String], rows: &[Vec<String>]) -> Lines {
        let letter = |align: Align| if align == Align::Left { 'l' } else { 'r' };
        let letters: String = self.aligned().into_iter().map(letter).collect();
        let line = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| latex(cell)).collect();
            cells.join(" & ") + " \\\\\n"
        };
        let heading = line(headings);
        Lines {
            head: format!("\\begin{{tabular}}{{{letters}}}\n\\hline\n{heading}\\hline\n"),
            rows: rows.iter().map(|row| line(row)).collect(),
            foot: "\\hline\n\\end{tabular}\n".to_owned(),
        }
    }
}

/// Lines of comma-separated cells, names first.
#[must_use]
pub fn csv<'a>(names: impl Iterator<Item = &'a str>, rows: &[Vec<String>]) -> String {
    let rows = rows.iter().map(|row| csv_line(row.iter().map(String::as_str)));
    csv_line(names) + &rows.collect::<String>()
}

fn csv_line<'a>(cells: impl Iterator<Item = &'a str>) -> String {
    let quoted = |cell: &str| {
        let plain = !cell.contains([',', '"', '\n']);
        if plain { cell.to_owned() } else { format!("\"{}\"", cell.replace('"', "\"\"")) }
    };
    cells.map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

/// Text whose every character LaTeX shows.
fn latex(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', c]),
            '\\' => escaped += "\\textbackslash{}",
            '~' => escaped += "\\textasciitilde{}",
            '^' => escaped += "\\textasciicircum{}",
            '<' => escaped += "\\textless{}",
            '>' => escaped += "\\textgreater{}",
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        let columns =
            vec![Column::new("method", "method"), Column::new("a", "A (%)"), Column::new("b", "B")];
        let row = |name: &str, a: Cell, b: Cell| vec![Cell::Word(name.into()), a, b];
        let rows = vec![
            row("dfb_x,&", Cell::number(1.0 / 3.0, 2), Cell::whole(1_234_u32)),
            row("m", Cell::Absent("equal"), Cell::Number("0.001".into(), "<0.01".into())),
        ];
        Grid { columns, rows }
    }

    #[test]
    fn for_people() {
        let expected = "method   A (%)      B\ndfb_x,&   0.33  1,234\nm        equal  <0.01\n";
        assert_eq!(grid().write(Syntax::Text), expected);
    }

    #[test]
    fn as_csv() {
        let expected = "method,a,b\n\"dfb_x,&\",0.3333333333333333,1234\nm,,0.001\n";
        assert_eq!(grid().write(Syntax::Csv), expected);
    }

    #[test]
    fn as_latex() {
        let expected = "\\begin{tabular}{lrr}\n\\hline\nmethod & A (\\%) & B \\\\\n\\hline\n\
                        dfb\\_x,\\& & 0.33 & 1,234 \\\\\nm & equal & \\textless{}0.01 \\\\\n\\hline\n\
                        \\end{tabular}\n";
        assert_eq!(grid().write(Syntax::Latex), expected);
        let all = latex("&%$#_{}~^\\<>");
        let expected = "\\&\\%\\$\\#\\_\\{\\}\\textasciitilde{}\\textasciicircum{}\
                        \\textbackslash{}\\textless{}\\textgreater{}";
        assert_eq!(all, expected);
    }
}
