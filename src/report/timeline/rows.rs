//! The rows of a timeline: its steps, with what is said between them.

use crate::explore::replay::timeline::{Change, Shown, Step, Timeline};

/// A row.
pub(super) struct Row<'a> {
    /// The step; `None` for what is said between steps.
    pub(super) step: Option<&'a Step>,
    /// What it says.
    pub(super) text: String,
    /// What every word holds after it.
    pub(super) values: Vec<String>,
    /// Which of them it has changed.
    pub(super) changed: Vec<bool>,
    /// It is the step to mark, or says what is wrong.
    pub(super) wrong: bool,
    /// It is among the steps of the first cause.
    pub(super) caused: bool,
    /// A barrier.
    pub(super) barrier: bool,
}

/// The rows, from the first step on.
pub(super) fn rows(timeline: &Timeline) -> Vec<Row<'_>> {
    let initial = |word: &crate::explore::replay::timeline::Word| {
        word.initial.clone().unwrap_or_else(|| "-".to_owned())
    };
    let mut values: Vec<String> = timeline.words.iter().map(initial).collect();
    let fault = timeline.fault.as_ref();
    let causes = fault.and_then(|fault| fault.causes.first());
    let marked = fault.and_then(|fault| fault.step);
    let mut rows: Vec<Row<'_>> = Vec::new();
    let said = |text: String, wrong: bool, barrier: bool, values: &[String]| Row {
        step: None,
        text,
        values: values.to_vec(),
        changed: vec![false; values.len()],
        wrong,
        caused: false,
        barrier,
    };
    for (i, step) in timeline.steps.iter().enumerate() {
        let stage = &timeline.stages[step.stage];
        if i > 0 && stage.first == step.number {
            let names: Vec<&str> = stage.lanes.iter().map(|lane| &*lane.name).collect();
            let text = format!("barrier, then {}: {}", stage.name, names.join(", "));
            rows.push(said(text, false, true, &values));
        }
        let is_cycle = timeline.cycle > 0 && i + timeline.cycle == timeline.steps.len();
        if is_cycle {
            rows.push(said("forever:".to_owned(), true, false, &values));
        }
        let before = values.clone();
        for change in &step.changes {
            values[change.word] = value(change);
        }
        let stale = step.read_from.as_ref().is_some_and(|source| !source.newer.is_empty());
        let again = if step.spins { ", again" } else { "" };
        let stale = if stale { " (stale)" } else { "" };
        rows.push(Row {
            step: Some(step),
            text: format!("{}{stale}{again}", step.short),
            values: values.clone(),
            changed: values.iter().zip(&before).map(|(now, before)| now != before).collect(),
            wrong: marked == Some(step.number),
            caused: causes.is_some_and(|cause| cause.steps.contains(&step.number)),
            barrier: false,
        });
        for wrong in &step.wrong {
            rows.push(said(format!("{}: {}", wrong.property, wrong.message), true, false, &values));
        }
        let doomed = fault.is_some_and(|fault| fault.shown == Shown::DoomedAfter);
        if doomed && marked == Some(step.number) {
            let text = "from here on, every continuation is wrong".to_owned();
            rows.push(said(text, true, false, &values));
        }
    }
    rows
}

/// What a word holds, and how many older values can still be read.
fn value(change: &Change) -> String {
    let older = change
        .oldest
        .iter()
        .flatten()
        .min()
        .map_or(0, |oldest| change.versions.len().saturating_sub(1).saturating_sub(*oldest));
    let newest = change.value.as_deref().unwrap_or("-");
    if older > 0 { format!("{newest} (+{older})") } else { newest.to_owned() }
}
