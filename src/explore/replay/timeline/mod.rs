//! A failing schedule as data that can be drawn: a lane per invocation, step by step, the words beside them, and the
//! step at which it goes wrong, with those that led to it.
//!
//! [`timeline`] makes it from a token. Its JSON is the format of `fragloom replay -o`'s pages and of reports:
//! `docs/schemas/timeline.json` is its schema.
//!
//! Values of words are hexadecimal text, lower case, without a prefix and without leading zeros: a word may have 64
//! bits, which a JSON number cannot hold everywhere. Steps have numbers from 1 on, as in `fragloom replay --trace`.
//! Whatever else is referred to (stages, lanes, words, fragments) is referred to by its place in its list, from 0 on.

mod causes;
mod make;

use serde::Serialize;

pub use self::make::{MOST_STEPS, timeline, timeline_of};

/// The version of the format. It is raised when a field is renamed or removed, or comes to mean something else.
pub const VERSION: u32 = 1;

/// A schedule of a litmus pixel, as it ran.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Timeline {
    /// The version of this format: 1.
    pub version: u32,
    /// The token that was replayed.
    pub token: String,
    /// The method's name.
    pub method: String,
    /// The method in words.
    pub title: String,
    /// The property that the token was made from, or `outcome`.
    pub property: String,
    /// The instance in one line: n, k, and the fragments as depth/data.
    pub instance: String,
    /// How many pixels there are.
    pub pixels: u32,
    /// k, for a method that has one.
    pub k: Option<u32>,
    /// The memory model: `sc` or `relaxed`.
    pub memory: String,
    /// What a shading language makes of orders, under relaxed memory: `vulkan`, `glsl` or `wgsl`.
    pub profile: Option<String>,
    /// Lanes of a warp that come together after blocks; null if invocations are independent.
    pub warp: Option<u32>,
    /// How many lanes there are: as many as the largest stage has invocations.
    pub lanes: usize,
    /// The fragments, in submission order.
    pub fragments: Vec<Fragment>,
    /// The stages that have steps, in their order: a barrier is between two of them.
    pub stages: Vec<Stage>,
    /// The words that any step reads or writes, in the order of the method's layout.
    pub words: Vec<Word>,
    /// The steps.
    pub steps: Vec<Step>,
    /// How many steps at the end repeat forever; 0 if every invocation ends.
    pub cycle: usize,
    /// From after this step on, every continuation is wrong; null if it is not known, or if there is no such step.
    pub doomed_after: Option<usize>,
    /// What goes wrong; null if nothing does.
    pub fault: Option<Fault>,
    /// What every pixel holds in the end.
    pub result: Vec<Pixel>,
}

/// A fragment of the litmus pixel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fragment {
    /// A, B, C and so on: the letter of the lane that stores it.
    pub name: String,
    /// The pixel.
    pub pixel: u32,
    /// The depth word, hexadecimal.
    pub depth: String,
    /// The data word, hexadecimal.
    pub data: String,
    /// The number of its triangle, if the method asks for it.
    pub primitive: Option<u32>,
    /// The thickness of its slab in depth words, hexadecimal, if the method has slabs.
    pub thickness: Option<String>,
    /// What its invocation says has become of it: `kept`, `culled`, `evicted`, `overflow`, `pool`, `duplicate`, `age` or
    /// `merged`; null while it has not ended.
    pub fate: Option<String>,
}

/// What runs between two barriers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Stage {
    /// The name of its first pass, `clear` or `resolve`.
    pub name: String,
    /// Rounds before this one, of a method that repeats its passes.
    pub round: usize,
    /// The number of its first step.
    pub first: usize,
    /// What every lane runs.
    pub lanes: Vec<Lane>,
}

/// An invocation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Lane {
    /// As `--trace` heads its column: letter, depth and data, or what it does.
    pub name: String,
    /// What it does.
    pub task: Task,
    /// The pixel, if it has one.
    pub pixel: Option<u32>,
    /// The fragment, if it has one.
    pub fragment: Option<usize>,
    /// It is a helper: its writes have no effect.
    pub helper: bool,
}

/// What an invocation does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Nothing, in this stage.
    Idle,
    /// Clear the frame's words, or a pixel's.
    Clear,
    /// An earlier geometry pass's part for a fragment.
    Prepare,
    /// A full-screen pass's part for a pixel.
    Screen,
    /// A pass over the frame's words.
    Frame,
    /// Store a fragment.
    Store,
    /// Resolve a pixel.
    Resolve,
}

/// A word of memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Word {
    /// The method's name for it, as `depth[1]`; with the pixel, if there are several. Its address if it has no name.
    pub name: String,
    /// The address as in `--trace`: `p0[2]` is the third word of pixel 0, `frame[5]L` the sixth 64-bit word of the frame.
    pub address: String,
    /// The pixel that it belongs to; null for a word of the frame.
    pub pixel: Option<u32>,
    /// 32 or 64.
    pub bits: u32,
    /// It is a lock: free at 0.
    pub lock: bool,
    /// The value before the first step, hexadecimal; null if it was never written: then a read finds any value.
    pub initial: Option<String>,
}

