//! From what a tile's pixels hold to sorted lists, colours and the accounting.

use std::cmp::Ordering;

use super::{Column, PixelCounts, TileOutput};
use crate::exec::Job;
use crate::exec::account::Tally;
use crate::exec::drive::Pipeline;
use crate::fragment::{Data, data_of, depth_of};
use crate::num::lanes::wide;
use crate::num::ray::Ray;
use crate::num::rays::{RAYS, Rays};
use crate::scheme::{Held, Record, Records, Scale, Single};

/// Merged records of a pixel that room is made for: the `-k` that is usual.
const USUAL: u32 = 8;

/// Takes a tile's pixels in storage order: sorts, composites and accounts for them.
pub struct Finisher<'a> {
    job: &'a Job<'a>,
    tile: usize,
    output: TileOutput,
}

impl<'a> Finisher<'a> {
    /// For one tile.
    #[must_use]
    pub fn new(job: &'a Job<'a>, tile: usize) -> Self {
        let room = job.kit.tile(tile);
        let mut output = TileOutput { column: Column::of(job.holds, room.column), ..room };
        let pixels = job.front.grid.pixels_per_tile();
        output.counts.reserve_exact(pixels);
        output.colors.reserve_exact(pixels);
        Self { job, tile, output }
    }

    /// Make room for the keys of a tile with these counts.
    pub fn reserve(&mut self, generated: &[u32]) {
        if let Column::Records(records) = &mut self.output.column {
            records.reserve(generated.iter().map(|&g| g.min(USUAL) as usize).sum());
            return;
        }
        let Column::Keys(keys) = &mut self.output.column else { return };
        let first = self.tile * self.job.front.grid.pixels_per_tile();
        let most = |(i, &g): (usize, &u32)| self.job.nearest.cut(first + i, g as usize);
        keys.reserve_exact(generated.iter().enumerate().map(most).sum());
    }

    /// The next pixel: what it holds, lists in any order, and its counts.
    #[inline]
    pub fn pixel(&mut self, held: &mut Held, generated: u32, gone: u32) {
        match held {
            Held::Keys(keys) => self.keys(keys, generated, gone),
            Held::Records(records) => self.records(records, generated, gone),
            Held::Light(_) | Held::Depth(_) => self.other(held, generated, gone),
        }
    }

    /// The next pixel: its fragments in any order, and its counts.
    #[inline]
    pub fn keys(&mut self, keys: &mut [u64], generated: u32, gone: u32) {
        self.singles(keys, Scale::default(), generated, gone, 0);
    }

    /// All pixels of the tile: their fragments one after another, in any order within a pixel, and where each ends.
    fn lists(&mut self, mut keys: Vec<u64>, mut ends: Vec<u32>, counts: &PixelCounts) {
        let Self { job, tile, output } = self;
        let (grid, front) = (&job.front.grid, job.front);
        let colors = &mut output.colors;
        match job.record.data {
            Data::Color | Data::Nothing => {
                Self::sorted(job, colors, &mut keys, &mut ends, |_, key| data_of(key));
            }
            Data::Primitive => Self::sorted(job, colors, &mut keys, &mut ends, |local, key| {
                let (x, y) = grid.position(*tile, local);
                front.color_of(data_of(key), x, y, depth_of(key))
            }),
        }
        let mut tally = Tally::default();
        for (&count, (&generated, &gone)) in
            ends.iter().zip(counts.generated.iter().zip(&counts.gone))
        {
            tally.pixel(generated, gone, count as usize, 0);
        }
        output.tally.merge(&tally);
        output.column = Column::Keys(keys);
        output.counts = ends;
    }

    /// Sort and composite every pixel's keys; `ends` becomes how many there are. `color` knows the colour of a key of a
    /// pixel of the tile.
    #[inline]
    fn sorted(
        job: &Job<'_>,
        colors: &mut Vec<[u8; 4]>,
        keys: &mut [u64],
        ends: &mut [u32],
        color: impl Fn(u32, u64) -> u32,
    ) {
        let mut begin = 0;
        for end in ends.iter_mut() {
            job.sort.keys(&mut keys[begin as usize..*end as usize]);
            begin = std::mem::replace(end, *end - begin);
        }
        // From here on, `ends` are numbers of entries.
        let nothing = Ray::default().finish(job.background);
        wide(
            #[inline(always)]
            || {
                let mut first = 0;
                for (counts, local) in ends.chunks(RAYS).zip((0..).step_by(RAYS)) {
                    let starts: [usize; RAYS] = std::array::from_fn(|i| {
                        let start = first;
                        first += counts.get(i).map_or(0, |&count| count as usize);
                        start
                    });
                    let counts: [u32; RAYS] =
                        std::array::from_fn(|i| counts.get(i).copied().unwrap_or(0));
                    let longest = counts.iter().copied().max().unwrap_or(0);
                    if longest == 0 {
                        colors.extend([nothing; RAYS]);
                        continue;
                    }
                    let mut rays = Rays::default();
                    for entry in 0..longest {
                        rays.over(std::array::from_fn(|i| {
                            let own = entry < counts[i];
                            let key = if own { keys[starts[i] + entry as usize] } else { 0 };
                            if own { color(local + i as u32, key) } else { 0 }
                        }));
                        if rays.are_opaque() {
                            break;
                        }
                    }
                    colors.extend(rays.finish(job.background));
                }
            },
        );
    }

