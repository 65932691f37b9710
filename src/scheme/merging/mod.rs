//! Merging what lies close together: slabs of the z-thickness model ("Fragment merging with z-thickness").
//!
//! A fragment of these methods is a slab, from its depth towards the eye ([`Extra::Near`]). Where slabs overlap, they
//! become one record; `-k` is M, the most records of a pixel.
//!
//! * `dfb+sfm` sorts all fragments and merges them smoothly in resolve ([`slab`]).
//! * `skb+ofm` merges on arrival, in a k+-buffer whose last record is a tail ([`sums`]).
//! * `dfb+ofm` merges all fragments as `skb+ofm` does, but in resolve, and so never depends on arrival.
//!
//! [`Extra::Near`]: crate::scheme::contract::Extra

pub mod components;
pub mod dfb_merged;
pub mod skb_ofm;
pub mod slab;
pub mod sums;

use super::contract::{Extra, Keeps};
use super::{Contract, Record};
use crate::fragment::Data;
use crate::num::planes::Distances;
use slab::{Slab, Visibility};

/// What merging must know of the run.
#[derive(Clone, Copy, Debug)]
pub struct Merging {
    /// Between optical (0) and smooth (1) subdivision: β of equation (4).
    pub beta: f64,
    /// Slabs are a multiple of the depth's precision thick, rather than world units.
    pub relative: bool,
}

impl Default for Merging {
    fn default() -> Self {
        Self { beta: 1.0, relative: true }
    }
}

impl PartialEq for Merging {
    fn eq(&self, other: &Self) -> bool {
        let of = |m: &Self| (m.beta.to_bits(), m.relative);
        of(self) == of(other)
    }
}

impl Eq for Merging {}

impl Slab {
    /// A fragment as a slab.
    #[must_use]
    pub fn of(distances: &Distances, depth: u32, near: u32, data: u32) -> Self {
        let Record { rgba, weight, .. } = Record::surface(depth, data);
        let far = distances.along(depth);
        let near = if near < depth { distances.along(near) } else { far };
        let visibility = Visibility::new(rgba);
        Self { near, far, visibility, sum: visibility.opacity, depth, weight }
    }
}

impl From<&Slab> for Record {
    fn from(slab: &Slab) -> Self {
        let Slab { near, far, depth, weight, .. } = *slab;
        Self { depth, thickness: far - near, rgba: slab.visibility.rgba(), weight }
    }
}

/// How slabs are put together. The default is as it must be; every other value is a fault, or the released shaders'.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blending {
    /// β.
    pub beta: f64,
    /// Slabs that touch overlap.
    pub closed: bool,
    /// β counts for the front part alone.
    pub front_only: bool,
    /// Visibilities are stored as four bytes.
    pub eight_bits: bool,
    /// The tail is mixed, not put behind.
    pub mixed_tail: bool,
    /// Shares of the thickness are squared.
    pub squared: bool,
}

impl Blending {
    /// A visibility as it is stored.
    fn stored(&self, v: Visibility) -> Visibility {
        let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() / 255.0;
        if self.eight_bits { Visibility::new(v.rgba().map(byte)) } else { v }
    }

    /// A share of a thickness as it is used.
    fn faulty(&self, share: f64) -> f64 {
        if self.squared { share * share } else { share }
    }
}

/// What methods that merge have in common. `-k` is the most records.
#[must_use]
pub const fn merging(name: &'static str) -> Contract {
    Contract {
        paper: "fragment merging with z-thickness, 2021",
        extra: Extra::Near,
        data: Some(Data::Color),
        default_k: Some(8),
        max_k: u32::MAX / 16,
        ..Contract::new(name, Keeps::Merged)
    }
}
