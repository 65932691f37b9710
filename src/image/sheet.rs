//! The comparison sheet of one method: exact | method | heat map, with a header and a legend.
//!
//! Tiny pictures are enlarged by an integer factor until the texts fit above them, and huge ones are reduced by an
//! integer factor. The heat map keeps the largest difference of each block, so that a single differing pixel stays
//! visible.

use embedded_graphics::mono_font::MonoFont;

use super::canvas::{BODY, Canvas, FRAME, INK, PAPER, QUIET, TITLE};
use super::{Image, difference, ramp};
use crate::error::Result;

/// The texts of a sheet. Only Latin-1 can be drawn; text too long for the sheet is cut short.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    /// First line: what is compared.
    pub title: String,
    /// Second line: what came out.
    pub facts: String,
    /// Above the left, middle and right panel.
    pub captions: [String; 3],
}

/// Panels are at least this wide, in pixels, and enlarged up to about twice that.
const PANEL: u32 = 264;
/// Above this, in pixels, pictures are reduced.
const LARGEST: u32 = 2_048;
/// Sheets wider than this, in pixels, are lettered at double size.
const WIDE: u32 = 1_800;

/// Compose the sheet.
///
/// # Errors
/// Pictures of different sizes.
pub fn compose(labels: &Labels, exact: &Image, method: &Image) -> Result<Image> {
    let heat = difference::heat_map(exact, method)?;
    let layout = Layout::of(exact);
    let mut canvas = Canvas::new(layout.width, layout.height, layout.unit, PAPER);
    layout.header(&mut canvas, labels);
    layout.panel(&mut canvas, 0, &labels.captions[0], &reduce(exact, layout.shrink, average));
    layout.panel(&mut canvas, 1, &labels.captions[1], &reduce(method, layout.shrink, average));
    layout.panel(&mut canvas, 2, &labels.captions[2], &reduce(&heat, layout.shrink, hottest));
    layout.legend(&mut canvas);
    Ok(canvas.into_image())
}

/// Where everything goes, in pixels.
struct Layout {
    unit: u32,
    scale: u32,
    shrink: u32,
    margin: u32,
    slot: u32,
    panels: u32,
    below: u32,
    width: u32,
    height: u32,
}

impl Layout {
    fn of(picture: &Image) -> Self {
        let [width, height] = [picture.width.max(1), picture.height.max(1)];
        let longest = width.max(height);
        let shrink = longest.div_ceil(LARGEST);
        let scale = PANEL.div_ceil(width).min((2 * PANEL / longest).max(1));
        let slot = (width.div_ceil(shrink) * scale).max(PANEL);
        let unit = if 3 * slot > WIDE { 2 } else { 1 };
        let margin = 14 * unit;
        let panels = margin + 68 * unit;
        let below = panels + height.div_ceil(shrink) * scale + 14 * unit;
        Self {
            unit,
            scale,
            shrink,
            margin,
            slot,
            panels,
            below,
            width: 3 * slot + 4 * margin,
            height: below + 46 * unit + margin,
        }
    }

    fn header(&self, canvas: &mut Canvas, labels: &Labels) {
        let [left, top, unit] = [self.margin, self.margin, self.unit];
        let room = self.width - 2 * self.margin;
        canvas.text([left, top], &self.fit(&labels.title, &TITLE, room), &TITLE, INK);
        let facts = self.fit(&labels.facts, &BODY, room);
        canvas.text([left, top + 23 * unit], &facts, &BODY, INK);
    }

    fn panel(&self, canvas: &mut Canvas, index: u32, caption: &str, picture: &Image) {
        let left = self.margin + index * (self.slot + self.margin);
        let caption = self.fit(caption, &BODY, self.slot);
        canvas.text([left, self.panels - 17 * self.unit], &caption, &BODY, QUIET);
        let [width, height] = [picture.width * self.scale, picture.height * self.scale];
        let left = left + (self.slot - width) / 2;
        canvas.fill([left - 1, self.panels - 1], [width + 2, height + 2], FRAME);
        canvas.place([left, self.panels], picture, self.scale);
    }

    /// A swatch for "equal", then one cell per difference of 1..=255 with numbers under it.
    fn legend(&self, canvas: &mut Canvas) {
        let [left, top, unit] = [self.margin, self.below, self.unit];
        let meaning = "heat map: the largest difference of R, G, B and A at a pixel, of 255";
        canvas.text([left, top], meaning, &BODY, QUIET);
        let [y, tall, numbers] = [top + 17 * unit, 13 * unit, top + 34 * unit];
        canvas.fill([left, y], [28 * unit, tall], ramp::EQUAL);
        canvas.text([left, numbers], "0", &BODY, INK);
        canvas.text([left + 34 * unit, y], "equal", &BODY, INK);
        let start = left + 90 * unit;
        let room = self.width.saturating_sub(start + self.margin) / 255;
        let cell = room.clamp(1, 3 * unit);
        for (place, step) in (0..).zip(1..=255u8) {
            canvas.fill([start + place * cell, y], [cell, tall], ramp::color(step));
        }
        for number in [1, 32, 64, 96, 128, 160, 192, 224, 255] {
            let text = number.to_string();
            let x = start + (number - 1) * cell + cell / 2;
            canvas.fill([x, y + tall], [unit, 3 * unit], QUIET);
            let half = self.length(&text, &BODY) / 2;
            canvas.text([x - half, numbers], &text, &BODY, INK);
        }
    }

