//! Which steps led to a fault, as far as the run itself tells: reads that were overtaken, accesses that nothing orders,
//! locks with two holders.

use super::super::run::Run;
use super::make::wrong;
use super::{Cause, CauseKind, Fault, Locking, Shown, Step, Timeline, Wrong};
use crate::explore::search::property::Property;

/// The most causes that are named.
const MOST: usize = 3;

/// What goes wrong in a timeline whose steps are there; `None` if nothing does.
pub(super) fn fault(timeline: &Timeline, run: &Run) -> Option<Fault> {
    let at_steps =
        timeline.steps.iter().flat_map(|step| step.wrong.iter().map(move |w| (Some(step), w)));
    let at_end: Vec<Wrong> =
        run.wrong.iter().map(|(property, told)| wrong(*property, told)).collect();
    let all: Vec<(Option<&Step>, &Wrong)> =
        at_steps.chain(at_end.iter().map(|wrong| (None, wrong))).collect();
    let own = all.iter().find(|(_, wrong)| wrong.property == timeline.property);
    if let (None, 1..) = (own, timeline.cycle) {
        return Some(endless(timeline));
    }
    let (step, found) = own.or(all.first())?;
    let doomed = timeline.doomed_after.filter(|_| step.is_none());
    let (marked, shown) = match (step, doomed) {
        (Some(step), _) => (Some(step.number), Shown::AtStep),
        (None, Some(step)) => (Some(step), Shown::DoomedAfter),
        (None, None) => (None, Shown::AtEnd),
    };
    let mut causes = match step {
        Some(step) => at(timeline, run, step, &found.property),
        None => of_result(timeline, doomed),
    };
    causes.truncate(MOST);
    let (property, message) = (found.property.clone(), found.message.clone());
    Some(Fault { property, message, step: marked, shown, causes })
}

/// A run whose last steps repeat forever.
fn endless(timeline: &Timeline) -> Fault {
    let steps = timeline.steps.len();
    let first = steps + 1 - timeline.cycle.min(steps);
    Fault {
        property: Property::Termination.name().to_owned(),
        message: format!("steps {first} to {steps} repeat forever"),
        step: Some(first),
        shown: Shown::Cycle,
        causes: Vec::new(),
    }
}

/// What led to a fault that a step itself shows.
fn at(timeline: &Timeline, run: &Run, step: &Step, property: &str) -> Vec<Cause> {
    let own = step.number;
    if property == Property::RaceFree.name() {
        let earlier = run.events[own - 1].races_with.map(|earlier| earlier + 1);
        let message = earlier.map_or_else(
            || format!("step {own} is not ordered with an earlier access"),
            |earlier| {
                let [a, b] = [earlier, own].map(|number| who(timeline, number));
                format!("nothing orders {a} and {b}")
            },
        );
        return vec![Cause {
            kind: CauseKind::Race,
            steps: earlier.into_iter().chain([own]).collect(),
            message,
        }];
    }
    if property == Property::MutualExclusion.name() {
        let holds = |s: &&Step| s.number <= own && s.word == step.word && s.lock.is_some();
        let mut steps: Vec<usize> = timeline.steps.iter().filter(holds).map(|s| s.number).collect();
        let takes = |number: &usize| {
            timeline.steps[number - 1].lock != Some(Locking::FindsLocked) || *number == own
        };
        steps.retain(takes);
        let steps = steps.split_off(steps.len().saturating_sub(2));
        let told: Vec<String> = steps.iter().map(|&number| who(timeline, number)).collect();
        let message = told.join(", then ");
        return vec![Cause { kind: CauseKind::TwoHolders, steps, message }];
    }
    if property == Property::Invariant.name() {
        let found = of_result(timeline, Some(own));
        if !found.is_empty() {
            return found;
        }
    }
    vec![Cause { kind: CauseKind::Step, steps: vec![own], message: who(timeline, own) }]
}

