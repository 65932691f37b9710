//! A scene cut into bands of tile rows that a device has room for, with what each of their pixels must hold.

use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

use rayon::prelude::*;

use super::expected::{Expected, Question, colored, kept, merged};
use super::picture::{Picture, TILE};
use crate::exec::Method;
use crate::exec::promise::{Promise, bound};
use crate::fragment::{Data, Fragment};
use crate::memory::Inputs;
use crate::num::depth::Format;
use crate::num::planes::Distances;
use crate::num::random::Random;
use crate::raster::primitive::Rect;
use crate::raster::{Batch, Grid, Record};
use crate::scheme::contract::{Contract, Extra, Keeps};
use crate::scheme::hash_table::table::{TableSettings, size_for_load};
use crate::scheme::{Config, exact};

/// What is stored for comparison: exact depths, and which triangle it is.
const RECORD: Record = Record { depth: Format::D32, data: Data::Primitive };

impl Picture {
    /// The whole of it as one band.
    #[must_use]
    pub fn whole(&self) -> Band<'_> {
        Band::new(self, 0..self.front.grid.tiles() / self.front.grid.columns().max(1) as usize)
    }

    /// Its bands, one after another: each is made on demand.
    pub fn bands(&self) -> impl Iterator<Item = Band<'_>> {
        self.bands.iter().map(|rows| Band::new(self, rows.clone()))
    }
}

/// Some rows of tiles: for a method, a picture of its own.
#[derive(Clone, Debug)]
pub struct Band<'p> {
    /// Of this picture.
    pub picture: &'p Picture,
    /// Which rows of tiles.
    pub rows: Range<usize>,
    /// The band as a grid.
    pub grid: Grid,
    /// All fragments of every storage pixel of a band that this one is a part of, exact depth and triangle, sorted.
    whole: Rc<Vec<Vec<u64>>>,
    /// Which of these pixels are its own.
    own: Range<usize>,
    /// The answers given so far.
    answers: RefCell<Vec<(Question, Rc<Expected>)>>,
}

impl<'p> Band<'p> {
    fn new(picture: &'p Picture, rows: Range<usize>) -> Self {
        let columns = picture.front.grid.columns() as usize;
        let tiles = rows.start * columns..rows.end * columns;
        let lists: Vec<Vec<u64>> = tiles
            .into_par_iter()
            .map(|tile| exact::tile(&picture.front, tile, RECORD, None))
            .flatten_iter()
            .collect();
        let own = 0..lists.len();
        let (whole, answers) = (Rc::new(lists), RefCell::default());
        Self { picture, grid: grid(picture, &rows), rows, whole, own, answers }
    }

    /// All fragments of every storage pixel.
    fn lists(&self) -> &[Vec<u64>] {
        &self.whole[self.own.clone()]
    }

    /// Its first row of pixels.
    #[must_use]
    pub fn top(&self) -> u32 {
        self.rows.start as u32 * TILE
    }

    /// The storage place in the picture of its first pixel.
    #[must_use]
    pub fn first_pixel(&self) -> u32 {
        let columns = self.grid.columns() as usize;
        (self.rows.start * columns * self.grid.pixels_per_tile()) as u32
    }

    /// Fragments generated in it.
    #[must_use]
    pub fn fragments(&self) -> u64 {
        self.lists().iter().map(|list| list.len() as u64).sum()
    }

    /// Two halves, if it has more than one row of tiles.
    #[must_use]
    pub fn halves(&self) -> Option<[Self; 2]> {
        let rows = self.rows.len();
        if rows < 2 {
            return None;
        }
        let middle = self.rows.start + rows / 2;
        let first = rows / 2 * self.grid.columns() as usize * self.grid.pixels_per_tile();
        let first = self.own.start + first;
        let part = |rows: Range<usize>, own: Range<usize>| Self {
            picture: self.picture,
            grid: grid(self.picture, &rows),
            rows,
            whole: Rc::clone(&self.whole),
            own,
            answers: RefCell::default(),
        };
        Some([
            part(self.rows.start..middle, self.own.start..first),
            part(middle..self.rows.end, first..self.own.end),
        ])
    }

