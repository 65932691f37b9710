//! The table of hash schemes: cells in two dimensions, addressed from a pixel by its position and a sequence of offsets
//! (García, Lefebvre, Hornus, Lasram, "Coherent parallel hashing", 2011; HA-buffer paper, sections 2.5.1 and 4.1).
//!
//! At age a, pixel p looks at cell p + offset(a) mod H, for both axes: neighbours look at neighbouring cells. Where the
//! table is at least as large as the screen on each axis, no two pixels look at one cell at the same age, so that a
//! cell and an age identify a pixel: the age equivalence of section 4.1.1. (The paper asks for a table of more *cells*
//! than the screen has pixels. That is enough in one dimension; in two, it must hold on each axis.)
//!
//! A second table has the largest age of every block of 8x8 pixels.

use serde::{Deserialize, Serialize};

use crate::memory::{At, Atomic, Global, Layout, Memory, Order, Word, Words};
use crate::num::random::Random;
use crate::raster::Grid;
use crate::scheme::Config;

/// The largest age that a record's 8 bits can hold.
pub const MOST_AGES: u32 = 255;

/// The most cells of a table.
pub const MOST_CELLS: u64 = 1 << 31;

/// Load for which a table is sized unless given, in per cent: what the paper recommends for speed (section 6.2).
pub const DEFAULT_LOAD: u32 = 50;

/// Words that one invocation of the clear pass clears.
const CLEARED: u64 = 64;

/// Pixels of a block on each side.
const BLOCK: u32 = 8;

/// Streams of random numbers.
const OFFSETS: u64 = 0x0FF5;

/// Candidates for the farthest point.
const CANDIDATES: usize = 4_096;

/// How a table is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TableSettings {
    /// Cells across and down; zeroes are for [`DEFAULT_LOAD`].
    pub size: [u32; 2],
    /// The largest age, 1 to [`MOST_AGES`]; a fragment that would need a greater one is dropped.
    pub ages: u32,
    /// Where ages lead to.
    pub offsets: Offsets,
    /// Seed of the offsets; the paper draws random ones anew for every frame.
    pub seed: u64,
    /// Early culling: transmittance (65,535 is all) below which nothing behind can be seen.
    pub opaque: u16,
}

/// Sequences of offsets (HA-buffer paper, section 4.1.3).
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Offsets {
    /// Independent and uniform.
    #[default]
    Random,
    /// Iterated farthest point sampling on the torus: each is as far as possible from all before it, so that the first
    /// are farthest apart.
    FarthestPoint,
    /// The seed's digits, to the base of the number of cells: for trying all sequences of small tables.
    Digits,
}

/// That for the paper's opacity threshold of 0.99.
pub const OPAQUE: u16 = 656;

impl Default for TableSettings {
    fn default() -> Self {
        Self { size: [0; 2], ages: MOST_AGES, offsets: Offsets::Random, seed: 0, opaque: OPAQUE }
    }
}

