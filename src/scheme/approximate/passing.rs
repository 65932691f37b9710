//! How much light passes all fragments of a pixel: Π (1 - α), whatever their order.
//!
//! One 64-bit word: the sum of -log2(1 - α) at scale 2^32, which is a table of the 256 opacities; an opaque fragment
//! sets the highest bit instead, and then nothing passes. Each logarithm is at most 2^-33 off, so that after n fragments
//! the product is right to the factor 2^(n 2^-33). There is room for 2^28 fragments.

use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Words};

/// Bits after the point of a logarithm.
const POINT: u32 = 32;

/// Set by an opaque fragment.
const OPAQUE: u64 = 1 << 63;

/// The word of each pixel.
#[derive(Debug)]
pub(super) struct Passing {
    word: Words<Pixel, Atomic, u64>,
    logarithms: Box<[u64; 256]>,
}

impl Passing {
    pub(super) fn new(layout: &mut Layout) -> Self {
        Self { word: layout.named("word").pixel(1), logarithms: logarithms() }
    }

    pub(super) async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.word.at(pixel, 0), 0, Order::Relaxed).await;
    }

    /// A fragment of that opacity byte.
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    pub(super) async fn add<M: Memory, Caller>(&self, mem: &M, pixel: u32, alpha: u32) {
        let (word, alpha) = (self.word.at(pixel, 0), alpha as usize & 255);
        let either = mem.block();
        if alpha == 255 {
            mem.or(word, OPAQUE, Order::Relaxed).await;
        } else {
            mem.add(word, self.logarithms[alpha], Order::Relaxed).await;
        }
        mem.merge(either).await;
    }

    /// The product.
    pub(super) async fn get<M: Memory>(&self, mem: &M, pixel: u32) -> f64 {
        product(mem.load(self.word.at(pixel, 0), Order::Relaxed).await)
    }

    /// The product of these opacity bytes, from no memory.
    pub(super) fn of(&self, alphas: impl Iterator<Item = u32>) -> f64 {
        product(alphas.fold(0, |word, alpha| match alpha {
            255 => word | OPAQUE,
            alpha => word + self.logarithms[alpha as usize & 255],
        }))
    }
}

fn product(word: u64) -> f64 {
    if word & OPAQUE != 0 {
        return 0.0;
    }
    libm::exp2(-(word as f64) / (1u64 << POINT) as f64)
}

/// -log2(1 - α) of every opacity byte; that of 255 is not added.
#[must_use]
pub fn logarithms() -> Box<[u64; 256]> {
    let of = |alpha: usize| {
        let through = (255 - alpha.min(254)) as f64 / 255.0;
        libm::round(-libm::log2(through) * (1u64 << POINT) as f64) as u64
    };
    Box::new(std::array::from_fn(of))
}
