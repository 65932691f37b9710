//! From what a tile's pixels hold to sorted lists, colours and the accounting.

use std::ops::Range;

use super::{Column, PixelCounts, TileOutput};
use crate::exec::Job;
use crate::exec::account::Tally;
use crate::exec::drive::{Ends, Pipeline};
use crate::fragment::{Data, data_of, depth_of, places};
use crate::num::lanes::wide;
use crate::num::ray::Ray;
use crate::num::rays::{RAYS, Rays, pixels};
use crate::scheme::{Held, Records};

/// Pixels that are composited before any of them is encoded, in units of [`RAYS`].
const AT_ONCE: usize = 16;

/// Merged records of a pixel that room is made for: the `-k` that is usual.
const USUAL: u32 = 8;

/// Takes a tile's pixels in storage order: sorts, composites and accounts for them.
pub struct Finisher<'a> {
    job: &'a Job<'a>,
    tile: usize,
    output: TileOutput,
    /// The pixels' lists, one after another, in any order within a pixel.
    held: Held,
    /// Where they end.
    ends: Ends,
    counts: PixelCounts,
}

impl<'a> Finisher<'a> {
    /// For one tile.
    #[must_use]
    pub fn new(job: &'a Job<'a>, tile: usize) -> Self {
        let mut output = job.kit.tile(tile);
        let mut held = job.holds.empty();
        match (&mut held, std::mem::take(&mut output.column)) {
            (Held::Keys(own), Column::Keys(room)) => *own = room,
            (Held::Records(own), Column::Records(room)) => *own = room,
            (Held::Light(_), column @ Column::Lights(_))
            | (Held::Depth(_), column @ Column::Depths(_)) => output.column = column,
            (Held::Light(_), _) => output.column = Column::Lights(Vec::new()),
            (Held::Depth(_), _) => output.column = Column::Depths(Vec::new()),
            (Held::Keys(_) | Held::Records(_), _) => {}
        }
        let pixels = job.front.grid.pixels_per_tile();
        output.counts.reserve_exact(pixels);
        output.colors.reserve_exact(pixels);
        let entries = std::mem::take(&mut output.counts);
        let ends = Ends { entries, merged: Vec::new() };
        Self { job, tile, output, held, ends, counts: PixelCounts::default() }
    }

    /// Make room for the keys of a tile with these counts.
    fn reserve(&mut self, generated: &[u32]) {
        let first = self.tile * self.job.front.grid.pixels_per_tile();
        match &mut self.held {
            Held::Keys(keys) => {
                let most = |(i, &g): (usize, &u32)| self.job.nearest.cut(first + i, g as usize);
                keys.reserve_exact(generated.iter().enumerate().map(most).sum());
            }
            Held::Records(records) => {
                records.reserve(generated.iter().map(|&g| g.min(USUAL) as usize).sum());
            }
            Held::Light(_) | Held::Depth(_) => {}
        }
    }

    /// The next pixel: what it holds, lists in any order, and its counts.
    pub fn pixel(&mut self, held: &Held, generated: u32, gone: u32) {
        match (&mut self.held, held) {
            (Held::Keys(all), Held::Keys(keys)) => {
                all.extend_from_slice(keys);
                self.ends.push(all);
            }
            (Held::Records(all), Held::Records(records)) => {
                all.append(records);
                self.ends.push(all);
            }
            _ => return self.other(held, generated, gone),
        }
        self.counts.generated.push(generated);
        self.counts.gone.push(gone);
    }

    /// All pixels: their fragments of several rounds, each with where its pixels end.
    pub fn lists(&mut self, rounds: &[(Held, Ends)], counts: PixelCounts) {
        let Held::Keys(all) = &mut self.held else { return };
        let rounds: Vec<(&[u64], &[u32])> = rounds
            .iter()
            .filter_map(|(held, ends)| Some((held.keys()?, &*ends.entries)))
            .filter(|(keys, _)| !keys.is_empty())
            .collect();
        all.reserve_exact(rounds.iter().map(|(keys, _)| keys.len()).sum());
        let mut begins = vec![0; rounds.len()];
        for pixel in 0..counts.generated.len() {
            for ((keys, ends), begin) in rounds.iter().zip(&mut begins) {
                let end = ends[pixel] as usize;
                all.extend_from_slice(&keys[*begin..end]);
                *begin = end;
            }
            self.ends.push(all);
        }
        self.counts = counts;
    }

    /// All pixels of the tile: their fragments.
    fn keys(&mut self, mut keys: Vec<u64>) {
        let Self { job, tile, output, ends, .. } = self;
        let (grid, front) = (&job.front.grid, job.front);
        let colors = &mut output.colors;
        job.sort.lists(&mut keys, &ends.entries);
        let data = |_, place: usize| data_of(keys[place]);
        let slow = (|_: Range<usize>| false, |_: Range<usize>| Ray::default());
        match job.record.data {
            Data::Color | Data::Nothing => composite(job, colors, &ends.entries, data, slow),
            Data::Primitive => {
                let color = |local, place: usize| {
                    let (x, y) = grid.position(*tile, local);
                    front.color_of(data_of(keys[place]), x, y, depth_of(keys[place]))
                };
                composite(job, colors, &ends.entries, color, slow);
            }
        }
        output.column = Column::Keys(keys);
    }

