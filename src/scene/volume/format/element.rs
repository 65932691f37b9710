//! Numbers as bytes.

use crate::scene::model::Unplaced;
use crate::scene::volume::grid::voxels;

/// The type of a number in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene::volume) enum Element {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

impl Element {
    /// Bytes of one.
    pub(in crate::scene::volume) fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// By the name that a scene file gives it.
    pub(in crate::scene::volume) fn named(name: &str) -> Unplaced<Self> {
        match name {
            "u8" => Ok(Self::U8),
            "i8" => Ok(Self::I8),
            "u16" => Ok(Self::U16),
            "i16" => Ok(Self::I16),
            "f32" => Ok(Self::F32),
            "f64" => Ok(Self::F64),
            _ => Err(format!("type: {name:?} must be one of u8, i8, u16, i16, f32, f64")),
        }
    }

    /// The numbers of a grid of `size` voxels, which are all of `bytes`. What is larger than an f32 becomes infinite.
    pub(in crate::scene::volume) fn decode(
        self,
        bytes: &[u8],
        size: [u64; 3],
        big: bool,
    ) -> Unplaced<Vec<f32>> {
        let needed = voxels(size)? as u64 * self.bytes() as u64;
        if bytes.len() as u64 != needed {
            let [x, y, z] = size;
            let (each, found) = (self.bytes(), bytes.len());
            return Err(format!(
                "data: {found} bytes, but {x} x {y} x {z} voxels of {each} bytes need {needed}"
            ));
        }
        let one = |chunk: &[u8]| {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            if big {
                word[..chunk.len()].reverse();
            }
            self.value(word)
        };
        Ok(bytes.chunks_exact(self.bytes()).map(one).collect())
    }

    /// From its bytes, the lowest first, filled up with zeroes.
    fn value(self, word: [u8; 8]) -> f32 {
        let bits = u64::from_le_bytes(word);
        match self {
            Self::U8 => f32::from(word[0]),
            Self::I8 => f32::from(word[0] as i8),
            Self::U16 => f32::from(bits as u16),
            Self::I16 => f32::from(bits as i16),
            Self::U32 => bits as u32 as f32,
            Self::I32 => bits as i32 as f32,
            Self::F32 => f32::from_bits(bits as u32),
            Self::F64 => f64::from_bits(bits) as f32,
        }
    }
}
