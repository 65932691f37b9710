//! A timeline as a drawing: a column for every lane, a row for every step, and what memory holds beside it.

use super::rows::{Row, rows};
use crate::error::{Error, Result};
use crate::explore::replay::timeline::{Locking, Timeline};
use crate::image::Image;
use crate::image::drawing::look::{Ink, LETTER, LINE, MARGIN};
use crate::image::drawing::{Anchor, Drawing, Face};

/// The most steps that are drawn: a page shows more.
pub const MOST_STEPS: usize = 500;

/// On both sides of the letters in a column.
const PAD: f64 = 8.0;

/// From the top of a row to where its letters stand.
const BASE: f64 = 13.0;

/// As SVG, with colours for light and dark paper.
///
/// # Errors
/// More than [`MOST_STEPS`] steps.
pub fn svg(timeline: &Timeline) -> Result<String> {
    Ok(drawing(timeline)?.svg())
}

/// As a picture, two pixels for every unit of the SVG.
///
/// # Errors
/// More than [`MOST_STEPS`] steps.
pub fn picture(timeline: &Timeline) -> Result<Image> {
    Ok(drawing(timeline)?.draw())
}

fn drawing(timeline: &Timeline) -> Result<Drawing> {
    let steps = timeline.steps.len();
    if steps > MOST_STEPS {
        let problem = format!(
            "{steps} steps are more than a picture has, at most {MOST_STEPS}: a page (.html) shows all"
        );
        return Err(Error::new("-o", problem));
    }
    let rows = rows(timeline);
    let columns = Columns::new(timeline, &rows);
    let width = columns.right + MARGIN;
    let letters = ((width - 2.0 * MARGIN) / LETTER[0]) as usize;
    let notes: Vec<(String, Ink)> =
        notes(timeline).into_iter().flat_map(|(note, ink)| wrapped(&note, letters, ink)).collect();
    let title = format!("{}, {}", timeline.method, timeline.instance);
    let head: Vec<(String, Ink)> = heading(timeline)
        .into_iter()
        .flat_map(|(line, ink)| wrapped(&line, letters, ink))
        .collect();
    let titles = wrapped(&title, letters * 8 / 9, Ink::Text);
    let top = MARGIN + LINE * (titles.len() + head.len()) as f64 + 10.0;
    let bottom = top + LINE * (rows.len() + 2) as f64;
    let height = bottom + LINE * (notes.len() + 1) as f64 + MARGIN;
    let mut drawing = Drawing::new([width, height], &title);
    let mut down = MARGIN;
    for (line, ink) in titles {
        drawing.letters([MARGIN, down + BASE], Anchor::Start, &line, ink, Face::Title);
        down += LINE;
    }
    for (line, ink) in head {
        drawing.text([MARGIN, down + BASE], Anchor::Start, &line, ink);
        down += LINE;
    }
    let sheet = Sheet { timeline, columns, top };
    sheet.draw(&mut drawing, &rows);
    let mut down = bottom + LINE / 2.0;
    for (line, ink) in notes {
        drawing.text([MARGIN, down + BASE], Anchor::Start, &line, ink);
        down += LINE;
    }
    Ok(drawing)
}

/// What stands below the title.
fn heading(timeline: &Timeline) -> Vec<(String, Ink)> {
    let profile = timeline.profile.iter().map(|profile| format!("/{profile}")).collect::<String>();
    let warp = if timeline.warp.is_some() { ", lanes of one warp" } else { "" };
    let memory =
        format!("memory {}{profile}{warp}: {} steps", timeline.memory, timeline.steps.len());
    let fault = timeline
        .fault
        .as_ref()
        .map(|fault| (format!("{}: {}", fault.property, fault.message), Ink::Fault));
    [Some((memory, Ink::Quiet)), fault].into_iter().flatten().collect()
}

