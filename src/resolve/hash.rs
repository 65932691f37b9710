//! The hash of resolved lists: what "the same fragments" means across machines, executors and methods.

use sha2::{Digest, Sha256};

use crate::num::hex;

/// Bytes gathered before the hash sees them: lists may fill most of the memory, so they are never copied whole.
const CHUNK: usize = 1 << 16;

/// SHA-256, hexadecimal, over little-endian u32 `width` and `height`, then the arrays of `--fragments`:
/// `offsets` (u64), all depths (u32), all data words (u32). A key is `depth << 32 | data`.
#[must_use]
pub fn fragments_hash(width: u32, height: u32, offsets: &[u64], keys: &[u64]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(width.to_le_bytes());
    hasher.update(height.to_le_bytes());
    update(&mut hasher, offsets, u64::to_le_bytes);
    update(&mut hasher, keys, |key| ((key >> 32) as u32).to_le_bytes());
    update(&mut hasher, keys, |key| (key as u32).to_le_bytes());
    hex(&hasher.finalize())
}

/// SHA-256, hexadecimal, of a hash table: over width and height (little-endian u32), then its cells (u64), row by row.
#[must_use]
pub fn table_hash([width, height]: [u32; 2], cells: &[u64]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(width.to_le_bytes());
    hasher.update(height.to_le_bytes());
    update(&mut hasher, cells, u64::to_le_bytes);
    hex(&hasher.finalize())
}

fn update<const N: usize>(hasher: &mut Sha256, words: &[u64], bytes: impl Fn(u64) -> [u8; N]) {
    let mut chunk = Vec::with_capacity(CHUNK);
    for some in words.chunks(CHUNK / N) {
        chunk.clear();
        chunk.extend(some.iter().flat_map(|&word| bytes(word)));
        hasher.update(&chunk);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sha256(bytes: &[u8]) -> String {
        Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
    }

    #[test]
    fn the_bytes_are_sizes_offsets_depths_and_data() {
        let keys = [0x0102_0304_0506_0708, 0x1112_1314_1516_1718];
        #[rustfmt::skip]
        let bytes = [
            2, 0, 0, 0,  1, 0, 0, 0,
            0, 0, 0, 0, 0, 0, 0, 0,  2, 0, 0, 0, 0, 0, 0, 0,  2, 0, 0, 0, 0, 0, 0, 0,
            4, 3, 2, 1,  0x14, 0x13, 0x12, 0x11,
            8, 7, 6, 5,  0x18, 0x17, 0x16, 0x15,
        ];
        assert_eq!(fragments_hash(2, 1, &[0, 2, 2], &keys), sha256(&bytes));
    }

    #[test]
    fn chunks_do_not_show() {
        let keys: Vec<u64> = (0..40_000).map(|i| (i << 32) | (i * i)).collect();
        let mut bytes = vec![1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        bytes.extend(40_000u64.to_le_bytes());
        bytes.extend(keys.iter().flat_map(|key| ((key >> 32) as u32).to_le_bytes()));
        bytes.extend(keys.iter().flat_map(|&key| (key as u32).to_le_bytes()));
        assert_eq!(fragments_hash(1, 1, &[0, 40_000], &keys), sha256(&bytes));
    }

    #[test]
    fn every_part_counts() {
        let hash = |offsets: &[u64], keys: &[u64]| fragments_hash(2, 1, offsets, keys);
        let whole = hash(&[0, 1, 2], &[1 << 32, 2]);
        assert_ne!(whole, hash(&[0, 2, 2], &[1 << 32, 2]));
        assert_ne!(whole, hash(&[0, 1, 2], &[2 << 32, 2]));
        assert_ne!(whole, hash(&[0, 1, 2], &[1 << 32, 3]));
        assert_ne!(whole, fragments_hash(1, 2, &[0, 1, 2], &[1 << 32, 2]));
    }
}
