//! What draws a band with a twin: a device, or in tests a double of one.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::gpu::driver::device::{AdapterName, Device};
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::twin::band::Band;
use crate::gpu::twin::expected::Expected;
use crate::gpu::twin::program::Program;
use crate::gpu::twin::raster::{self, Raster, Triangles};
use crate::gpu::twin::resolve::{Downloaded, draw};
use crate::gpu::twin::shape::{Shape, constants};
use crate::gpu::twin::source::Twin;
use crate::raster::Record;

/// How fragments reach the store pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Path {
    /// The device rasterizes; a fragment shader stores.
    Raster,
    /// The simulator's own fragments are uploaded; a compute shader stores.
    Compute,
}

impl Path {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Raster, Self::Compute];
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Raster => "raster",
            Self::Compute => "compute",
        })
    }
}

/// A band to be drawn.
#[derive(Debug)]
pub struct Job<'a> {
    /// With this twin.
    pub twin: Twin,
    /// Its fragments come this way.
    pub path: Path,
    /// `-k`.
    pub k: Option<u32>,
    /// The compute path's order: submission, or shuffled by this seed.
    pub shuffle: Option<u64>,
    /// What is stored of a fragment.
    pub record: Record,
    /// The scene's name.
    pub scene: &'a str,
    /// The band.
    pub band: &'a Band<'a>,
    /// What its pixels must hold: how much room there must be for results.
    pub expected: &'a Expected,
}

/// What came of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// The results.
    pub got: Downloaded,
    /// Fragments of the raster path that took the compute path.
    pub by_compute: u64,
    /// Invocations that gave up waiting for a lock and were rerun on the compute path.
    pub repeated: u64,
}

/// Draws bands.
pub trait Backend {
    /// Its name.
    fn name(&self) -> &AdapterName;

    /// Whether it can no longer be used.
    fn is_lost(&self) -> bool;

    /// Whether the method's twin can be run at all on this path.
    ///
    /// # Errors
    /// It cannot.
    fn can(&self, twin: Twin, path: Path) -> Result<()>;

    /// Draw a band.
    ///
    /// # Errors
    /// The device lacks something, has no room, fails, or is lost.
    fn draw(&self, job: &Job<'_>) -> Result<Drawn>;
}

impl Backend for Device {
    fn name(&self) -> &AdapterName {
        &self.name
    }

    fn is_lost(&self) -> bool {
        Self::is_lost(self)
    }

    fn can(&self, twin: Twin, path: Path) -> Result<()> {
        if path == Path::Raster {
            raster::knows_fragments_of(twin.method.contract())?;
        }
        if twin.needs_atomics64() && !self.atomics64 {
            return Err(Failure::Unsupported("no atomic operations on 64 bits".to_owned()));
        }
        Ok(())
    }

    fn draw(&self, job: &Job<'_>) -> Result<Drawn> {
        let contract = job.twin.method.contract();
        let (band, record) = (job.band, job.record);
        let shape = Shape::new(job.twin.method, band.config(contract, job.k))?;
        shape.fits(self)?;
        let constants = constants(&shape, record, band.picture.background);
        let program = Program::new(self, job.twin, shape, constants)?;
        let (palette, starts) = (&band.picture.palette, job.expected.starts());
        let mut by_compute = 0;
        let got = match job.path {
            Path::Compute => {
                let fragments = band.stream(contract, record, job.shuffle);
                draw(&program, palette, starts, |function| program.compute(function, &fragments))?
            }
            Path::Raster => {
                let triangles = Triangles::new(band, record, job.twin.waits());
                let raster = Raster::new(&program, band, &triangles)?;
                by_compute = triangles.rest.len() as u64;
                draw(&program, palette, starts, |function| raster.draw(function))?
            }
        };
        Ok(Drawn { got, by_compute, repeated: program.again() })
    }
}
