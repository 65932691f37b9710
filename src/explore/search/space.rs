//! The states met so far, each with how it was first reached.
//!
//! States are slices of u32, one after another in one array; tables of their indices find equal ones. Breadth-first
//! order is the order of insertion, so a state's index also says when it was met.
//!
//! Many states can be inserted at once, by several threads: a state's hash says in which table it is, and each table is
//! one thread's. A new state is first known by its place in the list, and numbered when all tables have been asked.

use hashbrown::HashTable;
use rayon::prelude::*;

use crate::explore::program::schedule::Move;

/// Index of a state.
pub(in crate::explore) type StateId = u32;

/// Tables of states.
const TABLES: usize = 16;

pub(in crate::explore) struct Space {
    words: Vec<u32>,
    /// Where each state ends in `words`.
    ends: Vec<usize>,
    tables: [HashTable<Entry>; TABLES],
    came: Vec<(StateId, Move)>,
}

/// A state, or the inverse of a place in a list; and the lower half of its hash.
#[derive(Clone, Copy)]
struct Entry {
    id: StateId,
    low: u32,
}

/// A state to be inserted.
#[derive(Clone, Copy)]
pub(super) struct Offered<'a> {
    pub(super) words: &'a [u32],
    pub(super) hash: u64,
    pub(super) from: StateId,
    pub(super) by: Move,
}

impl Space {
    pub(in crate::explore) fn new() -> Self {
        Self { words: Vec::new(), ends: vec![0], tables: Default::default(), came: Vec::new() }
    }

    pub(in crate::explore) fn len(&self) -> usize {
        self.came.len()
    }

    /// Bytes in use, but for the table's.
    pub(in crate::explore) fn bytes(&self) -> usize {
        self.words.len() * 4 + self.len() * (size_of::<(StateId, Move)>() + size_of::<usize>())
    }

    #[inline]
    pub(in crate::explore) fn get(&self, state: StateId) -> &[u32] {
        &self.words[self.ends[state as usize]..self.ends[state as usize + 1]]
    }

    /// The state's index, and whether it is new.
    pub(in crate::explore) fn insert(
        &mut self,
        state: &[u32],
        from: StateId,
        by: Move,
    ) -> (StateId, bool) {
        self.insert_hashed(state, hash(state), from, by)
    }

    /// The same, with its hash.
    #[inline]
    pub(super) fn insert_hashed(
        &mut self,
        state: &[u32],
        hash: u64,
        from: StateId,
        by: Move,
    ) -> (StateId, bool) {
        let Self { words, ends, tables, .. } = self;
        let (low, table) = (hash as u32, &mut tables[table_of(hash)]);
        let same = |known: &Entry| {
            let at = known.id as usize;
            known.low == low && words[ends[at]..ends[at + 1]] == *state
        };
        if let Some(known) = table.find(hash, same) {
            return (known.id, false);
        }
        let id = self.came.len() as StateId;
        table.insert_unique(hash, Entry { id, low }, |known| spread(known.low));
        self.push(Offered { words: state, hash, from, by });
        (id, true)
    }

    fn push(&mut self, new: Offered<'_>) {
        self.words.extend_from_slice(new.words);
        self.ends.push(self.words.len());
        self.came.push((new.from, new.by));
    }

