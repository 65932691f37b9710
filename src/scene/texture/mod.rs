//! Pictures on surfaces, as glTF 2.0 asks (sections 3.8 and 3.9.2): the colour is decoded from sRGB before it is
//! filtered, and multiplied with the material's and the vertices'.
//!
//! All arithmetic is f32 in the order written. A coordinate u stands for the place x = u * width; texel i covers i to
//! i + 1. `nearest` takes the texel at floor(x); otherwise, with i = floor(x - 0.5) and f = (x - 0.5) - i, it is
//! a + (b - a) * f between texels i and i + 1, along the rows first. There are no smaller copies of a picture: where it is
//! seen small, pixels skip texels.

mod decode;

use std::fmt;
use std::sync::{Arc, LazyLock};

use self::decode::decode;
use crate::image::Image;
use crate::num::color;

/// The most texels of all pictures of a file.
pub(super) const MAX_TEXELS: usize = 1 << 28;

/// A picture, how it goes on beyond its edges, and what its opacity means.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Shared, since materials repeat pictures.
    pub picture: Arc<Picture>,
    /// To the right and downwards.
    pub wrap: [Wrap; 2],
    /// The nearest texel instead of a mixture of four.
    pub nearest: bool,
    /// What its opacity means.
    pub opacity: Opacity,
}

/// sRGB and opacity, the top row first; at least one pixel.
#[derive(Clone, PartialEq)]
pub struct Picture {
    image: Image,
    checksum: u32,
}

/// How a picture goes on beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// From its other edge.
    #[default]
    Repeat,
    /// Mirrored, again and again.
    Mirror,
    /// By its last row or column.
    Clamp,
}

/// What the opacity of a surface means, before it is drawn (glTF's `alphaMode`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opacity {
    /// Nothing: all is opaque.
    Opaque,
    /// What is at least as opaque as `cutoff` is opaque, the rest is not there. The material's own opacity is kept
    /// beside.
    Mask {
        /// The material's opacity.
        alpha: f32,
        /// The least that is drawn.
        cutoff: f32,
    },
    /// What it says.
    Blend,
}

impl Picture {
    /// The picture in a PNG or JPEG file of at most 8192 pixels each way; of deeper ones, the upper 8 bits.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn of_file(bytes: &[u8]) -> Result<Self, String> {
        Self::new(decode(bytes)?).ok_or_else(|| "has no pixels".to_owned())
    }

    /// The same, opaque.
    #[must_use]
    pub fn opaque(self) -> Self {
        let mut image = self.image;
        image.pixels.iter_mut().for_each(|pixel| pixel[3] = 255);
        let checksum = checksum(&image);
        Self { image, checksum }
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.image.width, self.image.height]
    }

    /// Of an image with at least one pixel; `None` for any other.
    #[must_use]
    pub fn new(image: Image) -> Option<Self> {
        if image.pixels.is_empty() {
            return None;
        }
        let checksum = checksum(&image);
        Some(Self { image, checksum })
    }

    /// The texels.
    pub(super) fn image(&self) -> &Image {
        &self.image
    }

    /// How many texels it has.
    pub(super) fn texels(&self) -> usize {
        self.image.pixels.len()
    }
}

fn checksum(image: &Image) -> u32 {
    let mut crc = flate2::Crc::new();
    image.pixels.iter().for_each(|pixel| crc.update(pixel));
    crc.sum()
}

/// In few words, however large it is.
impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Image { width, height, .. } = self.image;
        write!(f, "{width}x{height} {:08x}", self.checksum)
    }
}

impl Texture {
    /// The linear colour and the opacity at a place, 0..1 from the upper left corner to the lower right one, beyond that
    /// as it goes on.
    #[inline]
    #[must_use]
    pub fn at(&self, place: [f32; 2]) -> [f32; 4] {
        let size = [self.picture.image.width, self.picture.image.height];
        let [x, y] = [place[0] * size[0] as f32, place[1] * size[1] as f32];
        if self.nearest {
            return self.texel([whole(x), whole(y)]);
        }
        let [x, y] = [x - 0.5, y - 0.5];
        let [i, j] = [whole(x), whole(y)];
        let [across, down] = [x - x.floor(), y - y.floor()].map(|f| if f < 1.0 { f } else { 0.0 });
        let row = |j: i64| {
            let [left, right] = [self.texel([i, j]), self.texel([i.saturating_add(1), j])];
            mixed(left, right, across)
        };
        mixed(row(j), row(j.saturating_add(1)), down)
    }

    fn texel(&self, place: [i64; 2]) -> [f32; 4] {
        let Image { width, height, ref pixels } = self.picture.image;
        let [x, y] = [self.wrap[0].index(place[0], width), self.wrap[1].index(place[1], height)];
        let [r, g, b, alpha] = pixels[y * width as usize + x];
        let [r, g, b] = [r, g, b].map(|channel| LINEAR[usize::from(channel)]);
        [r, g, b, f32::from(alpha) / 255.0]
    }

