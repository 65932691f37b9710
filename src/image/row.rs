//! Pictures of one size side by side, each under its caption.

use super::Image;
use super::canvas::{BODY, Canvas, FRAME, INK, PAPER, QUIET, TITLE};

/// Pictures narrower than this, in pixels, are enlarged.
const NARROW: u32 = 256;

/// Between pictures and around them, in pixels.
const MARGIN: u32 = 14;

/// The row, under a title. Only Latin-1 can be drawn; text too long for its place is cut short.
#[must_use]
pub fn compose(title: &str, pictures: &[(&str, &Image)]) -> Image {
    let of = |edge: fn(&Image) -> u32| pictures.iter().map(|(_, p)| edge(p)).max().unwrap_or(1);
    let (wide, tall) = (of(|p| p.width).max(1), of(|p| p.height).max(1));
    let scale = NARROW.div_ceil(wide);
    let slot = wide * scale;
    let count = pictures.len().max(1) as u32;
    let width = count * (slot + MARGIN) + MARGIN;
    let top = MARGIN + 44;
    let mut canvas = Canvas::new(width, top + tall * scale + MARGIN, 1, PAPER);
    let cut = |text: &str, room: u32, letter: u32| -> String {
        text.chars().take((room / letter) as usize).collect()
    };
    let room = width - 2 * MARGIN;
    canvas.text([MARGIN, MARGIN], &cut(title, room, TITLE.character_size.width), &TITLE, INK);
    let mut left = MARGIN;
    for (caption, picture) in pictures {
        let caption = cut(caption, slot, BODY.character_size.width);
        canvas.text([left, top - 17], &caption, &BODY, QUIET);
        let size = [picture.width * scale, picture.height * scale];
        canvas.fill([left - 1, top - 1], size.map(|edge| edge + 2), FRAME);
        canvas.place([left, top], picture, scale);
        left += slot + MARGIN;
    }
    canvas.into_image()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_is_there_enlarged() {
        let [a, b] = [[1, 2, 3, 255], [4, 5, 6, 255]].map(|color| Image::filled(64, 32, color));
        let row = compose("two", &[("a", &a), ("b", &b)]);
        assert_eq!([row.width, row.height], [2 * 256 + 3 * MARGIN, 128 + 2 * MARGIN + 44]);
        for color in [[1, 2, 3, 255], [4, 5, 6, 255]] {
            assert_eq!(row.pixels.iter().filter(|&&pixel| pixel == color).count(), 256 * 128);
        }
        let none = compose("none", &[]);
        assert!(none.pixels.len() > 1);
    }
}
