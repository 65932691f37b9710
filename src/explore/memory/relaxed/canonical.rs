//! A state of relaxed memory as a slice, in canonical form: states that no live invocation can tell apart are mostly one
//! slice.

use super::{Message, Relaxed, View};
use crate::explore::memory::model::Profile;

/// Encode a state; `live` has a bit for every invocation that has not ended.
pub(super) fn encode(state: &Relaxed, live: u32, into: &mut Vec<u32>) {
    Canonical::new(state, live).encode(into);
}

/// Read what [`encode`] wrote.
pub(super) fn decode(state: &mut Relaxed, encoded: &[u32]) {
    let mut bytes = encoded.iter().flat_map(|word| word.to_le_bytes());
    let mut byte = || bytes.next().unwrap_or(0);
    let fenced = state.profile == Profile::Glsl;
    let (cells, invocations) = (state.messages.len(), state.invocations);
    let read_view = |view: &mut View, byte: &mut dyn FnMut() -> u8| {
        view.from.iter_mut().for_each(|v| *v = byte());
        view.clock.iter_mut().for_each(|v| *v = byte());
    };
    for cell in 0..cells {
        let count = usize::from(byte());
        let list = &mut state.messages[cell];
        list.resize_with(count, || Message {
            value: 0,
            unwritten: false,
            attached: false,
            view: View::new(cells, invocations),
        });
        for message in list {
            let flags = byte();
            (message.unwritten, message.attached) = (flags & 1 != 0, flags & 2 != 0);
            let value: [u8; 8] =
                std::array::from_fn(|i| if i < state.bits[cell] as usize / 8 { byte() } else { 0 });
            message.value = u64::from_le_bytes(value);
            read_view(&mut message.view, &mut byte);
        }
    }
    for thread in &mut state.threads {
        read_view(&mut thread.cur, &mut byte);
        if fenced {
            read_view(&mut thread.acq, &mut byte);
            read_view(&mut thread.rel, &mut byte);
        }
    }
    for access in &mut state.accesses {
        access.iter_mut().for_each(|time| *time = byte());
    }
}

/// A state, as far as live invocations can tell it from others. Each reduction leaves out only what is never asked
/// for:
///
/// - Messages below `base`: every live invocation has its `cur` at or above it, and none begins before the next
///   barrier. Where a view names one, joining it changes no `cur`; 0 stands for all of these. Nothing is put before
///   the message at `base` any more, so it does not matter whether it is attached.
/// - Views of ended invocations. What they have released is in messages.
/// - Accesses that happened before what every other live invocation does next: clocks only grow, so they race no
///   more.
/// - Clock values, but for their order among the accesses that matter. An entry says which accesses are ordered, so
///   it is replaced by the number of their times up to it. Accesses to come are at the own clock or after it, so the
///   own clock counts as one of these times. Of two entries with equal rank neither says more (`says_more`).
struct Canonical<'a> {
    state: &'a Relaxed,
    /// Bits of the live invocations.
    live: u32,
    /// The oldest message that a live invocation may read, of every cell; the last one, if none is live.
    base: Vec<u8>,
    /// The rank of every invocation's clock value among those that may matter.
    ranks: Vec<[u8; 256]>,
}

impl<'a> Canonical<'a> {
    fn new(state: &'a Relaxed, live: u32) -> Self {
        let oldest = |cell: usize| {
            let last = state.messages[cell].len() as u8 - 1;
            Self::living(state, live).map(|t| state.threads[t].cur.from[cell]).min().unwrap_or(last)
        };
        let base = (0..state.messages.len()).map(oldest).collect();
        let mut canonical = Self { state, live, base, ranks: Vec::new() };
        canonical.ranks = (0..state.invocations).map(|t| canonical.ranks_of(t)).collect();
        canonical
    }

    /// The live invocations.
    fn living(state: &Relaxed, live: u32) -> impl Iterator<Item = usize> + use<'_> {
        (0..state.invocations).filter(move |t| live & (1 << t) != 0)
    }

    /// Whether a live invocation other than its own is not yet ordered after an access: only then can it still race.
    fn matters(&self, invocation: usize, when: u8) -> bool {
        when != 0
            && Self::living(self.state, self.live)
                .any(|u| u != invocation && self.state.threads[u].cur.clock[invocation] < when)
    }

    /// For each clock value of an invocation, how many times that may matter are not after it. `when > clock` has the
    /// same answer for ranks as for the values, if `when` is such a time.
    fn ranks_of(&self, invocation: usize) -> [u8; 256] {
        let mut used = [false; 256];
        for cell in 0..self.state.messages.len() {
            for when in self.state.accesses[cell * self.state.invocations + invocation] {
                used[usize::from(when)] |= self.matters(invocation, when);
            }
        }
        if self.live & (1 << invocation) != 0 {
            used[usize::from(self.state.threads[invocation].cur.clock[invocation])] = true;
        }
        let mut rank = 0;
        std::array::from_fn(|when| {
            rank += u8::from(used[when]);
            rank
        })
    }

    /// The state's bytes, in words. A list of messages has its length before it, and all other lengths are the same
    /// in every state; so slices are equal exactly if the canonical states are.
    fn encode(&self, into: &mut Vec<u32>) {
        let mut bytes = Vec::with_capacity(256);
        for (cell, messages) in self.state.messages.iter().enumerate() {
            let kept = &messages[usize::from(self.base[cell])..];
            bytes.push(kept.len() as u8);
            for (i, message) in kept.iter().enumerate() {
                let attached = message.attached && i > 0;
                bytes.push(u8::from(message.unwritten) | u8::from(attached) << 1);
                let width = self.state.bits[cell] as usize / 8;
                bytes.extend_from_slice(&message.value.to_le_bytes()[..width]);
                self.view(&message.view, &mut bytes);
            }
        }
        for (t, thread) in self.state.threads.iter().enumerate() {
            let lives = self.live & (1 << t) != 0;
            let rows = [&thread.cur, &thread.acq, &thread.rel];
            for row in &rows[..if self.state.fenced() { 3 } else { 1 }] {
                if lives {
                    self.view(row, &mut bytes);
                } else {
                    bytes.resize(bytes.len() + row.from.len() + row.clock.len(), 0);
                }
            }
        }
        for (i, access) in self.state.accesses.iter().enumerate() {
            let t = i % self.state.invocations;
            let rank = |&when: &u8| {
                if self.matters(t, when) { self.ranks[t][usize::from(when)] } else { 0 }
            };
            bytes.extend(access.iter().map(rank));
        }
        let word = |chunk: &[u8]| {
            u32::from_le_bytes(std::array::from_fn(|i| chunk.get(i).copied().unwrap_or(0)))
        };
        into.extend(bytes.chunks(4).map(word));
    }

    /// A view with its messages renumbered and its clocks ranked.
    fn view(&self, view: &View, bytes: &mut Vec<u8>) {
        bytes.extend(
            view.from.iter().zip(&self.base).map(|(&from, &base)| from.saturating_sub(base)),
        );
        let clock = view.clock.iter().enumerate();
        bytes.extend(clock.map(|(t, &when)| self.ranks[t][usize::from(when)]));
    }
}
