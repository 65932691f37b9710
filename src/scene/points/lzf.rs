//! LZF (M. Lehmann's liblzf), which PCD files are compressed with.
//!
//! A byte c below 32 is followed by c + 1 bytes as they are. Any other says with its upper three bits, n, and its lower
//! five, h, to repeat what lies h * 256 + l + 1 bytes back, n + 2 bytes of it; l is the next byte, or, where n is 7, the
//! one after the next, which is added to n.

use crate::scene::model::Unplaced;

/// The most bytes that one byte can stand for: three give up to 264.
const RATIO: usize = 88;

/// The `length` bytes that `packed` stands for.
pub(super) fn unpack(packed: &[u8], length: usize) -> Unplaced<Vec<u8>> {
    if length > packed.len().saturating_mul(RATIO) {
        return Err(format!("{} bytes cannot hold {length}", packed.len()));
    }
    let mut bytes = Vec::with_capacity(length);
    let mut left = packed.iter().copied();
    let mut next = || left.next().ok_or("ends in the middle");
    while bytes.len() < length {
        let control = usize::from(next()?);
        if control < 32 {
            for _ in 0..=control {
                bytes.push(next()?);
            }
            continue;
        }
        let mut count = control >> 5;
        if count == 7 {
            count += usize::from(next()?);
        }
        let back = (control & 31) * 256 + usize::from(next()?) + 1;
        let Some(from) = bytes.len().checked_sub(back) else {
            return Err(format!("byte {} repeats what is before the first", bytes.len()));
        };
        // What is repeated may overlap what is written.
        (from..from + count + 2).for_each(|i| bytes.push(bytes[i]));
    }
    if bytes.len() > length || left.next().is_some() {
        return Err(format!("holds more than {length} bytes"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_repetitions() {
        assert_eq!(unpack(&[2, b'a', b'b', b'c'], 3).unwrap(), b"abc");
        // "ab", then three bytes from two back, which overlap.
        assert_eq!(unpack(&[1, b'a', b'b', 0x20, 1], 5).unwrap(), b"ababa");
        // One byte, then 7 + 255 + 2 of it.
        assert_eq!(unpack(&[0, b'x', 0xE0, 255, 0], 265).unwrap(), [b'x'; 265]);
        assert_eq!(unpack(&[], 0).unwrap(), b"");
    }

    #[test]
    fn damage_is_named() {
        for (packed, length, message) in [
            (&[2, b'a'][..], 3, "ends in the middle"),
            (&[0, b'a', 0x20], 4, "ends in the middle"),
            (&[0, b'a', 0x20, 1], 4, "byte 1 repeats what is before the first"),
            (&[1, b'a', b'b'], 1, "holds more than 1 bytes"),
            (&[0, b'a', 0, b'b'], 1, "holds more than 1 bytes"),
            (&[0, b'a'], 177, "2 bytes cannot hold 177"),
        ] {
            assert_eq!(unpack(packed, length).unwrap_err(), message);
        }
    }
}
