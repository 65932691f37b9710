//! `fragloom adapters`: the available devices.

use crate::cli::Verdict;
use crate::cli::terminal::say;
use crate::error::Result;
use crate::gpu::check::open;
use crate::gpu::driver::device::{self, Device};
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::raster;
use crate::report::json;
use crate::report::text::{Align, columns};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Print one JSON document instead of the table
    #[arg(long)]
    json: bool,
}

/// The properties of an adapter that matter here.
#[derive(Debug, serde::Serialize)]
struct Traits {
    #[serde(flatten)]
    name: device::AdapterName,
    /// Measured.
    sub_pixel_bits: Option<u32>,
    atomics64: bool,
    largest_buffer: u64,
    problem: Option<String>,
}

/// Print the available adapters.
///
/// # Errors
/// No adapter is available.
pub(in crate::cli) fn run(args: &Args) -> Result<Verdict> {
    let found = device::adapters();
    if found.is_empty() {
        return Err(open::none(None));
    }
    let rows: Vec<Traits> = found.iter().map(adapter).collect();
    if args.json {
        say::result(&json::document(&rows)?)?;
        return Ok(Verdict::Clean);
    }
    let heading =
        ["adapter", "driver", "backend", "kind", "sub-pixel bits", "64-bit atomics", "problem"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(rows.iter().map(|row| {
        let bits = row.sub_pixel_bits.map_or("?".to_owned(), |bits| bits.to_string());
        let atomics = if row.atomics64 { "yes" } else { "no" };
        let device::AdapterName { name, driver, backend, kind } = row.name.clone();
        let problem = row.problem.clone().unwrap_or_default();
        vec![name, driver, backend, kind, bits, atomics.to_owned(), problem]
    }));
    use Align::{Left, Right};
    say::result(&columns(&[Left, Left, Left, Left, Right, Left, Left], &lines))?;
    Ok(Verdict::Clean)
}

fn adapter(adapter: &wgpu::Adapter) -> Traits {
    let measured: std::result::Result<(Device, u32), Failure> = Device::open(adapter)
        .and_then(|device| raster::sub_pixel_bits(&device).map(|bits| (device, bits)));
    let name = device::name(adapter);
    match measured {
        Ok((device, bits)) => Traits {
            name,
            sub_pixel_bits: Some(bits),
            atomics64: device.atomics64,
            largest_buffer: device.largest(),
            problem: None,
        },
        Err(failure) => Traits {
            name,
            sub_pixel_bits: None,
            atomics64: false,
            largest_buffer: 0,
            problem: Some(failure.to_string()),
        },
    }
}
