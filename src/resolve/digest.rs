//! The digest of resolved lists: what "the same fragments" means across machines, executors and methods.

use sha2::{Digest, Sha256};

use super::{Kept, Lists};
use crate::num::hex;
use crate::scheme::{Depth, Record};

/// Bytes gathered before the hash sees them: lists may fill most of the memory, so they are never copied whole.
const CHUNK: usize = 1 << 16;

/// What a frame's pixels hold, as SHA-256, hexadecimal: of lists of fragments ([`fragments_hash`]) and of merged
/// records ([`records_hash`]), and of depths, row by row; `None` where there are only colours.
#[must_use]
pub fn kept_hash(kept: &Kept) -> Option<String> {
    match kept {
        Kept::Fragments(lists) => Some(fragments_hash(lists)),
        Kept::Records(lists) => Some(records_hash(lists)),
        Kept::Depths(depths) => Some(depths_hash(depths)),
        Kept::Color(_) | Kept::Gone(_) => None,
    }
}

/// SHA-256, hexadecimal, over little-endian u32 width and height, then the arrays of `--fragments`: offsets (u64), all
/// depths (u32), all data words (u32). A key is `depth << 32 | data`.
#[must_use]
pub fn fragments_hash(lists: &Lists) -> String {
    let mut stream = Stream::new(lists.width, lists.height);
    stream.offsets(&lists.offsets);
    stream.depths(&lists.entries);
    stream.data(&lists.entries);
    stream.finish()
}

/// [`fragments_hash`] or [`records_hash`], part by part: all offsets, then of fragments all depths, then all data words;
/// of records, all of every [`Part`].
#[derive(Debug)]
pub struct Stream {
    hasher: Sha256,
    chunk: Vec<u8>,
}

impl Stream {
    /// Of a picture of this size.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let mut hasher = Sha256::new();
        hasher.update(width.to_le_bytes());
        hasher.update(height.to_le_bytes());
        Self { hasher, chunk: Vec::with_capacity(CHUNK) }
    }

    /// The next offsets.
    pub fn offsets(&mut self, offsets: &[u64]) {
        self.words(offsets, u64::to_le_bytes);
    }

    /// The depths of the next fragments.
    pub fn depths(&mut self, keys: &[u64]) {
        self.words(keys, |key| ((key >> 32) as u32).to_le_bytes());
    }

    /// The data words of the next fragments.
    pub fn data(&mut self, keys: &[u64]) {
        self.words(keys, |key| (key as u32).to_le_bytes());
    }

    /// This part of the next records.
    pub fn records(&mut self, part: Part, records: impl Iterator<Item = Record>) {
        match part {
            Part::Depth => self.bytes(records.map(|record| record.depth.to_le_bytes())),
            Part::Color => self.bytes(records.map(|record| record.color().to_le_bytes())),
            Part::Thickness => self.bytes(records.map(|record| record.thickness.to_le_bytes())),
            Part::Rgba => self.bytes(records.flat_map(|record| record.rgba.map(f64::to_le_bytes))),
            Part::Weight => self.bytes(records.map(|record| record.weight.to_le_bytes())),
        }
    }

    /// Hexadecimal.
    #[must_use]
    pub fn finish(mut self) -> String {
        self.hasher.update(&self.chunk);
        hex(&self.hasher.finalize())
    }

    #[inline(always)]
    #[allow(clippy::inline_always, reason = "most calls bring a few words")]
    fn words<const N: usize>(&mut self, words: &[u64], bytes: impl Fn(u64) -> [u8; N]) {
        for some in words.chunks(CHUNK / N) {
            if self.chunk.len() + N * some.len() > CHUNK {
                self.hasher.update(&self.chunk);
                self.chunk.clear();
            }
            self.chunk.extend(some.iter().flat_map(|&word| bytes(word)));
        }
    }

    fn bytes<const N: usize>(&mut self, words: impl Iterator<Item = [u8; N]>) {
        for word in words {
            if self.chunk.len() + N > CHUNK {
                self.hasher.update(&self.chunk);
                self.chunk.clear();
            }
            self.chunk.extend(word);
        }
    }
}

