//! A map of one number a pixel, in colours, with a scale.

use super::canvas::{BODY, Canvas, FRAME, INK, PAPER, QUIET, TITLE};
use super::{Image, ramp};

/// Maps narrower than this, in pixels, are enlarged.
const NARROW: u32 = 400;

/// Numbers under the scale.
const TICKS: u32 = 4;

/// A map to draw.
#[derive(Clone, Debug)]
pub struct Map<'a> {
    /// Above it. Only Latin-1 can be drawn.
    pub title: &'a str,
    /// Under it: what the numbers are, with their unit.
    pub meaning: &'a str,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// A number for every pixel, row by row.
    pub values: &'a [f64],
    /// The number at the end of the scale, which begins at 0; above 0.
    pub most: f64,
}

/// The step of the colours for a number: 0 is apart from all others.
fn step(value: f64, most: f64) -> u8 {
    if value > 0.0 { (value / most * 255.0).round().clamp(1.0, 255.0) as u8 } else { 0 }
}

impl Map<'_> {
    /// The colours alone, a pixel for every number.
    #[must_use]
    pub fn plain(&self) -> Image {
        let color = |&value: &f64| {
            let [r, g, b] = ramp::color(step(value, self.most));
            [r, g, b, 255]
        };
        let pixels = self.values.iter().map(color).collect();
        Image { width: self.size[0], height: self.size[1], pixels }
    }

    /// The map under its title, above its scale.
    #[must_use]
    pub fn draw(&self) -> Image {
        let [width, height] = self.size.map(|edge| edge.max(1));
        let scale = (NARROW / width.max(height)).max(1);
        let (left, top) = (14, 44);
        let across = (width * scale).max(NARROW);
        let below = top + height * scale + 12;
        let mut canvas = Canvas::new(across + 2 * left, below + 60, 1, PAPER);
        let room = (across / TITLE.character_size.width) as usize;
        let title: String = self.title.chars().take(room).collect();
        canvas.text([left, 14], &title, &TITLE, INK);
        let map = self.plain();
        canvas.fill([left - 1, top - 1], [width * scale + 2, height * scale + 2], FRAME);
        canvas.place([left, top], &map, scale);
        let room = (across / BODY.character_size.width) as usize;
        let meaning: String = self.meaning.chars().take(room).collect();
        canvas.text([left, below], &meaning, &BODY, QUIET);
        let y = below + 17;
        for x in 0..across {
            let value = (f64::from(x) + 0.5) / f64::from(across) * self.most;
            canvas.fill([left + x, y], [1, 13], ramp::color(step(value, self.most)));
        }
        for tick in 0..=TICKS {
            let part = f64::from(tick) / f64::from(TICKS);
            let text = number(part * self.most);
            let long = text.chars().count() as u32 * BODY.character_size.width;
            let x = left + (part * f64::from(across - 1)) as u32;
            canvas.fill([x, y + 13], [1, 3], QUIET);
            let start = x.saturating_sub(long / 2).clamp(left, left + across - long);
            canvas.text([start, y + 18], &text, &BODY, INK);
        }
        canvas.into_image()
    }
}

fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_has_its_colours_and_its_scale() {
        let values = [0.0, 0.25, 0.5, 1.0];
        let map =
            Map { title: "title", meaning: "parts", size: [2, 2], values: &values, most: 1.0 };
        let image = map.draw();
        assert_eq!(image.pixels.len(), (image.width * image.height) as usize);
        for value in values {
            let [r, g, b] = ramp::color(step(value, 1.0));
            assert!(image.pixels.contains(&[r, g, b, 255]), "{value}");
        }
        assert_eq!(image.pixel(15, 45)[..3], ramp::EQUAL);
        assert_eq!([step(1e-9, 1.0), step(2.0, 1.0)], [1, 255], "something is not nothing");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.0, 0.25, 1.5, 7.0, 10.0].map(number), ["0", "0.25", "1.5", "7", "10"]);
    }
}