/// What stands below the steps.
fn notes(timeline: &Timeline) -> Vec<(String, Ink)> {
    let causes = timeline.fault.iter().flat_map(|fault| &fault.causes);
    let mut notes: Vec<(String, Ink)> =
        causes.map(|cause| (cause.message.clone(), Ink::Fault)).collect();
    let stale = timeline.steps.iter().flat_map(|step| &step.changes).any(|c| c.versions.len() > 1);
    if stale {
        let note = "(+1): an older value can still be read. Values are hexadecimal.";
        notes.push((note.to_owned(), Ink::Quiet));
    } else {
        notes.push(("Values are hexadecimal.".to_owned(), Ink::Quiet));
    }
    for pixel in &timeline.result {
        let found = pixel.found.as_deref().unwrap_or("nothing yet: the run has not ended");
        let must = match (&pixel.expected, &pixel.possible[..]) {
            (Some(expected), _) => format!(", must hold {expected}"),
            (None, []) => String::new(),
            (None, possible) => format!(", may hold {}", possible.join(" or ")),
        };
        let ink = if pixel.expected.is_some() && pixel.expected != pixel.found {
            Ink::Fault
        } else {
            Ink::Text
        };
        notes.push((format!("pixel {} holds {found}{must}", pixel.pixel), ink));
    }
    notes
}

/// Lines of at most so many letters, broken between words where that is possible.
fn wrapped(text: &str, letters: usize, ink: Ink) -> Vec<(String, Ink)> {
    let most = letters.max(20);
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        let length = |text: &str| text.chars().count();
        if length(&lines[last]) + 1 + length(word) <= most || lines[last].is_empty() {
            if !lines[last].is_empty() {
                lines[last].push(' ');
            }
            lines[last] += word;
        } else {
            lines.push(word.to_owned());
        }
    }
    let cut = |line: String| {
        let letters: Vec<char> = line.chars().collect();
        letters.chunks(most).map(|part| part.iter().collect::<String>()).collect::<Vec<_>>()
    };
    lines.into_iter().flat_map(cut).map(|line| (line, ink)).collect()
}

/// Where columns begin, and how wide they are.
struct Columns {
    lanes: Vec<[f64; 2]>,
    words: Vec<[f64; 2]>,
    right: f64,
}

impl Columns {
    fn new(timeline: &Timeline, rows: &[Row<'_>]) -> Self {
        let wide = |letters: usize| letters as f64 * LETTER[0] + 2.0 * PAD;
        let mut at = MARGIN + wide(4);
        let mut next = |letters: usize| {
            let column = [at, wide(letters)];
            at += column[1] + 4.0;
            column
        };
        let lane = |lane: usize| {
            let names = timeline.stages.iter().map(|stage| stage.lanes[lane].name.chars().count());
            let own = rows.iter().filter(|row| row.step.is_some_and(|step| step.lane == lane));
            names.chain(own.map(|row| row.text.chars().count())).max().unwrap_or(0)
        };
        let lanes = (0..timeline.lanes).map(|i| next(lane(i))).collect();
        let word = |i: usize| {
            let values = rows.iter().map(|row| row.values[i].chars().count());
            let name = timeline.words[i].name.chars().count();
            let initial = timeline.words[i].initial.as_ref().map_or(1, String::len);
            values.chain([name, initial]).max().unwrap_or(0)
        };
        let words = (0..timeline.words.len()).map(|i| next(word(i))).collect();
        // Room for what is said of a step.
        let said = rows.iter().filter(|row| row.step.is_none()).map(|row| row.text.chars().count());
        let right = at.max(MARGIN + wide(4) + wide(said.max().unwrap_or(0)));
        Self { lanes, words, right }
    }
}

/// The table of steps.
struct Sheet<'a> {
    timeline: &'a Timeline,
    columns: Columns,
    top: f64,
}

