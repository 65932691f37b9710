//! What does it cost that a scheme is an `async fn` over a memory? A k = 8 max-array insertion against the same thing
//! written by hand as a plain function over std atomics (native) and cells (exclusive). Goal: ratios of at most 1.1
//! and 1.2. Exits with 1 above them.

mod support;

use std::cell::Cell;
use std::hint::black_box;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU32, Ordering};

use fragloom::exec::drive::Pipeline;
use fragloom::fragment::{Fragment, key};
use fragloom::memory::arena::{Owned, Shared};
use fragloom::memory::exclusive::Exclusive;
use fragloom::memory::native::Native;
use fragloom::memory::{Inputs, Layout};
use fragloom::num::random::Random;
use fragloom::raster::Batch;
use fragloom::raster::batch::bits;
use fragloom::scheme::kplus_buffer::kplus_array::KPlusArray;
use fragloom::scheme::{Config, Outcome, Outcomes, Scheme};
use support::paired;

const K: usize = 8;
const PIXELS: u32 = 4_096;
const LAYERS: u32 = 32;
const PAIRS: usize = 41;

/// Words of a pixel: lock, counter, depths, data. Known only at run time, like the scheme's.
#[derive(Clone, Copy)]
struct Shape {
    k: usize,
    stride: usize,
}

fn shape() -> Shape {
    black_box(Shape { k: K, stride: 2 + 2 * K })
}