    /// What is one fragment each, and how many fragments were merged into others.
    #[inline]
    fn singles<T: Single>(
        &mut self,
        all: &mut [T],
        scale: Scale,
        generated: u32,
        gone: u32,
        merged: u32,
    ) {
        self.job.sort.run(all);
        let mut ray = Ray::default();
        for one in all.iter() {
            ray.over(self.color(one.key()));
            if ray.is_opaque() {
                break;
            }
        }
        match &mut self.output.column {
            Column::Keys(keys) => keys.extend(all.iter().map(|one| one.key())),
            Column::Records(records) => records.singles(all, scale),
            Column::Lights(_) | Column::Depths(_) => {}
        }
        self.output.colors.push(ray.finish(self.job.background));
        self.output.counts.push(all.len() as u32);
        self.output.tally.pixel(generated, gone, all.len(), merged);
    }

    /// Merged records. Those of one fragment are sorted and composited as fragments are, which gives the same.
    fn records(&mut self, records: &mut Records, generated: u32, gone: u32) {
        if !records.wholes.is_empty() {
            records.unite();
        }
        let Records { list, surfaces, wholes, scale, merged } = records;
        let scale = *scale;
        match (list.is_empty(), wholes.is_empty()) {
            (true, true) => self.singles(surfaces, scale, generated, gone, *merged),
            (true, false) => self.singles(wholes, scale, generated, gone, *merged),
            (false, true) => self.mixed(list, (surfaces, scale), generated, gone, *merged),
            (false, false) => self.mixed(list, (wholes, scale), generated, gone, *merged),
        }
    }

    /// Records among which there are some of one fragment.
    fn mixed<T: Single>(
        &mut self,
        list: &mut [Record],
        (singles, scale): (&mut [T], Scale),
        generated: u32,
        gone: u32,
        merged: u32,
    ) {
        self.job.sort.run(singles);
        list.sort_unstable();
        let Column::Records(all) = &mut self.output.column else { return };
        let (mut ray, mut rest) = (Ray::default(), &*singles);
        for record in list.iter().map(Some).chain([None]) {
            let is_before = |one: T| record.is_none_or(|record| is_before(one, scale, record));
            let (before, behind) = rest.split_at(rest.partition_point(|&one| is_before(one)));
            before.iter().for_each(|one| ray.over(data_of(one.key())));
            all.singles(before, scale);
            rest = behind;
            if let Some(record) = record {
                ray.over_record(record);
                all.record(*record);
            }
        }
        let count = list.len() + singles.len();
        self.output.colors.push(ray.finish(self.job.background));
        self.output.counts.push(count as u32);
        self.output.tally.pixel(generated, gone, count, merged);
    }

    /// A colour or a depth.
    #[inline(never)]
    fn other(&mut self, held: &Held, generated: u32, gone: u32) {
        let mut ray = Ray::default();
        match (held, &mut self.output.column) {
            (Held::Light(light), Column::Lights(all)) => {
                ray = Ray::of_light(light);
                all.push(*light);
            }
            (Held::Depth(depth), Column::Depths(all)) => {
                ray = Ray::of_depth(*depth);
                all.push(*depth);
            }
            _ => {}
        }
        self.output.colors.push(ray.finish(self.job.background));
        self.output.counts.push(0);
        self.output.tally.pixel(generated, gone, held.len(), 0);
    }

    #[inline]
    fn color(&self, key: u64) -> u32 {
        match self.job.record.data {
            Data::Color | Data::Nothing => data_of(key),
            Data::Primitive => {
                let local = self.output.counts.len() as u32;
                let (x, y) = self.job.front.grid.position(self.tile, local);
                self.job.front.color_of(data_of(key), x, y, depth_of(key))
            }
        }
    }

    /// All pixels are in; `reports` is what the tile's invocations reported.
    #[must_use]
    pub fn finish(mut self, reports: &Tally) -> TileOutput {
        self.output.tally.merge(reports);
        if self.job.picture_only {
            self.output.column = Column::default();
        }
        self.output
    }
}

/// Whether a fragment comes before a record in canonical order.
#[inline]
fn is_before(one: impl Single, scale: Scale, record: &Record) -> bool {
    match depth_of(one.key()).cmp(&record.depth) {
        Ordering::Equal => one.record(scale) < *record,
        order => order == Ordering::Less,
    }
}

/// Resolve a tile's pixels, the first of which is `first` in memory.
#[must_use]
pub fn resolve_tile<M>(
    scheme: &dyn Pipeline<M>,
    mem: &M,
    first: u32,
    counts: &PixelCounts,
    mut finisher: Finisher<'_>,
    reports: &Tally,
) -> TileOutput {
    finisher.reserve(&counts.generated);
    let pixels = first..first + counts.generated.len() as u32;
    if let Column::Keys(keys) = &mut finisher.output.column {
        // Lists are resolved straight into the tile's column.
        let mut held = Held::Keys(std::mem::take(keys));
        let mut ends = std::mem::take(&mut finisher.output.counts);
        scheme.resolve_all(mem, pixels, &mut held, Some(&mut ends));
        if let Held::Keys(keys) = held {
            finisher.lists(keys, ends, counts);
        }
        return finisher.finish(reports);
    }
    let mut held = finisher.job.holds.empty();
    for (pixel, (&generated, &gone)) in pixels.zip(counts.generated.iter().zip(&counts.gone)) {
        held.clear();
        scheme.resolve(mem, pixel, &mut held);
        finisher.pixel(&mut held, generated, gone);
    }
    finisher.finish(reports)
}

/// As [`resolve_tile`], from what was collected over several rounds.
pub fn collected_tile(
    collected: &mut [Held],
    counts: &PixelCounts,
    mut finisher: Finisher<'_>,
    reports: &Tally,
) -> TileOutput {
    for (held, (&generated, &gone)) in
        collected.iter_mut().zip(counts.generated.iter().zip(&counts.gone))
    {
        finisher.pixel(held, generated, gone);
    }
    finisher.finish(reports)
}
