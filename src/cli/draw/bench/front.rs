//! The front end alone: coverage, and fragments that nothing stores.

use std::hint::black_box;

use rayon::prelude::*;

use super::stats::timed;
use crate::error::{Error, Result};
use crate::raster::slab::Slabs;
use crate::raster::{Batch, CullFace, FrontEnd, Grid, Record};
use crate::render::Options;
use crate::scene::Scene;
use crate::scheme::contract::Extra;

/// A scene's front end as a run has it, and a pool of as many threads.
pub(super) struct Front {
    front: FrontEnd,
    record: Record,
    pool: rayon::ThreadPool,
}

impl Front {
    /// Set up and bin.
    ///
    /// # Errors
    /// So many threads cannot be started.
    pub(super) fn new(scene: &Scene, options: &Options) -> Result<Self> {
        let threads = options.worker_threads();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool =
            pool.map_err(|e| Error::new("--threads", format!("cannot start {threads}: {e}")))?;
        let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
        let front = pool
            .install(|| FrontEnd::new(scene, grid, options.sub_pixel_bits, CullFace::default()));
        let front = match options.method.contract().extra {
            Extra::Near => front.thick(Slabs::new(scene, options.thickness)),
            Extra::Primitive => front.numbered(),
            Extra::Nothing | Extra::Rank => front,
        };
        Ok(Self { front, record: options.record(), pool })
    }

    /// Seconds for the masks of all fragments; and how many there are.
    pub(super) fn coverage(&self) -> (f64, u64) {
        self.pool.install(|| timed(|| self.front.count_fragments().iter().sum()))
    }

    /// Seconds for the masks, depths and data words of all fragments, of which nothing is stored; and how many there
    /// are.
    pub(super) fn emit(&self) -> (f64, u64) {
        let tile = |batch: &mut Batch, tile: usize| {
            let mut sum = 0;
            self.front.packets(tile, |packet| {
                self.front.fragments(packet, self.record, 0, batch);
                sum += u64::from(black_box(&*batch).mask().count_ones());
            });
            sum
        };
        let tiles = 0..self.front.grid.tiles();
        self.pool.install(|| timed(|| tiles.into_par_iter().map_init(Batch::default, tile).sum()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{self, Overrides};

    #[test]
    fn coverage_and_emission_see_every_fragment() {
        let overrides = Overrides { size: Some([70, 40]), ..Overrides::default() };
        let scene = scene::load("layers:count=3", &overrides).expect("a built-in scene");
        for name in ["ab-ll", "dfb", "ha64"] {
            let method = crate::catalogue::method(name).expect("a built-in method");
            let options = Options { method, threads: 2, ..Options::default() };
            let front = Front::new(&scene, &options).expect("two threads");
            assert_eq!([front.coverage().1, front.emit().1], [3 * 70 * 40; 2], "{name}");
        }
    }
}