    /// Pixels that a line takes.
    fn length(&self, text: &str, font: &MonoFont<'_>) -> u32 {
        text.chars().count() as u32 * font.character_size.width * self.unit
    }

    /// `text`, cut short with an ellipsis where it exceeds `room` pixels.
    fn fit(&self, text: &str, font: &MonoFont<'_>, room: u32) -> String {
        if self.length(text, font) <= room {
            return text.to_owned();
        }
        let most = (room / (font.character_size.width * self.unit)) as usize;
        text.chars().take(most.saturating_sub(3)).chain("...".chars()).collect()
    }
}

/// One pixel per block of `factor` x `factor`.
fn reduce(picture: &Image, factor: u32, pick: fn(&[[u8; 4]]) -> [u8; 4]) -> Image {
    if factor == 1 {
        return picture.clone();
    }
    let [width, height] = [picture.width, picture.height].map(|edge| edge.div_ceil(factor));
    let mut block = Vec::new();
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for row in 0..height {
        for column in 0..width {
            let inside = |at: u32, edge: u32| at * factor..((at + 1) * factor).min(edge);
            block.clear();
            for y in inside(row, picture.height) {
                block.extend(inside(column, picture.width).map(|x| picture.pixel(x, y)));
            }
            pixels.push(pick(&block));
        }
    }
    Image { width, height, pixels }
}

fn average(block: &[[u8; 4]]) -> [u8; 4] {
    let count = block.len() as u64;
    std::array::from_fn(|c| {
        let sum: u64 = block.iter().map(|pixel| u64::from(pixel[c])).sum();
        ((sum + count / 2) / count) as u8
    })
}

/// The lightest colour: the ramp's lightness rises with the difference.
fn hottest(block: &[[u8; 4]]) -> [u8; 4] {
    let light =
        |pixel: &[u8; 4]| 3 * u32::from(pixel[0]) + 6 * u32::from(pixel[1]) + u32::from(pixel[2]);
    block.iter().copied().max_by_key(light).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(width: u32, height: u32) -> Image {
        let exact = Image::filled(width, height, [40, 120, 200, 255]);
        let mut method = exact.clone();
        method.pixels[0][3] ^= 128;
        let labels = Labels { title: "title ".repeat(99), ..Labels::default() };
        compose(&labels, &exact, &method).unwrap()
    }

    #[test]
    fn dimensions_follow_the_panels() {
        for (size, scale, unit) in
            [([64, 64], 5, 1), ([264, 200], 1, 1), ([640, 480], 1, 2), ([1, 4_000], 1, 1)]
        {
            let image = sheet(size[0], size[1]);
            let [slot, tall] = match size {
                [1, _] => [PANEL, 2_000],
                [width, height] => [width * scale, height * scale],
            };
            let expected = [3 * slot + 4 * 14 * unit, tall + (28 + 68 + 14 + 46) * unit];
            assert_eq!([image.width, image.height], expected, "{size:?}");
            assert!(image.pixels.iter().all(|pixel| pixel[3] == 255));
        }
    }

    #[test]
    fn one_differing_pixel_survives_reduction() {
        let [red, green, blue] = ramp::color(128);
        let legend = 3;
        let hot = |image: &Image| {
            image.pixels.iter().filter(|&&pixel| pixel == [red, green, blue, 255]).count()
        };
        assert!(hot(&sheet(4_096, 16)) > 13 * legend, "the legend's own cell and the pixel");
    }

    #[test]
    fn reduction_averages_pictures_and_keeps_the_hottest() {
        let block = [[0, 0, 0, 255], [255, 252, 214, 255], [62, 60, 178, 255]];
        assert_eq!(hottest(&block), block[1]);
        assert_eq!(average(&[[0, 10, 255, 255], [1, 11, 255, 255]]), [1, 11, 255, 255]);
        let picture = Image { width: 3, height: 1, pixels: block.to_vec() };
        assert_eq!(reduce(&picture, 2, hottest).pixels, [block[1], block[2]]);
    }

    #[test]
    fn pictures_of_different_sizes_are_an_error() {
        let [a, b] = [Image::filled(2, 1, [0; 4]), Image::filled(1, 2, [0; 4])];
        assert!(compose(&Labels::default(), &a, &b).is_err());
    }
}
