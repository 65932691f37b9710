//! Relaxed memory with views, after the promise-free part of release/acquire models: a word is a list of messages in
//! the order of their writes; an invocation sees each word from some message on.
//!
//! ```text
//! view        for every word the oldest message that may still be read, and a vector clock
//! invocation  cur: what it has seen; acq: what a barrier would let it see; rel: what it had seen at its last barrier
//! load        any message from cur on; an acquire load joins the message's view to cur, any load to acq
//! store       appends; the message's view is cur for a release store, else rel, and the message itself
//! update      reads the last message, appends one with that message's view too (release sequence); one that leaves the
//!             value as it is appends nothing unless its view says more, which keeps a spin lock finite
//! compare-exchange  an update if the last message is as expected; or a load of any other that is not
//! barrier     as acquire: joins acq to cur; as release: sets rel to cur
//! plain       as relaxed; a race, if an earlier access is unordered, one of both writes and one is plain
//! ```
//!
//! Left out: whatever needs a cycle of program order, reads and the order of writes, since a write enters its word's
//! order when it is performed: load buffering, 2+2W, S (`tests/memory_model.rs` lists them). Besides: sequentially
//! consistent barriers, mixed sizes, availability and visibility as separate steps.
//!
//! Two states are equal if no invocation that goes on can tell them apart: messages that nobody may read any more are
//! dropped and the rest renumbered; views of ended invocations are forgotten; clocks keep the order of accesses that
//! may still race, and nothing else.

use super::model::{Fences, Initial, Model, Profile, Race, cut, order_of};
use crate::memory::asked::Action;
use crate::memory::{Numbering, Order, Update};

/// Kinds of recorded accesses, by (write, plain).
const KINDS: usize = 4;

fn kind(writes: bool, plain: bool) -> usize {
    usize::from(writes) * 2 + usize::from(plain)
}

pub(super) struct Relaxed {
    profile: Profile,
    candidates: Vec<u64>,
    bits: Vec<u32>,
    invocations: usize,
    /// Every cell's messages, oldest first.
    messages: Vec<Vec<Message>>,
    threads: Vec<Thread>,
    /// When each invocation last accessed each cell, by kind: its own clock then; 0 is never.
    accesses: Vec<[u8; KINDS]>,
    race: Option<Race>,
    /// A word had no room for one more message.
    full: bool,
}

/// Messages of a word, at most: an invocation that waits and writes may make them without end.
const MOST_MESSAGES: usize = 250;

#[derive(Clone, Debug, PartialEq, Eq)]
struct Message {
    value: u64,
    /// Nobody wrote it, and nobody has read it.
    unwritten: bool,
    view: View,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct View {
    /// For every cell, the oldest message that may still be read.
    from: Vec<u8>,
    clock: Vec<u8>,
}

impl View {
    fn new(cells: usize, invocations: usize) -> Self {
        Self { from: vec![0; cells], clock: vec![0; invocations] }
    }

    fn join(&mut self, other: &Self) {
        let pairs = self.from.iter_mut().zip(&other.from);
        pairs.chain(self.clock.iter_mut().zip(&other.clock)).for_each(|(a, &b)| *a = (*a).max(b));
    }
}

#[derive(Clone, Debug)]
struct Thread {
    cur: View,
    /// Only where a profile has barriers.
    acq: View,
    rel: View,
}

/// Invocations that have done nothing.
fn threads(empty: &View) -> Vec<Thread> {
    let thread = |t: usize| {
        let mut cur = empty.clone();
        cur.clock[t] = 1;
        Thread { cur, acq: empty.clone(), rel: empty.clone() }
    };
    (0..empty.clock.len()).map(thread).collect()
}

/// What an operation reads: a message, and the value it gets if nobody wrote it.
#[derive(Clone, Copy, Debug)]
struct Choice {
    message: usize,
    candidate: usize,
}

impl Relaxed {
    pub(super) fn new(
        cells: &Numbering,
        initial: &[Initial],
        candidates: &[u64],
        invocations: usize,
        profile: Profile,
    ) -> Self {
        let empty = View::new(initial.len(), invocations);
        let message = |value: &Initial| {
            let (value, unwritten) = match *value {
                Initial::Written(value) => (value, false),
                Initial::Unwritten => (0, true),
            };
            vec![Message { value, unwritten, view: empty.clone() }]
        };
        Self {
            profile,
            candidates: candidates.to_vec(),
            bits: (0..initial.len() as u32).map(|cell| cells.address(cell).bits).collect(),
            invocations,
            messages: initial.iter().map(message).collect(),
            threads: threads(&empty),
            accesses: vec![[0; KINDS]; initial.len() * invocations],
            race: None,
            full: false,
        }
    }

