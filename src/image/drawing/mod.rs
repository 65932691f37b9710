//! A drawing: rectangles, lines and letters, made once, and written as SVG or drawn as a picture. Both are the same
//! bytes everywhere.
//!
//! Places and sizes are in units, from the top left corner. An SVG has them as they are, to a tenth; a picture has two
//! pixels for each.

pub(crate) mod look;
mod raster;
mod svg;

use self::look::Ink;
pub(crate) use self::svg::escaped;

/// Shapes, of which later ones lie over earlier ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Drawing {
    /// Width and height.
    pub(crate) size: [f64; 2],
    /// What it shows, for those who cannot see it.
    pub(crate) title: String,
    /// The shapes.
    pub(crate) shapes: Vec<Shape>,
}

/// One shape.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    /// A filled rectangle.
    Area {
        /// The top left corner.
        corner: [f64; 2],
        /// Width and height.
        size: [f64; 2],
        /// Its colour.
        ink: Ink,
    },
    /// A line through points.
    Line {
        /// The points, in the order in which they are joined.
        points: Vec<[f64; 2]>,
        /// Its colour.
        ink: Ink,
        /// Its width.
        width: u32,
        /// Lengths of strokes and gaps in turn; without gaps if empty.
        dashes: &'static [u32],
    },
    /// From one point to another.
    Segment {
        /// Both points.
        ends: [[f64; 2]; 2],
        /// Its colour.
        ink: Ink,
        /// Its width.
        width: u32,
        /// As of a line.
        dashes: &'static [u32],
    },
    /// A line of letters.
    Text {
        /// Where the letters stand.
        at: [f64; 2],
        /// Which part of the line stands there.
        anchor: Anchor,
        /// The letters.
        text: String,
        /// Their colour.
        ink: Ink,
        /// What they look like.
        face: Face,
    },
}

/// Where a line of letters stands by its x; or by its y, if it goes upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// What letters look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Face {
    /// As most.
    Body,
    /// Bold, and a little larger.
    Title,
    /// From the bottom to the top, with its middle at the place.
    Upright,
}

impl Drawing {
    /// An empty sheet of paper.
    pub(crate) fn new(size: [f64; 2], title: &str) -> Self {
        let mut drawing = Self { size, title: title.to_owned(), shapes: Vec::new() };
        drawing.area([0.0, 0.0], size, Ink::Paper);
        drawing
    }

    /// A filled rectangle.
    pub(crate) fn area(&mut self, corner: [f64; 2], size: [f64; 2], ink: Ink) {
        self.shapes.push(Shape::Area { corner, size, ink });
    }

    /// A thin line without gaps.
    pub(crate) fn rule(&mut self, from: [f64; 2], to: [f64; 2], ink: Ink) {
        self.segment([from, to], ink, 1, &[]);
    }

    /// A line from one point to another.
    pub(crate) fn segment(
        &mut self,
        ends: [[f64; 2]; 2],
        ink: Ink,
        width: u32,
        dashes: &'static [u32],
    ) {
        self.shapes.push(Shape::Segment { ends, ink, width, dashes });
    }

    /// A line through points.
    pub(crate) fn line(
        &mut self,
        points: Vec<[f64; 2]>,
        ink: Ink,
        width: u32,
        dashes: &'static [u32],
    ) {
        self.shapes.push(Shape::Line { points, ink, width, dashes });
    }

    /// Letters.
    pub(crate) fn text(&mut self, at: [f64; 2], anchor: Anchor, text: &str, ink: Ink) {
        self.letters(at, anchor, text, ink, Face::Body);
    }

    /// Letters of any face.
    pub(crate) fn letters(
        &mut self,
        at: [f64; 2],
        anchor: Anchor,
        text: &str,
        ink: Ink,
        face: Face,
    ) {
        self.shapes.push(Shape::Text { at, anchor, text: text.to_owned(), ink, face });
    }
}