    /// The indices of states, which may be equal to each other: what [`Self::insert`] gives for one after another.
    pub(super) fn insert_all(&mut self, offered: &[Offered<'_>]) -> Vec<StateId> {
        // Their places, by table.
        let mut starts = [0; TABLES + 1];
        offered.iter().for_each(|new| starts[table_of(new.hash) + 1] += 1);
        (0..TABLES).for_each(|table| starts[table + 1] += starts[table]);
        let (mut places, mut at) = (vec![0u32; offered.len()], starts);
        for (place, new) in (0..).zip(offered) {
            let next = &mut at[table_of(new.hash)];
            places[*next] = place;
            *next += 1;
        }
        let mut tables = std::mem::take(&mut self.tables);
        let of = |table: usize| &places[starts[table]..starts[table + 1]];
        let ask = |(number, table): (usize, &mut HashTable<Entry>)| {
            of(number).iter().map(|&place| self.place(table, offered, place)).collect()
        };
        let found: Vec<Vec<StateId>> = tables.par_iter_mut().enumerate().map(ask).collect();
        let mut ids = vec![0; offered.len()];
        let all = places.iter().zip(found.iter().flatten());
        all.for_each(|(&place, &id)| ids[place as usize] = id);
        for place in 0..offered.len() {
            ids[place] = match self.place_of(ids[place]) {
                None => ids[place],
                Some(first) if first < place => ids[first],
                Some(_) => {
                    self.push(offered[place]);
                    self.came.len() as StateId - 1
                }
            };
        }
        let number = |(number, table): (usize, &mut HashTable<Entry>)| {
            let all = of(number).iter().zip(&found[number]);
            for (&place, _) in all.filter(|&(&place, &id)| id == !place) {
                let (hash, id) = (offered[place as usize].hash, ids[place as usize]);
                table.find_mut(hash, |entry| entry.id == !place).expect("it was put there").id = id;
            }
        };
        tables.par_iter_mut().enumerate().for_each(number);
        self.tables = tables;
        ids
    }

    /// What stands in a table for the state at a place of a list: its index, or the inverse of the first place that has
    /// it.
    fn place(&self, table: &mut HashTable<Entry>, offered: &[Offered<'_>], place: u32) -> StateId {
        let Offered { words, hash, .. } = offered[place as usize];
        let low = hash as u32;
        let same = |known: &Entry| {
            let state =
                || self.place_of(known.id).map_or_else(|| self.get(known.id), |p| offered[p].words);
            known.low == low && state() == words
        };
        if let Some(known) = table.find(hash, same) {
            return known.id;
        }
        table.insert_unique(hash, Entry { id: !place, low }, |known| spread(known.low));
        !place
    }

    /// The place that an index stands for, if it is none of a state yet. There are fewer than 2^31 states.
    fn place_of(&self, id: StateId) -> Option<usize> {
        (id > StateId::MAX / 2).then_some(!id as usize)
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

/// A hash whose lower half determines all of it, so that the table can grow from stored halves. Two words at a time: it
/// is a good part of what a search does.
pub(super) fn hash(state: &[u32]) -> u64 {
    let mut h = 0xCBF2_9CE4_8422_2325u64;
    let (pairs, last) = state.as_chunks::<2>();
    for &[low, high] in pairs {
        h = fold(h ^ (u64::from(low) | u64::from(high) << 32));
    }
    if let &[word] = last {
        h = fold(h ^ u64::from(word));
    }
    spread((h ^ h >> 32) as u32)
}

/// Both halves of a product: every bit of the factor reaches every bit of the result's lower half.
#[inline]
fn fold(h: u64) -> u64 {
    let product = u128::from(h) * 0x9E37_79B9_7F4A_7C15;
    product as u64 ^ (product >> 64) as u64
}

/// The table that a state is in.
fn table_of(hash: u64) -> usize {
    (hash >> 32) as usize % TABLES
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

    /// Lists of states, many of them equal to each other or to earlier ones, get the numbers that they get one by one.
    #[test]
    fn states_inserted_at_once_are_numbered_as_one_by_one() {
        let (mut one, mut all) = (Space::new(), Space::new());
        let state = |i: u32| vec![i.wrapping_mul(0x9E37_79B9) % 3_001, i % 5, 0];
        let mut next = 0;
        for count in [0, 1, 2, 17, 1_000, 3, 20_000, 5_000] {
            let states: Vec<Vec<u32>> = (next..next + count).map(|i| state(i * i / 3)).collect();
            next += count;
            let offer = |(words, from): (&'_ Vec<u32>, StateId)| {
                let by = Move { invocation: (from % 7) as u8, alternative: 0 };
                (words.clone(), from, by)
            };
            let offers: Vec<_> = states.iter().zip(next..).map(offer).collect();
            let expected: Vec<StateId> =
                offers.iter().map(|(words, from, by)| one.insert(words, *from, *by).0).collect();
            let offered: Vec<Offered<'_>> = offers
                .iter()
                .map(|&(ref words, from, by)| Offered { words, hash: hash(words), from, by })
                .collect();
            assert_eq!(all.insert_all(&offered), expected, "{count}");
        }
        assert_eq!((one.len(), &one.words, &one.came), (all.len(), &all.words, &all.came));
        assert!(one.len() > 5_000, "{}", one.len());
        // A table that was told its numbers finds them again.
        for id in 0..all.len() as StateId {
            let words = all.get(id).to_vec();
            assert_eq!(all.insert(&words, 0, BY), (id, false));
        }
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
