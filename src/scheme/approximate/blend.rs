//! Sums in single precision, as a blending unit keeps them in a target of floats: one fragment of a pixel after another,
//! each rounded. The unit is a spin lock here; so fragments come in any order, and the sums show it.

use crate::memory::{Access, Layout, Memory, Order, Pixel, Plain, Words};
use crate::scheme::parts::lock::{FREE, SpinLock};

/// `N` floats of each pixel.
#[derive(Debug)]
pub(super) struct Blended<const N: usize> {
    lock: SpinLock,
    words: Words<Pixel, Plain, u32>,
}

impl<const N: usize> Blended<N> {
    pub(super) fn new(layout: &mut Layout) -> Self {
        Self { lock: SpinLock::new(layout), words: layout.named("words").pixel(N as u64) }
    }

    /// Begin with these values.
    pub(super) async fn clear<M: Memory>(&self, mem: &M, pixel: u32, values: [f32; N]) {
        self.lock.clear(mem, pixel).await;
        for (i, value) in (0..).zip(values) {
            mem.plain_store(self.words.at(pixel, i), value.to_bits()).await;
        }
    }

    /// Blend a fragment: the values become what `blend` makes of them.
    pub(super) async fn blend<M: Memory>(
        &self,
        mem: &M,
        pixel: u32,
        blend: impl Fn(usize, f32) -> f32,
    ) {
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if self.lock.try_acquire(mem, pixel, Order::Acquire).await == FREE {
                for i in 0..N {
                    let at = self.words.at(pixel, i as u32);
                    let old = f32::from_bits(mem.plain_load(at).await);
                    mem.plain_store(at, blend(i, old).to_bits()).await;
                }
                self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                return;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    /// The values, after a barrier.
    pub(super) async fn get<M: Memory>(&self, mem: &M, pixel: u32) -> [f32; N] {
        let mut values = [0.0; N];
        for (i, value) in (0..).zip(&mut values) {
            *value = f32::from_bits(mem.plain_load(self.words.at(pixel, i)).await);
        }
        values
    }
}
