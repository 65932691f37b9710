//! k-buffers: the k nearest fragments of a pixel, or what their authors took for it; and the Z-buffer, which is k = 1.

/// `$body` with a constant `$MOST` for the entries that it holds. A usual k is a number that the compiler knows, as a
/// shader's is: it unrolls the loops, and the entries are registers. Any other k has `MAX_K` entries, in memory.
macro_rules! with_entries {
    ($k:expr, $MOST:ident => $body:expr) => {
        match $k {
            4 => {
                const $MOST: usize = 4;
                $body
            }
            8 => {
                const $MOST: usize = 8;
                $body
            }
            16 => {
                const $MOST: usize = 16;
                $body
            }
            _ => {
                const $MOST: usize = MAX_K;
                $body
            }
        }
    };
}

pub mod kb;
pub mod kb_ab;
pub mod kb_ll;
pub mod kb_mdt32;
pub mod kb_mdt64;
pub mod kb_multi;
pub mod kb_ps;
pub mod kb_sr;
pub mod z_buffer;
