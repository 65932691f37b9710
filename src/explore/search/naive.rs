//! A naive explorer, right by reading, to compare the real one with: sequential consistency, one execution after another
//! from its beginning, no states, no symmetry, no marks. An invocation that waits goes on when another has written. An
//! access outside of a buffer is dropped, or hits the buffer's last word.

use std::collections::BTreeSet;
use std::task::{Context, Poll, Waker};

use super::waiting::Waiting;
use crate::explore::memory::model::cut;
use crate::explore::program::case::Case;
use crate::explore::program::machine::Final;
use crate::memory::Numbering;
use crate::memory::asked::{Action, Asked, Request};
use crate::scheme::Held;
use crate::scheme::course::{At, Course, Part};
use crate::scheme::task::{Ended, Task};

/// Every result, and how many executions there are; `None` above `most`.
fn outcomes(case: &Case, most: u64) -> Option<(BTreeSet<Vec<Held>>, u64)> {
    let (mut outcomes, mut executions) = (BTreeSet::new(), 0);
    // What was chosen, of how many, from the beginning of the present execution.
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    loop {
        let mut at = 0;
        let mut choose = |of: usize| {
            if at == chosen.len() {
                chosen.push((0, of));
            }
            at += 1;
            chosen[at - 1].0
        };
        outcomes.extend(execute(case, &mut choose));
        executions += 1;
        while chosen.last().is_some_and(|&(taken, of)| taken + 1 == of) {
            chosen.pop();
        }
        match chosen.last_mut() {
            None => return Some((outcomes, executions)),
            Some(_) if executions == most => return None,
            Some((taken, _)) => *taken += 1,
        }
    }
}

/// One execution; `None` if invocations wait for ever.
fn execute(case: &Case, choose: &mut dyn FnMut(usize) -> usize) -> Option<Vec<Held>> {
    let course = Course::of(&case.contract.program);
    let stages = case.litmus.stages(case.contract, &course, |pass| case.instance.invocations(pass));
    let nothing = vec![case.method.holds().empty(); case.litmus.pixels as usize];
    let mut end = Final { pixels: nothing, outcomes: Vec::new() };
    let mut words = vec![None; case.numbering.count() as usize];
    let mut at = At::default();
    loop {
        let mut again = false;
        let one_by_one = matches!(course.parts(at), [Part::Clear | Part::Resolve]);
        let tasks = &stages[at.stage].tasks;
        for together in tasks.chunks(if one_by_one { 1 } else { tasks.len().max(1) }) {
            for ended in run(case, together, &mut words, choose)? {
                again |= end.add(&ended);
            }
        }
        let Some(next) = course.after(at, again) else { break };
        at = next;
    }
    end.pixels.iter_mut().for_each(Held::sort);
    Some(end.pixels)
}

/// Invocations at the same time, in the chosen order.
fn run(
    case: &Case,
    tasks: &[Task],
    words: &mut [Option<u64>],
    choose: &mut dyn FnMut(usize) -> usize,
) -> Option<Vec<Ended>> {
    let memories: Vec<Asked<'_>> = tasks.iter().map(|_| Asked::new(&case.inputs, false)).collect();
    let pairs = memories.iter().zip(tasks);
    let mut invocations: Vec<_> = pairs.map(|(mem, &task)| case.instance.ask(mem, task)).collect();
    let mut ended = vec![None; tasks.len()];
    let mut waiting = Waiting::new(tasks.len());
    let mut go_on = |i: usize, ended: &mut Vec<Option<Ended>>| {
        let mut context = Context::from_waker(Waker::noop());
        if let Poll::Ready(end) = invocations[i].as_mut().poll(&mut context) {
            ended[i] = Some(end);
        }
    };
    (0..tasks.len()).for_each(|i| go_on(i, &mut ended));
    while ended.iter().any(Option::is_none) {
        let ready = (0..tasks.len()).filter(|&i| ended[i].is_none() && !waiting.waits(i));
        let ready: Vec<usize> = ready.collect();
        if ready.is_empty() {
            return None;
        }
        let i = ready[choose(ready.len())];
        let answer = match memories[i].request() {
            Some(Request::Operation { at, action, .. }) => {
                let mut number = case.numbering.number(at);
                if Numbering::is_outside(number) {
                    let end = case.numbering.end(number);
                    let Some(end) = end.filter(|_| choose(2) == 1) else {
                        memories[i].answer(0);
                        go_on(i, &mut ended);
                        continue;
                    };
                    number = end;
                }
                let word = &mut words[number as usize];
                let reads = !matches!(action, Action::Write(..));
                let old = match *word {
                    Some(value) => value,
                    None if reads => case.litmus.candidates()[choose(3)],
                    None => 0,
                };
                let old = cut(old, at.bits);
                let new = match action {
                    Action::Read(_) => old,
                    Action::Write(value, _) => value,
                    Action::Update(update, _) => update.apply(old),
                };
                if word.replace(cut(new, at.bits)) != Some(cut(new, at.bits)) {
                    waiting.change(i);
                }
                if reads { old } else { 0 }
            }
            Some(Request::Spin(..)) => {
                waiting.spin(i);
                memories[i].answer(0);
                go_on(i, &mut ended);
                continue;
            }
            _ => unreachable!("it waits for an operation, or for others"),
        };
        memories[i].answer(answer);
        go_on(i, &mut ended);
    }
    ended.into_iter().collect()
}

