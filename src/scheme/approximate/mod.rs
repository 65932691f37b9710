//! Approximate transparency: another answer than the exact one, from a few words a pixel.
//!
//! A pixel ends as a colour ([`Light`](super::Light)). What a paper adds up in any order is added up here in integers,
//! so that no order changes a bit: each file says at which scale, how many fragments have room, and how far off a sum
//! can be. The forms `@published-f32` add in single precision, as a blending unit does, and depend on arrival by
//! rounding. What depends on arrival by design says so in its contract; it may then hold one result for each order of
//! arrival, and nothing else ([`Scheme::possible`]).
//!
//! [`Scheme::possible`]: super::Scheme::possible
//!
//! * [`wboit`]: one pass, colours by a weight of depth and opacity.
//! * [`mbt`]: two passes, transmittance from power moments ([`moments`]).
//! * [`mlab`]: k nodes in order, the last two merged.
//! * [`adaptive`]: two passes, the visibility function in k nodes.
//! * [`hybrid`]: the k nearest exactly, the average of the rest.
//! * [`stochastic`]: opacity as a share of samples.
//! * [`unsorted`]: no order at all.

pub mod adaptive;
mod blend;
pub mod hybrid;
pub mod mbt;
pub mod mlab;
pub mod moments;
pub mod passing;
pub mod stochastic;
pub mod unsorted;
pub mod wboit;

use super::Contract;
use super::contract::{Keeps, Limit, Overflow};
use crate::fragment::{Data, Fragment};
use crate::num::orders::orders;
use wboit::Weight;

/// What approximations must know of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Approximation {
    /// The weight of `wboit`.
    pub weight: Weight,
    /// Power moments of `mbt`: 4, 6 or 8.
    pub moments: u32,
    /// Samples a pixel of `stochastic`, 1 to [`stochastic::MOST_SAMPLES`].
    pub samples: u32,
    /// The seed of its samples.
    pub seed: u64,
}

impl Default for Approximation {
    fn default() -> Self {
        Self { weight: Weight::Eq7, moments: 4, samples: 8, seed: 0 }
    }
}

/// What these methods have in common.
const fn approximate(name: &'static str, limit: Limit) -> Contract {
    Contract {
        data: Some(Data::Color),
        ties: "all count alike",
        overflow: Overflow::Never("every fragment goes into the pixel's colour"),
        ..Contract::new(name, Keeps::Approximate(limit))
    }
}

/// The most fragments that are put into every order.
const MOST_ORDERED: usize = 4;

/// Fragments in every order of arrival; nothing if there are too many.
fn arrivals(generated: &[Fragment]) -> impl Iterator<Item = Vec<Fragment>> + '_ {
    let n = generated.len();
    let all = if n <= MOST_ORDERED { orders(n) } else { Vec::new() };
    all.into_iter().map(|order| order.iter().map(|&i| generated[i]).collect())
}

/// The opacity byte of a colour word.
#[inline]
fn alpha(data: u32) -> u32 {
    data >> 24
}

/// Red, green and blue of a colour word, each times its opacity: 0 to 65,025.
#[inline]
fn premultiplied(data: u32) -> [u32; 3] {
    let [r, g, b, a] = data.to_le_bytes().map(u32::from);
    [r * a, g * a, b * a]
}

/// The same, 0 to 1.
#[inline]
fn real(data: u32) -> [f64; 3] {
    premultiplied(data).map(|c| f64::from(c) / 65_025.0)
}