    fn fenced(&self) -> bool {
        self.profile == Profile::Glsl
    }

    /// The values that a message may have.
    fn choices_of(&self, cell: usize, message: usize) -> impl Iterator<Item = Choice> + use<> {
        let unwritten = self.messages[cell][message].unwritten;
        let count = if unwritten { self.candidates.len() } else { 1 };
        (0..count).map(move |candidate| Choice { message, candidate })
    }

    fn value(&self, cell: usize, choice: Choice) -> u64 {
        let message = &self.messages[cell][choice.message];
        if message.unwritten {
            cut(self.candidates[choice.candidate], self.bits[cell])
        } else {
            message.value
        }
    }

    /// Everything that an operation may read.
    fn choices(&self, invocation: usize, cell: usize, action: Action) -> Vec<Choice> {
        let first = usize::from(self.threads[invocation].cur.from[cell]);
        let last = self.messages[cell].len() - 1;
        let mut choices: Vec<Choice> = match action {
            Action::Write(..) => return vec![Choice { message: last, candidate: 0 }],
            Action::Read(_) => (first..=last).flat_map(|m| self.choices_of(cell, m)).collect(),
            Action::Update(..) => self.choices_of(cell, last).collect(),
        };
        if let Action::Update(Update::CompareExchange { expected, .. }, _) = action {
            let stale = (first..last).flat_map(|m| self.choices_of(cell, m));
            choices.extend(stale.filter(|&c| self.value(cell, c) != expected));
        }
        choices
    }

    fn append(
        &mut self,
        invocation: usize,
        cell: usize,
        value: u64,
        releases: bool,
        read: Option<usize>,
    ) {
        let index = self.messages[cell].len();
        if index == MOST_MESSAGES {
            self.full = true;
            return;
        }
        let thread = &self.threads[invocation];
        let mut view = if releases { thread.cur.clone() } else { thread.rel.clone() };
        if let Some(read) = read {
            view.join(&self.messages[cell][read].view);
        }
        view.from[cell] = index as u8;
        self.messages[cell].push(Message { value, unwritten: false, view });
        self.threads[invocation].cur.from[cell] = index as u8;
    }

    /// Whether an update that leaves the value as it is would tell its readers more than the message it read does: of
    /// other words, or of plain accesses. Its own accesses to atomic words do not count, or else an exchange that
    /// releases could never be waited with; an alarm that this adds needs plain and atomic accesses to one word.
    fn says_more(&self, invocation: usize, cell: usize, read: usize, releases: bool) -> bool {
        let thread = &self.threads[invocation];
        let own = if releases { &thread.cur } else { &thread.rel };
        let known = &self.messages[cell][read].view;
        let others = (0..self.invocations).filter(|&other| other != invocation);
        let released = known.clock[invocation] + 1..=own.clock[invocation];
        own.from.iter().zip(&known.from).any(|(own, known)| own > known)
            || others.into_iter().any(|other| own.clock[other] > known.clock[other])
            || self.accesses[invocation..].iter().step_by(self.invocations).any(|of_cell| {
                [false, true].iter().any(|&writes| released.contains(&of_cell[kind(writes, true)]))
            })
    }

