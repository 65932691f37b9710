//! What a comparison found for one method: in JSON, as a line of the table, and as the texts of its sheet.

use serde::Serialize;

use crate::exec::Method;
use crate::image::difference::Difference;
use crate::image::metrics::Metrics;
use crate::image::sheet::Labels;
use crate::render::Rendering;
use crate::report::errors::{self, Errors};
use crate::report::grid::Syntax;
use crate::report::text::{Align, columns, percent, thousands};
use crate::scheme::contract::{Contract, Demand, Keeps};

/// One method next to its reference.
#[derive(Clone, Debug, Default, Serialize)]
pub(in crate::cli) struct Compared {
    pub(in crate::cli) method: String,
    pub(in crate::cli) scene: String,
    pub(in crate::cli) width: u32,
    pub(in crate::cli) height: u32,
    pub(in crate::cli) exec: String,
    /// The reference method.
    pub(in crate::cli) reference: String,
    /// Fragments per pixel kept by the reference that the lists must equal; `None` is all.
    pub(in crate::cli) reference_k: Option<u32>,
    pub(in crate::cli) generated: u64,
    pub(in crate::cli) kept: u64,
    /// Fragments that a race lost.
    pub(in crate::cli) lost: u64,
    /// Fragments dropped for any reason, including lost ones.
    pub(in crate::cli) dropped: u64,
    pub(in crate::cli) lists_equal: bool,
    /// The method need not keep all that the reference does, and says so: hidden or duplicate fragments.
    pub(in crate::cli) may_look_different: bool,
    /// Against the reference with `reference_k`.
    pub(in crate::cli) from_reference: Difference,
    /// Against the reference with all fragments; so are the following.
    pub(in crate::cli) from_all: Difference,
    #[serde(flatten)]
    pub(in crate::cli) metrics: Metrics,
    /// Smallest and largest number of records that a pixel with fragments has room for; none where nothing limits it.
    pub(in crate::cli) k_range: Option<[u32; 2]>,
    /// Generated fragments that are not in the lists, in per cent.
    pub(in crate::cli) loss: f64,
    /// Bytes of records that hold a fragment (8 each), in per cent of the memory budget.
    pub(in crate::cli) utilisation: Option<f64>,
    pub(in crate::cli) memory_budget: Option<u64>,
    pub(in crate::cli) bytes: u64,
    pub(in crate::cli) arrival_dependent: bool,
    pub(in crate::cli) image_hash: String,
    pub(in crate::cli) fragments_hash: Option<String>,
    pub(in crate::cli) warnings: Vec<String>,
    pub(in crate::cli) violations: Vec<String>,
}

impl Compared {
    /// The row of a frame, differences still to be filled in.
    pub(in crate::cli) fn new(
        method: Method,
        reference: &str,
        k: Option<u32>,
        drawn: &Rendering,
    ) -> Self {
        let report = &drawn.report;
        Self {
            method: method.name().to_owned(),
            scene: report.scene.clone(),
            width: report.width,
            height: report.height,
            exec: report.exec.clone(),
            reference: reference.to_owned(),
            reference_k: k,
            generated: report.generated,
            kept: report.kept,
            lost: report.dropped.get("lost").copied().unwrap_or(0),
            dropped: report.dropped.values().sum(),
            image_hash: report.image_hash.clone(),
            fragments_hash: report.fragments_hash.clone(),
            warnings: report.warnings.clone(),
            violations: report.violations.clone(),
            k_range: k_range(method.contract(), drawn),
            loss: share(report.generated.saturating_sub(report.kept), report.generated),
            utilisation: report.budget.as_ref().map(|b| share(RECORD * report.kept, b.bytes)),
            memory_budget: report.budget.as_ref().map(|budget| budget.bytes),
            bytes: report.bytes,
            arrival_dependent: method.contract().is_arrival_dependent(),
            ..Self::default()
        }
    }

    /// Nothing differs from the reference, and nothing forbidden happened.
    pub(in crate::cli) fn agrees(&self) -> bool {
        let same = self.from_reference.differing == 0 || self.may_look_different;
        self.lists_equal && same && self.violations.is_empty()
    }

    /// `exact`, or `exact -k 8`.
    fn held_to(&self) -> String {
        self.reference_k
            .map_or_else(|| self.reference.clone(), |k| format!("{} -k {k}", self.reference))
    }

    /// The texts of this row's sheet.
    pub(in crate::cli) fn labels(&self, scene: &str) -> Labels {
        let size = format!("{}\u{d7}{}", self.width, self.height);
        let kept = self.reference_k.map_or_else(|| "all kept".to_owned(), |k| format!("k = {k}"));
        let differing = self.from_all.differing;
        let share = percent(differing, self.from_all.pixels);
        let lists = if self.lists_equal { "equal" } else { "differ from" };
        Labels {
            title: format!("{} \u{b7} {scene} \u{b7} {size} \u{b7} {kept}", self.method),
            facts: format!(
                "lost {}, differing pixels {} ({share}), at most by {}; lists {lists} {}",
                thousands(self.lost),
                thousands(differing),
                self.from_all.max,
                self.held_to()
            ),
            captions: [
                format!("{}, all fragments", self.reference),
                self.method.clone(),
                "difference".to_owned(),
            ],
        }
    }