impl TableSettings {
    /// Cells in all.
    #[must_use]
    pub fn cells(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// The offsets of all ages, the first for age 1.
    #[must_use]
    pub fn offsets(&self) -> Vec<[u32; 2]> {
        let [width, height] = self.size.map(u64::from);
        let mut random = Random::new(self.seed, OFFSETS);
        let mut draw = || [random.below(width) as u32, random.below(height) as u32];
        match self.offsets {
            Offsets::Random => (0..self.ages).map(|_| draw()).collect(),
            Offsets::FarthestPoint => farthest(self.size, self.ages, draw),
            Offsets::Digits => {
                let mut rest = self.seed;
                let mut digit = |base: u64| {
                    let digit = rest % base.max(1);
                    rest /= base.max(1);
                    digit as u32
                };
                (0..self.ages).map(|_| [digit(width), digit(height)]).collect()
            }
        }
    }
}

/// The size of a table that has at least as many cells, is at least as large as the screen on each axis, and else has
/// its proportions.
#[must_use]
pub fn size_for(cells: u64, screen: [u32; 2]) -> [u32; 2] {
    let [width, height] = screen.map(|edge| u64::from(edge.max(1)));
    let across = (cells.saturating_mul(width) / height).isqrt().max(width);
    [across as u32, cells.div_ceil(across).max(height) as u32]
}

/// The size of a table that `records` fill to `load` per cent, as far as the screen allows.
#[must_use]
pub fn size_for_load(records: u64, load: u32, screen: [u32; 2]) -> [u32; 2] {
    size_for((records * 100).div_ceil(u64::from(load.max(1))), screen)
}

fn farthest(
    [width, height]: [u32; 2],
    count: u32,
    mut draw: impl FnMut() -> [u32; 2],
) -> Vec<[u32; 2]> {
    let first = draw();
    let all = width as usize * height as usize;
    let candidates: Vec<[u32; 2]> = if all <= CANDIDATES {
        (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect()
    } else {
        (0..CANDIDATES).map(|_| draw()).collect()
    };
    let between = |a: [u32; 2], b: [u32; 2]| {
        let along = |a: u32, b: u32, size: u32| {
            let apart = a.abs_diff(b);
            u64::from(apart.min(size - apart)).pow(2)
        };
        along(a[0], b[0], width) + along(a[1], b[1], height)
    };
    let mut nearest = vec![u64::MAX; candidates.len()];
    let mut chosen = vec![first];
    while chosen.len() < count as usize {
        let last = chosen[chosen.len() - 1];
        for (distance, &candidate) in nearest.iter_mut().zip(&candidates) {
            *distance = between(last, candidate).min(*distance);
        }
        // The first of equally far ones. Where all are taken, the sequence begins again.
        let best = (0..candidates.len()).rev().max_by_key(|&i| nearest[i]).unwrap_or(0);
        if nearest[best] == 0 {
            let again = chosen[chosen.len() % all.min(chosen.len())];
            chosen.push(again);
        } else {
            chosen.push(candidates[best]);
        }
    }
    chosen
}

/// A place on the torus: a pixel's, or a cell's.
pub type Place = [u32; 2];

/// The cells and the largest ages.
#[derive(Clone, Debug)]
pub struct Table<W> {
    cells: Words<Global, Atomic, W>,
    largest: Words<Global, Atomic, u32>,
    grid: Grid,
    size: [u32; 2],
    offsets: Box<[[u32; 2]]>,
}

impl<W: Word> Table<W> {
    /// Declare it. What a scheme stores only grows until the next frame, and so do the largest ages.
    #[must_use]
    pub fn new(config: &Config, layout: &mut Layout) -> Self {
        let (grid, mut settings) = (config.grid, config.table);
        if settings.size.contains(&0) {
            let screen = [grid.width, grid.height];
            settings.size = size_for_load(config.generated, DEFAULT_LOAD, screen);
        }
        let cells = layout.named("cells").global(settings.cells());
        let blocks = grid.width.div_ceil(BLOCK) * grid.height.div_ceil(BLOCK);
        let largest = layout.named("largest").global(u64::from(blocks));
        layout.grows(cells);
        layout.grows(largest);
        let offsets = settings.offsets().into();
        Self { cells, largest, grid, size: settings.size, offsets }
    }

    /// A table of at least as many cells, but half as wide: for showing what comes of it.
    #[must_use]
    pub fn narrow(config: &Config, layout: &mut Layout) -> Self {
        let mut config = *config;
        if config.table.size.contains(&0) {
            let screen = [config.grid.width, config.grid.height];
            config.table.size = size_for_load(config.generated, DEFAULT_LOAD, screen);
        }
        let [width, height] = config.table.size;
        config.table.size = [width.div_ceil(2), height * 2];
        Self::new(&config, layout)
    }

    /// The largest age.
    #[inline(always)]
    #[must_use]
    pub fn ages(&self) -> u32 {
        self.offsets.len() as u32
    }

    /// Cells across and down.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether it is at least as large as the screen on each axis, so that walks begin where their pixels are.
    #[must_use]
    pub fn covers_screen(&self) -> bool {
        self.size[0] >= self.grid.width && self.size[1] >= self.grid.height
    }

    /// All cells, row by row.
    #[must_use]
    pub fn cells(&self) -> Words<Global, Atomic, W> {
        self.cells
    }

    /// Where a pixel's walk begins.
    #[inline(always)]
    #[must_use]
    pub fn place(&self, pixel: u32) -> Place {
        let (x, y) = self.grid.place(pixel);
        [x % self.size[0], y % self.size[1]]
    }

    /// Whether a storage place is a pixel of the image: tiles that its edge cuts have others, which no fragment
    /// reaches.
    #[inline(always)]
    #[must_use]
    pub fn is_seen(&self, pixel: u32) -> bool {
        let (x, y) = self.grid.place(pixel);
        x < self.grid.width && y < self.grid.height
    }

    /// The storage place of the pixel at `place`.
    #[must_use]
    pub fn pixel(&self, [x, y]: Place) -> u32 {
        self.grid.pixel(x, y)
    }

    /// The cell at which a walk is at an age, which is 1 or more.
    #[inline(always)]
    #[must_use]
    pub fn cell(&self, [x, y]: Place, age: u32) -> Place {
        let [dx, dy] = self.offsets[age as usize - 1];
        [turn(x + dx, self.size[0]), turn(y + dy, self.size[1])]
    }

    /// The cells of a row of pixels at an age, if they lie one after another; `place` is the first one's.
    #[inline(always)]
    #[must_use]
    pub fn row(&self, place: Place, age: u32, pixels: u32) -> Option<u64> {
        let [x, y] = self.cell(place, age);
        let first = u64::from(y) * u64::from(self.size[0]) + u64::from(x);
        (x + pixels <= self.size[0]).then_some(first)
    }

    /// The same for ages beyond the largest, which only a faulty form has: offsets of their own, one cell on.
    #[inline(always)]
    #[must_use]
    pub fn cell_beyond(&self, place: Place, age: u32) -> Place {
        if age <= self.ages() {
            return self.cell(place, age);
        }
        let [x, y] = self.cell(place, (age - 1) % self.ages() + 1);
        [turn(x + 1, self.size[0]), y]
    }

    /// Where the walk that is at this cell at this age began. An age that does not exist, which only a faulty form
    /// finds, has offset 0, as an access outside of a buffer reads on a robust device.
    #[inline(always)]
    #[must_use]
    pub fn origin(&self, [x, y]: Place, age: u32) -> Place {
        let [dx, dy] = self.offsets.get(age.wrapping_sub(1) as usize).copied().unwrap_or_default();
        let [width, height] = self.size;
        [turn(x + width - dx, width), turn(y + height - dy, height)]
    }

    /// The cell's word.
    #[inline(always)]
    #[must_use]
    pub fn word(&self, [x, y]: Place) -> At<Global, Atomic, W> {
        self.cells.at(u64::from(y) * u64::from(self.size[0]) + u64::from(x))
    }

    /// The place of a cell's word.
    #[must_use]
    pub fn place_of(&self, word: u64) -> Place {
        let width = u64::from(self.size[0]);
        [(word % width) as u32, (word / width) as u32]
    }

    /// The largest age of the place's block.
    #[inline(always)]
    #[must_use]
    pub fn largest(&self, [x, y]: Place) -> At<Global, Atomic, u32> {
        let blocks = self.grid.width.div_ceil(BLOCK);
        self.largest.at(u64::from(y / BLOCK * blocks + x / BLOCK))
    }

    /// Invocations of the clear pass.
    #[must_use]
    pub fn clearing(&self) -> u32 {
        (self.cells.count() + self.largest.count()).div_ceil(CLEARED) as u32
    }

    /// One invocation of the clear pass: 0 is an empty cell, and no age.
    pub async fn clear<M: Memory>(&self, mem: &M, index: u32) {
        let first = u64::from(index) * CLEARED;
        let cells = self.cells.count();
        for i in first..(first + CLEARED).min(cells) {
            mem.store(self.cells.at(i), W::default(), Order::Relaxed).await;
        }
        let rest = first.max(cells)..(first + CLEARED).min(cells + self.largest.count());
        for i in rest {
            mem.store(self.largest.at(i - cells), 0, Order::Relaxed).await;
        }
    }
}

/// `x` modulo `size`, for an `x` below twice the size.
#[inline(always)]
fn turn(x: u32, size: u32) -> u32 {
    if x >= size { x - size } else { x }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn settings(size: [u32; 2], ages: u32, offsets: Offsets, seed: u64) -> TableSettings {
        TableSettings { size, ages, offsets, seed, ..TableSettings::default() }
    }

    #[test]
    fn a_table_is_never_smaller_than_the_screen() {
        assert_eq!(size_for(0, [10, 20]), [10, 20]);
        assert_eq!(size_for(1_000, [10, 10]), [31, 33]);
        assert_eq!(size_for(1_000, [100, 2]), [223, 5]);
        for load in [30, 50, 80, 90, 95] {
            let [width, height] = size_for_load(100_000, load, [96, 96]);
            let cells = u64::from(width) * u64::from(height);
            assert!(cells * u64::from(load) >= 100 * 100_000);
            assert!(cells * u64::from(load) < 101 * 100_000, "{width}x{height}");
        }
    }

    #[test]
    fn the_farthest_points_come_first_and_are_all_different() {
        let all = settings([8, 4], 32, Offsets::FarthestPoint, 3).offsets();
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), 32);
        let apart = |[a, b]: [[u32; 2]; 2]| {
            let along = |a: u32, b: u32, n: u32| a.abs_diff(b).min(n - a.abs_diff(b)).pow(2);
            along(a[0], b[0], 8) + along(a[1], b[1], 4)
        };
        let least = |n: usize| (0..n).map(|i| apart([all[i], all[n]])).min();
        let gaps: Vec<_> = (1..32).map(least).collect();
        assert!(gaps.is_sorted_by(|a, b| a >= b), "{gaps:?}");
        assert_eq!(gaps[0], Some(16 + 4), "half of both axes");
        let beyond = settings([2, 1], 5, Offsets::FarthestPoint, 0).offsets();
        assert_eq!(beyond.len(), 5, "also with more ages than cells");
    }

