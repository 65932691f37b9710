//! Pictures as bytes: RGBA8 images, their hash, PNG files, differences and comparison sheets.
//! Nothing here knows how a picture came about.

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