fn main() -> ExitCode {
    let fragments = fragments();
    let batches: Vec<Batch> = fragments.chunks(64).map(Batch::of_block).collect();
    let native = report("native", 1.1, native(&batches), fragments.len());
    let exclusive = report("exclusive", 1.2, exclusive(&batches), fragments.len());
    if native && exclusive { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn report(name: &str, goal: f64, [scheme, plain, ratio]: [f64; 3], fragments: usize) -> bool {
    let ns = |seconds: f64| seconds * 1e9 / fragments as f64;
    println!(
        "{name:<10} async fn {:6.2} ns   plain function {:6.2} ns   ratio {ratio:.3} (goal {goal})",
        ns(scheme),
        ns(plain)
    );
    ratio <= goal
}

/// Layer after layer over all pixels, random depths.
fn fragments() -> Vec<Fragment> {
    let mut random = Random::new(1, 0);
    let mut all = Vec::new();
    for _ in 0..LAYERS {
        let layer = (0..PIXELS).map(|pixel| {
            let depth = random.below(1 << 31) as u32;
            Fragment { pixel, depth, data: random.bits() as u32, extra: 0 }
        });
        all.extend(layer);
    }
    all
}

fn scheme() -> (KPlusArray, Layout) {
    let mut layout = Layout::default();
    let config = Config { k: Some(K as u32), pixels: PIXELS, ..Config::default() };
    (KPlusArray::new(&config, &mut layout), layout)
}

fn native(batches: &[Batch]) -> [f64; 3] {
    let (scheme, layout) = scheme();
    let pixel = Shared::new(layout.per_pixel(), PIXELS as usize);
    let global = Shared::new(layout.per_frame(), 1);
    let inputs = Inputs::defaults(&layout);
    let mem = Native::new(&pixel, &global, &inputs, &());
    let shape = shape();
    let words: Vec<AtomicU32> =
        (0..PIXELS as usize * shape.stride).map(|_| AtomicU32::new(0)).collect();
    let mut outcomes = Outcomes::default();
    let mut plain_outcomes = Outcomes::default();
    paired(
        PAIRS,
        || {
            Pipeline::clear(&scheme, &mem, 0..PIXELS);
            for batch in batches {
                Pipeline::store(&scheme, &mem, batch, &mut outcomes);
            }
            black_box(&outcomes);
        },
        || {
            clear_native(shape, &words);
            for batch in batches {
                store_native(shape, &words, batch, &mut plain_outcomes);
            }
            black_box(&plain_outcomes);
        },
    )
}

fn exclusive(batches: &[Batch]) -> [f64; 3] {
    let (scheme, layout) = scheme();
    let pixel = Owned::new(layout.per_pixel(), PIXELS as usize);
    let global = Shared::new(layout.per_frame(), 1);
    let inputs = Inputs::defaults(&layout);
    let mem = Exclusive::new(&pixel, &global, &inputs, &());
    let shape = shape();
    let words = vec![Cell::new(0u32); PIXELS as usize * shape.stride];
    let mut outcomes = Outcomes::default();
    let mut plain_outcomes = Outcomes::default();
    paired(
        PAIRS,
        || {
            Pipeline::clear(&scheme, &mem, 0..PIXELS);
            for batch in batches {
                Pipeline::store(&scheme, &mem, batch, &mut outcomes);
            }
            black_box(&outcomes);
        },
        || {
            clear_exclusive(shape, &words);
            for batch in batches {
                store_exclusive(shape, &words, batch, &mut plain_outcomes);
            }
            black_box(&plain_outcomes);
        },
    )
}

#[inline(never)]
fn clear_native(shape: Shape, words: &[AtomicU32]) {
    for record in words.chunks(shape.stride) {
        record[0].store(0, Ordering::Relaxed);
        record[1].store(0, Ordering::Relaxed);
    }
}

#[inline(never)]
fn clear_exclusive(shape: Shape, words: &[Cell<u32>]) {
    for record in words.chunks(shape.stride) {
        record[0].set(0);
        record[1].set(0);
    }
}

/// The two plain functions differ only in how a word is read, written, locked and unlocked.
macro_rules! plain {
    ($name:ident, $word:ty, $get:expr, $set:expr, $acquire:expr, $raise:expr, $release:expr) => {
        #[inline(never)]
        fn $name(shape: Shape, words: &[$word], batch: &Batch, outcomes: &mut Outcomes) {
            outcomes.reset();
            for bit in bits(batch.mask()) {
                let fragment = batch.get(bit);
                let outcome = {
                    let (k, base) = (shape.k, fragment.pixel as usize * shape.stride);
                    let (lock, counter) = (base, base + 1);
                    let depth = |i: usize| base + 2 + i;
                    let data = |i: usize| base + 2 + k + i;
                    let entry = |i: usize| key($get(&words[depth(i)]), $get(&words[data(i)]));
                    let put = |i: usize, entry: u64| {
                        $set(&words[data(i)], entry as u32);
                        $set(&words[depth(i)], (entry >> 32) as u32);
                    };
                    if $acquire(&words[counter], false) == k as u32
                        && fragment.depth > $get(&words[depth(0)])
                    {
                        Outcome::Culled
                    } else {
                        while $acquire(&words[lock], true) != 0 {
                            std::hint::spin_loop();
                        }
                        let count = $get(&words[counter]) as usize;
                        let outcome = if count < k {
                            let mut last = fragment.key();
                            if count > 0 {
                                let farthest = entry(0);
                                if last > farthest {
                                    put(0, last);
                                    last = farthest;
                                }
                            }
                            put(count, last);
                            $raise(&words[counter], count as u32 + 1);
                            Outcome::Kept
                        } else if fragment.key() >= entry(0) {
                            Outcome::Culled
                        } else {
                            let (mut place, mut farthest) = (0, fragment.key());
                            for i in 1..k {
                                let d = $get(&words[depth(i)]);
                                if u64::from(d) >= farthest >> 32 {
                                    let entry = key(d, $get(&words[data(i)]));
                                    if entry > farthest {
                                        (place, farthest) = (i, entry);
                                    }
                                }
                            }
                            if place != 0 {
                                put(place, fragment.key());
                            }
                            put(0, farthest);
                            Outcome::Evicted
                        };
                        $release(&words[lock]);
                        outcome
                    }
                };
                outcomes.set(bit, outcome);
            }
        }
    };
}

plain!(
    store_native,
    AtomicU32,
    |w: &AtomicU32| w.load(Ordering::Relaxed),
    |w: &AtomicU32, v| w.store(v, Ordering::Relaxed),
    |w: &AtomicU32, exchange: bool| if exchange {
        w.swap(1, Ordering::Acquire)
    } else {
        w.load(Ordering::Acquire)
    },
    |w: &AtomicU32, v| w.store(v, Ordering::Release),
    |w: &AtomicU32| w.store(0, Ordering::Release)
);

plain!(
    store_exclusive,
    Cell<u32>,
    |w: &Cell<u32>| w.get(),
    |w: &Cell<u32>, v| w.set(v),
    |w: &Cell<u32>, exchange: bool| if exchange { w.replace(1) } else { w.get() },
    |w: &Cell<u32>, v| w.set(v),
    |w: &Cell<u32>| w.set(0)
);
