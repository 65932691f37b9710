//! How hash tables are made for a scene, and what is reported about them.

use serde::Serialize;

use super::Options;
use crate::error::{Error, Result};
use crate::exec::table::TableWords;
use crate::resolve::digest::table_hash;
use crate::scheme::Contract;
use crate::scheme::hash_table::table::{
    DEFAULT_LOAD, MOST_AGES, MOST_CELLS, Offsets, TableSettings, size_for_load,
};

/// How a hash table is made.
#[derive(Clone, Debug, PartialEq)]
pub struct TableOptions {
    /// The share of cells to be filled by fragments, in per cent, 1 to 100. A table is at least as large as the image
    /// on each axis, so the actual load may be lower. `None` is 50.
    pub load: Option<u32>,
    /// Cells across and down, instead; at least the image's pixels on each axis.
    pub size: Option<[u32; 2]>,
    /// Where ages lead.
    pub offsets: Offsets,
    /// The seed of the offsets.
    pub seed: u64,
    /// The largest age, 1 to 255.
    pub ages: u32,
    /// Early culling: the opacity above which nothing behind is seen, 0 to 1.
    pub threshold: f64,
}

impl Default for TableOptions {
    fn default() -> Self {
        Self {
            load: None,
            size: None,
            offsets: Offsets::Random,
            seed: 0,
            ages: MOST_AGES,
            threshold: 0.99,
        }
    }
}

impl TableOptions {
    /// Check every value against its range.
    ///
    /// # Errors
    /// The first that is out of range, by the name of its option.
    pub(super) fn check(&self) -> Result<()> {
        let wrong = |option: &str, problem: String| Err(Error::new(option, problem));
        if let Some(load) = self.load.filter(|load| !(1..=100).contains(load)) {
            return wrong("--load", format!("is {load}, but must be 1 to 100 per cent"));
        }
        if let (Some(load), Some([w, h])) = (self.load, self.size) {
            return wrong("--load", format!("is {load}, and --table {w}x{h}: give one of them"));
        }
        if !(1..=MOST_AGES).contains(&self.ages) {
            let ages = self.ages;
            return wrong("--age-limit", format!("is {ages}, but must be 1 to {MOST_AGES}"));
        }
        if !(0.0..=1.0).contains(&self.threshold) {
            let threshold = self.threshold;
            return wrong("--cull-threshold", format!("is {threshold}, but must be 0 to 1"));
        }
        Ok(())
    }

    /// The transmittance (65,535 is all) below which the opacity is above the threshold.
    #[must_use]
    pub fn opaque(&self) -> u16 {
        ((1.0 - self.threshold) * 65_535.0).ceil().min(65_535.0) as u16
    }

    /// The settings of a scheme for this many fragments.
    pub(super) fn settings(&self, fragments: u64, image: [u32; 2]) -> Result<TableSettings> {
        let size = self
            .size
            .unwrap_or_else(|| size_for_load(fragments, self.load.unwrap_or(DEFAULT_LOAD), image));
        let [[w, h], [iw, ih]] = [size, image];
        if w < iw || h < ih {
            let problem = format!(
                "is {w}x{h} cells, but must have at least the image's {iw}x{ih} on each axis: else an age does not \
                 name a pixel"
            );
            return Err(Error::new("--table", problem));
        }
        let settings = TableSettings {
            size,
            ages: self.ages,
            offsets: self.offsets,
            seed: self.seed,
            opaque: self.opaque(),
        };
        if settings.cells() > MOST_CELLS {
            let problem = format!("is {w}x{h} cells, above the most, {MOST_CELLS}");
            return Err(Error::new("--table", problem));
        }
        Ok(settings)
    }

    /// Every option that differs from its default.
    pub(super) fn given(&self) -> Vec<&'static str> {
        let default = Self::default();
        let given = [
            (self.load != default.load, "--load"),
            (self.size != default.size, "--table"),
            (self.offsets != default.offsets, "--offsets"),
            (self.seed != default.seed, "--offset-seed"),
            (self.ages != default.ages, "--age-limit"),
            (self.threshold != default.threshold, "--cull-threshold"),
        ];
        given.into_iter().filter(|(given, _)| *given).map(|(_, name)| name).collect()
    }
}

/// What is reported about a hash table.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TableReport {
    /// Cells across.
    pub width: u32,
    /// Cells down.
    pub height: u32,
    /// Records stored.
    pub stored: u64,
    /// Their share of the cells, in per cent.
    pub load: f64,
    /// The largest age of a record.
    pub max_age: u32,
    /// Records by age, from 1 on.
    pub ages: Vec<u64>,
    /// SHA-256 of width and height as u32, and of the cells as u64, all little-endian.
    pub hash: String,
}

impl TableReport {
    pub(super) fn new(table: &TableWords) -> Self {
        let ages = table.ages();
        let stored: u64 = ages.iter().sum();
        let [width, height] = table.size;
        Self {
            width,
            height,
            stored,
            load: stored as f64 * 100.0 / table.cells.len() as f64,
            max_age: ages.len().saturating_sub(1) as u32,
            ages: ages.into_iter().skip(1).collect(),
            hash: table_hash(table.size, &table.cells),
        }
    }

    /// No cell is empty.
    pub(super) fn is_full(&self) -> bool {
        self.stored == u64::from(self.width) * u64::from(self.height)
    }
}

/// A warning about options of hash tables for a method that has none.
pub(super) fn idle(options: &Options, contract: &Contract) -> Option<String> {
    let given = options.table.given();
    let (none, name) = (given.is_empty() || contract.crosses(), contract.name);
    (!none).then(|| format!("{} has no effect: {name} has no hash table", given.join(", ")))
}