mod tests {
    use super::*;
    use crate::catalogue::Catalogue;
    use crate::explore::memory::model::MemoryModel;
    use crate::explore::program::instances::{Family, of_size};
    use crate::explore::program::machine::Conditions;
    use crate::explore::program::subject::Subject;
    use crate::explore::search::exhaustive::explore;
    use crate::explore::search::explored::Limits;
    use crate::explore::search::property::Property;

    /// Compare the first instances of a method with `n` fragments, but for those with too many executions; how many
    /// were, and their executions.
    fn compare(name: &str, n: u32, ks: &[u32], first: usize, most: u64) -> (usize, u64) {
        let method = Catalogue::built_in().find("METHOD", name).expect("a method");
        let subject = Subject::new(method).expect("a scheme");
        let limits = Limits { states: 1_000_000, cancelled: &|| false };
        let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
        let family = Family { fragments: n, ks: ks.to_vec(), helpers: 0 };
        let (mut compared, mut executions) = (0, 0);
        // Of a hash table, some of many.
        let instances = of_size(&subject, &family, n);
        let step = instances.len().div_ceil(40);
        for litmus in instances.into_iter().step_by(step).take(first) {
            let case = subject.case(&litmus);
            let explored = explore(&case, conditions, &limits);
            assert!(explored.complete, "{name}: {}", litmus.describe());
            let Some((found, count)) = outcomes(&case, most) else { continue };
            let known: BTreeSet<Vec<Held>> = explored.outcomes.into_keys().collect();
            assert_eq!(known, found, "{name}: {}", litmus.describe());
            compared += 1;
            executions += count;
        }
        (compared, executions)
    }

    /// Every instance with up to 10,000 executions. Some methods have more on all of theirs (two passes and a lock, or a
    /// pass over many words): with `FRAGLOOM_EXECUTIONS=10000000`, their first instance is compared, too. That takes
    /// minutes.
    #[test]
    fn outcomes_of_two_fragments_are_those_of_a_naive_search() {
        let most = std::env::var("FRAGLOOM_EXECUTIONS").ok().and_then(|n| n.parse().ok());
        let (mut all, mut left_out) = (0, Vec::new());
        for method in Catalogue::built_in().promised() {
            let name = method.name();
            let (mut compared, mut executions) = compare(name, 2, &[1, 2], usize::MAX, 10_000);
            if let (0, Some(most)) = (compared, most) {
                (compared, executions) = compare(name, 2, &[1], 1, most);
            }
            println!("{name}: {compared} instances, {executions} executions");
            if compared == 0 {
                left_out.push(name);
            }
            all += executions;
        }
        println!("{all} executions");
        assert!(all > 100_000, "{all}");
        let large = [
            "kplus-sb",
            "kplus-sb@heap",
            "kplus-sb@published",
            "k-variable",
            "depth-peel-bucket",
            "kplus-multi",
            "skb+ofm",
            "skb+ofm@published",
            "skb+ofm@released",
            "wboit@published-f32",
            "mbt",
            "mbt@published-f32",
            "adaptive",
            "adaptive@over",
            "adaptive@keeps-last",
            "stochastic@depth",
            "blend-unsorted",
            "kb-ll@rmw",
            "kplus-array@rmw",
            "kplus-heap@rmw",
            "kplus-sb@atomic",
            "kplus-sb@rmw",
        ];
        assert_eq!(left_out, if most.is_some() { vec![] } else { large.to_vec() });
    }

    #[test]
    fn outcomes_of_three_fragments_are_those_of_a_naive_search() {
        let mut all = 0;
        for name in ["z-buffer", "ab-ll", "ab-array", "kb-mdt64", "kb"] {
            let (compared, executions) = compare(name, 3, &[1], usize::MAX, 800_000);
            println!("{name}: {compared} instances, {executions} executions");
            assert!(compared > 0, "{name}");
            all += executions;
        }
        assert!(all > 500_000, "{all}");
    }

    /// Accesses outside of buffers, dropped or clamped.
    #[test]
    fn outcomes_of_accesses_outside_are_those_of_a_naive_search() {
        let limits = Limits { states: 1_000_000, cancelled: &|| false };
        let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
        let family = Family { fragments: 2, ks: vec![1], helpers: 0 };
        for name in ["ab-array@M14", "ab-ll@M14"] {
            let method = Catalogue::built_in().find("METHOD", name).expect("a fault");
            let subject = Subject::new(method).expect("a scheme");
            let mut compared = 0;
            for litmus in of_size(&subject, &family, 2) {
                let case = subject.case(&litmus);
                let explored = explore(&case, conditions, &limits);
                // What is clamped may close a ring, and a naive search would follow it for ever.
                if !explored.complete || !explored.violations.contains_key(&Property::Bounds) {
                    continue;
                }
                let Some((found, _)) = outcomes(&case, 20_000) else { continue };
                let known: BTreeSet<Vec<Held>> = explored.outcomes.into_keys().collect();
                assert_eq!(known, found, "{name}: {}", litmus.describe());
                compared += 1;
            }
            println!("{name}: {compared} instances");
            assert!(compared > 0, "{name}");
        }
    }

    /// The comparison sees what a search would lose that takes a racy method for one without a race.
    #[test]
    fn a_naive_search_finds_every_way_to_lose_a_fragment() {
        let method = Catalogue::built_in().find("METHOD", "z-buffer@load-store").expect("a fault");
        let subject = Subject::new(method).expect("a scheme");
        let family = Family { fragments: 2, ks: vec![], helpers: 0 };
        let litmus = of_size(&subject, &family, 2).remove(0);
        let (found, executions) = outcomes(&subject.case(&litmus), 1_000).expect("few");
        assert_eq!((found.len(), executions), (2, 6));
    }
}
