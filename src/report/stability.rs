//! The stability matrix as a drawing: a row for every method, a column for everything that its result may depend on.

use crate::explore::sample::stability::Stability;
use crate::image::Image;
use crate::image::drawing::look::{Ink, LETTER, LINE, MARGIN};
use crate::image::drawing::{Anchor, Drawing, Face};

/// The columns with marks.
const COLUMNS: [&str; 4] = ["arrival", "at ties", "at overflow", "schedule"];

/// From one column to the next.
const WIDE: f64 = 100.0;

/// The edge of a mark.
const MARK: f64 = 12.0;

/// How long the bar of the largest spread is: that of 1.
const BAR: f64 = 120.0;

/// From the top of a row to where its letters stand.
const BASE: f64 = 13.0;

/// As SVG, with colours for light and dark paper.
#[must_use]
pub fn svg(rows: &[Stability]) -> String {
    drawing(rows).svg()
}

/// As a picture, two pixels for every unit of the SVG.
#[must_use]
pub fn picture(rows: &[Stability]) -> Image {
    drawing(rows).draw()
}

/// How a dependence is drawn: what was observed and declared, observed and not declared, not observed.
fn inks(seen: bool, agrees: bool) -> Option<Ink> {
    match (seen, agrees) {
        (false, _) => None,
        (true, true) => Some(Ink::Series(0)),
        (true, false) => Some(Ink::Fault),
    }
}

fn drawing(rows: &[Stability]) -> Drawing {
    let longest = rows.iter().map(|row| row.method.chars().count()).max().unwrap_or(0).max(6);
    let left = MARGIN + LETTER[0] * (longest + 2) as f64;
    let bars = left + WIDE * COLUMNS.len() as f64;
    let right = bars + BAR + 10.0 * LETTER[0];
    let top = MARGIN + 3.5 * LINE;
    let bottom = top + LINE * rows.len() as f64;
    let title = "What results are seen to depend on";
    let mut drawing = Drawing::new([right + MARGIN, bottom + 4.0 * LINE + MARGIN], title);
    drawing.letters([MARGIN, MARGIN + BASE], Anchor::Start, title, Ink::Text, Face::Title);
    let heads = top - LINE + BASE - 4.0;
    drawing.text([MARGIN, heads], Anchor::Start, "method", Ink::Text);
    for (i, name) in COLUMNS.iter().enumerate() {
        let across = left + WIDE * i as f64;
        drawing.text([across, heads], Anchor::Start, name, Ink::Text);
        drawing.rule([across - 6.0, top], [across - 6.0, bottom], Ink::Rule);
    }
    drawing.text([bars, heads], Anchor::Start, "spread, 0 to 1", Ink::Text);
    for part in 0..=2 {
        let across = bars + BAR * f64::from(part) / 2.0;
        drawing.rule([across, top], [across, bottom], Ink::Rule);
    }
    drawing.rule([MARGIN, top - 2.0], [right, top - 2.0], Ink::Quiet);
    for (i, row) in rows.iter().enumerate() {
        let down = top + LINE * i as f64;
        let agrees = row.agrees();
        let ink = if agrees { Ink::Text } else { Ink::Fault };
        drawing.text([MARGIN, down + BASE], Anchor::Start, row.method, ink);
        let seen = [row.arrival, row.arrival_at_ties, row.arrival_at_overflow, row.schedule];
        for (column, seen) in seen.into_iter().enumerate() {
            let corner = [left + WIDE * column as f64, down + 3.0];
            mark(&mut drawing, corner, inks(seen, agrees));
            if column == 2 && seen && row.pooled {
                let at = [corner[0] + MARK + 6.0, down + BASE];
                drawing.text(at, Anchor::Start, "pool", Ink::Quiet);
            }
        }
        if row.spread > 0.0 {
            let long = (BAR * row.spread.min(1.0)).max(1.0);
            drawing.area([bars, down + 3.0], [long, MARK], Ink::Series(1));
            let at = [bars + long + 6.0, down + BASE];
            let number = if row.spread < 0.01 {
                format!("{:.1e}", row.spread)
            } else {
                format!("{:.2}", row.spread)
            };
            drawing.text(at, Anchor::Start, &number, Ink::Quiet);
        }
    }
    let legend = [
        (inks(true, true), "depends on it, as its contract says"),
        (
            inks(true, false),
            "depends on something that its contract does not say, or not on what it says",
        ),
        (inks(false, true), "no dependence was seen, which proves nothing"),
    ];
    for (i, (ink, text)) in legend.into_iter().enumerate() {
        let down = bottom + LINE * (i as f64 + 0.7);
        mark(&mut drawing, [MARGIN, down + 3.0], ink);
        drawing.text([MARGIN + MARK + 8.0, down + BASE], Anchor::Start, text, Ink::Text);
    }
    drawing
}

/// A filled square, or an empty one: shape alone tells them apart.
fn mark(drawing: &mut Drawing, [left, top]: [f64; 2], ink: Option<Ink>) {
    match ink {
        Some(ink) => drawing.area([left, top], [MARK, MARK], ink),
        None => {
            let corners = [[0.0, 0.0], [MARK, 0.0], [MARK, MARK], [0.0, MARK], [0.0, 0.0]];
            let corners = corners.map(|[x, y]| [left + x, top + y]);
            drawing.line(corners.to_vec(), Ink::Quiet, 1, &[]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &'static str, declared: [bool; 2]) -> Stability {
        Stability {
            method,
            arrival: true,
            arrival_at_ties: false,
            arrival_at_overflow: true,
            pooled: true,
            schedule: false,
            inexact_at_ties: false,
            spread: 0.25,
            runs: 42,
            declared,
        }
    }

    #[test]
    fn what_is_seen_is_drawn() {
        let [right, wrong] =
            [row("a", [true, false]), row("a", [false, false])].map(|row| svg(&[row]));
        let count = |text: &str, what: &str| text.matches(what).count();
        // Two marks, and that of the legend.
        assert_eq!(count(&right, "class=\"f-series0\""), 3, "{right}");
        assert_eq!(count(&wrong, "class=\"f-series0\""), 1);
        assert_eq!(count(&right, "<polyline class") + count(&right, "stroke=\"#606068\""), 4);
        assert!(right.contains("0.25") && right.contains("pool"));
        assert_eq!(picture(&[row("a", [true, false])]), picture(&[row("a", [true, false])]));
        assert_ne!(picture(&[row("a", [true, false])]), picture(&[row("a", [false, false])]));
    }
}
