//! Which primitives may touch which tile.
//!
//! The thread that sets up a part also sorts its primitives by row of tiles: they are in its cache then. After that, one
//! thread bins each row of tiles. It goes through the row's primitives in submission order. Threads share no counter
//! and no list.

use rayon::prelude::*;

use super::super::grid::Grid;
use super::super::primitive::{Primitive, Rect};
use super::{PART, PART_BITS};

/// A part's primitives by row of tiles.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// The first row that any of them touches.
    first: u32,
    /// Row `first + r` has `touched[ends[r - 1]..ends[r]]`, from 0 on.
    ends: Vec<u32>,
    touched: Vec<Touched>,
}

/// A primitive that may touch tiles of a row.
#[derive(Clone, Copy, Debug, Default)]
struct Touched {
    /// Its place in its part.
    at: u16,
    /// The first and the last column of tiles.
    columns: [u16; 2],
}

const _: () = assert!(PART <= 1 << u16::BITS, "a place in a part is a u16");

impl Rows {
    /// Sort primitives by the rows of tiles that they touch. Their bounds lie in the image, and are not empty.
    pub(super) fn sort(&mut self, primitives: &[Primitive], grid: &Grid) {
        // Tiles are powers of two.
        let edge = grid.tile.trailing_zeros();
        let rows = |bounds: Rect| (bounds.y0 >> edge, (bounds.y1 - 1) >> edge);
        let all = || primitives.iter().map(|p| p.bounds);
        let ends = |(first, last): (u32, u32), bounds: Rect| {
            let (from, to) = rows(bounds);
            (first.min(from), last.max(to))
        };
        let (first, last) = all().fold((u32::MAX, 0), ends);
        let first = first.min(last);
        self.first = first;
        self.ends.clear();
        self.ends.resize((last - first) as usize + 2, 0);
        // Counts, one place ahead, become where rows begin, and by filling them, where they end.
        for bounds in all() {
            let (from, to) = rows(bounds);
            (from..=to).for_each(|row| self.ends[(row - first) as usize + 1] += 1);
        }
        let mut sum = 0;
        for end in &mut self.ends {
            sum += *end;
            *end = sum;
        }
        self.touched.clear();
        self.touched.resize(sum as usize, Touched::default());
        for (at, bounds) in (0..).zip(all()) {
            let (from, to) = rows(bounds);
            let columns = [bounds.x0 >> edge, (bounds.x1 - 1) >> edge].map(|c| c as u16);
            for row in from..=to {
                let next = &mut self.ends[(row - first) as usize];
                self.touched[*next as usize] = Touched { at, columns };
                *next += 1;
            }
        }
        self.ends.pop();
    }

    fn of(&self, row: u32) -> &[Touched] {
        let Some(at) = row.checked_sub(self.first).map(|at| at as usize) else { return &[] };
        let Some(&end) = self.ends.get(at) else { return &[] };
        let start = if at == 0 { 0 } else { self.ends[at - 1] };
        &self.touched[start as usize..end as usize]
    }
}

/// The bins of all tiles.
#[derive(Debug)]
pub(super) struct Bins {
    columns: usize,
    rows: Vec<Row>,
}

/// The bins of a row of tiles: that of column c is `binned[starts[c]..starts[c + 1]]`.
#[derive(Debug, Default)]
pub(super) struct Row {
    starts: Vec<usize>,
    binned: Vec<u32>,
}

impl Bins {
    /// Of parts, in their order; `room` gives an empty row.
    pub(super) fn new(parts: &[&Rows], grid: &Grid, room: impl Fn() -> Row + Sync) -> Self {
        let columns = grid.columns() as usize;
        let rows = (grid.tiles() / columns.max(1)) as u32;
        let row = |row: u32| {
            let mut bins = room();
            bins.fill(parts, row, columns);
            bins
        };
        Self { columns, rows: (0..rows).into_par_iter().map(row).collect() }
    }

    /// The indices of the primitives that may touch a tile, in submission order.
    #[inline]
    pub(super) fn of(&self, tile: usize) -> &[u32] {
        let (row, column) = (&self.rows[tile / self.columns], tile % self.columns);
        &row.binned[row.starts[column]..row.starts[column + 1]]
    }

    /// The room that it takes.
    pub(super) fn leave(self) -> Vec<Row> {
        self.rows
    }
}

impl Row {
    fn fill(&mut self, parts: &[&Rows], row: u32, columns: usize) {
        let each = |visit: &mut dyn FnMut(u32, &[Touched])| {
            for (part, at) in parts.iter().zip(0u32..) {
                visit(at << PART_BITS, part.of(row));
            }
        };
        let starts = &mut self.starts;
        starts.resize(columns + 2, 0);
        // As above, but two places ahead, so that the starts of all columns and the end of the last are left.
        each(&mut |_, touched| {
            for &Touched { columns: [from, to], .. } in touched {
                (from..=to).for_each(|column| starts[usize::from(column) + 2] += 1);
            }
        });
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        self.binned.resize(sum, 0);
        each(&mut |first, touched| {
            for &Touched { at, columns: [from, to] } in touched {
                for column in from..=to {
                    let next = &mut starts[usize::from(column) + 1];
                    self.binned[*next] = first + u32::from(at);
                    *next += 1;
                }
            }
        });
        starts.pop();
    }

    pub(super) fn emptied(mut self) -> Self {
        self.starts.clear();
        self.binned.clear();
        self
    }
}
