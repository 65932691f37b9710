//! The exact answer: what a method must give for a scene, with its options.

use rayon::prelude::*;

use super::configure::{self, HeldTo, configure, held_to};
use super::{Options, render};
use crate::error::Result;
use crate::exec::promise::Promise;
use crate::fragment::Fragment;
use crate::raster::{FrontEnd, Grid};
use crate::resolve::{Kept, Lists};
use crate::scene::Scene;
use crate::scheme::{Held, HeldKind, exact};

/// What a method must give on a scene.
#[derive(Clone, Debug)]
pub struct Reference {
    /// All fragments, in the words that the method stores.
    pub all: Lists,
    /// What the pixels must hold, where room and arrival do not matter; `None` if the method does not specify what it
    /// approximates.
    pub kept: Option<Kept>,
}

/// The exact answer for the method, k, depth format, data word and inputs of `options`: the oracle's fragments, and of
/// these what the method promises to keep.
///
/// # Errors
/// As [`render()`].
///
/// # Examples
/// ```
/// use fragloom::render::{Options, reference, render};
/// use fragloom::scene::{self, Overrides};
///
/// let scene = scene::load("cubes", &Overrides { size: Some([32, 32]), ..Overrides::default() })?;
/// let options = Options { k: Some(3), ..Options::default() };
/// assert_eq!(reference(&scene, &options)?.kept, Some(render(&scene, &options)?.kept));
/// # Ok::<(), fragloom::error::Error>(())
/// ```
pub fn reference(scene: &Scene, options: &Options) -> Result<Reference> {
    let exact = Options { counters: false, ..options.exact(None) };
    let all = render(scene, &exact)?.lists()?.clone();
    let grid = Grid { width: all.width, height: all.height, tile: options.tile };
    let kept = promise(scene, options, &grid, |promise, front| {
        let whole = whole(front, options);
        let generated = |x: u32, y: u32| match whole.get(grid.pixel(x, y) as usize) {
            Some(fragments) => fragments.clone(),
            None => all.pixel(x, y).iter().map(|&key| Fragment::of_key(key)).collect(),
        };
        kept(&generated, &grid, options.method.holds(), promise)
    })?;
    Ok(Reference { all, kept })
}

/// What the method of `options` must hold at pixel (x, y), where room and arrival do not matter; `generated` are all
/// fragments of the pixel in canonical order, in the words that the method stores. `None` if the method does not
/// specify what it approximates.
///
/// # Errors
/// As [`render()`].
pub fn promised(
    scene: &Scene,
    options: &Options,
    pixel: [u32; 2],
    generated: &[u64],
) -> Result<Option<Held>> {
    promising(scene, options, |promises| promises.pixel(pixel, generated))
}

/// Ask for what the method of `options` must hold at any pixels of a scene ([`promised`]).
///
/// # Errors
/// As [`render()`].
pub fn promising<T>(
    scene: &Scene,
    options: &Options,
    ask: impl FnOnce(&Promises<'_>) -> T,
) -> Result<T> {
    let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
    promise(scene, options, &grid, |promise, front| ask(&Promises { promise, front, options }))
}

/// What a method must hold at the pixels of a scene.
pub struct Promises<'a> {
    promise: &'a Promise<'a>,
    front: &'a FrontEnd,
    options: &'a Options,
}

impl Promises<'_> {
    /// As [`promised`]. Of a method whose fragments have a third word, the pixel's tile is drawn for it.
    #[must_use]
    pub fn pixel(&self, [x, y]: [u32; 2], generated: &[u64]) -> Option<Held> {
        let Self { promise, front, options } = self;
        let pixel = front.grid.pixel(x, y);
        let per_tile = front.grid.pixels_per_tile();
        let fragments = if options.method.contract().has_third_word() {
            let mut tile = exact::fragments(front, pixel as usize / per_tile, options.record());
            tile.swap_remove(pixel as usize % per_tile)
        } else {
            generated.iter().map(|&key| Fragment::of_key(key)).collect()
        };
        promise.pixel(pixel, &fragments)
    }
}

/// Ask what a method promises on a scene.
fn promise<T>(
    scene: &Scene,
    options: &Options,
    grid: &Grid,
    ask: impl FnOnce(&Promise<'_>, &FrontEnd) -> T,
) -> Result<T> {
    let k = options.k.or(options.method.contract().default_k);
    let front = FrontEnd::new(scene, *grid, options.sub_pixel_bits, options.cull_face);
    let front = configure::third_word(front, scene, options);
    let (config, _, _) = configure(&front, options, k)?;
    let k = config.k;
    let instance = options.method.instance(&config);
    let HeldTo { inputs, nearest, .. } = held_to(instance.as_deref(), scene, options, &front, k)?;
    Ok(ask(&Promise::new(options.method, instance.as_deref(), &inputs, nearest), &front))
}

/// By storage pixel, its fragments, for a method whose fragments have a third word.
fn whole(front: &FrontEnd, options: &Options) -> Vec<Vec<Fragment>> {
    if !options.method.contract().has_third_word() {
        return Vec::new();
    }
    let tiles = 0..front.grid.tiles();
    let of = |tile| exact::fragments(front, tile, options.record());
    tiles.into_par_iter().map(of).collect::<Vec<_>>().concat()
}

/// What all pixels must hold, row by row; `None` if it is unspecified for one of them.
fn kept(
    generated: &dyn Fn(u32, u32) -> Vec<Fragment>,
    grid: &Grid,
    holds: HeldKind,
    promise: &Promise<'_>,
) -> Option<Kept> {
    let Grid { width, height, .. } = *grid;
    let mut offsets = vec![0];
    let (mut keys, mut records) = (Vec::new(), Vec::new());
    let (mut lights, mut depths) = (Vec::new(), Vec::new());
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        match promise.pixel(grid.pixel(x, y), &generated(x, y))? {
            Held::Keys(list) => keys.extend(list),
            Held::Records(list) => records.extend(list.into_list()),
            Held::Light(light) => lights.push(light),
            Held::Depth(depth) => depths.push(depth),
        }
        offsets.push((keys.len() + records.len()) as u64);
    }
    Some(match holds {
        HeldKind::Fragments => Kept::Fragments(Lists { width, height, offsets, entries: keys }),
        HeldKind::Records => Kept::Records(Lists { width, height, offsets, entries: records }),
        HeldKind::Color => Kept::Color(lights),
        HeldKind::Depth => Kept::Depths(depths),
    })
}