impl Sheet<'_> {
    fn draw(&self, drawing: &mut Drawing, rows: &[Row<'_>]) {
        let first = self.top + 2.0 * LINE;
        let place = |row: usize| first + LINE * row as f64;
        self.heads(drawing);
        let wide = self.columns.right - MARGIN;
        for (i, _) in rows.iter().enumerate().filter(|(_, row)| row.wrong) {
            drawing.area([MARGIN, place(i)], [wide, LINE], Ink::FaultPanel);
        }
        for lane in 0..self.timeline.lanes {
            self.lane(drawing, rows, lane, &place);
        }
        for (i, row) in rows.iter().enumerate() {
            self.row(drawing, row, place(i));
        }
    }

    /// The names of lanes and words, and what the words hold at first.
    fn heads(&self, drawing: &mut Drawing) {
        let stage = self.timeline.stages.first();
        let wide = self.columns.right - MARGIN;
        drawing.area([MARGIN, self.top], [wide, 2.0 * LINE], Ink::Panel);
        for (i, [left, _]) in self.columns.lanes.iter().enumerate() {
            let name = stage.map_or("", |stage| &stage.lanes[i].name);
            drawing.text([left + PAD, self.top + BASE], Anchor::Start, name, Ink::Text);
        }
        for (word, [left, _]) in self.timeline.words.iter().zip(&self.columns.words) {
            drawing.text([left + PAD, self.top + BASE], Anchor::Start, &word.name, Ink::Text);
            let initial = word.initial.as_deref().unwrap_or("-");
            let at = [left + PAD, self.top + LINE + BASE];
            drawing.text(at, Anchor::Start, initial, Ink::Quiet);
        }
        let down = self.top + LINE;
        drawing.rule([MARGIN, down], [self.columns.right, down], Ink::Quiet);
    }

    /// A lane's line: wide where it holds a lock.
    fn lane(
        &self,
        drawing: &mut Drawing,
        rows: &[Row<'_>],
        lane: usize,
        place: &dyn Fn(usize) -> f64,
    ) {
        let across = self.columns.lanes[lane][0] + 1.5;
        let mut holds = false;
        let mut from = place(0);
        let mut draw = |from: f64, to: f64, holds: bool| {
            if to > from {
                let width = if holds { 4 } else { 1 };
                drawing.line(vec![[across, from], [across, to]], Ink::Series(lane), width, &[]);
            }
        };
        for (i, row) in rows.iter().enumerate() {
            let own = row.step.filter(|step| step.lane == lane).and_then(|step| step.lock);
            match own {
                Some(Locking::Locks) if !holds => {
                    draw(from, place(i), false);
                    (from, holds) = (place(i), true);
                }
                Some(Locking::Unlocks) if holds => {
                    draw(from, place(i + 1), true);
                    (from, holds) = (place(i + 1), false);
                }
                _ => {}
            }
        }
        draw(from, place(rows.len()), holds);
    }

    fn row(&self, drawing: &mut Drawing, row: &Row<'_>, down: f64) {
        let letters = down + BASE;
        let Some(step) = row.step else {
            let ink = if row.wrong { Ink::Fault } else { Ink::Quiet };
            if row.barrier {
                drawing.rule([MARGIN, down + 1.0], [self.columns.right, down + 1.0], Ink::Quiet);
            }
            drawing.text([self.columns.first() + PAD, letters], Anchor::Start, &row.text, ink);
            return;
        };
        let number_ink = if row.caused { Ink::Fault } else { Ink::Quiet };
        let at = [MARGIN + 4.0 * LETTER[0], letters];
        drawing.text(at, Anchor::End, &step.number.to_string(), number_ink);
        if row.caused {
            drawing.area([MARGIN - 6.0, down], [3.0, LINE], Ink::Fault);
        }
        let [left, wide] = self.columns.lanes[step.lane];
        drawing.area([left, down + 1.0], [wide, LINE - 2.0], Ink::SeriesPanel(step.lane));
        drawing.area([left, down + 1.0], [4.0, LINE - 2.0], Ink::Series(step.lane));
        drawing.text([left + PAD, letters], Anchor::Start, &row.text, Ink::Text);
        for (i, (value, [left, wide])) in row.values.iter().zip(&self.columns.words).enumerate() {
            let changed = row.changed[i];
            if changed {
                drawing.area([*left, down + 1.0], [*wide, LINE - 2.0], Ink::SeriesPanel(step.lane));
            }
            let ink = if changed { Ink::Text } else { Ink::Quiet };
            drawing.text([left + PAD, letters], Anchor::Start, value, ink);
        }
    }
}

impl Columns {
    /// Where the first lane begins.
    fn first(&self) -> f64 {
        self.lanes.first().map_or(MARGIN, |column| column[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words() {
        let lines = |text: &str, most| {
            wrapped(text, most, Ink::Text).into_iter().map(|(line, _)| line).collect::<Vec<_>>()
        };
        assert_eq!(lines("a b", 20), ["a b"]);
        let text = "aaaaaaaaaa bbbbbbbbbb cccccccccc";
        assert_eq!(lines(text, 21), ["aaaaaaaaaa bbbbbbbbbb", "cccccccccc"]);
        assert_eq!(lines(&"x".repeat(45), 20), ["x".repeat(20), "x".repeat(20), "x".repeat(5)]);
        assert_eq!(lines("", 20).concat(), "");
    }
}
