//! A map of importance from a picture, stretched over the frame.

use std::io::{BufRead, Seek};

use png::{ColorType, Decoder, Transformations};

use crate::error::{Error, Result};
use crate::scene::MAX_SIZE;

/// Importance by place: 0 (black) to 1 (white), as stored, without any gamma.
#[derive(Clone, PartialEq)]
pub struct ImportanceMap {
    size: [u32; 2],
    /// 0 to 65,535, row by row.
    values: Vec<u16>,
}

impl std::fmt::Debug for ImportanceMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [width, height] = self.size;
        write!(f, "ImportanceMap({width}x{height}, {:016x})", self.digest())
    }
}

impl ImportanceMap {
    /// From values of 0 to 65,535, row by row.
    ///
    /// # Errors
    /// Another number of values than pixels, no pixels, or an edge above [`MAX_SIZE`].
    pub fn new(size: [u32; 2], values: Vec<u16>) -> Result<Self> {
        let [width, height] = size;
        let wrong = |problem: String| Err(Error::new("importance map", problem));
        if size.iter().any(|edge| !(1..=MAX_SIZE).contains(edge)) {
            return wrong(format!("is {width}x{height}, but each edge must be 1 to {MAX_SIZE}"));
        }
        if values.len() != width as usize * height as usize {
            return wrong(format!("has {} values for {width}x{height} pixels", values.len()));
        }
        Ok(Self { size, values })
    }

    /// From a PNG file; `place` names it in errors. Colours count by their luma (Rec. 709), and opacity does not.
    ///
    /// # Errors
    /// Not a PNG, or one that is damaged or too large.
    pub fn from_png(place: &str, file: impl BufRead + Seek) -> Result<Self> {
        let wrong = |problem: String| Error::new(place, problem);
        let broken = |error: png::DecodingError| {
            wrong(format!("cannot be read as an importance map: must be a PNG picture ({error})"))
        };
        let mut decoder = Decoder::new(file);
        decoder.set_transformations(Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(broken)?;
        let (width, height) = (reader.info().width, reader.info().height);
        if width > MAX_SIZE || height > MAX_SIZE {
            let problem = format!("is {width}x{height}, but each edge must be 1 to {MAX_SIZE}");
            return Err(wrong(problem));
        }
        let bytes = reader.output_buffer_size().unwrap_or(0);
        let mut buffer = vec![0; bytes];
        let frame = reader.next_frame(&mut buffer).map_err(broken)?;
        let (channels, wide) = (frame.color_type.samples(), frame.bit_depth as u32 == 16);
        let colored = matches!(frame.color_type, ColorType::Rgb | ColorType::Rgba);
        let samples: Vec<u16> = if wide {
            let pairs = buffer[..frame.buffer_size()].chunks_exact(2);
            pairs.map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
        } else {
            buffer[..frame.buffer_size()].iter().map(|&byte| u16::from(byte) * 257).collect()
        };
        let value = |pixel: &[u16]| {
            if !colored {
                return pixel[0];
            }
            let [r, g, b] = [pixel[0], pixel[1], pixel[2]].map(u32::from);
            ((2_126 * r + 7_152 * g + 722 * b + 5_000) / 10_000) as u16
        };
        Self::new([width, height], samples.chunks_exact(channels).map(value).collect())
    }

    /// Pixels across and down.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The value at the centre of a pixel of a picture of another size, 0 to 1: bilinear between the centres of the
    /// map's pixels, and the nearest of them beyond.
    #[must_use]
    pub fn at(&self, picture: [u32; 2], x: u32, y: u32) -> f64 {
        let [left, top] = [(0, x), (1, y)].map(|(axis, place)| {
            let (edge, whole) = (f64::from(self.size[axis]), f64::from(picture[axis]));
            let at = (f64::from(place) + 0.5) * edge / whole - 0.5;
            at.clamp(0.0, edge - 1.0)
        });
        let [column, row] = [left, top].map(f64::floor);
        let [across, down] = [left - column, top - row];
        let value = |dx: u32, dy: u32| {
            let x = (column as u32 + dx).min(self.size[0] - 1);
            let y = (row as u32 + dy).min(self.size[1] - 1);
            f64::from(self.values[y as usize * self.size[0] as usize + x as usize]) / 65_535.0
        };
        let upper = value(0, 0) + (value(1, 0) - value(0, 0)) * across;
        let lower = value(0, 1) + (value(1, 1) - value(0, 1)) * across;
        upper + (lower - upper) * down
    }

    /// A number that differs where the values do.
    fn digest(&self) -> u64 {
        let step = |sum: u64, &value: &u16| (sum ^ u64::from(value)).wrapping_mul(0x0100_0000_01B3);
        self.values.iter().fold(0xCBF2_9CE4_8422_2325, step)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::image::{Image, png as writer};

    #[test]
    fn a_map_of_the_pictures_size_is_itself() {
        let values: Vec<u16> = (0..12).map(|i| i * 5_000).collect();
        let map = ImportanceMap::new([4, 3], values.clone()).unwrap();
        for (i, &value) in (0..).zip(&values) {
            let found = map.at([4, 3], i % 4, i / 4) * 65_535.0;
            assert!((found - f64::from(value)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_map_of_another_size_is_stretched() {
        let map = ImportanceMap::new([2, 1], vec![0, 65_535]).unwrap();
        let row: Vec<f64> = (0..4).map(|x| map.at([4, 7], x, 3)).collect();
        assert_eq!(row, [0.0, 0.25, 0.75, 1.0]);
        let one = ImportanceMap::new([1, 1], vec![65_535]).unwrap();
        assert!((one.at([4096, 1], 4095, 0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn colours_count_by_their_luma() {
        let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 9], [255; 4], [0, 0, 0, 255]];
        let bytes = writer::encode(&Image { width: 4, height: 1, pixels }).unwrap();
        let map = ImportanceMap::from_png("x.png", Cursor::new(bytes)).unwrap();
        assert_eq!(map.values, [13_933, 46_871, 65_535, 0]);
        let cut = ImportanceMap::from_png("x.png", Cursor::new(b"GIF89a".to_vec())).unwrap_err();
        assert!(cut.to_string().contains("x.png") && cut.to_string().contains("PNG"), "{cut}");
    }
}
