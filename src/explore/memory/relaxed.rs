//! Relaxed memory by messages and views: the promising semantics without promises, in which a write takes its place
//! in its word's order when it is performed.
//!
//! A word is a list of messages in its coherence order, oldest first. An invocation sees it from some message on.
//!
//! ```text
//! view        for every word the oldest message that may still be read, and a vector clock
//! invocation  cur: what it has seen; acq: what a barrier would let it see; rel: what it had seen at its last barrier
//! load        any message from cur on; an acquire load joins the message's view to cur, any load to acq
//! store       appends; the message's view is cur for a release store, else rel, and the message itself
//! update      reads the last message, appends one with that message's view too (release sequence); one that leaves the
//!             value as it is appends nothing unless its view says more, which keeps a spin lock finite
//! compare-exchange  an update if the last message is as expected; or a load of any message that is not
//! barrier     as acquire: joins acq to cur; as release: sets rel to cur
//! plain       as relaxed; a race, if an earlier access is unordered, one of both writes and one is plain
//! ```
//!
//! State: `messages` (value, unwritten or not, view); `threads` (`cur`, and with barriers `acq` and `rel`);
//! `accesses` (each invocation's clock at its last access to each word, by kind). A slice is the bytes of these three
//! in canonical form ([`Canonical`]): messages that no live invocation may read any more are dropped and the rest
//! renumbered; views of ended invocations are forgotten; clocks keep the order of accesses that may still race, and
//! nothing else. Equal slices are one state. States that behave alike may have different slices: that costs states,
//! not results.
//!
//! Invariants, between operations:
//!
//! 1. A word's order grows at its end only. A message's view names the message itself.
//! 2. An invocation's `cur` only grows, and its reads start there. So each word alone is coherent.
//! 3. A live invocation's clock, in its own `cur`, exceeds its clock in any other view: it is raised after each
//!    release.
//! 4. If the `cur` of u knows the clock of t up to w, the accesses of t at clock w or before happen before what u
//!    does next. The converse holds too, but for updates that append nothing (`says_more`).
//!
//! Why it is sound: a message is there before it is read, so the order of a run contains program order, reads-from
//! and coherence order. Joins pass on what happened before, and by 2 no read contradicts it: a run is an execution of
//! C++20, with the orders and barriers that the profile leaves. Conversely, if these three orders have no cycle in
//! such an execution, every sequence that contains them is a run. An update that appends nothing hides no result:
//! what it read is the last message, has the same value, and lets its readers see as much. A state and its canonical
//! form have the same alternatives, results and races, and lead to states that are alike again (a bisimulation).
//!
//! Left out: executions in which program order, reads-from and coherence order have a cycle: load buffering, 2+2W, S
//! (`tests/memory_model.rs` lists them). Besides: sequentially consistent operations, scopes, mixed sizes, torn
//! accesses, availability and visibility as separate steps. An unwritten word has one of a few candidate values. At
//! [`MOST_MESSAGES`] a write is lost, and what follows is no execution; `full` then says that the search was not
//! complete. A compare-exchange that fails counts as a write: where a word has plain accesses too, that can be called
//! a race that is none.
//!
//! Published: messages, views, and cur, acq and rel are those of Kang et al., "A promising semantics for
//! relaxed-memory concurrency" (POPL 2017), without promises, and with each new timestamp the greatest of its word.
//! There and in RC11 (Lahav et al., PLDI 2017) an invocation's own later stores continue its release sequence; here,
//! as in C++20 (P0982R1), only updates do. That coherence orders and the order of execution agree is strong
//! release/acquire: Lahav, Giannarakis and Vafeiadis, "Taming release-acquire consistency" (POPL 2016). Clocks in
//! messages and at barriers: Lidbury and Donaldson, "Dynamic race detection for C++11" (POPL 2017). Clocks of
//! accesses: DJIT+ (Pozniansky and Schuster, PPOPP 2003), here by plain and atomic too.

use super::model::{Fences, Initial, Model, Profile, Race, cut, order_of};
use crate::memory::asked::Action;
use crate::memory::{Numbering, Order, Update};

/// Kinds of recorded accesses, by (write, plain).
const KINDS: usize = 4;

/// A kind's number: bit 1 for a write, bit 0 for a plain access.
fn kind(writes: bool, plain: bool) -> usize {
    usize::from(writes) * 2 + usize::from(plain)
}

