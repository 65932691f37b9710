//! Tiles joined row by row.

use rayon::prelude::*;

use super::{Column, Frame, TileOutput};
use crate::fragment::BLOCK;
use crate::image::Image;
use crate::raster::Grid;
use crate::resolve::digest::{Part, Stream};
use crate::resolve::{Kept, Lists};
use crate::scheme::{Depth, Light};

impl Frame {
    /// What the pixels hold, and the picture, row by row.
    #[must_use]
    pub fn assemble(&self, grid: &Grid) -> (Kept, Image) {
        let tiles = &self.tiles;
        let (kept, pixels) = match tiles.first().map(|tile| &tile.column) {
            Some(Column::Records(_)) => {
                let (lists, pixels) = join(tiles, grid, |column, first, out| {
                    if let Column::Records(records) = column {
                        records.copy(first, out);
                    }
                });
                (Kept::Records(lists), pixels)
            }
            Some(Column::Lights(_)) => {
                let (_, pixels) = join::<u64>(tiles, grid, |_, _, _| ());
                let light = |column: &Column, i: usize| match column {
                    Column::Lights(lights) => lights[i],
                    _ => Light::default(),
                };
                (Kept::Color(each(tiles, grid, light)), pixels)
            }
            Some(Column::Depths(_)) => {
                let (_, pixels) = join::<u64>(tiles, grid, |_, _, _| ());
                let depth = |column: &Column, i: usize| match column {
                    Column::Depths(depths) => depths[i],
                    _ => Depth::default(),
                };
                (Kept::Depths(each(tiles, grid, depth)), pixels)
            }
            Some(Column::Keys(_)) | None => {
                let (lists, pixels) = join(tiles, grid, |column, first, out| {
                    out.copy_from_slice(&column.keys()[first..first + out.len()]);
                });
                (Kept::Fragments(lists), pixels)
            }
        };
        (kept, Image { width: grid.width, height: grid.height, pixels })
    }
}

impl Frame {
    /// The picture alone.
    #[must_use]
    pub fn picture(&self, grid: &Grid) -> Image {
        let mut pixels = vec![[0u8; 4]; grid.width as usize * grid.height as usize];
        let rows = pixels.par_chunks_mut((grid.tile * grid.width) as usize);
        rows.zip(self.tiles.par_chunks(grid.columns() as usize)).for_each(|(pixels, tiles)| {
            let lines = pixels.chunks_mut(grid.width as usize);
            for (y, line) in (0..).zip(lines) {
                // The pixels of a line in a block lie side by side in storage.
                let blocks = line.chunks_mut(BLOCK as usize);
                for (x, part) in (0..).step_by(BLOCK as usize).zip(blocks) {
                    let local = grid.local_pixel(x, y) as usize;
                    let colors = &tiles[(x / grid.tile) as usize].colors;
                    part.copy_from_slice(&colors[local..local + part.len()]);
                }
            }
        });
        Image { width: grid.width, height: grid.height, pixels }
    }

    /// The hash of the lists of fragments ([`crate::resolve::digest::fragments_hash`]) or merged records
    /// ([`crate::resolve::digest::records_hash`]), if that is what pixels hold. Lists are not joined for it.
    #[must_use]
    pub fn lists_hash(&self, grid: &Grid) -> Option<String> {
        let starts: Vec<Vec<u32>> = self.tiles.iter().map(starts).collect();
        // The pixels of a line in a block lie side by side in storage, and so do their entries.
        let lines = (0..grid.height)
            .flat_map(|y| (0..grid.width).step_by(BLOCK as usize).map(move |x| (x, y)))
            .map(|(x, y)| {
                let tile = (y / grid.tile * grid.columns() + x / grid.tile) as usize;
                let first = grid.local_pixel(x, y) as usize;
                let last = first + (grid.width - x).min(BLOCK) as usize - 1;
                let TileOutput { counts, column, .. } = &self.tiles[tile];
                let ends =
                    starts[tile][first] as usize..(starts[tile][last] + counts[last]) as usize;
                (&counts[first..=last], column, ends)
            });
        let mut stream = Stream::new(grid.width, grid.height);
        let mut end = 0;
        stream.offsets(&[0]);
        for &count in lines.clone().flat_map(|(counts, ..)| counts) {
            end += u64::from(count);
            stream.offsets(&[end]);
        }
        match self.tiles.first().map_or(&Column::default(), |tile| &tile.column) {
            Column::Keys(_) => {
                let keys = lines.map(|(_, column, places)| &column.keys()[places]);
                keys.clone().for_each(|keys| stream.depths(keys));
                keys.for_each(|keys| stream.data(keys));
            }
            Column::Records(_) => {
                for part in Part::ALL {
                    for (_, column, places) in lines.clone() {
                        if let Column::Records(records) = column {
                            stream.records(part, places.map(|place| records.record(place)));
                        }
                    }
                }
            }
            Column::Lights(_) | Column::Depths(_) => return None,
        }
        Some(stream.finish())
    }
}