    /// Against the reference with all fragments.
    pub(in crate::cli) fn errors(&self) -> Errors<'_> {
        let pixels = self.from_all.pixels;
        Errors { method: &self.method, reference: &self.reference, metrics: &self.metrics, pixels }
    }

    fn cells(&self) -> Vec<String> {
        vec![
            self.method.clone(),
            self.held_to(),
            thousands(self.kept),
            thousands(self.lost),
            thousands(self.dropped),
            if self.lists_equal { "yes" } else { "NO" }.to_owned(),
            thousands(self.from_reference.differing),
            self.from_reference.max.to_string(),
            thousands(self.from_all.differing),
            self.from_all.max.to_string(),
            format!("{:.4}", self.from_all.mean()),
        ]
    }
}

/// Bytes of a record: a depth and a data word.
const RECORD: u64 = 8;

/// In per cent.
fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { 100.0 * part as f64 / whole as f64 }
}

/// See [`Compared::k_range`].
fn k_range(contract: &Contract, drawn: &Rendering) -> Option<[u32; 2]> {
    if let Some(importance) = &drawn.report.importance {
        return Some([importance.smallest_k, importance.largest_k]);
    }
    let k = drawn.report.k?;
    if contract.keeps != Keeps::Nearest || contract.demand != Demand::Bounded {
        return Some([k, k]);
    }
    // It has room for as many as there are, up to k.
    let lists = drawn.kept.fragments()?;
    let sizes = lists.offsets.windows(2).map(|ends| (ends[1] - ends[0]) as u32);
    let filled = || sizes.clone().filter(|&size| size > 0);
    Some([filled().min()?, filled().max()?])
}

/// The columns of the importance paper's Table 2, for methods at one memory budget.
fn at_budget(rows: &[Compared]) -> String {
    let Some(budget) = rows.iter().find_map(|row| row.memory_budget) else { return String::new() };
    let heading =
        ["method", "k", "stored", "loss", "utilised", "bytes", "PSNR", "SSIM", "by at most"];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    for row in rows {
        let k = match row.k_range {
            Some([low, high]) if low == high => low.to_string(),
            Some([low, high]) => format!("{low}-{high}"),
            None => "-".to_owned(),
        };
        cells.push(vec![
            row.method.clone(),
            k,
            thousands(row.kept),
            format!("{:.1} %", row.loss),
            row.utilisation.map_or_else(|| "-".to_owned(), |share| format!("{share:.1} %")),
            thousands(row.bytes),
            row.metrics.psnr.map_or_else(|| "equal".to_owned(), |psnr| format!("{psnr:.2} dB")),
            format!("{:.5}", row.metrics.ssim),
            row.from_all.max.to_string(),
        ]);
    }
    let mut aligned = [Align::Right; 9];
    aligned[0] = Align::Left;
    let budget = thousands(budget);
    format!("\nin {budget} bytes, against all fragments\n\n{}", columns(&aligned, &cells))
}

/// The rows under a heading, with what they have in common above.
pub(in crate::cli) fn table(rows: &[Compared]) -> String {
    let Some(first) = rows.first() else { return "no methods to compare\n".to_owned() };
    let heading = [
        "method",
        "held to",
        "kept",
        "lost",
        "dropped",
        "lists equal",
        "pixels differ",
        "by at most",
        "differ from all",
        "by at most",
        "on average",
    ];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    cells.extend(rows.iter().map(Compared::cells));
    let mut aligned = [Align::Right; 11];
    aligned[..2].fill(Align::Left);
    let wrong = rows.iter().filter(|row| !row.agrees()).count();
    let summary = match wrong {
        0 => "all agree with their reference".to_owned(),
        n => format!("{n} of {} differ from their reference", rows.len()),
    };
    let errors: Vec<Errors<'_>> = rows.iter().map(Compared::errors).collect();
    format!(
        "{} at {}x{}, {}, {} fragments\n\n{}\nerrors against all fragments of {}\n\n{}{}\n{summary}\n",
        first.scene,
        first.width,
        first.height,
        first.exec,
        thousands(first.generated),
        columns(&aligned, &cells),
        first.reference,
        errors::grid(&errors).write(Syntax::Text),
        at_budget(rows)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Compared {
        let from_all = Difference {
            pixels: 4_096,
            differing: 12,
            max: 33,
            sums: [40, 0, 0, 0],
            ..Difference::default()
        };
        Compared {
            method: "kplus-array".into(),
            scene: "cubes".into(),
            width: 64,
            height: 64,
            reference: "exact".into(),
            reference_k: Some(8),
            kept: 1_234,
            lists_equal: true,
            from_all,
            ..Compared::default()
        }
    }

    #[test]
    fn the_price_of_k_is_no_disagreement() {
        assert!(row().agrees());
        assert!(table(&[row()]).ends_with("\nall agree with their reference\n"));
    }

    #[test]
    fn each_kind_of_disagreement_counts() {
        let pixel = Difference { differing: 1, ..Difference::default() };
        let wrong = [
            Compared { lists_equal: false, ..row() },
            Compared { from_reference: pixel, ..row() },
            Compared { violations: vec!["unbalanced".into()], ..row() },
        ];
        assert!(wrong.iter().all(|row| !row.agrees()));
        assert!(table(&wrong).ends_with("\n3 of 3 differ from their reference\n"));
    }

    #[test]
    fn a_sheet_says_what_was_compared() {
        let labels = row().labels("cubes");
        assert_eq!(labels.title, "kplus-array \u{b7} cubes \u{b7} 64\u{d7}64 \u{b7} k = 8");
        let facts = "lost 0, differing pixels 12 (0.29 %), at most by 33; lists equal exact -k 8";
        assert_eq!(labels.facts, facts);
    }
}
