//! PFM files: colours as 32-bit floating point, without opacity.

use super::Linear;

/// The bytes of a PFM file: linear red, green and blue, all light being 1; little-endian, which the negative scale says,
/// and the bottom row first, as the format asks.
#[must_use]
pub fn encode(picture: &Linear) -> Vec<u8> {
    let Linear { width, height, .. } = *picture;
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    for y in (0..height).rev() {
        for x in 0..width {
            let [colors @ .., _] = picture.parts(x, y);
            bytes.extend(colors.iter().flat_map(|channel| channel.to_le_bytes()));
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bottom_row_comes_first() {
        let pixels = vec![[u16::MAX, 0, 0, u16::MAX], [0, 13_107, 0, u16::MAX]];
        let bytes = encode(&Linear { width: 1, height: 2, pixels });
        let head = b"PF\n1 2\n-1.0\n";
        assert_eq!(bytes[..head.len()], *head);
        let numbers: Vec<f32> = bytes[head.len()..]
            .chunks_exact(4)
            .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]))
            .collect();
        assert_eq!(numbers, [0.0, 0.2, 0.0, 1.0, 0.0, 0.0]);
    }
}
