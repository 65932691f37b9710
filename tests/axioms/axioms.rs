//! The results of a program by the axioms of relaxed memory: executions are guessed as a whole, and those that break
//! an axiom are dropped. Nothing here moves step by step, and nothing is shared with the explorer.
//!
//! ```text
//! po      program order: the operations of a thread
//! rf      reads-from: the write that a read gets its value from
//! mo      a total order of the writes to each word, the initial value first
//! rb      from a read to every write behind the one it reads
//! eco     the transitive closure of rf, mo and rb
//! sw      from a release to an acquire that reads from its release sequence: it, and updates that continue it
//! hb      the transitive closure of po and sw
//!
//! coherence   no a, b with a hb b and b eco a
//! atomicity   nothing comes in mo between an update and the write it reads
//! causality   po and rf have no cycle
//! ```
//!
//! So Lahav et al., "Repairing sequential consistency in C/C++11" (PLDI 2017), without sequentially consistent
//! operations; release sequences as in C++20 (P0982R1).

use std::collections::BTreeSet;

use fragloom::explore::Profile;
use fragloom::memory::Order::{AcqRel, Acquire, Release};

use crate::program::{Kind, MOST, Op, Program, value};

/// What is asked of an execution. All of it is the model; controls leave something out or add to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axioms {
    /// Coherence of a write with what happened before it, as against that of reads.
    pub(crate) writes_are_coherent: bool,
    pub(crate) reads_are_coherent: bool,
    pub(crate) atomicity: bool,
    pub(crate) causality: bool,
    /// Writes come in mo as their threads can be interleaved: strong release/acquire.
    pub(crate) write_order_is_causal: bool,
    /// Releases and acquires make sw.
    pub(crate) synchronises: bool,
    /// Updates continue a release sequence.
    pub(crate) updates_continue: bool,
    /// As in C++11, so do later stores of the same thread.
    pub(crate) own_stores_continue: bool,
}

/// The model.
pub(crate) const MODEL: Axioms = Axioms {
    writes_are_coherent: true,
    reads_are_coherent: true,
    atomicity: true,
    causality: true,
    write_order_is_causal: false,
    synchronises: true,
    updates_continue: true,
    own_stores_continue: false,
};

/// A result: for each operation the value read, 0 for none, then the last value of each word; 4 bits each.
pub(crate) type Outcome = u32;

/// A result with its parts.
pub(crate) fn outcome(read: [u32; 2 * MOST], last: [u32; 2]) -> Outcome {
    read.into_iter().chain(last).rev().fold(0, |all, digit| all << 4 | digit)
}

/// The most events: operations, and the initial values.
const EVENTS: usize = 2 * MOST + 2;

/// A relation on events: for each the set of those it leads to, as bits.
type Relation = [u32; 3 * EVENTS];

/// Close a relation on so many.
fn close(relation: &mut Relation, count: usize) {
    for middle in 0..count {
        for from in 0..count {
            if relation[from] & 1 << middle != 0 {
                relation[from] |= relation[middle];
            }
        }
    }
}

fn is_irreflexive(relation: &Relation) -> bool {
    relation.iter().enumerate().all(|(i, to)| to & 1 << i == 0)
}

#[derive(Clone, Copy)]
struct Event {
    thread: usize,
    place: usize,
    op: Op,
}

struct Enumerator {
    profile: Profile,
    axioms: Axioms,
    /// The operations. The initial values have the two numbers behind.
    events: Vec<Event>,
    /// For each operation the event that it reads from.
    source: [usize; EVENTS],
    results: BTreeSet<Outcome>,
}

/// All results of a program.
pub(crate) fn results(program: &Program, profile: Profile, axioms: Axioms) -> BTreeSet<Outcome> {
    let of_thread = |(thread, ops): (usize, &Vec<Op>)| {
        let events = ops.iter().enumerate().map(|(place, &op)| Event { thread, place, op });
        events.collect::<Vec<_>>()
    };
    let events = program.iter().enumerate().flat_map(of_thread).collect();
    let (source, results) = ([0; EVENTS], BTreeSet::new());
    let mut all = Enumerator { profile, axioms, events, source, results };
    all.guess_sources(0);
    all.results
}

impl Enumerator {
    fn count(&self) -> usize {
        self.events.len()
    }

    fn reads(&self, event: usize) -> bool {
        event < self.count() && self.events[event].op.kind != Kind::Store
    }

    /// The word of an event, be it an initial value.
    fn word(&self, event: usize) -> usize {
        let initial = event.checked_sub(self.count());
        initial.unwrap_or_else(|| usize::from(self.events[event].op.word))
    }