/// The words of one state. `profile` to `invocations` are the same in all states; `messages`, `threads` and
/// `accesses` are the state.
pub(super) struct Relaxed {
    profile: Profile,
    /// The values that an unwritten word may turn out to have.
    candidates: Vec<u64>,
    /// The width of every cell.
    bits: Vec<u32>,
    invocations: usize,
    /// Every cell's messages, oldest first; never empty.
    messages: Vec<Vec<Message>>,
    threads: Vec<Thread>,
    /// When each invocation last accessed each cell, by kind: its own clock then; 0 is never. All of a cell's
    /// invocations, then those of the next cell.
    accesses: Vec<[u8; KINDS]>,
    /// The race that the last operation was part of. Not part of the state.
    race: Option<Race>,
    /// A word had no room for one more message, at any time. Not part of the state: it is never taken back.
    full: bool,
}

/// Messages of a word, at most: an invocation that waits and writes may make them without end. An index fits a byte.
const MOST_MESSAGES: usize = 250;

/// A write, as its readers find it. Its timestamp is its place in its cell's list.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Message {
    value: u64,
    /// It has not been written, and not been read: its value is still open. Only a cell's first message can be so.
    unwritten: bool,
    /// What an acquire that reads it comes to see.
    view: View,
}

/// What is known of memory at some point: a lower bound of what may be read, and what has happened before.
#[derive(Clone, Debug, PartialEq, Eq)]
struct View {
    /// For every cell, the oldest message that may still be read.
    from: Vec<u8>,
    /// For every invocation, the clock value up to which its operations have happened before.
    clock: Vec<u8>,
}

impl View {
    /// A view that knows nothing.
    fn new(cells: usize, invocations: usize) -> Self {
        Self { from: vec![0; cells], clock: vec![0; invocations] }
    }

    /// Add what another view knows: the least upper bound.
    fn join(&mut self, other: &Self) {
        let pairs = self.from.iter_mut().zip(&other.from);
        pairs.chain(self.clock.iter_mut().zip(&other.clock)).for_each(|(a, &b)| *a = (*a).max(b));
    }
}

/// An invocation's views.
#[derive(Clone, Debug)]
struct Thread {
    /// What it has seen: it reads from here on. The clock's entry for the invocation itself is its own clock.
    cur: View,
    /// The views of all messages that it has read: what an acquire barrier adds to `cur`. Empty without barriers.
    acq: View,
    /// `cur` at the last release barrier: the view of a store that does not release. Empty without barriers.
    rel: View,
}

/// Invocations that have done nothing. Clocks begin at 1: a 0 in a view means that it knows nothing of the
/// invocation.
fn threads(empty: &View) -> Vec<Thread> {
    let thread = |t: usize| {
        let mut cur = empty.clone();
        cur.clock[t] = 1;
        Thread { cur, acq: empty.clone(), rel: empty.clone() }
    };
    (0..empty.clock.len()).map(thread).collect()
}

/// What an operation reads: a message, and the value it gets if it is unwritten.
#[derive(Clone, Copy, Debug)]
struct Choice {
    /// Its place in its cell's list.
    message: usize,
    /// Index of the candidate value.
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

    /// Whether operations are ordered by barriers around them.
    fn fenced(&self) -> bool {
        self.profile == Profile::Glsl
    }

    /// A message with each of the values that it may have.
    fn choices_of(&self, cell: usize, message: usize) -> impl Iterator<Item = Choice> + use<> {
        let unwritten = self.messages[cell][message].unwritten;
        let count = if unwritten { self.candidates.len() } else { 1 };
        (0..count).map(move |candidate| Choice { message, candidate })
    }

    /// The value that is read.
    fn value(&self, cell: usize, choice: Choice) -> u64 {
        let message = &self.messages[cell][choice.message];
        if message.unwritten {
            cut(self.candidates[choice.candidate], self.bits[cell])
        } else {
            message.value
        }
    }

    /// Everything that an operation may read. The order depends on the state alone: an alternative is an index into
    /// it.
    fn choices(&self, invocation: usize, cell: usize, action: Action) -> Vec<Choice> {
        let first = usize::from(self.threads[invocation].cur.from[cell]);
        let last = self.messages[cell].len() - 1;
        let mut choices: Vec<Choice> = match action {
            // A write has one way to go: to the end. Kang et al. also allow a place between older messages.
            Action::Write(..) => return vec![Choice { message: last, candidate: 0 }],
            Action::Read(_) => (first..=last).flat_map(|m| self.choices_of(cell, m)).collect(),
            // Its message must come directly after the one it reads, and messages are appended: it reads the last.
            Action::Update(..) => self.choices_of(cell, last).collect(),
        };
        // A compare-exchange that fails is a load: it may read an older message.
        if let Action::Update(Update::CompareExchange { expected, .. }, _) = action {
            let stale = (first..last).flat_map(|m| self.choices_of(cell, m));
            choices.extend(stale.filter(|&c| self.value(cell, c) != expected));
        }
        choices
    }

