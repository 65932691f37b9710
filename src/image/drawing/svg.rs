//! A drawing as SVG: attributes have the colours for light paper, and a style those for dark.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::look::{FONTS, Ink, LETTER};
use super::{Anchor, Drawing, Face, Shape};

impl Drawing {
    /// The text of an SVG file.
    pub(crate) fn svg(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{FONTS}\" font-size=\"{}\">\n\
             <title>{}</title>\n{}",
            LETTER[1],
            escaped(&self.title),
            self.style(),
        );
        for shape in &self.shapes {
            text += &markup(shape);
            text.push('\n');
        }
        text + "</svg>\n"
    }

    /// The colours on dark paper, of those that are used.
    fn style(&self) -> String {
        let used: BTreeSet<(bool, Ink)> = self.shapes.iter().map(painted).collect();
        let mut text = "<style>@media (prefers-color-scheme: dark) {\n".to_owned();
        for (fills, ink) in used {
            let property = if fills { "fill" } else { "stroke" };
            let _ = writeln!(text, ".{} {{ {property}: {} }}", class(fills, ink), hex(ink, true));
        }
        text + "}</style>\n"
    }
}

/// Whether a shape fills with its colour, or strokes.
fn painted(shape: &Shape) -> (bool, Ink) {
    match shape {
        Shape::Area { ink, .. } | Shape::Text { ink, .. } => (true, *ink),
        Shape::Line { ink, .. } | Shape::Segment { ink, .. } => (false, *ink),
    }
}

/// The class of a shape with this colour.
fn class(fills: bool, ink: Ink) -> String {
    let kind = if fills { 'f' } else { 's' };
    match ink {
        Ink::Series(number) => format!("{kind}-series{number}"),
        Ink::SeriesPanel(number) => format!("{kind}-panel{number}"),
        ink => format!("{kind}-{}", format!("{ink:?}").to_lowercase()),
    }
}

fn hex(ink: Ink, dark: bool) -> String {
    let [r, g, b] = ink.color(dark);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn markup(shape: &Shape) -> String {
    let (fills, ink) = painted(shape);
    let paint = format!(
        "class=\"{}\" {}=\"{}\"",
        class(fills, ink),
        if fills { "fill" } else { "stroke" },
        hex(ink, false)
    );
    match shape {
        Shape::Area { corner: [x, y], size: [width, height], .. } => format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" {paint}/>"
        ),
        Shape::Line { points, width, dashes, .. } => {
            let points: Vec<String> =
                points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
            let points = points.join(" ");
            let dashes = gaps(dashes);
            format!(
                "<polyline points=\"{points}\" {paint} stroke-width=\"{width}\"{dashes} fill=\"none\"/>"
            )
        }
        Shape::Segment { ends: [[x1, y1], [x2, y2]], width, dashes, .. } => format!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {paint} \
             stroke-width=\"{width}\"{}/>",
            gaps(dashes)
        ),
        Shape::Text { at: [x, y], anchor, text, face, .. } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let face = match face {
                Face::Body => String::new(),
                Face::Title => " font-size=\"15\" font-weight=\"bold\"".to_owned(),
                Face::Upright => format!(" transform=\"rotate(-90 {x:.1} {y:.1})\""),
            };
            format!(
                "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {paint}{face} \
                 xml:space=\"preserve\">{}</text>",
                escaped(text)
            )
        }
    }
}

/// The attribute of a line's gaps, if it has any.
fn gaps(dashes: &[u32]) -> String {
    if dashes.is_empty() {
        return String::new();
    }
    let lengths: Vec<String> = dashes.iter().map(ToString::to_string).collect();
    format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
}

/// Text as it stands in XML and HTML, also within quotes. What XML cannot have is replaced.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\'' => safe += "&#39;",
            '\t' | '\n' | '\r' => safe.push(letter),
            '\0'..'\u{20}' | '\u{FFFE}' | '\u{FFFF}' => safe.push('\u{FFFD}'),
            _ => safe.push(letter),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        assert_eq!(escaped("a <b> & \"c\" 'd'"), "a &lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
        assert_eq!(escaped("a\0b\u{1b}"), "a\u{FFFD}b\u{FFFD}");
        let mut drawing = Drawing::new([10.0, 10.0], "</title><script>");
        drawing.text([1.0, 9.0], Anchor::Start, "</svg> & \"", Ink::Fault);
        let svg = drawing.svg();
        assert_eq!(
            (svg.matches("</svg>").count(), svg.matches("<script").count()),
            (1, 0),
            "{svg}"
        );
        assert!(svg.contains(">&lt;/svg&gt; &amp; &quot;</text>"), "{svg}");
    }

    #[test]
    fn both_papers_have_their_colours() {
        let mut drawing = Drawing::new([10.0, 10.0], "");
        drawing.rule([0.0, 0.0], [9.0, 9.0], Ink::Series(1));
        let svg = drawing.svg();
        assert!(
            svg.contains("fill=\"#fafaf8\"") && svg.contains(".f-paper { fill: #18181b }"),
            "{svg}"
        );
        assert!(svg.contains(".s-series1 { stroke: #f07828 }"), "{svg}");
        assert!(!svg.contains(".f-series1"), "{svg}");
    }
}