    fn may_read(&self, event: usize, source: usize) -> bool {
        let is_later = || self.same_thread(source, event) && source >= event;
        let writes = || source >= self.count() || self.events[source].op.kind != Kind::Load;
        self.word(source) == self.word(event) && writes() && !is_later()
    }

    fn same_thread(&self, a: usize, b: usize) -> bool {
        let thread = |event: usize| self.events.get(event).map(|e| e.thread);
        thread(a) == thread(b)
    }

    fn guess_sources(&mut self, event: usize) {
        if event == self.count() {
            self.judge_sources();
        } else if self.reads(event) {
            for source in 0..self.count() + 2 {
                if self.may_read(event, source) {
                    self.source[event] = source;
                    self.guess_sources(event + 1);
                }
            }
        } else {
            self.guess_sources(event + 1);
        }
    }

    /// What every event reads and writes; `None` if a value comes from nowhere, or is read from what does not write.
    fn values(&self) -> Option<([u32; EVENTS], [Option<u32>; EVENTS])> {
        let n = self.count();
        let (mut read, mut written) = ([0; EVENTS], [None; EVENTS]);
        let mut known = 0b11 << n;
        (written[n], written[n + 1]) = (Some(0), Some(0));
        for (event, e) in self.events.iter().enumerate() {
            // These write the same, whatever they read.
            if matches!(e.op.kind, Kind::Store | Kind::Exchange) {
                (written[event], known) = (Some(value(e.thread, e.place)), known | 1 << event);
            }
        }
        let mut done: u32 = 0;
        loop {
            let ready = |&event: &usize| {
                done & 1 << event == 0
                    && (!self.reads(event) || known & 1 << self.source[event] != 0)
            };
            let Some(event) = (0..n).find(ready) else { break };
            done |= 1 << event;
            if self.reads(event) {
                let Event { thread, place, op } = self.events[event];
                let own = value(thread, place);
                let old = written[self.source[event]]?;
                read[event] = old;
                written[event] = match op.kind {
                    Kind::Load => None,
                    Kind::Store | Kind::Exchange => Some(own),
                    Kind::Keep => Some(old),
                    Kind::Max => Some(old.max(own)),
                    Kind::IfZero => (old == 0).then_some(own),
                    Kind::IfOther => (old == value(1 - thread, 0)).then_some(own),
                };
                known |= 1 << event;
            }
        }
        (done.count_ones() as usize == n).then_some((read, written))
    }

    fn judge_sources(&mut self) {
        let Some((read, written)) = self.values() else { return };
        if self.axioms.causality && !is_irreflexive(&self.order(|_| Vec::new(), true, &[])) {
            return;
        }
        let updates = |event: usize| self.reads(event) && written[event].is_some();
        let hb = self.order(|event| self.releases_read_by(event, &updates), false, &[]);
        if !is_irreflexive(&hb) {
            return;
        }
        // Coherence and atomicity are of each word alone.
        let orders = [0, 1].map(|word| self.write_orders(word, &hb, &written));
        let mut results = Vec::new();
        for x in &orders[0] {
            for y in &orders[1] {
                if self.axioms.write_order_is_causal
                    && !is_irreflexive(&self.order(|_| Vec::new(), true, &[x, y]))
                {
                    continue;
                }
                let last = [x, y].map(|order| order.last().and_then(|&w| written[w]).unwrap_or(0));
                let mut by_place = [0; 2 * MOST];
                for (event, e) in self.events.iter().enumerate() {
                    by_place[e.thread * MOST + e.place] = read[event];
                }
                results.push(outcome(by_place, last));
            }
        }
        self.results.extend(results);
    }

    /// Program order with more edges, closed. An operation has three points: before it, where its release barrier
    /// stands if it has one; itself; and behind it, for an acquire barrier.
    fn order(
        &self,
        synchronised: impl Fn(usize) -> Vec<(usize, usize)>,
        reads_from: bool,
        write_orders: &[&Vec<usize>],
    ) -> Relation {
        let n = self.count();
        let mut order: Relation = [0; 3 * EVENTS];
        for (point, to) in order.iter_mut().enumerate().take(3 * n) {
            let (event, next) = (point / 3, (point + 1) / 3);
            if next < n && self.same_thread(event, next) {
                *to |= 1 << (point + 1);
            }
        }
        for event in (0..n).filter(|&event| self.reads(event)) {
            synchronised(event).into_iter().for_each(|(from, to)| order[from] |= 1 << to);
            if reads_from && self.source[event] < n {
                order[3 * self.source[event] + 1] |= 1 << (3 * event + 1);
            }
        }
        let pairs = write_orders.iter().flat_map(|writes| writes[1..].windows(2));
        pairs.for_each(|pair| order[3 * pair[0] + 1] |= 1 << (3 * pair[1] + 1));
        close(&mut order, 3 * n);
        order
    }

