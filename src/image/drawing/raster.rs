//! A drawing as a picture, two pixels for every unit. Ends of lines are rounded to pixels; what lies between them is
//! integer arithmetic.

use embedded_graphics::mono_font::MonoFont;

use super::look::Ink;
use super::{Anchor, Drawing, Face, Shape};
use crate::image::Image;
use crate::image::canvas::{BODY, Canvas, TITLE};

/// Pixels of a unit.
const SCALE: u32 = 2;

/// The pixel of a place.
fn pixel(place: [f64; 2]) -> [u32; 2] {
    place.map(|at| (at * f64::from(SCALE)).round().max(0.0) as u32)
}

impl Drawing {
    /// The picture, on light paper. Only Latin-1 can be drawn: other letters become `?`. What does not fit is cut off.
    pub(crate) fn draw(&self) -> Image {
        let [width, height] = pixel(self.size);
        let mut canvas = Canvas::new(width, height, SCALE, Ink::Paper.color(false));
        for shape in &self.shapes {
            match shape {
                Shape::Area { corner, size, ink } => {
                    let far = pixel([corner[0] + size[0], corner[1] + size[1]]);
                    let near = pixel(*corner);
                    let size = std::array::from_fn(|i| far[i].saturating_sub(near[i]));
                    canvas.fill(near, size, ink.color(false));
                }
                Shape::Line { points, ink, width, dashes } => {
                    line(&mut canvas, points, ink.color(false), *width, dashes);
                }
                Shape::Segment { ends, ink, width, dashes } => {
                    line(&mut canvas, ends, ink.color(false), *width, dashes);
                }
                Shape::Text { at, text, ink, face: Face::Upright, .. } => {
                    upright(&mut canvas, *at, text, *ink);
                }
                Shape::Text { at, anchor, text, ink, face } => {
                    let font = if *face == Face::Title { &TITLE } else { &BODY };
                    write(&mut canvas, *at, *anchor, text, *ink, font);
                }
            }
        }
        canvas.into_image()
    }
}

/// Pixels that letters take across.
fn long(text: &str, font: &MonoFont<'_>) -> u32 {
    SCALE * text.chars().count() as u32 * font.character_size.width
}

/// Write a line whose letters stand on y.
fn write(
    canvas: &mut Canvas,
    [x, y]: [f64; 2],
    anchor: Anchor,
    text: &str,
    ink: Ink,
    font: &MonoFont<'_>,
) {
    let [across, down] = pixel([x, y - f64::from(font.baseline)]);
    let left = match anchor {
        Anchor::Start => across,
        Anchor::Middle => across.saturating_sub(long(text, font) / 2),
        Anchor::End => across.saturating_sub(long(text, font)),
    };
    canvas.text([left, down], text, font, ink.color(false));
}

/// Write a line from the bottom to the top, with its middle at a place.
fn upright(canvas: &mut Canvas, [x, y]: [f64; 2], text: &str, ink: Ink) {
    let (long, tall) = (long(text, &BODY), SCALE * BODY.character_size.height);
    let mut strip = Canvas::new(long, tall, SCALE, Ink::Paper.color(false));
    strip.text([0, 0], text, &BODY, ink.color(false));
    let lying = strip.into_image();
    let turned = |(x, y): (u32, u32)| lying.pixel(long - 1 - y, x);
    let places = (0..long).flat_map(|y| (0..tall).map(move |x| (x, y)));
    let standing = Image { width: tall, height: long, pixels: places.map(turned).collect() };
    let [across, middle] = pixel([x - f64::from(BODY.baseline), y]);
    canvas.place([across, middle.saturating_sub(long / 2)], &standing, 1);
}

/// Join points by a line of square dots, with gaps. A thin line is one pixel wide.
fn line(canvas: &mut Canvas, points: &[[f64; 2]], color: [u8; 3], width: u32, dashes: &[u32]) {
    let points: Vec<[u32; 2]> = points.iter().map(|&point| pixel(point)).collect();
    let width = if width == 1 { 1 } else { width * SCALE };
    let mut passed = 0;
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|point| point.map(i64::from));
        let across = [to[0] - from[0], to[1] - from[1]];
        let steps = across[0].abs().max(across[1].abs());
        for step in 0..=steps {
            if is_drawn(dashes, passed / SCALE) {
                // The nearest pixel, halves up.
                let along = |axis: usize| match steps {
                    0 => from[axis],
                    n => from[axis] + (2 * across[axis] * step + n).div_euclid(2 * n),
                };
                let corner = [along(0), along(1)].map(|at| (at - i64::from(width / 2)).max(0));
                canvas.fill(corner.map(|at| at as u32), [width, width], color);
            }
            passed += u32::from(step < steps);
        }
    }
}

/// Whether a line is drawn at this distance from its beginning.
fn is_drawn(dashes: &[u32], at: u32) -> bool {
    let Some(mut rest) = at.checked_rem(dashes.iter().sum()) else { return true };
    for (i, &length) in dashes.iter().enumerate() {
        if rest < length {
            return i % 2 == 0;
        }
        rest -= length;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_where_the_pattern_has_them() {
        let drawn = |dashes| (0..8).map(|at| is_drawn(dashes, at)).collect::<Vec<_>>();
        assert_eq!(drawn(&[3, 2]), [true, true, true, false, false, true, true, true]);
        assert!(drawn(&[]).iter().all(|&drawn| drawn));
    }

    #[test]
    fn shapes_are_where_they_are_put() {
        let mut drawing = Drawing::new([20.0, 10.0], "");
        drawing.area([2.0, 3.0], [4.0, 2.0], Ink::Fault);
        drawing.rule([10.0, 0.0], [10.0, 9.0], Ink::Text);
        let image = drawing.draw();
        let count =
            |ink: Ink| image.pixels.iter().filter(|pixel| pixel[..3] == ink.color(false)).count();
        assert_eq!((image.width, image.height), (40, 20));
        assert_eq!((count(Ink::Fault), count(Ink::Text)), (8 * 4, 19));
        assert_eq!(image.pixel(4, 6)[..3], Ink::Fault.color(false));
        assert_eq!(image.pixel(20, 18)[..3], Ink::Text.color(false));
    }
}
