//! A surface to compose pictures and bitmap text on. Text and rectangles are measured in *units* of one or
//! more pixels, so that captions stay readable on large sheets; pictures are placed in pixels.

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::{FONT_8X13, FONT_9X18_BOLD};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Baseline, Text};
use embedded_graphics::{Drawable, Pixel};

use super::Image;

/// Colours and fonts of everything that is composed.
pub(super) use super::drawing::look::{FRAME, INK, PAPER, QUIET};
pub(super) const TITLE: MonoFont<'_> = FONT_9X18_BOLD;
pub(super) const BODY: MonoFont<'_> = FONT_8X13;

/// An opaque image that can be drawn on; everything outside is cut off.
pub(super) struct Canvas {
    image: Image,
    unit: u32,
}

impl Canvas {
    /// A canvas of `width` x `height` pixels in one colour.
    pub(super) fn new(width: u32, height: u32, unit: u32, color: [u8; 3]) -> Self {
        Self { image: Image::filled(width, height, opaque(color)), unit }
    }

    pub(super) fn into_image(self) -> Image {
        self.image
    }

    /// Fill a rectangle given in pixels.
    pub(super) fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], color: [u8; 3]) {
        let right = (x + width).min(self.image.width);
        for row in y..(y + height).min(self.image.height) {
            let start = row as usize * self.image.width as usize;
            let span = start + x.min(right) as usize..start + right as usize;
            self.image.pixels[span].fill(opaque(color));
        }
    }

    /// Place a picture at a pixel, each of its pixels as a square of `scale` pixels, alpha left out.
    pub(super) fn place(&mut self, [x, y]: [u32; 2], picture: &Image, scale: u32) {
        for row in 0..picture.height {
            for column in 0..picture.width {
                let [red, green, blue, _] = picture.pixel(column, row);
                let corner = [x + column * scale, y + row * scale];
                self.fill(corner, [scale, scale], [red, green, blue]);
            }
        }
    }

    /// Write one line with its top left corner at a pixel. Characters outside Latin-1 become `?`.
    pub(super) fn text(
        &mut self,
        [x, y]: [u32; 2],
        text: &str,
        font: &MonoFont<'_>,
        color: [u8; 3],
    ) {
        let style = MonoTextStyle::new(font, Rgb888::new(color[0], color[1], color[2]));
        let mut target = Units { canvas: self, origin: [x, y] };
        let line = Text::with_baseline(text, Point::zero(), style, Baseline::Top);
        // Units cannot fail to draw: its error type has no values.
        let _ = line.draw(&mut target);
    }
}

/// The canvas seen in units from an origin.
struct Units<'a> {
    canvas: &'a mut Canvas,
    origin: [u32; 2],
}

impl OriginDimensions for Units<'_> {
    fn size(&self) -> Size {
        Size::new(
            (self.canvas.image.width - self.origin[0].min(self.canvas.image.width))
                / self.canvas.unit,
            (self.canvas.image.height - self.origin[1].min(self.canvas.image.height))
                / self.canvas.unit,
        )
    }
}

impl DrawTarget for Units<'_> {
    type Color = Rgb888;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Self::Error> {
        let unit = self.canvas.unit;
        for Pixel(point, color) in pixels {
            let (Ok(x), Ok(y)) = (u32::try_from(point.x), u32::try_from(point.y)) else { continue };
            let corner = [self.origin[0] + x * unit, self.origin[1] + y * unit];
            self.canvas.fill(corner, [unit, unit], [color.r(), color.g(), color.b()]);
        }
        Ok(())
    }
}

fn opaque([red, green, blue]: [u8; 3]) -> [u8; 4] {
    [red, green, blue, 255]
}

#[cfg(test)]
mod tests {
    use embedded_graphics::mono_font::iso_8859_1::FONT_8X13;

    use super::*;

    fn dark(image: &Image) -> usize {
        image.pixels.iter().filter(|pixel| pixel[0] == 0).count()
    }

    #[test]
    fn text_grows_with_the_unit_and_is_cut_off_outside() {
        let written = |unit, at| {
            let mut canvas = Canvas::new(64, 32, unit, [255; 3]);
            canvas.text(at, "#", &FONT_8X13, [0; 3]);
            dark(&canvas.into_image())
        };
        assert!(written(1, [0, 0]) > 10);
        assert_eq!(written(2, [0, 0]), 4 * written(1, [0, 0]));
        assert_eq!(written(1, [64, 0]), 0);
    }

    #[test]
    fn rectangles_are_cut_off_outside() {
        let mut canvas = Canvas::new(4, 4, 1, [255; 3]);
        canvas.fill([3, 2], [9, 9], [0; 3]);
        canvas.fill([7, 0], [1, 1], [0; 3]);
        assert_eq!(dark(&canvas.into_image()), 2);
    }
}
