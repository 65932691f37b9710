//! Table 1 of the HA-buffer paper: memory in MiB for a screen of 1024x1024, by its formulas (section 6.2), and the
//! bytes that our methods actually declare.
//!
//! The paper counts fragments of 56 bits (depth 24, RGBA 32) and pointers of 32; ours have 32-bit depths where the
//! method allows it, and need more for their form (locks, counters, blocks of prefix sums), so they are larger.

use super::{Outcome, Scale, Verdict};
use crate::catalogue::method;
use crate::error::Result;
use crate::raster::Grid;
use crate::render::storage_bytes;
use crate::scheme::Config;
use crate::scheme::hash_table::table::{TableSettings, size_for_load};

/// Pixels on each side.
const EDGE: u32 = 1_024;

/// Fragments of a page.
const PAGE: f64 = 4.0;

/// The columns: fragments.
const FRAGMENTS: [u64; 3] = [850_000, 1_500_000, 10_000_000];

/// A row: the technique, our method, the paper's values in MiB, its formula in bits for V² pixels and F fragments.
struct Technique {
    name: &'static str,
    method: &'static str,
    printed: [f64; 3],
    bits: fn(pixels: f64, fragments: f64) -> f64,
    /// Per cent.
    load: u32,
    /// Pages that are partly full, per pixel.
    spare: f64,
}

const TECHNIQUES: [Technique; 7] = [
    Technique {
        name: "count-gather-sort",
        method: "s-buffer",
        printed: [9.7, 14.0, 70.8],
        bits: |v, f| 32.0 * v + 56.0 * f,
        load: 0,
        spare: 0.0,
    },
    Technique {
        name: "linked-list",
        method: "ab-ll",
        printed: [12.9, 19.7, 108.9],
        bits: |v, f| 32.0 * v + 88.0 * f,
        load: 0,
        spare: 0.0,
    },
    Technique {
        name: "paged, K = 4, lower bound",
        method: "ab-ll-paged",
        printed: [11.5, 16.4, 81.3],
        bits: |v, f| 40.0 * v + f / PAGE * (56.0 * PAGE + 32.0),
        load: 0,
        spare: 0.0,
    },
    Technique {
        name: "paged, K = 4, upper bound",
        method: "ab-ll-paged",
        printed: [32.5, 37.4, 102.3],
        bits: |v, f| 40.0 * v + f / PAGE * (56.0 * PAGE + 32.0) + 56.0 * (PAGE - 1.0) * v,
        load: 0,
        spare: (PAGE - 1.0) / PAGE,
    },
    ha("HA-buffer, L = 90 %", [7.2, 12.7, 84.8], |v, f| v / 8.0 + 64.0 * f / 0.9, 90),
    ha("HA-buffer, L = 80 %", [8.1, 14.3, 95.4], |v, f| v / 8.0 + 64.0 * f / 0.8, 80),
    ha("HA-buffer, L = 50 %", [13.0, 22.9, 152.6], |v, f| v / 8.0 + 64.0 * f / 0.5, 50),
];

const fn ha(
    name: &'static str,
    printed: [f64; 3],
    bits: fn(f64, f64) -> f64,
    load: u32,
) -> Technique {
    Technique { name, method: "ha64", printed, bits, load, spare: 0.0 }
}

const MIB: f64 = 8.0 * 1_048_576.0;

pub(super) fn table(_: &Scale) -> Result<Outcome> {
    let (mut rows, mut differences) = (Vec::new(), Vec::new());
    for technique in &TECHNIQUES {
        for (column, &fragments) in FRAGMENTS.iter().enumerate() {
            let printed = technique.printed[column];
            let pixels = f64::from(EDGE) * f64::from(EDGE);
            let computed = (technique.bits)(pixels, fragments as f64) / MIB;
            if format!("{computed:.1}") != format!("{printed:.1}") {
                let name = technique.name;
                differences.push(format!("{name}, F = {fragments}: {computed:.3} of {printed}"));
            }
            let ours = storage_bytes(method(technique.method)?, &technique.config(fragments));
            rows.push(vec![
                technique.name.to_owned(),
                format!("{:.2}", fragments as f64 / 1e6),
                format!("{printed:.1}"),
                format!("{computed:.1}"),
                technique.method.to_owned(),
                format!("{:.1}", 8.0 * ours as f64 / MIB),
                ours.to_string(),
            ]);
        }
    }
    let right = rows.len() - differences.len();
    let columns = vec![
        "technique",
        "fragments (million)",
        "printed (MiB)",
        "by its formula (MiB)",
        "our method",
        "ours (MiB)",
        "ours (bytes)",
    ];
    let summary =
        format!("{right} of {} printed values follow from the paper's formulas", rows.len());
    let verdict = Some(Verdict::of(&differences));
    Ok(Outcome { columns, rows, verdict, differences, ..Outcome::new("ha-table1", summary) })
}

impl Technique {
    /// The configuration of our method for a scene with this many fragments.
    fn config(&self, fragments: u64) -> Config {
        let grid = Grid { width: EDGE, height: EDGE, tile: 64 };
        let pixels = grid.storage_pixels() as u32;
        let pages = (fragments as f64 / PAGE + self.spare * f64::from(pixels)).ceil() as u64;
        // A table as large as the load requires, even where that is smaller than the screen, as in the paper's table.
        let cells = (fragments * 100).div_ceil(u64::from(self.load.max(1)));
        let mut size = size_for_load(fragments, self.load.max(1), [EDGE; 2]);
        if cells < u64::from(pixels) {
            size = [EDGE, cells.div_ceil(u64::from(EDGE)) as u32];
        }
        let table = TableSettings { size, ..TableSettings::default() };
        Config {
            pixels,
            generated: fragments,
            bounded: fragments,
            pages,
            grid,
            table,
            ..Config::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_printed_values_come_out() {
        let outcome = table(&Scale { edge: 0, repeats: 0 }).unwrap();
        assert_eq!(outcome.differences, Vec::<String>::new());
        assert_eq!(outcome.rows.len(), 7 * 3);
        // 850,000 cells at 90 %, of 8 bytes; 128x128 blocks of a 4-byte age.
        let ha = &outcome.rows[4 * 3];
        let cells = 1_024 * 850_000_u64.div_ceil(9).saturating_mul(10).div_ceil(1_024);
        let bytes: u64 = ha[6].parse().unwrap();
        assert!(bytes.abs_diff(8 * cells + 4 * 128 * 128) <= 8 * 2_048, "{ha:?}");
    }

    #[test]
    fn a_wrong_value_is_seen() {
        let wrong = (TECHNIQUES[0].bits)(1_048_576.0, 900_000.0) / MIB;
        assert_ne!(format!("{wrong:.1}"), format!("{:.1}", TECHNIQUES[0].printed[0]));
    }
}
