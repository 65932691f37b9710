//! Pictures as bytes: RGBA8 images, their hash, linear pictures of 16 bits, files, differences, comparison sheets and
//! plots. Nothing here knows how a picture was made.

mod canvas;
pub mod difference;
pub(crate) mod drawing;
pub mod flip;
pub mod foreign;
pub mod heat;
#[cfg(test)]
mod ledger;
pub mod legend;
pub mod linear;
pub mod metrics;
pub mod plot;
pub mod png;
pub mod ramp;
pub mod row;
pub mod sheet;
pub mod similarity;

use sha2::{Digest, Sha256};

/// An image in sRGB RGBA8, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width * height` pixels, row by row.
    pub pixels: Vec<[u8; 4]>,
}

impl Image {
    /// An image of one colour.
    #[must_use]
    pub fn filled(width: u32, height: u32, color: [u8; 4]) -> Self {
        Self { width, height, pixels: vec![color; width as usize * height as usize] }
    }

    /// SHA-256, hexadecimal, over little-endian u32 width and height, then the RGBA8 bytes, top row first.
    #[must_use]
    pub fn hash(&self) -> String {
        let mut hasher = Sha256::new();
        hasher.update(self.width.to_le_bytes());
        hasher.update(self.height.to_le_bytes());
        hasher.update(self.bytes());
        crate::num::hex(&hasher.finalize())
    }

    /// The RGBA8 bytes, top row first.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }

    /// The pixel at column `x` of row `y`, both inside the image.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        self.pixels[y as usize * self.width as usize + x as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_sha256_over_size_and_bytes() {
        let image = Image { width: 2, height: 1, pixels: vec![[1, 2, 3, 255], [4, 5, 6, 0]] };
        let bytes = [2, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3, 255, 4, 5, 6, 0];
        let expected: String =
            Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(image.hash(), expected);
    }

    #[test]
    fn the_hash_sees_the_shape_and_every_channel() {
        let image = Image::filled(3, 2, [10, 20, 30, 40]);
        let mut others = vec![Image { width: 2, height: 3, pixels: image.pixels.clone() }];
        for channel in 0..4 {
            let mut other = image.clone();
            other.pixels[5][channel] ^= 1;
            others.push(other);
        }
        assert!(others.iter().all(|other| other.hash() != image.hash()));
    }
}
