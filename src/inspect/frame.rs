//! All pixels of a frame: their fragments, and what becomes of them with each method. It is the same as
//! [`inspect()`](super::inspect) says of every pixel, but each method draws once.

use rayon::prelude::*;

use super::found::{Generated, title};
use super::gone::Facts;
use super::sight::{Look, View, k_of, with_promises};
use super::{Extra, check};
use crate::effect::solids::Solids;
use crate::error::{Error, Result};
use crate::fragment::Data;
use crate::image::Image;
use crate::num::planes::Distances;
use crate::raster::Batch;
use crate::render::{Options, Promises, Rendering, render};
use crate::scene::Scene;

/// The fragments of all pixels.
pub struct Frame<'a> {
    view: View<'a>,
    /// Row-major; pixel p's fragments are `generated[offsets[p]..offsets[p + 1]]`.
    offsets: Vec<u64>,
    generated: Vec<Generated>,
    solids: Solids,
    /// What they give, one over the other.
    pub exact: Image,
}

/// A frame as one method has drawn it.
pub struct Drawn<'a> {
    frame: &'a Frame<'a>,
    options: &'a Options,
    promises: Option<&'a Promises<'a>>,
    /// Picture, lists and report.
    pub rendering: &'a Rendering,
}

impl<'a> Frame<'a> {
    /// The fragments that `methods` get.
    ///
    /// # Errors
    /// As [`inspect()`](super::inspect), or more fragments than fit in the memory that is allowed.
    pub fn new(scene: &'a Scene, methods: &[Options]) -> Result<Self> {
        check(scene, methods, [0, 0])?;
        let first = methods.first().cloned().unwrap_or_default();
        let view = View::new(scene, &first);
        let count: u64 = view.front.count_fragments().iter().sum();
        let bytes = count.saturating_mul(BYTES);
        if bytes > first.max_memory {
            let most = first.max_memory;
            let problem = format!("{count} fragments need {bytes} bytes, but {most} are allowed");
            return Err(Error::new("--max-memory", problem));
        }
        let tiles: Vec<Vec<Vec<Generated>>> =
            (0..view.front.grid.tiles()).into_par_iter().map(|tile| of_tile(&view, tile)).collect();
        let [width, height] = scene.size;
        let grid = view.front.grid;
        let (mut offsets, mut generated) = (vec![0], Vec::with_capacity(count as usize));
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let place = grid.pixel(x, y) as usize;
            let per_tile = grid.pixels_per_tile();
            generated.extend_from_slice(&tiles[place / per_tile][place % per_tile]);
            offsets.push(generated.len() as u64);
        }
        drop(tiles);
        let solids = Solids::new(scene);
        let exact = Image { width, height, pixels: Vec::new() };
        let mut frame = Self { view, offsets, generated, solids, exact };
        let color = |p: usize| frame.view.color(frame.number(p));
        frame.exact.pixels = (0..frame.offsets.len() - 1).into_par_iter().map(color).collect();
        Ok(frame)
    }

    fn number(&self, p: usize) -> &[Generated] {
        &self.generated[self.offsets[p] as usize..self.offsets[p + 1] as usize]
    }

    /// Pixels across and down.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.view.scene.size
    }

    /// All fragments of all pixels.
    #[must_use]
    pub fn fragments(&self) -> u64 {
        self.generated.len() as u64
    }

    /// The fragments of pixel (x, y), in canonical order.
    ///
    /// # Panics
    /// If the pixel lies outside.
    #[must_use]
    pub fn pixel(&self, [x, y]: [u32; 2]) -> &[Generated] {
        self.number(y as usize * self.view.scene.size[0] as usize + x as usize)
    }

    /// The objects, by triangle.
    #[must_use]
    pub fn solids(&self) -> &Solids {
        &self.solids
    }

    /// What depth words stand for.
    #[must_use]
    pub fn distances(&self) -> Distances {
        Distances { planes: self.view.lens.planes(), format: self.view.words.depth }
    }

    /// The colour of an entry of a method's list at a pixel, by its words.
    #[must_use]
    pub fn color_of(&self, options: &Options, [x, y]: [u32; 2], extra: &Extra) -> u32 {
        match options.record().data {
            Data::Primitive => self.view.front.color_of(extra.data, x, y, extra.depth),
            _ => extra.data,
        }
    }

    /// Draw with a method, and use what it gives.
    ///
    /// # Errors
    /// As [`render()`].
    pub fn draw<T>(&self, options: &Options, then: impl FnOnce(&Drawn<'_>) -> T) -> Result<T> {
        let options = Options { counters: false, ..options.clone() };
        let rendering = render(self.view.scene, &options)?;
        with_promises(self.view.scene, &options, &rendering.kept, |promises| {
            then(&Drawn { frame: self, options: &options, promises, rendering: &rendering })
        })
    }
}

/// Bytes of a fragment while a frame is made: by tile and row by row.
const BYTES: u64 = 2 * size_of::<Generated>() as u64;

/// The fragments of a tile's pixels, in storage order.
fn of_tile(view: &View<'_>, tile: usize) -> Vec<Vec<Generated>> {
    let front = &view.front;
    let mut pixels = vec![Vec::new(); front.grid.pixels_per_tile()];
    let mut batch = Batch::default();
    front.packets(tile, |packet| {
        let first = front.grid.local_block(packet) * 64;
        let triangle = front.primitive(packet.primitive).triangle;
        front.fragments(packet, view.words, first, &mut batch);
        for fragment in batch.iter() {
            let (depth, color) = (fragment.depth, fragment.data);
            pixels[fragment.pixel as usize].push(Generated { triangle, depth, color });
        }
    });
    pixels.iter_mut().for_each(|generated: &mut Vec<Generated>| {
        view.order(generated);
        generated.shrink_to_fit();
    });
    pixels
}

impl Drawn<'_> {
    /// The method's name, and k where it has one.
    #[must_use]
    pub fn title(&self) -> String {
        title(self.options.method.name(), self.k())
    }

    /// Fragments kept per pixel, if that decides what the method keeps.
    #[must_use]
    pub fn k(&self) -> Option<u32> {
        k_of(self.options, self.rendering)
    }

    /// What became of the fragments of pixel (x, y).
    ///
    /// # Panics
    /// If the pixel lies outside.
    #[must_use]
    pub fn look(&self, pixel: [u32; 2]) -> Look {
        let facts = Facts { options: self.options, report: &self.rendering.report };
        let generated = self.frame.pixel(pixel);
        let kept = &self.rendering.kept;
        self.frame.view.look(&facts, kept, pixel, generated, self.promises)
    }
}