/// One operation of one invocation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Step {
    /// Its number, from 1 on.
    pub number: usize,
    /// The stage.
    pub stage: usize,
    /// The lane.
    pub lane: usize,
    /// What it does.
    pub operation: Operation,
    /// How it is ordered; null for what is no access.
    pub order: Option<Ordering>,
    /// A shading language has a memory barrier before it, after it, or both (`glsl` only).
    pub fences: Option<Fences>,
    /// The word; null for what is no access, and for one outside of all words that is dropped.
    pub word: Option<usize>,
    /// The access is outside of the method's words: dropped, or clamped to the last one.
    pub outside: bool,
    /// What it writes, adds, or compares with, hexadecimal: of a compare-exchange, the new value.
    pub operand: Option<String>,
    /// What a compare-exchange expects, hexadecimal.
    pub expected: Option<String>,
    /// Whether a compare-exchange found what it expects.
    pub succeeded: Option<bool>,
    /// The value that it read, hexadecimal.
    pub read: Option<String>,
    /// Where that value comes from.
    pub read_from: Option<Source>,
    /// The newest value of the word before it, hexadecimal; null if it was never written.
    pub before: Option<String>,
    /// The value that it wrote, hexadecimal; null if it wrote none.
    pub written: Option<String>,
    /// What it does to a lock.
    pub lock: Option<Locking>,
    /// The invocation goes back, to try again.
    pub spins: bool,
    /// The line of the source that it comes from: file:line:column.
    pub site: Option<String>,
    /// The step as `--trace` shows it.
    pub text: String,
    /// The same in few letters, with the word: `load depth[0] = 0`, `exchange.acquire lock 0 -> 1`.
    pub short: String,
    /// How the invocation ends with it: `kept`, `culled`, `done`, what a pixel holds; null if it does not.
    pub ends: Option<String>,
    /// Words that are not as they were before it. All others are.
    pub changes: Vec<Change>,
    /// What is wrong with it, or with memory after it.
    pub wrong: Vec<Wrong>,
}

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the names say it")]
pub enum Operation {
    Load,
    Store,
    Exchange,
    CompareExchange,
    Add,
    And,
    Or,
    Min,
    Max,
    /// It leaves a block with the other lanes of its warp.
    Merge,
    /// The method's code panics.
    Panic,
}

/// How an access is ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the names say it")]
pub enum Ordering {
    Plain,
    Relaxed,
    Acquire,
    Release,
    AcqRel,
}

/// Memory barriers around an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Fences {
    pub before: bool,
    pub after: bool,
}

/// What a step does to a lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Locking {
    /// It takes it.
    Locks,
    /// It tries, and finds it taken.
    FindsLocked,
    /// It frees it.
    Unlocks,
}

/// Where a value that was read comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Source {
    /// The step that wrote it; null if none did: it was there before.
    pub step: Option<usize>,
    /// The steps that had written the word after that. If there are any, the value is stale: under relaxed memory, an
    /// invocation need not see them yet.
    pub newer: Vec<usize>,
}

/// A word after a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Change {
    /// The word.
    pub word: usize,
    /// Its newest value, hexadecimal; null if it was never written.
    pub value: Option<String>,
    /// Under relaxed memory, all values that some invocation may still read, the newest last; else empty.
    pub versions: Vec<Version>,
    /// Under relaxed memory, for every lane the oldest of these that it may still read, by its place among them; null for
    /// a lane that has ended. Else empty.
    pub oldest: Vec<Option<usize>>,
}

/// One of a word's values.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Version {
    /// The value, hexadecimal; null if it was never written.
    pub value: Option<String>,
    /// The step that wrote it; null if none did.
    pub by: Option<usize>,
}

/// A property that fails.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Wrong {
    /// The property's name.
    pub property: String,
    /// What is wrong, in words.
    pub message: String,
}

/// What goes wrong.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// The property that fails: the token's, if it is among those.
    pub property: String,
    /// What is wrong, in words.
    pub message: String,
    /// The step to mark; null if only the end shows it, and no step is known after which every continuation is wrong.
    pub step: Option<usize>,
    /// What the marked step is.
    pub shown: Shown,
    /// What led to it, as far as that is known; the likeliest first.
    pub causes: Vec<Cause>,
}

/// What the marked step of a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shown {
    /// The property fails at the step itself.
    AtStep,
    /// After the step, every continuation is wrong.
    DoomedAfter,
    /// The first of those that repeat forever.
    Cycle,
    /// No step: the end is wrong.
    AtEnd,
}

/// Steps that led to a fault.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Cause {
    /// How they did.
    pub kind: CauseKind,
    /// The steps, in their order.
    pub steps: Vec<usize>,
    /// The same in words.
    pub message: String,
}

/// How steps led to a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CauseKind {
    /// An invocation reads a word, another writes it, and the first writes it without having read it again.
    LostUpdate,
    /// An invocation reads a word before another writes it.
    ReadTooEarly,
    /// Memory gives an invocation a value that was overwritten.
    StaleRead,
    /// Two accesses that nothing orders.
    Race,
    /// Two invocations hold one lock.
    TwoHolders,
    /// A step that is wrong by itself.
    Step,
}

/// What a pixel holds in the end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Pixel {
    /// The pixel.
    pub pixel: u32,
    /// What it must hold; null if several results are right, or the method does not say.
    pub expected: Option<String>,
    /// What it may hold, one for each order of arrival; empty if `expected` says it, or the method does not say.
    pub possible: Vec<String>,
    /// What it holds; null if the run has not come to its end.
    pub found: Option<String>,
}