    /// What comes with reading a message.
    fn read(&mut self, invocation: usize, cell: usize, message: usize, acquires: bool) {
        let fenced = self.fenced();
        let view = &self.messages[cell][message].view;
        let thread = &mut self.threads[invocation];
        thread.cur.from[cell] = thread.cur.from[cell].max(message as u8);
        if fenced {
            thread.acq.join(view);
        }
        if acquires {
            thread.cur.join(view);
        }
    }

    fn tick(&mut self, invocation: usize) {
        let clock = &mut self.threads[invocation].cur.clock[invocation];
        *clock = clock.checked_add(1).expect("canonical clocks stay small");
    }

    /// Record an access; is there an earlier one that it races with?
    fn access(&mut self, invocation: usize, cell: usize, writes: bool, plain: bool) {
        if !self.profile.has_races() {
            return;
        }
        let clock = &self.threads[invocation].cur.clock;
        let now = clock[invocation];
        let others = (0..self.invocations).filter(|&other| other != invocation);
        let found =
            others.flat_map(|other| (0..KINDS).map(move |k| (other, k))).find(|&(other, k)| {
                let (other_writes, other_plain) = (k & 2 != 0, k & 1 != 0);
                let when = self.accesses[cell * self.invocations + other][k];
                when > clock[other] && (writes || other_writes) && (plain || other_plain)
            });
        self.race = found.map(|(other, k)| Race {
            other,
            cell: cell as u32,
            other_writes: k & 2 != 0,
            other_plain: k & 1 != 0,
        });
        self.accesses[cell * self.invocations + invocation][kind(writes, plain)] = now;
    }
}

impl Model for Relaxed {
    fn load(&mut self, encoded: &[u32]) {
        let mut bytes = encoded.iter().flat_map(|word| word.to_le_bytes());
        let mut byte = || bytes.next().unwrap_or(0);
        let fenced = self.profile == Profile::Glsl;
        let (cells, invocations) = (self.messages.len(), self.invocations);
        let read_view = |view: &mut View, byte: &mut dyn FnMut() -> u8| {
            view.from.iter_mut().for_each(|v| *v = byte());
            view.clock.iter_mut().for_each(|v| *v = byte());
        };
        for cell in 0..cells {
            let count = usize::from(byte());
            let list = &mut self.messages[cell];
            list.resize_with(count, || Message {
                value: 0,
                unwritten: false,
                view: View::new(cells, invocations),
            });
            for message in list {
                message.unwritten = byte() != 0;
                let value: [u8; 8] =
                    std::array::from_fn(
                        |i| if i < self.bits[cell] as usize / 8 { byte() } else { 0 },
                    );
                message.value = u64::from_le_bytes(value);
                read_view(&mut message.view, &mut byte);
            }
        }
        for thread in &mut self.threads {
            read_view(&mut thread.cur, &mut byte);
            if fenced {
                read_view(&mut thread.acq, &mut byte);
                read_view(&mut thread.rel, &mut byte);
            }
        }
        for access in &mut self.accesses {
            access.iter_mut().for_each(|time| *time = byte());
        }
        self.race = None;
    }

    fn alternatives(&mut self, invocation: usize, cell: u32, action: Action) -> usize {
        if cell == Numbering::OUTSIDE {
            return 1;
        }
        self.choices(invocation, cell as usize, action).len()
    }

