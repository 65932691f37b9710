//! The oracle: the sequential exact A-buffer. It has no invocations, no shared memory and no lock; it collects every
//! fragment of a pixel, sorts them, and keeps the nearest k. It is verified by reading.

use crate::fragment::{Fragment, Packet};
use crate::raster::{Batch, FrontEnd, Record};
use crate::scheme::contract::{Contract, Keeps, Overflow};

/// What the oracle promises.
pub const CONTRACT: Contract = Contract {
    title: "Sequential exact A-buffer: the reference",
    paper: "Carpenter 1984",
    section: "-",
    words: "2 f(p)",
    exact_when: "always; all fragments unless -k is given",
    overflow: Overflow::Never("none"),
    needs: "nothing: it is sequential",
    default_k: None,
    max_k: u32::MAX,
    source: include_str!("exact.rs"),
    ..Contract::new("exact", Keeps::Nearest)
};

/// The fragments of a tile's pixels, in storage order (`Grid::local_pixel`), front to back: all, or the nearest k.
#[must_use]
pub fn tile(front: &FrontEnd, tile: usize, record: Record, k: Option<u32>) -> Vec<Vec<u64>> {
    let mut pixels = collect(front, tile, record, Fragment::key);
    pixels.iter_mut().for_each(|keys| nearest(keys, k));
    pixels
}

/// The same with all that is known of a fragment: the third word, too.
#[must_use]
pub fn fragments(front: &FrontEnd, tile: usize, record: Record) -> Vec<Vec<Fragment>> {
    let mut pixels = collect(front, tile, record, |fragment| fragment);
    pixels.iter_mut().for_each(|fragments| fragments.sort_unstable());
    pixels
}

fn collect<T: Clone>(
    front: &FrontEnd,
    tile: usize,
    record: Record,
    part: impl Fn(Fragment) -> T,
) -> Vec<Vec<T>> {
    let mut pixels = vec![Vec::new(); front.grid.pixels_per_tile()];
    let mut batch = Batch::default();
    front.packets(tile, |packet: Packet| {
        let first = front.grid.local_block(packet) * 64;
        front.fragments(packet, record, first, &mut batch);
        for fragment in batch.iter() {
            pixels[fragment.pixel as usize].push(part(fragment));
        }
    });
    pixels
}

/// The fragments of one pixel, front to back: all, or the nearest k.
#[must_use]
pub fn pixel(fragments: &[Fragment], k: Option<u32>) -> Vec<u64> {
    let mut keys: Vec<u64> = fragments.iter().map(|f| f.key()).collect();
    nearest(&mut keys, k);
    keys
}

fn nearest(keys: &mut Vec<u64>, k: Option<u32>) {
    keys.sort_unstable();
    keys.truncate(k.map_or(usize::MAX, |k| k as usize));
}