    #[test]
    fn digits_make_every_sequence_once() {
        let all: BTreeSet<_> =
            (0..64).map(|seed| settings([2, 2], 3, Offsets::Digits, seed).offsets()).collect();
        assert_eq!(all.len(), 64);
    }

    #[test]
    fn seeds_make_different_sequences() {
        for kind in [Offsets::Random, Offsets::FarthestPoint] {
            let of = |seed| settings([64, 64], 9, kind, seed).offsets();
            assert_eq!(of(1), of(1));
            assert_ne!(of(1), of(2));
        }
    }

    #[test]
    fn origin_undoes_cell() {
        let grid = Grid { width: 7, height: 5, tile: 16 };
        let table_settings = settings([9, 5], 20, Offsets::Random, 4);
        let config = Config { grid, table: table_settings, ..Config::default() };
        let table = Table::<u64>::new(&config, &mut Layout::default());
        for pixel in [(0, 0), (6, 4), (3, 2)].map(|(x, y)| grid.pixel(x, y)) {
            let place = table.place(pixel);
            assert_eq!(table.pixel(place), pixel);
            for age in 1..=20 {
                let cell = table.cell(place, age);
                assert!(cell[0] < 9 && cell[1] < 5);
                assert_eq!(table.origin(cell, age), place);
            }
        }
    }
}