    fn perform(&mut self, invocation: usize, cell: u32, action: Action, alternative: usize) -> u64 {
        self.race = None;
        if cell == Numbering::OUTSIDE {
            return 0;
        }
        let cell = cell as usize;
        let (order, fences) = match order_of(action) {
            Some(order) => self.profile.order(order),
            None => (Order::Relaxed, Fences::default()),
        };
        let plain = order_of(action).is_none();
        let (acquires, releases) = (
            matches!(order, Order::Acquire | Order::AcqRel),
            matches!(order, Order::Release | Order::AcqRel),
        );
        if fences.before {
            let thread = &mut self.threads[invocation];
            thread.rel = thread.cur.clone();
            self.tick(invocation);
        }
        let choice = self.choices(invocation, cell, action)[alternative];
        let mut result = 0;
        if let Action::Write(value, _) = action {
            self.access(invocation, cell, true, plain);
            self.append(invocation, cell, cut(value, self.bits[cell]), releases, None);
        } else {
            result = self.value(cell, choice);
            let message = &mut self.messages[cell][choice.message];
            (message.value, message.unwritten) = (result, false);
            self.read(invocation, cell, choice.message, acquires);
            self.access(invocation, cell, matches!(action, Action::Update(..)), plain);
            if let Action::Update(update, _) = action {
                let new = cut(update.apply(result), self.bits[cell]);
                let is_last = choice.message + 1 == self.messages[cell].len();
                let fails = matches!(update, Update::CompareExchange { expected, .. } if expected != result);
                if is_last
                    && !fails
                    && (new != result || self.says_more(invocation, cell, choice.message, releases))
                {
                    self.append(invocation, cell, new, releases, Some(choice.message));
                }
            }
        }
        if releases {
            self.tick(invocation);
        }
        if fences.after {
            let thread = &mut self.threads[invocation];
            let acq = thread.acq.clone();
            thread.cur.join(&acq);
        }
        result
    }

    fn race(&self) -> Option<Race> {
        self.race
    }

    fn full(&self) -> bool {
        self.full
    }

    fn store(&self, live: u32, into: &mut Vec<u32>) {
        Canonical::new(self, live).encode(into);
    }

    fn barrier(&mut self, written: &std::collections::BTreeMap<u32, u64>) {
        let empty = View::new(self.messages.len(), self.invocations);
        for messages in &mut self.messages {
            messages.drain(..messages.len() - 1);
            messages[0].view.clone_from(&empty);
        }
        for (&cell, &value) in written {
            let message = &mut self.messages[cell as usize][0];
            (message.value, message.unwritten) = (value, false);
        }
        self.threads = threads(&empty);
        self.accesses.fill([0; KINDS]);
    }

    fn settled(&self, cell: u32) -> Option<u64> {
        let last = self.messages.get(cell as usize)?.last()?;
        (!last.unwritten).then_some(last.value)
    }
}

/// A state, as those who go on can tell it from others.
struct Canonical<'a> {
    state: &'a Relaxed,
    live: u32,
    /// The oldest message that anybody may read, of every cell.
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

    fn living(state: &Relaxed, live: u32) -> impl Iterator<Item = usize> + use<'_> {
        (0..state.invocations).filter(move |t| live & (1 << t) != 0)
    }

    /// Whether somebody who goes on is not ordered after an access.
    fn matters(&self, invocation: usize, when: u8) -> bool {
        when != 0
            && Self::living(self.state, self.live)
                .any(|u| u != invocation && self.state.threads[u].cur.clock[invocation] < when)
    }

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

    fn encode(&self, into: &mut Vec<u32>) {
        let mut bytes = Vec::with_capacity(256);
        for (cell, messages) in self.state.messages.iter().enumerate() {
            let kept = &messages[usize::from(self.base[cell])..];
            bytes.push(kept.len() as u8);
            for message in kept {
                bytes.push(u8::from(message.unwritten));
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

    fn view(&self, view: &View, bytes: &mut Vec<u8>) {
        bytes.extend(
            view.from.iter().zip(&self.base).map(|(&from, &base)| from.saturating_sub(base)),
        );
        let clock = view.clock.iter().enumerate();
        bytes.extend(clock.map(|(t, &when)| self.ranks[t][usize::from(when)]));
    }
}
