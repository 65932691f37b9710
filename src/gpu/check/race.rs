//! The same scheme on the simulator and on a device, alternating: clear, all geometry passes, resolve and composite,
//! with the same fragments. What is set up once for a scene (triangles, buffers, pipelines) is not timed on either
//! side, and neither is what is fetched or compared.

use super::crosscheck::record;
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

/// A scene on a device, ready to be drawn repeatedly. It must fit the device as a whole.
#[derive(Debug)]
pub struct Contender<'d> {
    band: Band<'d>,
    triangles: Triangles,
    program: Program<'d>,
}

impl<'d> Contender<'d> {
    /// Set everything up.
    ///
    /// # Errors
    /// The device lacks something, or the scene does not fit it as a whole.
    pub fn new(
        device: &'d Device,
        picture: &'d Picture,
        twin: Twin,
        k: Option<u32>,
    ) -> Result<Self> {
        let contract = twin.method.contract();
        raster::knows_fragments_of(contract)?;
        let band = picture.whole();
        let record = record(contract);
        let shape = Shape::new(twin.method, band.config(contract, k))?;
        let constants = constants(&shape, record, picture.background);
        let program = Program::new(device, twin, shape, constants)?;
        // Large submissions: a twin that waits must not be timed with our caution.
        let triangles = Triangles::new(&band, record, false);
        Ok(Self { band, triangles, program })
    }

    /// Seconds of `runs` frames, after one that is not timed.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn seconds(
        &self,
        k: Option<u32>,
        runs: u32,
        mut between: impl FnMut(),
    ) -> Result<Vec<f64>> {
        let contract = self.program.shape.contract;
        let expected = self.band.expected(self.program.twin.method, record(contract), k);
        let starts = expected.starts();
        let raster = Raster::new(&self.program, &self.band, &self.triangles)?;
        let resolve = Resolve::new(&self.program, &self.band.picture.palette, starts)?;
        let frame = || resolve.frame(|function| raster.draw(function));
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
