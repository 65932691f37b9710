//! A map of colours that stand for something, with a line for each.

use super::Image;
use super::canvas::{BODY, Canvas, FRAME, INK, PAPER, TITLE};

/// Maps narrower than this, in pixels, are enlarged.
const NARROW: u32 = 400;

/// The height of a line, pixels.
const LINE: u32 = 18;

/// A map to draw.
#[derive(Clone, Debug)]
pub struct Legend<'a> {
    /// Above it. Only Latin-1 can be drawn.
    pub title: &'a str,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// A colour for every pixel, row by row.
    pub colors: &'a [[u8; 3]],
    /// What the colours stand for.
    pub entries: &'a [Entry],
}

/// A colour and what it stands for.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The colour.
    pub color: [u8; 3],
    /// In words. Only Latin-1 can be drawn.
    pub text: String,
}

impl Legend<'_> {
    /// The map under its title, above its lines.
    #[must_use]
    pub fn draw(&self) -> Image {
        let [width, height] = self.size.map(|edge| edge.max(1));
        let scale = (NARROW / width.max(height)).max(1);
        let (left, top) = (14, 44);
        let letter = BODY.character_size.width;
        let longest = self.entries.iter().map(|entry| entry.text.chars().count() as u32).max();
        let across = (width * scale).max(NARROW).max(22 + longest.unwrap_or(0) * letter);
        let below = top + height * scale + 14;
        let lines = self.entries.len() as u32 * LINE;
        let mut canvas = Canvas::new(across + 2 * left, below + lines + 12, 1, PAPER);
        let room = (across / TITLE.character_size.width) as usize;
        let title: String = self.title.chars().take(room).collect();
        canvas.text([left, 14], &title, &TITLE, INK);
        let pixels = self.colors.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
        let map = Image { width: self.size[0], height: self.size[1], pixels };
        canvas.fill([left - 1, top - 1], [width * scale + 2, height * scale + 2], FRAME);
        canvas.place([left, top], &map, scale);
        for (line, entry) in (0..).zip(self.entries) {
            let y = below + line * LINE;
            canvas.fill([left, y], [14, 14], FRAME);
            canvas.fill([left + 1, y + 1], [12, 12], entry.color);
            canvas.text([left + 22, y + 1], &entry.text, &BODY, INK);
        }
        canvas.into_image()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_and_every_line_has_its_colour() {
        let colors = [[1, 2, 3], [200, 0, 0], [1, 2, 3], [0, 9, 200]];
        let line = |color| Entry { color, text: "what it is".to_owned() };
        let entries: Vec<Entry> = [[1, 2, 3], [200, 0, 0], [7, 7, 7]].map(line).to_vec();
        let image = Legend { title: "t", size: [2, 2], colors: &colors, entries: &entries }.draw();
        let count =
            |[r, g, b]: [u8; 3]| image.pixels.iter().filter(|p| **p == [r, g, b, 255]).count();
        assert_eq!(count([1, 2, 3]), 2 * 200 * 200 + 144);
        assert_eq!(count([200, 0, 0]), 200 * 200 + 144);
        assert_eq!(count([0, 9, 200]), 200 * 200);
        assert_eq!(count([7, 7, 7]), 144);
        assert_eq!(image.pixel(14, 44), [1, 2, 3, 255]);
        assert_eq!(image.pixel(214, 44), [200, 0, 0, 255]);
    }
}