    /// Whether some of it lets light through.
    pub(super) fn is_translucent(&self) -> bool {
        self.opacity == Opacity::Blend
            && self.picture.image.pixels.iter().any(|texel| texel[3] < 255)
    }
}

impl Wrap {
    /// The row or column of a picture with `size` of them.
    #[inline]
    fn index(self, i: i64, size: u32) -> usize {
        let size = i64::from(size);
        let inside = match self {
            Self::Repeat => i.rem_euclid(size),
            Self::Clamp => i.clamp(0, size - 1),
            Self::Mirror => {
                let i = i.rem_euclid(2 * size);
                i.min(2 * size - 1 - i)
            }
        };
        inside as usize
    }
}

/// The whole number below; 0 for what is no number.
#[inline]
fn whole(x: f32) -> i64 {
    x.floor() as i64
}

/// From `a` to `b`; exactly `a` where both are the same.
#[inline]
fn mixed(a: [f32; 4], b: [f32; 4], share: f32) -> [f32; 4] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
}

static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| color::linear_of(byte as u8) as f32));

#[cfg(test)]
mod tests {
    use super::*;

    /// 2x2: opaque red, white of opacity 51 above black of opacity 102, blue of opacity 204.
    fn texture(wrap: Wrap, nearest: bool) -> Texture {
        let pixels = vec![[255, 0, 0, 255], [255, 255, 255, 51], [0, 0, 0, 102], [0, 0, 255, 204]];
        let picture = picture(2, 2, pixels);
        Texture { picture, wrap: [wrap; 2], nearest, opacity: Opacity::Blend }
    }

    fn picture(width: u32, height: u32, pixels: Vec<[u8; 4]>) -> Arc<Picture> {
        Arc::new(Picture::new(Image { width, height, pixels }).unwrap())
    }

    const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
    const WHITE: [f32; 4] = [1.0, 1.0, 1.0, 0.2];
    const BLACK: [f32; 4] = [0.0, 0.0, 0.0, 0.4];
    const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 0.8];

    #[test]
    fn the_nearest_texel_is_the_one_around_the_place() {
        let texture = texture(Wrap::Repeat, true);
        for (place, texel) in [
            ([0.0, 0.0], RED),
            ([0.49, 0.49], RED),
            ([0.5, 0.0], WHITE),
            ([0.0, 0.5], BLACK),
            ([0.99, 0.99], BLUE),
            ([1.0, 1.0], RED),
            ([-0.25, 7.25], WHITE),
            ([f32::NAN, f32::INFINITY], BLUE),
        ] {
            let texel = if place[0].is_nan() { texture.at(place) } else { texel };
            assert_eq!(texture.at(place), texel, "{place:?}");
        }
    }

    #[test]
    fn a_picture_goes_on_as_it_is_told() {
        let at = |wrap, place| texture(wrap, true).at(place);
        assert_eq!(at(Wrap::Repeat, [1.25, 0.25]), RED);
        assert_eq!(at(Wrap::Mirror, [1.25, 0.25]), WHITE);
        assert_eq!(at(Wrap::Clamp, [1.25, 0.25]), WHITE);
        assert_eq!(at(Wrap::Mirror, [-0.25, 0.25]), RED);
        assert_eq!(at(Wrap::Clamp, [-9.0, 9.0]), BLACK);
        assert_eq!(at(Wrap::Mirror, [2.25, -0.75]), BLACK);
    }

    /// Sums of halves and quarters of these numbers are exact.
    #[test]
    fn between_the_centres_of_texels_it_is_their_mixture() {
        let texture = texture(Wrap::Clamp, false);
        assert_eq!(texture.at([0.25, 0.25]), RED);
        assert_eq!(texture.at([0.75, 0.75]), BLUE);
        assert_eq!(texture.at([0.5, 0.25])[..3], [1.0, 0.5, 0.5]);
        assert_eq!(texture.at([0.25, 0.5])[..3], [0.5, 0.0, 0.0]);
        assert_eq!(texture.at([0.5, 0.5])[..3], [0.5, 0.25, 0.5]);
        assert_eq!(texture.at([0.0, 0.0]), RED, "clamped");
    }

    /// Colours are mixed as light: half way from black to white is more than the byte 128.
    #[test]
    fn colours_are_linear_before_they_are_mixed() {
        let pixels = vec![[0, 0, 0, 255], [188, 188, 188, 255]];
        let picture = picture(2, 1, pixels);
        let wrap = [Wrap::Clamp; 2];
        let texture = Texture { picture, wrap, nearest: false, opacity: Opacity::Opaque };
        let half = color::linear_of(188) as f32 / 2.0;
        assert_eq!(texture.at([0.5, 0.5]), [half, half, half, 1.0]);
    }
}
