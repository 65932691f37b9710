//! A page for browsers: one HTML file that needs no other file and no network. It shows pictures, tables, the fragments
//! of every pixel, and interleavings.
//!
//! A page is made of sections. A command makes a [`Section`] of each thing that it shows, adds them with [`Page::add`],
//! and writes the page:
//!
//! * a [`Section::Facts`] is names and values, with sentences below them;
//! * a [`Section::Table`] is a [`Grid`] whose rows may lead to other sections ([`Table`]);
//! * a [`Section::Pictures`] is pictures of one size that are zoomed together, two at a time under a slider
//!   ([`Pictures`]); with [`pixels::add`] they get a pixel inspector;
//! * a [`Section::Other`] is any data for a function of the page's script, by its name in `page.js` (`kinds`): so are the
//!   timelines of verdicts.
//!
//! What is large is attached ([`Page::attach`]), and read by the script when it is needed. To show something new, as of
//! another command: add its sections to a page as `cli::draw::report` does, and, for a new kind of section, a file with
//! a function to `files.rs` and its name to `kinds` in `page.js`.
//!
//! Equal pages have equal bytes.

mod block;
pub mod drawing;
mod files;
pub mod pixels;
pub mod verdicts;
mod write;

use serde::Serialize;

use super::grid::{Cell, Grid, Syntax};
use crate::error::{Error, Result};
use crate::image::{Image, png};

/// A page: a title and sections.
#[derive(Clone, Debug, Default)]
pub struct Page {
    title: String,
    sections: Vec<Placed>,
    /// Where the sections refer to: those that are needed at once, and the others.
    early: Vec<Vec<u8>>,
    late: Vec<Vec<u8>>,
}

/// A section with its name in links.
#[derive(Clone, Debug, Serialize)]
struct Placed {
    id: String,
    title: String,
    #[serde(flatten)]
    section: Section,
}

/// Something on a page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Section {
    /// Names and values, and sentences.
    Facts {
        /// Names and values.
        rows: Vec<[String; 2]>,
        /// Sentences below them.
        notes: Vec<String>,
    },
    /// A table that can be sorted.
    Table(Table),
    /// Pictures of one size.
    Pictures(Pictures),
    /// Data for a function of the script.
    #[serde(untagged)]
    Other {
        /// The function's name in `kinds`.
        kind: &'static str,
        /// Its data.
        data: serde_json::Value,
    },
}

/// A table that can be sorted, and exported as CSV and LaTeX.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Table {
    columns: Vec<Heading>,
    rows: Vec<Row>,
    /// What stands before and behind the rows in CSV and in LaTeX.
    csv: [String; 2],
    latex: [String; 2],
    notes: Vec<String>,
}

#[derive(Clone, Debug, Serialize)]
struct Heading {
    text: String,
    word: bool,
}

#[derive(Clone, Debug, Serialize)]
struct Row {
    /// What people read, and a number to sort by.
    cells: Vec<(String, Option<f64>)>,
    csv: String,
    latex: String,
    /// The section that the first cell leads to.
    #[serde(skip_serializing_if = "Option::is_none")]
    link: Option<String>,
}

impl Table {
    /// Of a grid; `links` are the names of sections that the rows lead to ([`Page::add`]), as far as they do.
    #[must_use]
    pub fn new(grid: &Grid, links: &[Option<String>], notes: Vec<String>) -> Self {
        let words = grid.words();
        let heading = |(column, word): (&super::grid::Column, &bool)| Heading {
            text: column.heading.clone(),
            word: *word,
        };
        let [csv, latex] = [Syntax::Csv, Syntax::Latex].map(|syntax| grid.lines(syntax));
        let cell = |cell: &Cell| match cell {
            Cell::Word(text) => (text.clone(), None),
            Cell::Number(full, text) => (text.clone(), full.parse().ok()),
            Cell::Absent(text) => ((*text).to_owned(), None),
        };
        let row = |(i, cells): (usize, &Vec<Cell>)| Row {
            cells: cells.iter().map(cell).collect(),
            csv: csv.rows[i].clone(),
            latex: latex.rows[i].clone(),
            link: links.get(i).cloned().flatten(),
        };
        Self {
            columns: grid.columns.iter().zip(&words).map(heading).collect(),
            rows: grid.rows.iter().enumerate().map(row).collect(),
            csv: [csv.head.clone(), csv.foot.clone()],
            latex: [latex.head.clone(), latex.foot.clone()],
            notes,
        }
    }
}

/// Pictures of one size.
#[derive(Clone, Debug, Serialize)]
pub struct Pictures {
    size: [u32; 2],
    pictures: Vec<Picture>,
    /// For the pixel inspector.
    #[serde(skip_serializing_if = "Option::is_none")]
    pixels: Option<pixels::Pixels>,
}

#[derive(Clone, Debug, Serialize)]
struct Picture {
    name: String,
    /// What is attached.
    data: String,
    /// A map of errors, which is never laid under the slider, with its meaning.
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<String>,
}

impl Pictures {
    /// None yet, of this width and height in pixels.
    #[must_use]
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, pictures: Vec::new(), pixels: None }
    }

    /// Add a picture; the first two are under the slider at first.
    ///
    /// # Errors
    /// A picture without pixels, or of another size.
    pub fn add(&mut self, page: &mut Page, name: &str, image: &Image) -> Result<()> {
        self.push(page, name, image, None)
    }

    /// Add a map of errors; `meaning` says what its colours stand for.
    ///
    /// # Errors
    /// A picture without pixels, or of another size.
    pub fn add_map(
        &mut self,
        page: &mut Page,
        name: &str,
        image: &Image,
        meaning: &str,
    ) -> Result<()> {
        self.push(page, name, image, Some(meaning.to_owned()))
    }

    fn push(
        &mut self,
        page: &mut Page,
        name: &str,
        image: &Image,
        map: Option<String>,
    ) -> Result<()> {
        let wrong = |problem: String| Error::new(format!("the picture {name:?}"), problem);
        let size = [image.width, image.height];
        if size != self.size {
            let ([w, h], [width, height]) = (size, self.size);
            return Err(wrong(format!("is {w}x{h}, and must be {width}x{height}")));
        }
        let bytes = png::encode(image).map_err(|error| wrong(error.to_string()))?;
        let data = page.attach(bytes, true);
        self.pictures.push(Picture { name: name.to_owned(), data, map });
        Ok(())
    }
}

impl Page {
    /// A page without sections.
    #[must_use]
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), ..Self::default() }
    }

    /// The name in links that the section will have which is added after `later` others.
    #[must_use]
    pub fn name(&self, later: usize) -> String {
        format!("section-{}", self.sections.len() + later + 1)
    }

    /// Add a section below the others.
    pub fn add(&mut self, title: &str, section: Section) {
        let id = self.name(0);
        self.sections.push(Placed { id, title: title.to_owned(), section });
    }

    /// Attach data, and give its name for the script. What is needed `at_once` stands before the script, and the rest
    /// behind it, so that it does not keep the page from opening.
    pub fn attach(&mut self, bytes: Vec<u8>, at_once: bool) -> String {
        let (list, letter) = match at_once {
            true => (&mut self.early, 'a'),
            false => (&mut self.late, 'b'),
        };
        list.push(bytes);
        format!("{letter}{}", list.len() - 1)
    }
}
