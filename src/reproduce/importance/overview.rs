//! Table 1 and Figure 3: how three methods choose k and take memory, and the passes of the third.

use super::METHODS;
use crate::catalogue;
use crate::error::Result;
use crate::raster::Grid;
use crate::render::storage_bytes;
use crate::reproduce::{Outcome, Scale, Verdict, word};
use crate::scheme::Config;

/// Figure 3: the pipeline, from the method's program.
pub(in crate::reproduce) fn pipeline(_: &Scale) -> Result<Outcome> {
    let program = catalogue::method("k-variable")?.contract().program;
    let rows: Vec<Vec<String>> = (0..)
        .zip(program.passes)
        .map(|(i, pass): (usize, _)| {
            vec![i.to_string(), pass.name.to_owned(), word(&pass.kind), word(&pass.before)]
        })
        .collect();
    let mut wrong = Vec::new();
    for stage in ["count", "importance", "k", "store"] {
        let times = program.passes.iter().filter(|pass| pass.name == stage).count();
        if times != 1 {
            wrong.push(format!("stage {stage} runs {times} times"));
        }
    }
    let summary = "the passes between clear and resolve, with the barrier before each; the sums stand for the paper's \
                   atomic total and for its contiguous ranges"
        .to_owned();
    let columns = vec!["pass", "name", "invocations", "behind a barrier of"];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, verdict, ..Outcome::new("varik-fig3", summary) })
}

/// Table 1: how the three methods choose k and take memory.
pub(in crate::reproduce) fn overview(scale: &Scale) -> Result<Outcome> {
    let grid = Grid { width: scale.edge, height: scale.edge, tile: 64 };
    let pixels = grid.storage_pixels() as u64;
    let (k, stored) = (4, 3 * pixels);
    let config = Config {
        k: Some(4),
        pixels: pixels as u32,
        bounded: stored,
        records: k * pixels,
        grid,
        ..Config::default()
    };
    let blocks = pixels.div_ceil(64);
    let groups = blocks.div_ceil(64);
    let printed = [
        ("fixed, by hand", "uniform", "fixed", 4 * (2 * k + 2) * pixels),
        (
            "fixed, by histogram",
            "uniform",
            "adaptive",
            4 * (3 * pixels + 2 * stored + blocks + groups),
        ),
        (
            "variable, by importance",
            "non-uniform",
            "adaptive",
            4 * (4 * pixels + 2 * k * pixels + 2 * blocks + 2 * groups + 2),
        ),
    ];
    let (mut rows, mut differences) = (Vec::new(), Vec::new());
    for (name, (selection, distribution, memory, formula)) in METHODS.into_iter().zip(printed) {
        let method = catalogue::method(name)?;
        let contract = method.contract();
        let measured = storage_bytes(method, &config);
        if measured != formula {
            differences.push(format!("{name}: {measured} bytes, {formula} by its formula"));
        }
        rows.push(vec![
            name.to_owned(),
            selection.to_owned(),
            distribution.to_owned(),
            memory.to_owned(),
            contract.words.to_owned(),
            contract.frame_words.to_owned(),
            formula.to_string(),
            measured.to_string(),
        ]);
    }
    let columns = vec![
        "method",
        "k (paper)",
        "distribution (paper)",
        "memory (paper)",
        "words per pixel",
        "words of the frame",
        "bytes by formula",
        "bytes",
    ];
    let summary =
        format!("bytes for {0}x{0} pixels, k = 4, and 3 fragments a pixel within it", scale.edge);
    let verdict = Some(Verdict::of(&differences));
    Ok(Outcome { columns, rows, verdict, differences, ..Outcome::new("varik-table1", summary) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Scale = Scale { edge: 64, repeats: 1 };

    #[test]
    fn formulas_are_what_is_measured() {
        assert_eq!(overview(&SMALL).unwrap().differences, Vec::<String>::new());
    }

    #[test]
    fn every_stage_is_there() {
        let outcome = pipeline(&SMALL).unwrap();
        assert!(outcome.verdict.unwrap().as_in_the_paper);
        assert!(outcome.rows.iter().all(|row| row.len() == outcome.columns.len()));
    }
}