    /// Append a message. `read` is the one that an update read.
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
            // The write is lost, so that what follows is no execution; the search is no longer complete.
            self.full = true;
            return;
        }
        let thread = &self.threads[invocation];
        let mut view = if releases { thread.cur.clone() } else { thread.rel.clone() };
        // An update continues the release sequences of what it read, whatever its own order.
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
    ///
    /// If it says no more, it need not be appended: a reader of the older message gets the same value and sees as
    /// much of every word. Only the updater's clock may be behind, by atomic accesses of its own.
    fn says_more(&self, invocation: usize, cell: usize, read: usize, releases: bool) -> bool {
        let thread = &self.threads[invocation];
        let own = if releases { &thread.cur } else { &thread.rel };
        let known = &self.messages[cell][read].view;
        let others = (0..self.invocations).filter(|&other| other != invocation);
        // Each release raises its own clock (3), so that alone is not more. A plain access of its own since then is.
        let released = known.clock[invocation] + 1..=own.clock[invocation];
        own.from.iter().zip(&known.from).any(|(own, known)| own > known)
            || others.into_iter().any(|other| own.clock[other] > known.clock[other])
            || self.accesses[invocation..].iter().step_by(self.invocations).any(|of_cell| {
                [false, true].iter().any(|&writes| released.contains(&of_cell[kind(writes, true)]))
            })
    }

    /// What comes with reading a message: the reader may read nothing older of this cell any more (2). The message's
    /// view is known at once to an acquire, and otherwise after the next acquire barrier.
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

    /// Raise an invocation's clock, after a release: what it does from now on is not released by it (3).
    fn tick(&mut self, invocation: usize) {
        let clock = &mut self.threads[invocation].cur.clock[invocation];
        *clock = clock.checked_add(1).expect("canonical clocks stay small");
    }

    /// Record an access; is there an earlier one that it races with?
    ///
    /// The last access of each invocation and kind is enough: its earlier ones come before it in program order. Of
    /// several races, this keeps the one with the lowest invocation.
    fn access(&mut self, invocation: usize, cell: usize, writes: bool, plain: bool) {
        // Then `accesses` stays zero, and no clock value matters to a state.
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
                // Unordered (4), one writes, one is plain.
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
    /// Read what [`Canonical::encode`] wrote.
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
            // Plain is as relaxed; that it is plain shows in races only.
            None => (Order::Relaxed, Fences::default()),
        };
        let plain = order_of(action).is_none();
        let (acquires, releases) = (
            matches!(order, Order::Acquire | Order::AcqRel),
            matches!(order, Order::Release | Order::AcqRel),
        );
        // Later stores carry what is known now. As after any release, the clock goes on (3).
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
            // From its first read on, an unwritten word has this value for all.
            let message = &mut self.messages[cell][choice.message];
            (message.value, message.unwritten) = (result, false);
            // First what an acquire learns: it is ordered after the releases that it reads.
            self.read(invocation, cell, choice.message, acquires);
            self.access(invocation, cell, matches!(action, Action::Update(..)), plain);
            if let Action::Update(update, _) = action {
                let new = cut(update.apply(result), self.bits[cell]);
                let is_last = choice.message + 1 == self.messages[cell].len();
                // A compare-exchange may fail on the last message, too. It is then a load, whatever its view would
                // say.
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
        // The barrier stands behind the operation: it adds the view of the message just read.
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

    /// All invocations have ended: of every word only the last value is left, and everything happened before what
    /// comes.
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

    /// The last message: what a barrier would leave.
    fn settled(&self, cell: u32) -> Option<u64> {
        let last = self.messages.get(cell as usize)?.last()?;
        (!last.unwritten).then_some(last.value)
    }
}

/// A state, as far as live invocations can tell it from others. Each reduction leaves out only what is never asked
/// for:
///
/// - Messages below `base`: every live invocation has its `cur` at or above it, and none begins before the next
///   barrier. Where a view names one, joining it changes no `cur`; 0 stands for all of these.
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

    /// A view with its messages renumbered and its clocks ranked.
    fn view(&self, view: &View, bytes: &mut Vec<u8>) {
        bytes.extend(
            view.from.iter().zip(&self.base).map(|(&from, &base)| from.saturating_sub(base)),
        );
        let clock = view.clock.iter().enumerate();
        bytes.extend(clock.map(|(t, &when)| self.ranks[t][usize::from(when)]));
    }
}
