//! One run of an instance with its invocations as they are: no trees, no states to compare, so that its size hardly
//! matters. Words are sequentially consistent, and all passes run as they do on a device, clear and resolve among them.

use std::ptr;

use super::property::{self, Property};
use super::waiting::Waiting;
use crate::explore::memory::model::cut;
use crate::explore::program::case::{Case, PATIENCE};
use crate::explore::program::forest::Fault;
use crate::explore::program::guard::guarded;
use crate::explore::program::machine::Final;
use crate::explore::program::schedule::Move;
use crate::memory::asked::{Action, Asked, Request, Site};
use crate::memory::{Address, Numbering, Snapshot};
use crate::num::random::Random;
use crate::scheme::Moment;
use crate::scheme::course::{At, Course, Part};
use crate::scheme::held::Held;
use crate::scheme::task::{Ended, Invocation, Task};
use std::task::{Context, Poll, Waker};

/// Steps of a run, at most: it may never end.
const MOST_STEPS: u64 = 1_000_000;

/// Streams of the random numbers.
const STREAM: u64 = 0x11FE;

/// A run.
pub(in crate::explore) struct Live {
    /// The operations, each with its stage in the method's course.
    pub(in crate::explore) moves: Vec<(At, Move)>,
    /// What went wrong, in order.
    pub(in crate::explore) wrong: Vec<(Property, String)>,
    /// Where operations were made, and what.
    pub(in crate::explore) sites: Vec<(Site, Action)>,
    /// It came to its end.
    pub(in crate::explore) has_ended: bool,
}

/// Run an instance, with random interleaving; a seed is a run. How often it switches between invocations is random too:
/// at every operation, or only a few times.
pub(in crate::explore) fn run(case: &Case, seed: u64) -> Live {
    let mut random = Random::new(seed, STREAM);
    let bursts = [1, 4, 16, 64, 1 << 20][random.below(5) as usize];
    let words = vec![None; case.numbering.count() as usize];
    let candidates = case.litmus.candidates();
    let live = Live { moves: Vec::new(), wrong: Vec::new(), sites: Vec::new(), has_ended: false };
    let mut runner = Runner { case, random, bursts, words, candidates, steps: 0, live };
    runner.run();
    runner.live
}

struct Runner<'a> {
    case: &'a Case,
    random: Random,
    /// Operations of one invocation without a switch, on average.
    bursts: u64,
    /// By number; `None` where nobody has written.
    words: Vec<Option<u64>>,
    candidates: [u64; 3],
    steps: u64,
    live: Live,
}