    /// All pixels of the tile: their records. Those of one fragment are sorted and composited as fragments are, which
    /// gives the same.
    fn records(&mut self, mut records: Records) {
        let Self { job, output, ends, .. } = self;
        if !(job.picture_only && records.arrange_colors(&ends.entries, job.sort)) {
            places(&ends.entries).for_each(|own| records.arrange(own, |keys| job.sort.keys(keys)));
        }
        let data = |_, place: usize| data_of(records.key(place));
        let merged = |places: Range<usize>| !records.are_single(places);
        let ray = |places: Range<usize>| {
            let mut ray = Ray::default();
            for place in places {
                match records.merged_at(place) {
                    Some(record) => ray.over_record(record),
                    None => ray.over(data_of(records.key(place))),
                }
            }
            ray
        };
        composite(job, &mut output.colors, &ends.entries, data, (merged, ray));
        output.column = Column::Records(records);
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

    /// All pixels are in; `reports` is what the tile's invocations reported.
    #[must_use]
    pub fn finish(mut self, reports: &Tally) -> TileOutput {
        match std::mem::replace(&mut self.held, Held::Keys(Vec::new())) {
            Held::Keys(keys) => self.keys(keys),
            Held::Records(records) => self.records(records),
            Held::Light(_) | Held::Depth(_) => {}
        }
        let Self { job, mut output, ends, counts, .. } = self;
        if matches!(output.column, Column::Keys(_) | Column::Records(_)) {
            let Ends { mut entries, mut merged } = ends;
            differences(&mut entries);
            differences(&mut merged);
            output.tally.pixels([&counts.generated, &counts.gone, &entries], &merged);
            output.counts = entries;
        }
        output.tally.merge(reports);
        if job.picture_only {
            output.column = Column::default();
        }
        output
    }
}

/// From where each ends to how many each has.
fn differences(ends: &mut [u32]) {
    let mut before = 0;
    for end in ends {
        (before, *end) = (*end, *end - before);
    }
}

/// Composite every pixel's sorted entries, [`RAYS`] pixels at a time, of which a tile has a multiple. `color` knows the
/// colour of a pixel's entry in a place. Of some pixels' places together, `merged` knows whether any has more to it than a
/// colour; if so, `ray` knows how to composite one pixel's.
#[inline]
fn composite(
    job: &Job<'_>,
    colors: &mut Vec<[u8; 4]>,
    ends: &[u32],
    color: impl Fn(u32, usize) -> u32,
    (merged, ray): (impl Fn(Range<usize>) -> bool, impl Fn(Range<usize>) -> Ray),
) {
    let nothing = Rays::default().before(job.background);
    let mut first = 0;
    for (ends, local) in ends.chunks(AT_ONCE * RAYS).zip((0..).step_by(AT_ONCE * RAYS)) {
        let mut lights = [nothing; AT_ONCE];
        wide(
            #[inline(always)]
            || {
                let all = ends.as_chunks::<RAYS>().0.iter().zip((local..).step_by(RAYS));
                for (lights, (ends, local)) in lights.iter_mut().zip(all) {
                    let mut begins = [first; RAYS];
                    begins[1..].copy_from_slice(&ends[..RAYS - 1]);
                    first = ends[RAYS - 1];
                    let all = begins[0] as usize..first as usize;
                    if all.is_empty() {
                        continue;
                    }
                    if merged(all) {
                        for i in 0..RAYS {
                            let ray = ray(begins[i] as usize..ends[i] as usize);
                            let light = ray.before(job.background);
                            (0..3).for_each(|c| lights[c][i] = light[c]);
                        }
                        continue;
                    }
                    let rays = through(&begins, ends, |i, place| color(local + i as u32, place));
                    *lights = rays.before(job.background);
                }
            },
        );
        pixels(&lights[..ends.len() / RAYS]).for_each(|pixels| colors.extend(pixels));
    }
}

/// Rays through the entries of [`RAYS`] pixels, which have these places each.
#[allow(clippy::inline_always, reason = "see `lanes`")]
#[inline(always)]
fn through(begins: &[u32; RAYS], ends: &[u32; RAYS], color: impl Fn(usize, usize) -> u32) -> Rays {
    let counts: [u32; RAYS] = std::array::from_fn(|i| ends[i] - begins[i]);
    let (least, most) =
        counts.iter().fold((u32::MAX, 0), |(low, high), &n| (low.min(n), high.max(n)));
    let mut rays = Rays::default();
    for entry in 0..most {
        let mut words = [0; RAYS];
        // As long as all of them have one, nothing is asked.
        if entry < least {
            for i in 0..RAYS {
                words[i] = color(i, (begins[i] + entry) as usize);
            }
        } else {
            for i in 0..RAYS {
                if entry < counts[i] {
                    words[i] = color(i, (begins[i] + entry) as usize);
                }
            }
        }
        rays.over(words);
        if rays.are_opaque() {
            break;
        }
    }
    rays
}

/// Resolve a tile's pixels, the first of which is `first` in memory.
#[must_use]
pub fn resolve_tile<M>(
    scheme: &dyn Pipeline<M>,
    mem: &M,
    first: u32,
    counts: PixelCounts,
    mut finisher: Finisher<'_>,
    reports: &Tally,
) -> TileOutput {
    let pixels = first..first + counts.generated.len() as u32;
    if matches!(finisher.held, Held::Keys(_) | Held::Records(_)) {
        finisher.reserve(&counts.generated);
        let Finisher { held, ends, .. } = &mut finisher;
        // Lists are resolved straight into the tile's column.
        scheme.resolve_all(mem, pixels, held, Some(ends));
        finisher.counts = counts;
        return finisher.finish(reports);
    }
    let mut held = finisher.job.holds.empty();
    for (pixel, (&generated, &gone)) in pixels.zip(counts.generated.iter().zip(&counts.gone)) {
        held.clear();
        scheme.resolve(mem, pixel, &mut held);
        finisher.pixel(&held, generated, gone);
    }
    finisher.finish(reports)
}
