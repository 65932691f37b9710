//! Bytes as text.

use std::fmt::Write as _;

/// Two lower-case hexadecimal digits per byte.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn digits_are_padded_and_in_order() {
        assert_eq!(super::hex(&[0, 0x0A, 0xF0, 0xFF]), "000af0ff");
    }
}
