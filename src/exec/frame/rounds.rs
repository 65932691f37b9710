//! What a tile's pixels hold from all rounds of a program that repeats.

use std::ops::Range;

use super::finish::Finisher;
use super::{PixelCounts, TileOutput};
use crate::exec::Job;
use crate::exec::account::Tally;
use crate::exec::drive::{Ends, Pipeline};
use crate::scheme::{Held, HeldKind};

/// What a tile's pixels hold from all rounds so far.
#[derive(Debug, Default)]
pub struct Rounds {
    /// Lists of fragments, round by round: all pixels' one after another, so that no pixel needs a list of its own.
    /// Those from `lists` on are room for later ones.
    rounds: Vec<(Held, Ends)>,
    lists: usize,
    /// Anything else, pixel by pixel.
    pixels: Vec<Held>,
}

impl Rounds {
    /// For another tile of so many pixels.
    pub fn reset(&mut self, holds: HeldKind, pixels: usize) {
        self.lists = 0;
        self.pixels.clear();
        if holds != HeldKind::Fragments {
            self.pixels.resize(pixels, holds.empty());
        }
    }

    /// Resolve a round; whether a pixel needs another one.
    pub fn resolve<M>(&mut self, scheme: &dyn Pipeline<M>, mem: &M, pixels: Range<u32>) -> bool {
        if !self.pixels.is_empty() {
            let all = pixels.zip(&mut self.pixels);
            return all.fold(false, |again, (p, held)| scheme.resolve(mem, p, held) | again);
        }
        if self.lists == self.rounds.len() {
            self.rounds.push((HeldKind::Fragments.empty(), Ends::default()));
        }
        let (held, ends) = &mut self.rounds[self.lists];
        self.lists += 1;
        held.clear();
        ends.entries.clear();
        scheme.resolve_all(mem, pixels, held, Some(ends))
    }

    /// The tile's output.
    #[must_use]
    pub fn finish(
        &self,
        job: &Job<'_>,
        tile: usize,
        counts: PixelCounts,
        reports: &Tally,
    ) -> TileOutput {
        let mut finisher = Finisher::new(job, tile);
        if self.pixels.is_empty() {
            finisher.lists(&self.rounds[..self.lists], counts);
        } else {
            let counts = counts.generated.iter().zip(&counts.gone);
            for (held, (&generated, &gone)) in self.pixels.iter().zip(counts) {
                finisher.pixel(held, generated, gone);
            }
        }
        finisher.finish(reports)
    }
}
