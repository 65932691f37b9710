//! A scene cut into pieces that threads set up.

use super::super::place::Placed;
use crate::scene::{Disc, ScreenTriangle};

/// Triangles or discs that follow each other.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    pub(super) source: Source<'a>,
    /// The global index of the first.
    pub(super) first: u32,
}

#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    /// Of an object.
    Triangles(&'a Placed<'a>, &'a [[u32; 3]]),
    /// Of an object.
    Discs(&'a Placed<'a>, &'a [Disc]),
    /// In pixels.
    Screen(&'a [ScreenTriangle]),
}

impl Piece<'_> {
    pub(super) fn len(&self) -> usize {
        match self.source {
            Source::Triangles(_, triangles) => triangles.len(),
            Source::Discs(_, discs) => discs.len(),
            Source::Screen(triangles) => triangles.len(),
        }
    }

    /// Cut off the first `n`, or all.
    pub(super) fn take(&mut self, n: usize) -> Self {
        let n = n.min(self.len());
        let (head, tail) = match self.source {
            Source::Triangles(placed, all) => {
                let (head, tail) = all.split_at(n);
                (Source::Triangles(placed, head), Source::Triangles(placed, tail))
            }
            Source::Discs(placed, all) => {
                let (head, tail) = all.split_at(n);
                (Source::Discs(placed, head), Source::Discs(placed, tail))
            }
            Source::Screen(all) => {
                let (head, tail) = all.split_at(n);
                (Source::Screen(head), Source::Screen(tail))
            }
        };
        let first = self.first;
        *self = Self { source: tail, first: first + n as u32 };
        Self { source: head, first }
    }
}