/// The tile of a row of tiles, and the place in its storage, of pixel `i` of the row, counted line by line.
#[inline]
fn place(grid: &Grid, i: usize) -> (usize, usize) {
    let (x, y) = (i as u32 % grid.width, i as u32 / grid.width);
    ((x / grid.tile) as usize, grid.local_pixel(x, y) as usize)
}

/// Lists and colours, row by row; `copy` reads a column's entries from a place on.
fn join<T: Copy + Default + Send + Sync>(
    tiles: &[TileOutput],
    grid: &Grid,
    copy: impl Fn(&Column, usize, &mut [T]) + Sync,
) -> (Lists<T>, Vec<[u8; 4]>) {
    let (width, height) = (grid.width, grid.height);
    let pixels = width as usize * height as usize;
    let total: usize = tiles.iter().map(entries_of).sum();
    let mut offsets = vec![0u64; pixels + 1];
    let mut entries = vec![T::default(); total];
    let mut colors = vec![[0u8; 4]; pixels];
    let band_pixels = (grid.tile * width) as usize;
    let mut rest = entries.as_mut_slice();
    let mut first_entry = 0;
    let mut bands = Vec::new();
    let rows = tiles.chunks(grid.columns() as usize);
    let parts = offsets[1..].chunks_mut(band_pixels).zip(colors.chunks_mut(band_pixels));
    for (row, (offsets, colors)) in rows.zip(parts) {
        let size = row.iter().map(entries_of).sum();
        let (entries, behind) = std::mem::take(&mut rest).split_at_mut(size);
        rest = behind;
        bands.push(Band { row, offsets, colors, entries, first_entry });
        first_entry += size as u64;
    }
    bands.into_par_iter().for_each(|band| band.fill(grid, &copy));
    (Lists { width, height, offsets, entries }, colors)
}

/// One row of tiles, on its way to row-major order.
struct Band<'a, T> {
    row: &'a [TileOutput],
    offsets: &'a mut [u64],
    colors: &'a mut [[u8; 4]],
    entries: &'a mut [T],
    first_entry: u64,
}

impl<T> Band<'_, T> {
    fn fill(self, grid: &Grid, copy: &impl Fn(&Column, usize, &mut [T])) {
        let starts: Vec<Vec<u32>> = self.row.iter().map(starts).collect();
        let mut end = 0usize;
        for (i, (offset, color)) in self.offsets.iter_mut().zip(self.colors).enumerate() {
            let (tile, local) = place(grid, i);
            let output = &self.row[tile];
            let start = starts[tile][local] as usize;
            let count = output.counts[local] as usize;
            copy(&output.column, start, &mut self.entries[end..end + count]);
            end += count;
            *offset = self.first_entry + end as u64;
            *color = output.colors[local];
        }
    }
}

/// How many entries a tile has.
fn entries_of(tile: &TileOutput) -> usize {
    tile.counts.iter().map(|&count| count as usize).sum()
}

/// Where each pixel's entries begin.
fn starts(tile: &TileOutput) -> Vec<u32> {
    let mut sum = 0;
    let start = |&count: &u32| {
        sum += count;
        sum - count
    };
    tile.counts.iter().map(start).collect()
}

/// What pixels hold that have one value each, row by row.
fn each<T>(tiles: &[TileOutput], grid: &Grid, value: impl Fn(&Column, usize) -> T) -> Vec<T> {
    let pixels = (0..grid.height).flat_map(|y| (0..grid.width).map(move |x| (x, y)));
    let of = |(x, y): (u32, u32)| {
        let tile = (y / grid.tile * grid.columns() + x / grid.tile) as usize;
        value(&tiles[tile].column, grid.local_pixel(x, y) as usize)
    };
    pixels.map(of).collect()
}
