//! Which devices take part, and what their rasterizers are like.

use super::crosscheck::{Options, Path};
use super::device::{self, Device};
use super::failure::Failure;
use super::raster;
use crate::error::{Error, Result};

/// An open device, and the sub-pixel bits that were measured on it.
#[derive(Debug)]
pub struct Opened {
    /// The device.
    pub device: Device,
    measured: std::result::Result<u32, Failure>,
}

impl Opened {
    /// The precision that vertices are snapped to for this device: the largest of ours that it has.
    #[must_use]
    pub fn bits(&self) -> u32 {
        match self.measured {
            Ok(bits) if bits < 8 => 4,
            _ => 8,
        }
    }

    /// Why the raster path is out of question, if it is and was asked for.
    #[must_use]
    pub fn no_raster(&self, options: &Options) -> Option<String> {
        if !options.paths.contains(&Path::Raster) {
            return None;
        }
        match &self.measured {
            Ok(bits) if *bits >= 4 => None,
            Ok(bits) => Some(format!("vertices have {bits} sub-pixel bits, at least 4 are needed")),
            Err(failure) => Some(failure.to_string()),
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

/// Open all adapters, or those whose name or driver contains `wanted`.
///
/// # Errors
/// There is none, and what would help.
pub fn devices(wanted: Option<&str>) -> Result<Vec<Opened>> {
    let fits = |adapter: &wgpu::Adapter| {
        let name = device::name(adapter);
        let text = format!("{} {}", name.name, name.driver).to_lowercase();
        wanted.is_none_or(|wanted| text.contains(&wanted.to_lowercase()))
    };
    let adapters: Vec<wgpu::Adapter> = device::adapters().into_iter().filter(fits).collect();
    let mut opened = Vec::new();
    for adapter in &adapters {
        let device = Device::open(adapter).map_err(|failure| {
            Error::new("--adapter", format!("{}: {failure}", device::name(adapter).name))
        })?;
        let measured = raster::sub_pixel_bits(&device);
        opened.push(Opened { device, measured });
    }
    if opened.is_empty() { Err(none(wanted)) } else { Ok(opened) }
}

/// What to say where there is no adapter.
#[must_use]
pub fn none(wanted: Option<&str>) -> Error {
    let help = "install a Vulkan driver: on Debian, mesa-vulkan-drivers (lavapipe), or chromium-common (SwiftShader; \
                VK_ADD_DRIVER_FILES=/usr/lib/chromium/vk_swiftshader_icd.json lets the loader find it)";
    match wanted {
        Some(wanted) => Error::new("--adapter", format!("there is none called '{wanted}'; {help}")),
        None => Error::new("--adapter", format!("there is none; {help}")),
    }
}
