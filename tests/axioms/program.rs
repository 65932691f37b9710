//! Litmus programs of two threads, as data: all over an alphabet of operations, up to symmetry.

use fragloom::memory::Order::{self, AcqRel, Acquire, Relaxed, Release};

/// The most operations of a thread.
pub(crate) const MOST: usize = 3;

/// What an operation does to its word. `Keep` is an update that leaves any value as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Load,
    Store,
    Exchange,
    Keep,
    /// The larger of the value that is there and the operation's own.
    Max,
    /// Compare-exchange, where the initial value 0 is expected.
    IfZero,
    /// Compare-exchange, where the value of the other thread's first operation is expected.
    IfOther,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Op {
    pub(crate) kind: Kind,
    /// 0 or 1.
    pub(crate) word: u8,
    pub(crate) order: Order,
}

/// The operations of both threads.
pub(crate) type Program = [Vec<Op>; 2];

/// The value of an operation that writes: no other has it.
pub(crate) fn value(thread: usize, place: usize) -> u32 {
    (1 + thread * MOST + place) as u32
}

/// Orders that make a difference to a kind.
fn orders(kind: Kind) -> &'static [Order] {
    match kind {
        Kind::Load => &[Relaxed, Acquire],
        Kind::Store => &[Relaxed, Release],
        _ => &[Relaxed, Acquire, Release, AcqRel],
    }
}

/// Kinds in all orders that make a difference.
pub(crate) fn in_all_orders(kinds: &[Kind]) -> Vec<(Kind, Order)> {
    kinds.iter().flat_map(|&kind| orders(kind).iter().map(move |&order| (kind, order))).collect()
}

fn renamed(thread: &[Op]) -> Vec<Op> {
    thread.iter().map(|&op| Op { word: 1 - op.word, ..op }).collect()
}

fn words(thread: &[Op]) -> u8 {
    thread.iter().fold(0, |bits, op| bits | 1 << op.word)
}

/// All sequences of 1 to `most` operations on two words.
fn threads(alphabet: &[(Kind, Order)], most: usize) -> Vec<Vec<Op>> {
    let of_word = |word| alphabet.iter().map(move |&(kind, order)| Op { kind, word, order });
    let ops: Vec<Op> = of_word(0).chain(of_word(1)).collect();
    let mut longest = vec![Vec::new()];
    let mut all = Vec::new();
    for _ in 0..most {
        let longer = |ops_before: &Vec<Op>| {
            ops.iter().map(|&op| [ops_before.as_slice(), &[op]].concat()).collect::<Vec<_>>()
        };
        longest = longest.iter().flat_map(longer).collect();
        all.extend_from_slice(&longest);
    }
    all
}

/// All programs of two threads with 1 to `most` operations on two words, one of each class of those that are the same
/// but for the names of threads and words. Where no word is shared, nothing can be told of memory.
pub(crate) fn programs(alphabet: &[(Kind, Order)], most: usize) -> impl Iterator<Item = Program> {
    // With its words renamed.
    let threads: Vec<[Vec<Op>; 2]> =
        threads(alphabet, most).into_iter().map(|ops| [renamed(&ops), ops]).collect();
    let count = threads.len();
    (0..count * count).filter_map(move |pair| {
        let [[other_a, a], [other_b, b]] = [&threads[pair / count], &threads[pair % count]];
        let is_first =
            (a, b) <= (b, a) && (a, b) <= (other_a, other_b) && (a, b) <= (other_b, other_a);
        (is_first && words(a) & words(b) != 0).then(|| [a.clone(), b.clone()])
    })
}

/// A program in one line.
pub(crate) fn describe(program: &Program) -> String {
    let of_thread = |(thread, ops): (usize, &Vec<Op>)| {
        let text = |(place, op): (usize, &Op)| {
            let word = ["x", "y"][usize::from(op.word)];
            let (own, other) = (value(thread, place), value(1 - thread, 0));
            let what = match op.kind {
                Kind::Load => format!("load {word}"),
                Kind::Store => format!("{word} := {own}"),
                Kind::Exchange => format!("exchange {word} {own}"),
                Kind::Keep => format!("or {word} 0"),
                Kind::Max => format!("max {word} {own}"),
                Kind::IfZero => format!("compare-exchange {word} 0 -> {own}"),
                Kind::IfOther => format!("compare-exchange {word} {other} -> {own}"),
            };
            format!("{what} {:?}", op.order)
        };
        ops.iter().enumerate().map(text).collect::<Vec<_>>().join("; ")
    };
    program.iter().enumerate().map(of_thread).collect::<Vec<_>>().join("  ||  ")
}
