//! The same scheme on the simulator and on a device, alternating: clear, all geometry passes, resolve and composite,
//! with the same fragments. What is set up once for a scene (triangles, buffers, pipelines) is not timed on either
//! side, and neither is what is fetched or compared.
//!
//! Where a buffer would be larger than a device's bindings may be, the picture is split into bands of rows, as for a
//! comparison. All of them stay on the device, and a frame is all of them, one after another.

use super::crosscheck::record;
use super::split::split;
use crate::exec::clock::Stopwatch;
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::Result;
use crate::gpu::twin::band::Band;
use crate::gpu::twin::picture::Picture;
use crate::gpu::twin::program::Program;
use crate::gpu::twin::raster::{self, Raster, Triangles};
use crate::gpu::twin::resolve::Resolve;
use crate::gpu::twin::shape::{Shape, constants};
use crate::gpu::twin::source::Twin;

/// A scene on a device, ready to be drawn repeatedly.
#[derive(Debug)]
pub struct Contender<'d> {
    parts: Vec<Part<'d>>,
    k: Option<u32>,
}

/// One of the bands that it is split into.
#[derive(Debug)]
struct Part<'d> {
    band: Band<'d>,
    triangles: Triangles,
    program: Program<'d>,
}

/// A part with the passes that draw it.
struct Stage<'a, 'd> {
    raster: Raster<'a, 'd>,
    resolve: Resolve<'a, 'd>,
}

impl<'d> Contender<'d> {
    /// Set everything up, in as few bands as the device has room for, and draw each once.
    ///
    /// # Errors
    /// The device lacks something, has no room even for one row of tiles, or fails.
    pub fn new(
        device: &'d Device,
        picture: &'d Picture,
        twin: Twin,
        k: Option<u32>,
    ) -> Result<Self> {
        raster::knows_fragments_of(twin.method.contract())?;
        let mut parts = Vec::new();
        split(&picture.whole(), &mut |band| {
            let part = Part::new(device, band, twin, k)?;
            part.stage(k)?.frame()?;
            parts.push(part);
            Ok(())
        })?;
        Ok(Self { parts, k })
    }

    /// Bands that a frame is drawn in.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Fragments of a frame.
    #[must_use]
    pub fn fragments(&self) -> u64 {
        self.parts.iter().map(|part| part.band.fragments()).sum()
    }

    /// Seconds of `runs` frames, after one that is not timed: of all bands together.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn seconds(&self, runs: u32, mut between: impl FnMut()) -> Result<Vec<f64>> {
        let stages: Vec<Stage<'_, 'd>> =
            self.parts.iter().map(|part| part.stage(self.k)).collect::<Result<_>>()?;
        let frame = || stages.iter().try_for_each(Stage::frame);
        frame()?;
        let mut seconds = Vec::new();
        for _ in 0..runs {
            between();
            let mut watch = Stopwatch::start();
            frame()?;
            watch.lap("frame");
            seconds.push(watch.seconds().values().sum());
        }
        Ok(seconds)
    }
}

impl<'d> Part<'d> {
    fn new(device: &'d Device, band: &Band<'d>, twin: Twin, k: Option<u32>) -> Result<Self> {
        let contract = twin.method.contract();
        let record = record(contract);
        let shape = Shape::new(twin.method, band.config(contract, k))?;
        let constants = constants(&shape, record, band.picture.background);
        let program = Program::new(device, twin, shape, constants)?;
        // Large submissions: a twin that waits must not be timed with our caution.
        let triangles = Triangles::new(band, record, false);
        Ok(Self { band: band.clone(), triangles, program })
    }

    fn stage(&self, k: Option<u32>) -> Result<Stage<'_, 'd>> {
        let twin = self.program.twin;
        let expected = self.band.expected(twin.method, record(self.program.shape.contract), k);
        let starts = expected.starts();
        let raster = Raster::new(&self.program, &self.band, &self.triangles)?;
        let resolve = Resolve::new(&self.program, &self.band.picture.palette, starts)?;
        Ok(Stage { raster, resolve })
    }
}

impl Stage<'_, '_> {
    fn frame(&self) -> Result<()> {
        self.resolve.frame(|function| self.raster.draw(function)).map(drop)
    }
}
