//! Option values with their own syntax: sizes, places, bytes.

use crate::error::{Error, Result};
use crate::scene::MAX_SIZE;

/// `WxH` in pixels, also with blanks, a capital X or a comma; one number is both edges, and names of screens are theirs.
///
/// # Errors
/// Wrong syntax, or an edge of 0 or above [`MAX_SIZE`].
pub(in crate::cli) fn size(text: &str) -> Result<[u32; 2]> {
    let edges = |(w, h): (&str, &str)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]);
    let own = text.to_lowercase();
    let parsed = match own.as_str() {
        "720p" => Some([1_280, 720]),
        "2k" | "1080p" => Some([1_920, 1_080]),
        "4k" | "2160p" => Some([3_840, 2_160]),
        "8k" => Some([7_680, 4_320]),
        own => edges(own.split_once(['x', '×', ',']).unwrap_or((own, own))),
    };
    match parsed {
        Some(size) if size.iter().all(|edge| (1..=MAX_SIZE).contains(edge)) => Ok(size),
        _ => {
            let right = format!(
                "must be WIDTHxHEIGHT, each 1 to {MAX_SIZE} pixels, like 640x480; or one number; or 720p, 1080p, 2k, 4k, 8k"
            );
            Err(Error::new("--size", format!("{text:?} {right}")))
        }
    }
}

/// `WxH` cells of a hash table.
///
/// # Errors
/// Wrong syntax, or an edge of no cells.
pub(in crate::cli) fn cells(option: &str, text: &str) -> Result<[u32; 2]> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed.filter(|size: &[u32; 2]| !size.contains(&0)).ok_or_else(|| {
        Error::new(option, format!("{text:?} must be WIDTHxHEIGHT in cells, like 640x480"))
    })
}

/// `X,Y` in pixels, from the top left.
///
/// # Errors
/// Wrong syntax.
pub(in crate::cli) fn pixel(text: &str) -> Result<[u32; 2]> {
    let parsed = text.split_once(',').and_then(|(x, y)| Some([x.parse().ok()?, y.parse().ok()?]));
    parsed.ok_or_else(|| {
        let right = "must be COLUMN,ROW, counted from 0 at the top left, like 320,240";
        Error::new("--pixel", format!("{text:?} {right}"))
    })
}

/// `X,Y` in pixels and parts of them, from the top left.
///
/// # Errors
/// Wrong syntax, or no numbers.
pub(in crate::cli) fn place(option: &str, text: &str) -> Result<[f64; 2]> {
    let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
    let parsed = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    parsed.ok_or_else(|| {
        let right = "must be X,Y in pixels, counted from the top left, like 320,240.5";
        Error::new(option, format!("{text:?} {right}"))
    })
}

/// A number of bytes, with K, M, G or T for powers of 1,024.
///
/// # Errors
/// Wrong syntax, 0, or more than 64 bits hold.
pub(in crate::cli) fn bytes(option: &str, text: &str) -> Result<u64> {
    let (digits, shift) = match text.char_indices().last() {
        Some((at, 'K' | 'k')) => (&text[..at], 10),
        Some((at, 'M' | 'm')) => (&text[..at], 20),
        Some((at, 'G' | 'g')) => (&text[..at], 30),
        Some((at, 'T' | 't')) => (&text[..at], 40),
        _ => (text, 0),
    };
    let number = digits.parse::<u64>().ok().and_then(|n| n.checked_mul(1 << shift));
    number.filter(|&n| n > 0).ok_or_else(|| {
        let right =
            "must be a number of bytes above 0, like 512M or 4G (K, M, G, T: powers of 1024)";
        Error::new(option, format!("{text:?} {right}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480").unwrap(), [640, 480]);
        assert_eq!(size("1x16384").unwrap(), [1, 16_384]);
        assert_eq!([size("24").unwrap(), size("4k").unwrap()], [[24, 24], [3_840, 2_160]]);
        for bad in
            ["0x4", "4x0", "16385x1", "0", "4y", "5k", "4x", "x4", "4x4x4", "-4x4", "4x4 px", ""]
        {
            assert_eq!(size(bad).unwrap_err().place(), "--size", "{bad}");
        }
    }

    #[test]
    fn byte_counts() {
        let count = |text| bytes("--max-memory", text).ok();
        assert_eq!([count("1"), count("3K"), count("512M")], [Some(1), Some(3_072), Some(1 << 29)]);
        assert_eq!([count("4G"), count("2t")], [Some(1 << 32), Some(1 << 41)]);
        for bad in ["", "G", "0", "0K", "4GB", "-1", "1.5G", "99999999999T", "é"] {
            assert_eq!(count(bad), None, "{bad}");
        }
    }
}
