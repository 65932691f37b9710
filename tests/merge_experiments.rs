//! The experiments on merging, small: whole tables with the promised columns, and the verdict that
//! `docs/merging_figures.md` reports. What decides the verdicts is shown to be able to fail in the tests beside the
//! experiments.

use fragloom::reproduce::{EXPERIMENTS, Outcome, Scale, experiment};

/// Large enough for the measures, small enough for a debug build.
const SMALL: Scale = Scale { edge: 96, repeats: 1 };

/// What every table with pictures says of a method.
const PROMISED: [&str; 11] = [
    "method",
    "k",
    "fragments",
    "kept",
    "merged",
    "words per pixel",
    "bytes",
    "operations per fragment",
    "seconds",
    "PSNR (dB)",
    "SSIM",
];

fn run(name: &str) -> Outcome {
    let outcome = experiment(name).and_then(|e| e.run(&SMALL)).expect("it runs");
    assert_eq!(outcome.experiment, name);
    assert!(!outcome.rows.is_empty());
    assert!(outcome.rows.iter().all(|row| row.len() == outcome.columns.len()), "{name}");
    assert!(outcome.differences.is_empty(), "{name}");
    outcome
}

/// It runs, has the columns, pictures and curves, and comes out as in the paper.
fn confirms(name: &str, pictures: usize, curves: usize) -> Outcome {
    let outcome = run(name);
    let verdict = outcome.verdict.clone().expect("a verdict");
    assert!(verdict.as_in_the_paper, "{name}: {verdict} {:?}", outcome.rows);
    shows(&outcome, pictures, curves);
    outcome
}

fn shows(outcome: &Outcome, pictures: usize, curves: usize) {
    let name = outcome.experiment;
    for column in PROMISED {
        assert!(outcome.columns.contains(&column), "{name}: {column}");
    }
    assert_eq!(outcome.pictures.len(), pictures, "{name}");
    assert_eq!(outcome.plot.as_ref().map_or(0, |plot| plot.curves.len()), curves, "{name}");
}

/// The cells of a column.
fn column<'a>(outcome: &'a Outcome, name: &str) -> Vec<&'a str> {
    let place = outcome.columns.iter().position(|column| *column == name).expect("a column");
    outcome.rows.iter().map(|row| row[place].as_str()).collect()
}

fn numbers(outcome: &Outcome, name: &str) -> Vec<f64> {
    column(outcome, name).iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()
}

#[test]
fn there_are_no_others() {
    let names: Vec<_> =
        EXPERIMENTS.iter().map(|e| e.name).filter(|name| name.starts_with("merge-")).collect();
    for name in ["fig1", "fig3", "fig5", "fig6", "fig7", "fig8", "fig9", "fig10", "fig11", "fig12"]
    {
        assert!(names.contains(&format!("merge-{name}").as_str()), "{name}");
    }
    for name in ["fig13", "fig14", "fig15", "fig16", "fig17"] {
        assert!(names.contains(&format!("merge-{name}").as_str()), "{name}");
    }
    assert_eq!(names.len(), 15, "every other name is run below");
}

#[test]
fn planes_fight_unless_merged() {
    let outcome = confirms("merge-fig1", 1, 0);
    let unlike = numbers(&outcome, "unlike the mix (%)");
    assert!(unlike[0] > 20.0, "a pixel shows one plane or the other, never their mix: {unlike:?}");
}

#[test]
fn slabs_become_their_components() {
    let outcome = run("merge-fig5");
    assert!(outcome.verdict.clone().expect("a verdict").as_in_the_paper, "{outcome:?}");
    assert_eq!(outcome.plot.expect("slabs").curves.len(), 3);
}

#[test]
fn smooth_merging_has_the_smaller_steps() {
    confirms("merge-fig6", 1, 4);
}

#[test]
fn beta_widens_transitions() {
    confirms("merge-fig7", 1, 0);
}

#[test]
fn curves_meet_at_both_ends() {
    let outcome = run("merge-fig8");
    assert!(outcome.verdict.clone().expect("a verdict").as_in_the_paper, "{outcome:?}");
    assert_eq!(outcome.plot.expect("curves").curves.len(), 6);
}

#[test]
fn contrast_rises_with_beta() {
    confirms("merge-fig9", 1, 1);
}

#[test]
fn absorbance_has_the_steps_of_groups() {
    confirms("merge-fig13", 0, 5);
}

#[test]
fn distances_become_colours() {
    confirms("merge-fig14", 2, 1);
}

#[test]
fn what_is_inside_is_seen() {
    confirms("merge-fig15", 1, 0);
}

#[test]
fn merged_samples_have_no_bands() {
    confirms("merge-fig16", 2, 0);
}

#[test]
fn no_radius_and_no_aperture_change_nothing() {
    confirms("merge-fig17", 1, 0);
}
