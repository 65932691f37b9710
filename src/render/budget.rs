//! A memory budget: how large k or a pool may be.
//!
//! The dynamic k-buffer takes k from the depth-complexity histogram (Vasilakis, Fudos 2014, section 5; the importance
//! paper, section 2): the largest k whose storage fits. A method whose storage does not depend on k, an A-buffer, is
//! configured for fewer fragments than there are, and drops what finds no room.

use crate::error::{Error, Result};
use crate::exec::Method;
use crate::raster::FrontEnd;
use crate::scheme::Config;
use crate::scheme::contract::{Contract, Demand, Keeps};
use crate::scheme::kplus_buffer::k_variable::MOST_RECORDS;

/// The result of a budget.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Budget {
    /// Bytes that the method's storage may take.
    pub bytes: u64,
    /// The chosen k, if storage depends on it.
    pub k: Option<u32>,
    /// Otherwise, how many fragments there is room for: in the frame, or at each pixel; or how many records are divided
    /// among the pixels.
    pub room: Option<u64>,
    /// For every number of fragments, how many pixels have it.
    pub histogram: Vec<u64>,
    /// Fragments that no pixel has a place for: beyond its k, or its n.
    pub beyond: u64,
}

/// What a scene needs, before memory is allocated.
pub(super) struct Scene<'a> {
    front: &'a FrontEnd,
    /// By storage pixel: those outside of the picture have no fragments.
    histogram: Vec<u64>,
    method: Method,
    contract: &'static Contract,
    /// What does not depend on the scene.
    base: Config,
}

impl<'a> Scene<'a> {
    pub(super) fn new(front: &'a FrontEnd, method: Method, base: Config) -> Self {
        let (histogram, contract) = (front.depth_complexity(), method.contract());
        Self { front, histogram, method, contract, base }
    }

    fn sum(&self, of: impl Fn(u64) -> u64) -> u64 {
        (0..).zip(&self.histogram).map(|(f, &pixels)| of(f) * pixels).sum()
    }

    /// The configuration with this k, if memory is no concern.
    pub(super) fn config(&self, k: Option<u32>) -> Config {
        let bound = k.filter(|_| self.contract.keeps == Keeps::Nearest).map(u64::from);
        Config {
            k,
            pixels: self.front.grid.storage_pixels() as u32,
            generated: self.sum(|f| f),
            max_depth_complexity: self.histogram.len() as u32 - 1,
            bounded: self.sum(|f| bound.map_or(f, |k| k.min(f))),
            pages: self.sum(|f| f.div_ceil(u64::from(self.contract.page))),
            grid: self.front.grid,
            ..self.base
        }
    }

    /// The largest configuration whose storage fits.
    pub(super) fn within(&self, bytes: u64, k: Option<u32>) -> Result<(Config, Budget)> {
        let grid = &self.front.grid;
        let most = self.histogram.len() as u64 - 1;
        let padding = grid.storage_pixels() as u64 - u64::from(grid.width) * u64::from(grid.height);
        let mut histogram = self.histogram.clone();
        histogram[0] -= padding;
        let mut budget = Budget { bytes, histogram, ..Budget::default() };
        let size = |config: Config| storage_bytes(self.method, &config);
        if self.contract.demand == Demand::Records {
            let with = |records: u64| Config { records, ..self.config(k) };
            let records = self.largest(MOST_RECORDS, &|n| size(with(n)), bytes, "one fragment")?;
            budget.room = Some(records);
            return Ok((with(records), budget));
        }
        let takes_k = self.contract.default_k.is_some();
        let ends = [1, most.max(2) as u32].map(|k| size(self.config(Some(k))));
        let [small, large] = ends;
        if takes_k && small < large {
            let most = most.clamp(1, u64::from(self.contract.max_k));
            let with = |k: u64| self.config(Some(k as u32));
            let k = self.largest(most, &|k| size(with(k)), bytes, "k = 1")?;
            budget.k = Some(k as u32);
            if self.contract.keeps != Keeps::All {
                budget.beyond = self.sum(|f| f.saturating_sub(k));
            }
            return Ok((with(k), budget));
        }
        let full = self.config(k.or(self.contract.default_k));
        if self.contract.demand == Demand::Nothing {
            self.largest(1, &|_| size(full), bytes, "this scene")?;
            return Ok((full, budget));
        }
        let with = |room: u64| match self.contract.demand {
            Demand::MaxDepthComplexity => Config { max_depth_complexity: room as u32, ..full },
            _ => Config {
                generated: room.min(full.generated),
                bounded: room.min(full.bounded),
                pages: room.min(full.pages),
                ..full
            },
        };
        let most = match self.contract.demand {
            Demand::MaxDepthComplexity => u64::from(full.max_depth_complexity),
            _ => full.generated,
        };
        let room = self.largest(most, &|room| size(with(room)), bytes, "one fragment")?;
        if self.contract.demand == Demand::MaxDepthComplexity {
            budget.beyond = self.sum(|f| f.saturating_sub(room));
        }
        budget.room = Some(room);
        Ok((with(room), budget))
    }

    /// The largest number up to `most` whose storage fits; `least` names what 1 stands for.
    fn largest(
        &self,
        most: u64,
        size: &dyn Fn(u64) -> u64,
        bytes: u64,
        least: &str,
    ) -> Result<u64> {
        let needed = size(1);
        if needed > bytes {
            let name = self.contract.name;
            let problem = format!("{bytes} bytes: {name} needs {needed} for {least} at this size");
            return Err(Error::new("--memory-budget", problem));
        }
        let (mut fits, mut beyond) = (1, most.max(1) + 1);
        while beyond - fits > 1 {
            let middle = u64::midpoint(fits, beyond);
            if size(middle) <= bytes { fits = middle } else { beyond = middle }
        }
        Ok(fits)
    }
}

/// The bytes of a method's storage for a configuration, by its own declaration.
#[must_use]
pub fn storage_bytes(method: Method, config: &Config) -> u64 {
    match method.instance(config) {
        Some(instance) => instance.layout().bytes(u64::from(config.pixels)),
        None => 8 * config.generated,
    }
}
