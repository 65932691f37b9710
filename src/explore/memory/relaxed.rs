//! Relaxed memory by messages and views: the promising semantics without promises. A write takes any place in its
//! word's order behind what its invocation has seen.
//!
//! A word is a list of messages in its coherence order, oldest first. An invocation sees it from some message on.
//!
//! ```text
//! view        for every word the oldest message that may still be read, and a vector clock
//! invocation  cur: what it has seen; acq: what a barrier would let it see; rel: what it had seen at its last barrier
//! load        any message from cur on; an acquire load joins the message's view to cur, any load to acq
//! store       directly behind any message from cur on that no update has read; the message's view is cur for a
//!             release store, else rel, and the message itself
//! update      reads any message from cur on that no update has read, and puts one directly behind it, attached to it,
//!             with that message's view too (release sequence); one that leaves the value as it is puts none there
//!             unless its view says more, which keeps a spin lock finite
//! compare-exchange  an update of a message that is as expected; or a load of any message that is not
//! barrier     as acquire: joins acq to cur; as release: sets rel to cur
//! plain       as relaxed; a race, if an earlier access is unordered, one of both writes and one is plain
//! ```
//!
//! State: `messages` (value, unwritten or not, attached or not, view); `threads` (`cur`, and with barriers `acq` and
//! `rel`); `accesses` (each invocation's clock at its last access to each word, by kind). A slice is the bytes of these
//! three in canonical form ([`canonical`]): messages that no live invocation may read any more are dropped and the rest
//! renumbered; views of ended invocations are forgotten; clocks keep the order of accesses that may still race, and
//! nothing else. Equal slices are one state. States that behave alike may have different slices: that costs states,
//! not results.
//!
//! Invariants, between operations:
//!
//! 1. Messages never change places among themselves. Nothing comes between an attached message and the one before it,
//!    which its update read. A message's view names the message itself.
//! 2. An invocation's `cur` only grows, and its reads and writes start there. So each word alone is coherent.
//! 3. A live invocation's clock, in its own `cur`, exceeds its clock in any other view: it is raised after each
//!    release.
//! 4. If the `cur` of u knows the clock of t up to w, the accesses of t at clock w or before happen before what u
//!    does next. The converse holds too, but for updates that put no message there (`says_more`).
//!
//! Why it is sound: a message is there before it is read, so the order of a run contains program order and reads-from.
//! Joins pass on what happened before. By 2 no read contradicts it, and no write comes before what its invocation has
//! written, read or learned of; by 1 updates are atomic. So a run is an execution of C++20, with the orders and
//! barriers that the profile leaves. Conversely, if program order and reads-from have no cycle in such an execution,
//! every sequence that contains them is a run: each write takes its place in the coherence order among those that are
//! there. Coherence puts that behind what its invocation has seen, and atomicity never behind a message that an update
//! has read already.
//!
//! An update that puts no message there hides no result, and adds none. Say it read m, and its message would be m'.
//! Given a run without m', put it in, directly behind m, where nothing was attached: what reads m from then on, reads
//! m', and what is placed behind m, stands behind m'. The value is the same, and so is the view, but for the updater's
//! own clock and for m' in place of m; nobody could tell it from m. Given a run with m', leave it out: what reads m'
//! reads m, what is placed behind m' is placed behind m, and the views of those that know m' are as before or know
//! less; so all of it is still allowed. It does not matter whether m is the last message, or what comes behind it
//! later.
//!
//! A state and its canonical form have the same alternatives, results and races, and lead to states that are alike
//! again (a bisimulation).
//!
//! Left out: executions in which program order and reads-from have a cycle: load buffering. Besides: sequentially
//! consistent operations, scopes, mixed sizes, torn accesses, availability and visibility as separate steps. An
//! unwritten word has one of a few candidate values. Where a word would have more than [`MOST_MESSAGES`] messages or
//! a clock would not fit, the operation is not performed: `lost` says so, and nothing may follow; `full` then says
//! that the search was not complete.
//!
//! Published: messages, views, and cur, acq and rel are those of Kang et al., "A promising semantics for
//! relaxed-memory concurrency" (POPL 2017), without promises; attached messages are those with adjacent timestamps.
//! What is left is RC11 without sequentially consistent operations: Lahav et al., "Repairing sequential consistency in
//! C/C++11" (PLDI 2017). In both, an invocation's own later stores continue its release sequence; here, as in C++20
//! (P0982R1), only updates do. Clocks in messages and at barriers: Lidbury and Donaldson, "Dynamic race detection for
//! C++11" (POPL 2017). Clocks of accesses: DJIT+ (Pozniansky and Schuster, PPOPP 2003), here by plain and atomic too.