    /// The configuration of a method that draws the band.
    #[must_use]
    pub fn config(&self, contract: &Contract, k: Option<u32>) -> Config {
        let k = k.or(contract.default_k);
        let bound = k.filter(|_| contract.keeps == Keeps::Nearest).map(u64::from);
        let counts = || self.lists().iter().map(|list| list.len() as u64);
        let generated = counts().sum();
        let image = [self.grid.width, self.grid.height];
        let size = size_for_load(generated, self.picture.load, image);
        Config {
            k,
            pixels: self.lists().len() as u32,
            generated,
            max_depth_complexity: counts().max().unwrap_or(0) as u32,
            bounded: counts().map(|f| bound.map_or(f, |k| k.min(f))).sum(),
            pages: counts().map(|f| f.div_ceil(contract.page.into())).sum(),
            grid: self.grid,
            table: TableSettings { size, ..TableSettings::default() },
            records: u64::from(k.unwrap_or(0))
                * u64::from(self.grid.width)
                * u64::from(self.grid.height),
            approximation: self.picture.approximation,
            distances: Distances {
                planes: self.picture.front.planes(),
                format: contract.depth_format.unwrap_or_default(),
            },
            ..Config::default()
        }
    }

    /// The fragments as a method gets them, in the order of submission, or shuffled.
    #[must_use]
    pub fn stream(
        &self,
        contract: &Contract,
        record: Record,
        shuffle: Option<u64>,
    ) -> Vec<Fragment> {
        let all = self.picture.front.indices();
        let mut fragments = self.stream_of(record, contract.extra == Extra::Primitive, all);
        if let Some(seed) = shuffle {
            Random::new(seed, self.rows.start as u64).shuffle(&mut fragments);
        }
        fragments
    }

    /// Those of some primitives. If they are numbered, their third word is that of their triangle.
    #[must_use]
    pub fn stream_of(
        &self,
        record: Record,
        numbered: bool,
        primitives: impl IntoIterator<Item = u32>,
    ) -> Vec<Fragment> {
        let front = &self.picture.front;
        let (window, first) = (self.window(), self.first_pixel());
        let (mut fragments, mut batch) = (Vec::new(), Batch::default());
        for primitive in primitives {
            front.primitive_packets(primitive, window, |packet| {
                let place = front.grid.first_pixel(packet) - first;
                front.fragments(packet, record, place, &mut batch);
                let first = fragments.len();
                fragments.extend(batch.iter());
                if numbered {
                    let extra = front.primitive(primitive).triangle;
                    fragments[first..].iter_mut().for_each(|fragment| fragment.extra = extra);
                }
            });
        }
        fragments
    }

    /// Its pixels in the picture.
    #[must_use]
    pub fn window(&self) -> Rect {
        let image = self.picture.front.grid.image();
        let (y0, y1) = (self.top(), self.top() + self.grid.height);
        Rect { y0, y1, ..image }
    }

    /// What must be in every pixel after resolve, and what was generated there.
    #[must_use]
    pub fn expected(&self, method: Method, record: Record, k: Option<u32>) -> Rc<Expected> {
        let contract = method.contract();
        let (keeps, identical) = (contract.keeps, contract.keeps_alike());
        let (k, arrival) = (k.or(contract.default_k), contract.is_arrival_dependent());
        let approximates = keeps.is_approximate().then_some(contract.name);
        let question = Question { record, keeps, approximates, identical, arrival, k };
        let known = self.answers.borrow().iter().find(|(known, _)| *known == question).cloned();
        if let Some((_, answer)) = known {
            return answer;
        }
        let config = self.config(contract, k);
        let answer = Rc::new(self.answer(method, &config, question));
        self.answers.borrow_mut().push((question, Rc::clone(&answer)));
        answer
    }

    fn answer(&self, method: Method, config: &Config, question: Question) -> Expected {
        let contract = method.contract();
        let instance = method.instance(config);
        let instance = instance.as_deref();
        let inputs = instance.map_or_else(Inputs::default, |i| Inputs::defaults(i.layout()));
        let counts = || self.lists().iter().map(|list| list.len() as u32).collect();
        let bound = bound(method, instance, question.k, &inputs, config.pixels, counts);
        let promise = Promise::new(method, instance, &inputs, bound);
        if contract.keeps.is_approximate() {
            let fragments = self.stream(contract, question.record, None);
            return colored(method, config, fragments, &promise);
        }
        if contract.keeps != Keeps::Merged {
            return kept(self.lists(), self.picture, contract, &promise, question);
        }
        let columns = self.grid.columns() as usize;
        let tiles = self.rows.start * columns..self.rows.end * columns;
        let slabs = |tile| exact::fragments(&self.picture.front, tile, question.record);
        let lists: Vec<Vec<Fragment>> = tiles.into_par_iter().map(slabs).flatten_iter().collect();
        merged(&lists, &promise, config)
    }
}

fn grid(picture: &Picture, rows: &Range<usize>) -> Grid {
    let whole = picture.front.grid;
    let (top, bottom) = (rows.start as u32 * TILE, rows.end as u32 * TILE);
    Grid { height: bottom.min(whole.height) - top, ..whole }
}