    fn releases(&self, event: usize) -> bool {
        matches!(self.events[event].op.order, Release | AcqRel)
    }

    fn acquires(&self, event: usize) -> bool {
        matches!(self.events[event].op.order, Acquire | AcqRel)
    }

    /// The edges of sw that come with a read: along the release sequences that it reads from.
    fn releases_read_by(
        &self,
        event: usize,
        updates: &dyn Fn(usize) -> bool,
    ) -> Vec<(usize, usize)> {
        let n = self.count();
        let mut edges = Vec::new();
        let mut write = self.source[event];
        // No longer than this; without causality, a sequence may lead round.
        for _ in 0..n {
            if write >= n || !self.axioms.synchronises {
                break;
            }
            self.synchronise(write, event, &mut edges);
            if self.axioms.own_stores_continue {
                let is_earlier = |&earlier: &usize| {
                    self.same_thread(earlier, write)
                        && earlier < write
                        && self.word(earlier) == self.word(write)
                        && (updates(earlier) || self.events[earlier].op.kind == Kind::Store)
                };
                (0..n).filter(is_earlier).for_each(|w| self.synchronise(w, event, &mut edges));
            }
            if !updates(write) || !self.axioms.updates_continue {
                break;
            }
            write = self.source[write];
        }
        edges
    }

    /// The edge from a write, or the barrier before it, to a read, or the barrier behind it.
    fn synchronise(&self, write: usize, read: usize, edges: &mut Vec<(usize, usize)>) {
        match self.profile {
            Profile::Vulkan => {
                if self.releases(write) && self.acquires(read) {
                    edges.push((3 * write + 1, 3 * read + 1));
                }
            }
            Profile::Glsl => {
                for release in
                    (0..=write).filter(|&w| self.same_thread(w, write) && self.releases(w))
                {
                    for acquire in read..self.count() {
                        if self.same_thread(acquire, read) && self.acquires(acquire) {
                            edges.push((3 * release, 3 * acquire + 2));
                        }
                    }
                }
            }
            Profile::Wgsl => {}
        }
    }

    /// The orders of a word's writes that are coherent, and in which updates are atomic.
    fn write_orders(
        &self,
        word: usize,
        hb: &Relation,
        written: &[Option<u32>; EVENTS],
    ) -> Vec<Vec<usize>> {
        let n = self.count();
        let rest: Vec<usize> =
            (0..n).filter(|&e| self.word(e) == word && written[e].is_some()).collect();
        let mut orders = Vec::new();
        permute(&mut vec![n + word], &rest, &mut |order| {
            if self.is_allowed(order, word, hb) {
                orders.push(order.to_vec());
            }
        });
        orders
    }

    fn is_allowed(&self, order: &[usize], word: usize, hb: &Relation) -> bool {
        let n = self.count();
        let place = |event: usize| order.iter().position(|&w| w == event);
        let mut eco: Relation = [0; 3 * EVENTS];
        for pair in order.windows(2) {
            eco[pair[0]] |= 1 << pair[1];
        }
        for read in (0..n).filter(|&e| self.reads(e) && self.word(e) == word) {
            let source = place(self.source[read]).expect("it reads from a write");
            // Between the write that an update reads and its own is no other.
            if self.axioms.atomicity && place(read).is_some_and(|own| own != source + 1) {
                return false;
            }
            eco[self.source[read]] |= 1 << read;
            for &later in order[source + 1..].iter().filter(|&&later| later != read) {
                eco[read] |= 1 << later;
            }
        }
        close(&mut eco, n + 2);
        (0..n).all(|b| {
            let asked = if place(b).is_some() {
                self.axioms.writes_are_coherent
            } else {
                self.axioms.reads_are_coherent
            };
            let contradicts =
                |a: usize| hb[3 * a + 1] & 1 << (3 * b + 1) != 0 && eco[b] & 1 << a != 0;
            !asked || !(0..n).any(contradicts)
        })
    }
}

/// Every order of `rest`, behind what is there.
fn permute(order: &mut Vec<usize>, rest: &[usize], each: &mut dyn FnMut(&[usize])) {
    if rest.is_empty() {
        each(order);
    }
    for (i, &next) in rest.iter().enumerate() {
        order.push(next);
        permute(order, &[&rest[..i], &rest[i + 1..]].concat(), each);
        order.pop();
    }
}