mod canonical;

use super::model::{Fences, Initial, Model, Profile, Race, Touched, cut, order_of, writes};
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
#[derive(Clone)]
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
    /// The last operation wrote less than the message before it has, or more than the one behind it. Not part of the
    /// state.
    descends: bool,
    /// What the last operation read and wrote. Not part of the state.
    touched: Touched,
    /// There was no room for what the last operation does. Not part of the state: none follows.
    lost: bool,
    /// The same of any operation so far. Not part of the state: it is never taken back.
    full: bool,
}

/// Messages of a word, at most: an invocation that waits and writes may make them without end. An index fits a byte.
const MOST_MESSAGES: usize = 250;

/// A write, as its readers find it. Its timestamp is its place in its cell's list, and changes when another is put
/// before it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Message {
    value: u64,
    /// It has not been written, and not been read: its value is still open. Only a cell's first message can be so.
    unwritten: bool,
    /// An update wrote it, which read the message directly before it. Nothing may come between.
    attached: bool,
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

/// What an operation reads: a message, and the value it gets if it is unwritten. For a write, the message that it is
/// put behind.
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
            vec![Message { value, unwritten, attached: false, view: empty.clone() }]
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
            descends: false,
            touched: Touched::default(),
            lost: false,
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

    /// Whether a message may be put directly behind this one: no update has read it.
    fn is_open(&self, cell: usize, message: usize) -> bool {
        self.messages[cell].get(message + 1).is_none_or(|next| !next.attached)
    }

    /// Everything that an operation may read, or be put behind. The order depends on the state alone: an alternative
    /// is an index into it. The end of the word's order is where sequential consistency goes, so writes and updates
    /// have it first.
    fn choices(&self, invocation: usize, cell: usize, action: Action) -> Vec<Choice> {
        let first = usize::from(self.threads[invocation].cur.from[cell]);
        let last = self.messages[cell].len() - 1;
        let older = || (first..last).rev().filter(|&m| self.is_open(cell, m));
        let readable = |m| self.choices_of(cell, m);
        match action {
            Action::Write(..) => {
                let behind = std::iter::once(last).chain(older());
                behind.map(|message| Choice { message, candidate: 0 }).collect()
            }
            Action::Read(_) => (first..=last).flat_map(readable).collect(),
            // One that fails is a load: it may read any message.
            Action::Update(Update::CompareExchange { expected, .. }, _) => {
                let is = |choice: &Choice| self.value(cell, *choice) == expected;
                let stale = (first..last).flat_map(readable).filter(|choice| !is(choice));
                let found = older().flat_map(readable).filter(is);
                self.choices_of(cell, last).chain(stale).chain(found).collect()
            }
            Action::Update(..) => std::iter::once(last).chain(older()).flat_map(readable).collect(),
        }
    }

    /// Put a message directly behind the one at `before`; `attached`, if an update does it that has read that one.
    fn put(
        &mut self,
        invocation: usize,
        cell: usize,
        before: usize,
        value: u64,
        releases: bool,
        attached: bool,
    ) {
        let messages = &self.messages[cell];
        if messages.len() == MOST_MESSAGES {
            self.lose();
            return;
        }
        let thread = &self.threads[invocation];
        let mut view = if releases { thread.cur.clone() } else { thread.rel.clone() };
        // An update continues the release sequences of what it read, whatever its own order.
        if attached {
            view.join(&messages[before].view);
        }
        let index = before + 1;
        let exceeds = |a: Option<&Message>, b| a.is_some_and(|a| !a.unwritten && a.value > b);
        self.descends = exceeds(messages.get(before), value)
            || messages.get(index).is_some_and(|next| next.value < value);
        if index < messages.len() {
            self.renumber(cell, index);
        }
        self.touched.put = Some(index);
        view.from[cell] = index as u8;
        let message = Message { value, unwritten: false, attached, view };
        self.messages[cell].insert(index, message);
        self.threads[invocation].cur.from[cell] = index as u8;
    }

    /// Make room for a message: the one that is at `index` and those behind it go up by one, wherever a view names
    /// them.
    fn renumber(&mut self, cell: usize, index: usize) {
        let threads = self.threads.iter_mut().flat_map(|t| [&mut t.cur, &mut t.acq, &mut t.rel]);
        let messages = self.messages.iter_mut().flatten().map(|message| &mut message.view);
        for view in threads.chain(messages) {
            let from = &mut view.from[cell];
            *from += u8::from(usize::from(*from) >= index);
        }
    }

    /// There is no room for what the operation does: it must not count as performed.
    fn lose(&mut self) {
        (self.lost, self.full) = (true, true);
    }

    /// Whether an update that leaves the value as it is would tell its readers more than the message it read does: of
    /// other words, or of plain accesses. Its own accesses to atomic words do not count, or else an exchange that
    /// releases could never be waited with; an alarm that this adds needs plain and atomic accesses to one word.
    ///
    /// If it says no more, no message is needed: a reader of the older one gets the same value and sees as much of
    /// every word. Only the updater's clock may be behind, by atomic accesses of its own.
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
        match clock.checked_add(1) {
            Some(next) => *clock = next,
            None => self.lose(),
        }
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
    fn copy(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }

    fn load(&mut self, encoded: &[u32]) {
        canonical::decode(self, encoded);
        self.touched = Touched::default();
        (self.race, self.descends, self.lost) = (None, false, false);
    }

    fn alternatives(&mut self, invocation: usize, cell: u32, action: Action) -> usize {
        self.choices(invocation, cell as usize, action).len()
    }

    fn perform(&mut self, invocation: usize, cell: u32, action: Action, alternative: usize) -> u64 {
        (self.race, self.descends, self.lost) = (None, false, false);
        self.touched = Touched::default();
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
            let value = cut(value, self.bits[cell]);
            self.put(invocation, cell, choice.message, value, releases, false);
        } else {
            result = self.value(cell, choice);
            self.touched.read = Some(choice.message);
            // From its first read on, an unwritten word has this value for all.
            let message = &mut self.messages[cell][choice.message];
            (message.value, message.unwritten) = (result, false);
            // First what an acquire learns: it is ordered after the releases that it reads.
            self.read(invocation, cell, choice.message, acquires);
            // A compare-exchange that fails is a load.
            let writes = writes(action, result);
            self.access(invocation, cell, writes, plain);
            if let Action::Update(update, _) = action
                && writes
            {
                let new = cut(update.apply(result), self.bits[cell]);
                if new != result || self.says_more(invocation, cell, choice.message, releases) {
                    self.put(invocation, cell, choice.message, new, releases, true);
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

    fn descends(&self) -> bool {
        self.descends
    }

    fn lost(&self) -> bool {
        self.lost
    }

    fn full(&self) -> bool {
        self.full
    }

    fn store(&self, live: u32, into: &mut Vec<u32>) {
        canonical::encode(self, live, into);
    }

    /// All invocations have ended: of every word only the last value is left, and everything happened before what
    /// comes.
    fn barrier(&mut self, written: &std::collections::BTreeMap<u32, u64>) {
        let empty = View::new(self.messages.len(), self.invocations);
        for messages in &mut self.messages {
            messages.drain(..messages.len() - 1);
            messages[0].attached = false;
            messages[0].view.clone_from(&empty);
        }
        for (&cell, &value) in written {
            let message = &mut self.messages[cell as usize][0];
            (message.value, message.unwritten) = (value, false);
        }
        self.threads = threads(&empty);
        self.accesses.fill([0; KINDS]);
    }

    fn versions(&self, cell: u32) -> Vec<Option<u64>> {
        let messages = self.messages[cell as usize].iter();
        messages.map(|message| (!message.unwritten).then_some(message.value)).collect()
    }

    fn oldest(&self, invocation: usize, cell: u32) -> usize {
        self.threads[invocation].cur.from[cell as usize].into()
    }

    fn touched(&self) -> Option<Touched> {
        Some(self.touched)
    }

    /// The last message: what a barrier would leave.
    fn settled(&self, cell: u32) -> Option<u64> {
        let last = self.messages.get(cell as usize)?.last()?;
        (!last.unwritten).then_some(last.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::{Access, Atomic, Layout};

    /// Two invocations, and one word that holds 0.
    fn model() -> Relaxed {
        let mut layout = Layout::default();
        layout.pixel::<Atomic, u32>(1);
        let cells = Numbering::new(&layout, 1);
        Relaxed::new(&cells, &[Initial::Written(0)], &[0], 2, Profile::Vulkan)
    }

    fn write(value: u64) -> Action {
        Action::Write(value, Access::Atomic(Order::Relaxed))
    }

    #[test]
    fn a_write_takes_any_place_behind_what_was_seen_but_none_behind_what_an_update_read() {
        let mut model = model();
        model.perform(0, 0, write(5), 0);
        assert_eq!(model.alternatives(0, 0, write(6)), 1, "its own write is seen");
        assert_eq!(model.alternatives(1, 0, write(3)), 2);
        model.perform(1, 0, write(3), 1);
        assert!(!model.descends());
        assert_eq!(model.settled(0), Some(5));
        let add = Action::Update(Update::Add(1), Order::Relaxed);
        assert_eq!(model.alternatives(1, 0, add), 2);
        assert_eq!(model.perform(1, 0, add, 1), 3);
        assert_eq!(model.settled(0), Some(5));
        assert_eq!(model.messages[0].iter().map(|m| m.value).collect::<Vec<_>>(), [0, 3, 4, 5]);
        let places = model.messages[0].iter().map(|m| m.view.from[0]).collect::<Vec<_>>();
        assert_eq!(places, [0, 1, 2, 3]);
        assert_eq!(model.threads.iter().map(|t| t.cur.from[0]).collect::<Vec<_>>(), [3, 2]);
        // Behind 4 and 5.
        assert_eq!(model.alternatives(1, 0, write(9)), 2);
        model.perform(1, 0, write(9), 1);
        assert!(model.descends(), "5 comes behind 9");
        assert_eq!(model.settled(0), Some(5));
    }

    #[test]
    fn what_finds_no_room_is_not_performed() {
        let mut full = model();
        for value in 1..MOST_MESSAGES as u64 {
            full.perform(0, 0, write(value), 0);
            assert!(!full.lost() && !full.full());
        }
        full.perform(0, 0, write(0), 0);
        assert!(full.lost() && full.full());
        full.perform(1, 0, Action::Read(Access::Atomic(Order::Acquire)), 0);
        assert!(!full.lost() && full.full());

        // Releases raise the clock.
        let mut full = model();
        let nothing = Action::Update(Update::Or(0), Order::Release);
        for _ in 1..u8::MAX {
            full.perform(0, 0, nothing, 0);
            assert!(!full.lost());
        }
        full.perform(0, 0, nothing, 0);
        assert!(full.lost() && full.full());
    }
}