/// The parts of merged records in their digest, one after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// u32.
    Depth,
    /// The colour as a data word (RGBA8).
    Color,
    /// f64.
    Thickness,
    /// The four premultiplied components of the colour, f64 each.
    Rgba,
    /// f64.
    Weight,
}

impl Part {
    /// In their order.
    pub const ALL: [Self; 5] =
        [Self::Depth, Self::Color, Self::Thickness, Self::Rgba, Self::Weight];
}

/// The same of merged records: width and height, offsets, then all of every [`Part`].
#[must_use]
pub fn records_hash(lists: &Lists<Record>) -> String {
    let mut stream = Stream::new(lists.width, lists.height);
    stream.offsets(&lists.offsets);
    Part::ALL.iter().for_each(|&part| stream.records(part, lists.entries.iter().copied()));
    stream.finish()
}

fn depths_hash(depths: &[Depth]) -> String {
    let mut hasher = Sha256::new();
    update(&mut hasher, depths, |Depth(depth)| depth.to_le_bytes());
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

fn update<T: Copy, const N: usize>(hasher: &mut Sha256, words: &[T], bytes: impl Fn(T) -> [u8; N]) {
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

    fn lists<T>(width: u32, height: u32, offsets: &[u64], entries: Vec<T>) -> Lists<T> {
        Lists { width, height, offsets: offsets.to_vec(), entries }
    }

    fn hash(width: u32, height: u32, offsets: &[u64], keys: &[u64]) -> String {
        fragments_hash(&lists(width, height, offsets, keys.to_vec()))
    }

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
        assert_eq!(hash(2, 1, &[0, 2, 2], &keys), sha256(&bytes));
    }

    #[test]
    fn parts_do_not_show() {
        let keys: Vec<u64> = (0..50_000).map(|i| (i << 33) | (i * i)).collect();
        for size in [1, 7, 4_096, 50_000] {
            let mut stream = Stream::new(1, 1);
            stream.offsets(&[0]);
            stream.offsets(&[50_000]);
            keys.chunks(size).for_each(|part| stream.depths(part));
            keys.chunks(size).for_each(|part| stream.data(part));
            assert_eq!(stream.finish(), hash(1, 1, &[0, 50_000], &keys), "{size}");
        }
    }

    #[test]
    fn chunks_do_not_show() {
        let keys: Vec<u64> = (0..40_000).map(|i| (i << 32) | (i * i)).collect();
        let mut bytes = vec![1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        bytes.extend(40_000u64.to_le_bytes());
        bytes.extend(keys.iter().flat_map(|key| ((key >> 32) as u32).to_le_bytes()));
        bytes.extend(keys.iter().flat_map(|&key| (key as u32).to_le_bytes()));
        assert_eq!(hash(1, 1, &[0, 40_000], &keys), sha256(&bytes));
    }

    #[test]
    fn every_part_counts() {
        let whole = hash(2, 1, &[0, 1, 2], &[1 << 32, 2]);
        assert_ne!(whole, hash(2, 1, &[0, 2, 2], &[1 << 32, 2]));
        assert_ne!(whole, hash(2, 1, &[0, 1, 2], &[2 << 32, 2]));
        assert_ne!(whole, hash(2, 1, &[0, 1, 2], &[1 << 32, 3]));
        assert_ne!(whole, hash(1, 2, &[0, 1, 2], &[1 << 32, 2]));
    }

    #[test]
    fn every_part_of_a_record_counts() {
        let hash = |record| records_hash(&lists(1, 1, &[0, 1], vec![record]));
        let record = Record { depth: 5, thickness: 0.5, rgba: [0.1, 0.2, 0.3, 0.4], weight: 2.0 };
        let changed = [
            Record { depth: 6, ..record },
            Record { thickness: 0.75, ..record },
            Record { rgba: [0.1, 0.2, 0.3000001, 0.4], ..record },
            Record { weight: 1.0, ..record },
        ];
        for other in changed {
            assert_ne!(hash(other), hash(record), "{other:?}");
        }
        assert_eq!(hash(record), hash(record));
        let none = Kept::Color(vec![crate::scheme::Light::default()]);
        assert_eq!(kept_hash(&none), None, "no lists, no digest");
    }
}
