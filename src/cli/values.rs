//! Option values with a form of their own: sizes, bytes, schedules.

use std::fs;

use crate::error::{Error, Result};
use crate::render::Policy;
use crate::scene::MAX_SIZE;

/// `WxH` in pixels.
///
/// # Errors
/// Another form, or an edge of 0 or above [`MAX_SIZE`].
pub(super) fn size(text: &str) -> Result<[u32; 2]> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parsed {
        Some(size) if size.iter().all(|edge| (1..=MAX_SIZE).contains(edge)) => Ok(size),
        _ => {
            let right = format!("must be WIDTHxHEIGHT, each 1 to {MAX_SIZE} pixels, like 640x480");
            Err(Error::new("--size", format!("{text:?} {right}")))
        }
    }
}

/// `WxH` cells of a hash table.
///
/// # Errors
/// Another form, or an edge of no cells.
pub(super) fn cells(option: &str, text: &str) -> Result<[u32; 2]> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed.filter(|size: &[u32; 2]| !size.contains(&0)).ok_or_else(|| {
        Error::new(option, format!("{text:?} must be WIDTHxHEIGHT in cells, like 640x480"))
    })
}

/// `X,Y` in pixels, from the top left.
///
/// # Errors
/// Another form.
pub(super) fn pixel(text: &str) -> Result<[u32; 2]> {
    let parsed = text.split_once(',').and_then(|(x, y)| Some([x.parse().ok()?, y.parse().ok()?]));
    parsed.ok_or_else(|| {
        let right = "must be COLUMN,ROW, counted from 0 at the top left, like 320,240";
        Error::new("--pixel", format!("{text:?} {right}"))
    })
}

/// A number of bytes, with K, M, G or T for powers of 1,024.
///
/// # Errors
/// Another form, 0, or more than 64 bits hold.
pub(super) fn bytes(option: &str, text: &str) -> Result<u64> {
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

/// A scheduling policy; `recorded:FILE` reads the file.
///
/// # Errors
/// An unknown policy, a warp of no invocations, or a file that cannot be read.
pub(super) fn schedule(text: &str) -> Result<Policy> {
    if let Some(file) = text.strip_prefix("recorded:") {
        let read = fs::read(file);
        return read
            .map(Policy::Recorded)
            .map_err(|error| Error::new("--schedule", format!("{file} cannot be read: {error}")));
    }
    if let Some(Ok(lanes @ 1..)) = text.strip_prefix("warp:").map(str::parse) {
        return Ok(Policy::Warp(lanes));
    }
    if let Some(Ok(depth @ 1..)) = text.strip_prefix("pct:").map(str::parse) {
        return Ok(Policy::Pct(depth));
    }
    match text {
        "order" => Ok(Policy::Order),
        "reverse" => Ok(Policy::Reverse),
        "round-robin" => Ok(Policy::RoundRobin),
        "random" => Ok(Policy::Random),
        _ => {
            let right = "must be order, reverse, round-robin, random, pct:D or warp:N (D and N at \
                         least 1), or recorded:FILE";
            Err(Error::new("--schedule", format!("{text:?} {right}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480").unwrap(), [640, 480]);
        assert_eq!(size("1x16384").unwrap(), [1, 16_384]);
        for bad in ["0x4", "4x0", "16385x1", "4", "4x", "x4", "4x4x4", "-4x4", "4 x 4", ""] {
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

    #[test]
    fn schedules() {
        assert_eq!(schedule("round-robin").unwrap(), Policy::RoundRobin);
        assert_eq!(schedule("warp:32").unwrap(), Policy::Warp(32));
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), [1, 2, 3]).unwrap();
        let recorded = format!("recorded:{}", file.path().display());
        assert_eq!(schedule(&recorded).unwrap(), Policy::Recorded(vec![1, 2, 3]));
        for bad in ["", "warp", "warp:0", "warp:x", "fifo", "recorded:", "recorded:/no/such/file"] {
            assert_eq!(schedule(bad).unwrap_err().place(), "--schedule", "{bad}");
        }
    }
}
