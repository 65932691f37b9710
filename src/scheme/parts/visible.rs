//! What early culling goes by: how much light passes the fragments in front.
//!
//! Transmittance is in 16 bits, as compositing has it (`resolve::composite`): T from 65,535, then (T (255 - a) + 127) /
//! 255 for every opacity a. It never grows, and a fragment more in front never makes it larger: an invocation that
//! knows only some of the fragments in front never underestimates it.

use crate::fragment::{data_of, depth_of};

/// All light.
pub const CLEAR: u32 = 65_535;

/// Transmittance behind a fragment with this data word (RGBA8).
#[inline]
#[must_use]
pub const fn behind(transmittance: u32, data: u32) -> u32 {
    (transmittance * (255 - (data >> 24)) + 127) / 255
}

/// Whether the fragment is behind others, of those generated at its pixel (sorted), that let less than `opaque` light
/// through. Others of its own depth count as in front: no order of equal depths is the right one.
#[must_use]
pub fn is_hidden(generated: &[u64], key: u64, opaque: u16) -> bool {
    let nearer = generated.partition_point(|&other| depth_of(other) < depth_of(key));
    let end = generated.partition_point(|&other| depth_of(other) <= depth_of(key));
    // As tables order them: of equal depths, the larger data word first.
    let mut front: Vec<u64> = generated[..end].to_vec();
    if let Some(own) = front[nearer..].iter().position(|&other| other == key) {
        front.remove(nearer + own);
    }
    front.dedup();
    front.sort_unstable_by_key(|&other| (depth_of(other), u32::MAX - data_of(other)));
    let passes = front.iter().fold(CLEAR, |light, &other| behind(light, data_of(other)));
    passes < u32::from(opaque)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fragment::key;

    const DARK: u32 = 250 << 24;

    #[test]
    fn fragments_behind_opaque_ones_are_hidden() {
        let list = [key(1, DARK), key(2, DARK), key(3, 0), key(3, 1)];
        let hidden = |key| is_hidden(&list, key, 656);
        assert!(hidden(list[2]) && hidden(list[3]));
        assert!(!hidden(list[0]) && !hidden(list[1]));
        let ties = [key(1, DARK), key(2, DARK), key(2, DARK + 1)];
        assert!(is_hidden(&ties, ties[1], 656), "either of two may be in front of the other");
        assert!(is_hidden(&ties, ties[2], 656));
        let alike = [key(1, DARK), key(1, DARK)];
        assert!(!is_hidden(&alike, alike[0], 656), "but none is in front of itself");
    }

    proptest! {
        #[test]
        fn more_in_front_never_lets_more_through(
            alphas in prop::collection::vec(0u32..256, 0..12), at in 0usize..12, extra in 0u32..256
        ) {
            let through = |alphas: &[u32]| alphas.iter().fold(CLEAR, |t, a| behind(t, a << 24));
            let mut more = alphas.clone();
            more.insert(at.min(alphas.len()), extra);
            prop_assert!(through(&more) <= through(&alphas));
        }
    }
}