impl Runner<'_> {
    fn run(&mut self) {
        let Case { contract, instance, litmus, method, .. } = self.case;
        let course = Course::of(&contract.program);
        let stages = litmus.stages(contract, &course, |pass| instance.invocations(pass));
        let nothing = vec![method.holds().empty(); litmus.pixels as usize];
        let mut end = Final { pixels: nothing, outcomes: Vec::new() };
        let mut at = At::default();
        loop {
            let resolves = course.parts(at) == [Part::Resolve];
            if resolves {
                self.invariant();
            }
            // Outcomes are those of the last round.
            if course.parts(at).contains(&Part::Pass(0)) {
                end.outcomes.clear();
            }
            let Some(ended) = self.stage(at, &stages[at.stage].tasks) else { return };
            let mut again = false;
            ended.iter().for_each(|ended| again |= end.add(ended));
            let Some(next) = course.after(at, again) else { break };
            at = next;
        }
        end.pixels.iter_mut().for_each(Held::sort);
        match guarded(|| property::judge(self.case, &end)) {
            Ok(wrong) => self.live.wrong.extend(wrong),
            Err(told) => self.live.wrong.push((Property::Panics, told)),
        }
        self.live.has_ended = true;
    }

    /// What the method says of itself when all is quiet.
    fn invariant(&mut self) {
        let words = &self.words;
        let value = |address: Address| {
            words.get(self.case.numbering.number(address) as usize).copied().flatten()
        };
        let words = Snapshot { value: &value };
        let holds = |p| self.case.instance.invariant(&words, p, Moment::Quiet);
        let found = guarded(|| (0..self.case.litmus.pixels).try_for_each(holds));
        if let Err(told) = found.unwrap_or_else(Err) {
            self.live.wrong.push((Property::Invariant, told));
        }
    }

    /// Run the invocations of a stage; how they ended, or `None` if one has not.
    fn stage(&mut self, at: At, tasks: &[Task]) -> Option<Vec<Ended>> {
        let asked = |_: &Task| Asked::new(&self.case.inputs, false).with_patience(PATIENCE);
        let memories: Vec<Asked<'_>> = tasks.iter().map(asked).collect();
        let all = memories.iter().zip(tasks);
        let mut invocations: Vec<Invocation<'_>> =
            all.map(|(mem, &task)| self.case.instance.ask(mem, task)).collect();
        let mut ended: Vec<Option<Ended>> = vec![None; tasks.len()];
        let mut left: Vec<usize> = (0..tasks.len()).collect();
        let mut context = Context::from_waker(Waker::noop());
        let mut waiting = Waiting::new(tasks.len());
        let mut place = 0;
        let mut switches = true;
        while !left.is_empty() {
            self.steps += 1;
            if self.steps > MOST_STEPS {
                return None;
            }
            if switches || self.random.below(self.bursts) == 0 {
                place = self.random.below(left.len() as u64) as usize;
                // If all wait, none will ever go on.
                let after = (place..left.len()).chain(0..place);
                place = after.into_iter().find(|&p| !waiting.waits(left[p]))?;
            }
            switches = false;
            let invocation = left[place];
            let mem = &memories[invocation];
            // What it waits for is answered, if it waits; then it goes on to its next question.
            match mem.request() {
                Some(Request::Operation { at: word, action, site }) => {
                    let (answer, changes) = self.operation(at, invocation, word, action, site);
                    if changes {
                        waiting.change(invocation);
                    }
                    mem.answer(answer);
                }
                Some(Request::Spin(..)) => {
                    mem.answer(0);
                    waiting.spin(invocation);
                    switches = true;
                }
                Some(Request::Merge(_)) => mem.answer(0),
                None => {}
            }
            let polled = guarded(|| invocations[invocation].as_mut().poll(&mut context));
            match polled {
                Ok(Poll::Pending) => {}
                Ok(Poll::Ready(end)) => {
                    ended[invocation] = Some(end);
                    left.swap_remove(place);
                    switches = true;
                }
                Err(_) if mem.endless().is_some() => return None,
                Err(told) => {
                    self.note(at, invocation, 0);
                    self.live.wrong.push((Property::Panics, told));
                    return None;
                }
            }
        }
        ended.into_iter().collect()
    }

    fn note(&mut self, at: At, invocation: usize, alternative: u16) {
        self.live.moves.push((at, Move { invocation: invocation as u8, alternative }));
    }

    /// Perform an operation; the value read, or 0, and whether the word has changed.
    fn operation(
        &mut self,
        at: At,
        invocation: usize,
        word: Address,
        action: Action,
        site: Site,
    ) -> (u64, bool) {
        if !self.live.sites.iter().any(|(known, _)| ptr::eq(*known, site)) {
            self.live.sites.push((site, action));
        }
        let mut number = self.case.numbering.number(word);
        let mut alternative = 0;
        if Numbering::is_outside(number) {
            self.live.wrong.push((Property::Bounds, Fault::Outside.message().to_owned()));
            // Dropped, or clamped to the buffer's end: alternatives as a machine has them.
            let end = self.case.numbering.end(number);
            let Some(end) = end.filter(|_| self.random.below(2) == 1) else {
                self.note(at, invocation, 0);
                return (0, false);
            };
            (number, alternative) = (end, 1);
        }
        let mut candidate = 0;
        if self.words[number as usize].is_none() && !matches!(action, Action::Write(..)) {
            candidate = self.random.below(self.candidates.len() as u64) as usize;
            alternative += candidate as u16;
        }
        self.note(at, invocation, alternative);
        let old = self.words[number as usize].unwrap_or(self.candidates[candidate]);
        let old = cut(old, word.bits);
        let (answer, new) = match action {
            Action::Read(_) => (old, old),
            Action::Write(value, _) => (0, value),
            Action::Update(update, _) => (old, update.apply(old)),
        };
        let before = self.words[number as usize].replace(cut(new, word.bits));
        (answer, before != self.words[number as usize])
    }
}