/// What led to a wrong result. `marked` is the step after which it cannot become right: causes that it is part of come
/// first, and are the only ones if there are any.
fn of_result(timeline: &Timeline, marked: Option<usize>) -> Vec<Cause> {
    let mut all = lost_updates(timeline);
    let marked_step = marked.map(|marked| &timeline.steps[marked - 1]);
    all.extend(marked_step.and_then(|step| too_early(timeline, step)));
    all.extend(stale(timeline));
    let holds = |cause: &Cause| marked.is_some_and(|marked| cause.steps.contains(&marked));
    if all.iter().any(holds) {
        all.retain(holds);
    } else if let Some(marked) = marked {
        // Those that end soonest after it, or at least before it.
        let last = |cause: &Cause| cause.steps.last().copied().unwrap_or_default();
        all.sort_by_key(|cause| (last(cause) < marked, last(cause).abs_diff(marked)));
    }
    all
}

/// Reads of a word that another invocation writes before the reader does, who has not read it again.
fn lost_updates(timeline: &Timeline) -> Vec<Cause> {
    let steps = &timeline.steps;
    let mut all = Vec::new();
    for write in steps.iter().filter(|s| s.written.is_some() && s.read.is_none()) {
        let same = |s: &&Step| s.word == write.word && s.stage == write.stage;
        let before = || steps[..write.number - 1].iter().filter(same);
        let own = |s: &&Step| s.lane == write.lane;
        let Some(read) = before().rev().filter(own).find(|s| s.read.is_some()) else { continue };
        // What it wrote itself since then, it knows.
        if before().filter(own).any(|s| s.number > read.number) {
            continue;
        }
        let missed = read.read_from.iter().flat_map(|source| &source.newer).copied();
        let between = before().filter(|s| s.number > read.number && s.lane != write.lane);
        let written = between.filter(|s| s.written.is_some()).map(|s| s.number);
        let mut others: Vec<usize> = missed.chain(written).collect();
        others.sort_unstable();
        let Some(&last) = others.last() else { continue };
        let mut involved = vec![read.number, last, write.number];
        involved.extend(others[..others.len() - 1].iter().copied());
        involved.sort_unstable();
        let message = format!(
            "{}; {}; then {}, without having read it again",
            who(timeline, read.number),
            who(timeline, last),
            who(timeline, write.number),
        );
        all.push(Cause { kind: CauseKind::LostUpdate, steps: involved, message });
    }
    all
}

/// A read of a word that another invocation writes only afterwards.
fn too_early(timeline: &Timeline, read: &Step) -> Option<Cause> {
    read.read.as_ref().filter(|_| read.written.is_none())?;
    let later = timeline.steps[read.number..].iter();
    let write = later.take_while(|s| s.stage == read.stage).find(|s| {
        s.word == read.word && s.word.is_some() && s.lane != read.lane && s.written.is_some()
    })?;
    let message = format!("{}, before {}", who(timeline, read.number), who(timeline, write.number));
    let steps = vec![read.number, write.number];
    Some(Cause { kind: CauseKind::ReadTooEarly, steps, message })
}

/// Reads of values that were overwritten.
fn stale(timeline: &Timeline) -> Vec<Cause> {
    let reads = timeline.steps.iter().filter_map(|step| Some((step, step.read_from.as_ref()?)));
    let stale = reads.filter_map(|(step, source)| Some((step, *source.newer.last()?)));
    let cause = |(step, newer): (&Step, usize)| {
        let message = format!("{}, although {}", who(timeline, step.number), who(timeline, newer),);
        let mut steps = vec![newer, step.number];
        steps.sort_unstable();
        Cause { kind: CauseKind::StaleRead, steps, message }
    };
    stale.map(cause).collect()
}

/// A step in a clause: who does what, and when.
fn who(timeline: &Timeline, number: usize) -> String {
    let step = &timeline.steps[number - 1];
    let lane = &timeline.stages[step.stage].lanes[step.lane];
    let word = step.word.map_or_else(
        || if step.outside { " outside of all words".to_owned() } else { String::new() },
        |word| format!(" of {}", timeline.words[word].name),
    );
    let what = match (&step.read, &step.written) {
        (Some(read), None) => format!("reads {read}{word}"),
        (None, Some(written)) => format!("writes {written}{}", word.replacen(" of", " to", 1)),
        (Some(read), Some(written)) => {
            format!("makes {written} of {read}{}", word.replacen(" of", " in", 1))
        }
        (None, None) => format!("does '{}'{word}", step.text),
    };
    format!("{} {what} (step {number})", lane.name)
}
