//! The devices that take part, and the precision of their rasterizers.

use crate::error::{Error, Result};
use crate::gpu::check::crosscheck::{Options, Path};
use crate::gpu::driver::device::{self, AdapterName, Device};
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::raster;

/// An open device, and the sub-pixel bits that were measured on it.
#[derive(Debug)]
pub struct Opened {
    /// The device.
    pub device: Device,
    measured: std::result::Result<u32, Failure>,
}

impl Opened {
    /// The precision that vertices are snapped to for this device: the largest of ours that it supports.
    #[must_use]
    pub fn bits(&self) -> u32 {
        match self.measured {
            Ok(bits) if bits < 8 => 4,
            _ => 8,
        }
    }

    /// Why the raster path is impossible, if it is and was requested.
    #[must_use]
    pub fn no_raster(&self, options: &Options) -> Option<Failure> {
        if !options.paths.contains(&Path::Raster) {
            return None;
        }
        match &self.measured {
            Ok(bits) if *bits >= 4 => None,
            Ok(bits) => {
                let why = format!("vertices have {bits} sub-pixel bits, at least 4 are needed");
                Some(Failure::Unsupported(why))
            }
            Err(failure) => Some(failure.clone()),
        }
    }

    /// The options without what the device cannot do at all.
    #[must_use]
    pub fn paths(&self, options: &Options) -> Options {
        let mut options = options.clone();
        if self.no_raster(&options).is_some() {
            options.paths.retain(|&path| path != Path::Raster);
        }
        options
    }
}

/// The devices that take part, and the adapters that could not be opened.
#[derive(Debug, Default)]
pub struct Devices {
    /// Those that take part, at least one.
    pub opened: Vec<Opened>,
    /// Adapters that refused, and why.
    pub refused: Vec<String>,
}

/// The adapters whose name or driver contains `wanted`, or all, by the names that they have here: of those with the same
/// name and driver, the second is called `NAME (2)`, and so on.
fn named(wanted: Option<&str>) -> Vec<(AdapterName, wgpu::Adapter)> {
    let mut found = Vec::new();
    let mut names = Vec::new();
    for adapter in device::adapters() {
        let mut name = device::name(&adapter);
        let text = format!("{} {}", name.name, name.driver).to_lowercase();
        if wanted.is_some_and(|wanted| !text.contains(&wanted.to_lowercase())) {
            continue;
        }
        names.push(text.clone());
        let same = names.iter().filter(|&other| *other == text).count();
        if same > 1 {
            name.name += &format!(" ({same})");
        }
        found.push((name, adapter));
    }
    found
}

/// The names of the adapters that [`devices`] would open; none is opened.
///
/// # Errors
/// No adapter exists; the message says what would help.
pub fn names(wanted: Option<&str>) -> Result<Vec<AdapterName>> {
    let names: Vec<AdapterName> = named(wanted).into_iter().map(|(name, _)| name).collect();
    if names.is_empty() { Err(none(wanted)) } else { Ok(names) }
}

fn open(name: AdapterName, adapter: &wgpu::Adapter) -> std::result::Result<Opened, Failure> {
    let mut device = Device::open(adapter)?;
    device.name = name;
    let measured = raster::sub_pixel_bits(&device);
    Ok(Opened { device, measured })
}

/// Open the adapter that [`names`] gives this name and driver. Which of several equal ones is called `(2)` does not
/// depend on which are wanted.
///
/// # Errors
/// It refuses, or is not there any more.
pub fn one(name: &str, driver: &str) -> std::result::Result<Opened, Failure> {
    let is =
        |(known, _): &(AdapterName, wgpu::Adapter)| known.name == name && known.driver == driver;
    match named(None).into_iter().find(is) {
        Some((name, adapter)) => open(name, &adapter),
        None => Err(Failure::Lost("the adapter is not there any more".to_owned())),
    }
}

/// Open all adapters, or those whose name or driver contains `wanted`.
///
/// # Errors
/// No adapter exists or none can be opened; the message says what would help.
pub fn devices(wanted: Option<&str>) -> Result<Devices> {
    let mut found = Devices::default();
    for (name, adapter) in named(wanted) {
        let called = name.name.clone();
        match open(name, &adapter) {
            Ok(opened) => found.opened.push(opened),
            Err(failure) => found.refused.push(format!("{called}: {failure}")),
        }
    }
    match (found.opened.is_empty(), found.refused.first()) {
        (false, _) => Ok(found),
        (true, Some(refused)) => Err(Error::new("--adapter", refused.clone())),
        (true, None) => Err(none(wanted)),
    }
}

/// The error for a missing adapter.
#[must_use]
pub fn none(wanted: Option<&str>) -> Error {
    let help = "install a Vulkan driver: on Debian, mesa-vulkan-drivers (lavapipe), or chromium-common (SwiftShader; \
                VK_ADD_DRIVER_FILES=/usr/lib/chromium/vk_swiftshader_icd.json lets the loader find it)";
    match wanted {
        Some(wanted) => Error::new("--adapter", format!("no adapter is called '{wanted}'; {help}")),
        None => Error::new("--adapter", format!("no adapter is available; {help}")),
    }
}
