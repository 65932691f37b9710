//! The states met so far, each with how it was first reached.
//!
//! States are slices of u32, one after another in one array; a table of their indices finds equal ones. Breadth-first
//! order is the order of insertion, so a state's index also says when it was met.

use hashbrown::HashTable;

use crate::explore::program::schedule::Move;

/// Index of a state.
pub(in crate::explore) type StateId = u32;

pub(in crate::explore) struct Space {
    words: Vec<u32>,
    /// Where each state ends in `words`.
    ends: Vec<usize>,
    hashes: Vec<u32>,
    table: HashTable<StateId>,
    came: Vec<(StateId, Move)>,
}

impl Space {
    pub(in crate::explore) fn new() -> Self {
        Self {
            words: Vec::new(),
            ends: vec![0],
            hashes: Vec::new(),
            table: HashTable::new(),
            came: Vec::new(),
        }
    }

    pub(in crate::explore) fn len(&self) -> usize {
        self.came.len()
    }

    /// Bytes in use, but for the table's.
    pub(in crate::explore) fn bytes(&self) -> usize {
        self.words.len() * 4 + self.len() * (size_of::<(StateId, Move)>() + 12)
    }

    #[inline]
    pub(in crate::explore) fn get(&self, state: StateId) -> &[u32] {
        &self.words[self.ends[state as usize]..self.ends[state as usize + 1]]
    }

    /// The state's index, and whether it is new.
    #[inline]
    pub(in crate::explore) fn insert(
        &mut self,
        state: &[u32],
        from: StateId,
        by: Move,
    ) -> (StateId, bool) {
        let hash = hash(state);
        let (words, ends, hashes) = (&self.words, &self.ends, &self.hashes);
        let same = |&id: &StateId| {
            hashes[id as usize] == hash as u32
                && words[ends[id as usize]..ends[id as usize + 1]] == *state
        };
        if let Some(&known) = self.table.find(hash, same) {
            return (known, false);
        }
        let id = self.came.len() as StateId;
        self.table.insert_unique(hash, id, |&id| spread(hashes[id as usize]));
        self.words.extend_from_slice(state);
        self.ends.push(self.words.len());
        self.hashes.push(hash as u32);
        self.came.push((from, by));
        (id, true)
    }

    /// The moves that first led to a state, as they were recorded.
    pub(in crate::explore) fn path(&self, state: StateId) -> Vec<Move> {
        let mut moves = Vec::new();
        let mut at = state;
        while at != 0 {
            let (from, by) = self.came[at as usize];
            moves.push(by);
            at = from;
        }
        moves.reverse();
        moves
    }
}

/// A hash whose lower half determines all of it, so that the table can grow from stored halves.
fn hash(state: &[u32]) -> u64 {
    let mut h = 0xCBF2_9CE4_8422_2325u64;
    for &word in state {
        h = (h ^ u64::from(word)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        h ^= h >> 29;
    }
    spread((h ^ h >> 32) as u32)
}

fn spread(half: u32) -> u64 {
    let h = u64::from(half).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    // The table takes its tag from the upper bits, `insert` compares the lower half.
    (h & !0xFFFF_FFFF) | u64::from(half)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BY: Move = Move { invocation: 3, alternative: 7 };

    /// Enough states for the table to grow many times over.
    #[test]
    fn equal_states_are_found_again() {
        let mut space = Space::new();
        let state = |i: u32| [i, i.wrapping_mul(0x9E37_79B9), 0, i % 7];
        for i in 0..100_000 {
            assert_eq!(space.insert(&state(i), i / 2, BY), (i, true));
        }
        for i in (0..100_000).rev() {
            assert_eq!(space.insert(&state(i), 0, BY), (i, false));
            assert_eq!(space.get(i), state(i));
        }
        assert_eq!(space.len(), 100_000);
    }

    #[test]
    fn states_of_other_lengths_are_others() {
        let mut space = Space::new();
        for length in 0..40u32 {
            assert_eq!(space.insert(&vec![0; length as usize], 0, BY), (length, true));
        }
        assert!(space.get(0).is_empty());
        assert_eq!(space.insert(&[0; 12], 0, BY), (12, false));
    }

    #[test]
    fn a_path_is_how_a_state_was_first_reached() {
        let mut space = Space::new();
        let by = |invocation| Move { invocation, alternative: u16::from(invocation) };
        space.insert(&[0], 0, by(9));
        let (one, _) = space.insert(&[1], 0, by(1));
        let (two, _) = space.insert(&[2], one, by(2));
        assert_eq!(space.insert(&[2], 0, by(8)), (two, false));
        assert_eq!(space.path(two), [by(1), by(2)]);
        assert!(space.path(0).is_empty());
    }

    /// What the table compares after it has grown is what it compared before.
    #[test]
    fn a_hash_is_made_again_from_its_lower_half() {
        for i in 0..10_000u32 {
            let whole = hash(&[i, !i]);
            assert_eq!(spread(whole as u32), whole);
        }
    }
}
