//! A scene's pixels as methods get them, what each method's frame holds there, and one pixel looked at.

use super::absorbance::{self, Slab, share};
use super::found::{Exact, Extra, Generated, Inspected, PixelFragment, PixelRecord};
use super::gone::Facts;
use super::{Fate, fates, records};
use crate::effect::lens::Lens;
use crate::effect::solids::Solids;
use crate::error::Result;
use crate::fragment::{Data, data_of, depth_of};
use crate::num::color::word16;
use crate::raster::{FrontEnd, Grid, Record as Words};
use crate::render::{Kept, Options, Promises, Rendering, promising, render};
use crate::resolve::composite::Ray;
use crate::scene::Scene;
use crate::scheme::contract::{Contract, Demand};
use crate::scheme::{Held, Record};

/// A scene, and its fragments before any method.
pub(super) struct View<'a> {
    pub(super) scene: &'a Scene,
    pub(super) front: FrontEnd,
    pub(super) lens: Lens,
    pub(super) words: Words,
    /// The word that decides the order of fragments of equal depth.
    data: Data,
}

/// What a method made of a pixel's fragments, and what it holds there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// What became of each fragment.
    pub fates: Vec<Fate>,
    /// Merged records, front to back.
    pub records: Vec<PixelRecord>,
    /// Entries that are no fragment's.
    pub extra: Vec<Extra>,
    /// The share of the background's light that is absorbed.
    pub absorbed: f64,
    /// As [`Inspected::absorbance`].
    pub absorbance: Vec<[f64; 2]>,
}

impl<'a> View<'a> {
    pub(super) fn new(scene: &'a Scene, options: &Options) -> Self {
        let format = options.record().depth;
        let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
        let front = FrontEnd::new(scene, grid, options.sub_pixel_bits, options.cull_face);
        let lens = Lens::new(&scene.camera, scene.size, format);
        let words = Words { depth: format, data: Data::Color };
        Self { scene, front, lens, words, data: options.data }
    }

    /// Bring a pixel's fragments into canonical order.
    pub(super) fn order(&self, generated: &mut [Generated]) {
        generated.sort_unstable_by_key(|g| (g.key(self.data), g.color, g.triangle));
    }

    /// The fragments of one pixel.
    fn pixel(&self, pixel: [u32; 2]) -> Vec<Generated> {
        let mut generated = Vec::new();
        self.front.fragments_of_pixel(pixel, self.words, |triangle, fragment| {
            generated.push(Generated { triangle, depth: fragment.depth, color: fragment.data });
        });
        self.order(&mut generated);
        generated
    }

    /// The colour of all fragments.
    pub(super) fn color(&self, generated: &[Generated]) -> [u8; 4] {
        let mut light = Ray::default();
        generated.iter().for_each(|g| light.over(g.color));
        light.finish(self.scene.background.map(word16))
    }

    /// What a method's frame holds at a pixel.
    pub(super) fn look(
        &self,
        facts: &Facts<'_>,
        kept: &Kept,
        [x, y]: [u32; 2],
        generated: &[Generated],
        promises: Option<&Promises<'_>>,
    ) -> Look {
        match kept {
            Kept::Fragments(lists) => {
                self.list(facts, lists.pixel(x, y), [x, y], generated, promises)
            }
            Kept::Records(lists) => self.records(facts, lists.pixel(x, y), generated),
            Kept::Color(lights) => {
                let light = &lights[y as usize * self.scene.size[0] as usize + x as usize];
                Look {
                    fates: fates::of_color(facts, generated.len(), light.kept),
                    absorbed: 1.0 - share(light.transmittance),
                    ..Look::default()
                }
            }
            Kept::Depths(_) | Kept::Gone(_) => Look::default(),
        }
    }

    /// A list of fragments.
    fn list(
        &self,
        facts: &Facts<'_>,
        kept: &[u64],
        [x, y]: [u32; 2],
        generated: &[Generated],
        promises: Option<&Promises<'_>>,
    ) -> Look {
        let data = facts.options.record().data;
        let own: Vec<u64> = generated.iter().map(|g| g.key(data)).collect();
        let mut sorted = own.clone();
        sorted.sort_unstable();
        let promised = match promises.and_then(|promises| promises.pixel([x, y], &sorted)) {
            Some(Held::Keys(keys)) => Some(keys),
            _ => None,
        };
        let lists =
            fates::Lists { own: &own, sorted: &sorted, kept, promised: promised.as_deref() };
        let color = |key: u64| match data {
            Data::Color | Data::Nothing => data_of(key),
            Data::Primitive => self.front.color_of(data_of(key), x, y, depth_of(key)),
        };
        let extra = |(what, key)| Extra {
            what,
            depth: depth_of(key),
            distance: self.lens.along(depth_of(key)),
            data: data_of(key),
        };
        let surface = |&key: &u64| Slab::surface(self.lens.along(depth_of(key)), color(key));
        let (absorbance, absorbed) = absorbance::along(kept.iter().map(surface));
        let fates = lists.fates(facts);
        let extra = lists.extra().into_iter().map(extra).collect();
        Look { fates, extra, absorbed, absorbance, ..Look::default() }
    }

    /// A list of merged records.
    fn records(&self, facts: &Facts<'_>, records: &[Record], generated: &[Generated]) -> Look {
        let distance = |depth| self.lens.along(depth);
        let record = |record: &Record| PixelRecord {
            depth: record.depth,
            distance: distance(record.depth),
            thickness: record.thickness,
            rgba: record.rgba,
            weight: record.weight,
        };
        let slab = |record: &Record| Slab::record(distance(record.depth), record);
        let (absorbance, absorbed) = absorbance::along(records.iter().map(slab));
        Look {
            fates: records::fates(facts, generated, records, distance),
            records: records.iter().map(record).collect(),
            extra: Vec::new(),
            absorbed,
            absorbance,
        }
    }
}

/// What is seen at one pixel.
pub(super) struct Sight<'a> {
    view: View<'a>,
    pixel: [u32; 2],
    /// In canonical order.
    generated: Vec<Generated>,
}

impl<'a> Sight<'a> {
    /// With the exact answer.
    pub(super) fn new(scene: &'a Scene, options: &Options, pixel: [u32; 2]) -> (Self, Exact) {
        let view = View::new(scene, options);
        let generated = view.pixel(pixel);
        let surface = |g: &Generated| Slab::surface(view.lens.along(g.depth), g.color);
        let (absorbance, absorbed) = absorbance::along(generated.iter().map(surface));
        let exact = Exact { color: view.color(&generated), absorbed, absorbance };
        (Self { view, pixel, generated }, exact)
    }

    pub(super) fn fragments(&self) -> Vec<PixelFragment> {
        let solids = Solids::new(self.view.scene);
        let object = |triangle| Some(solids.names()[solids.part(triangle)?.solid].clone());
        let fragment = |(index, g): (usize, &Generated)| PixelFragment {
            index,
            object: object(g.triangle),
            triangle: g.triangle,
            depth: g.depth,
            distance: self.view.lens.along(g.depth),
            rgba: g.color.to_le_bytes(),
        };
        self.generated.iter().enumerate().map(fragment).collect()
    }

    /// Draw with one method.
    pub(super) fn inspect(&self, options: &Options, exact: &Exact) -> Result<Inspected> {
        let options = Options { counters: false, ..options.clone() };
        let scene = self.view.scene;
        let drawn = render(scene, &options)?;
        let [x, y] = self.pixel;
        let facts = Facts { options: &options, report: &drawn.report };
        let look = with_promises(scene, &options, &drawn.kept, |promises| {
            self.view.look(&facts, &drawn.kept, self.pixel, &self.generated, promises)
        })?;
        let color = drawn.image.pixel(x, y);
        let Look { fates, records, extra, absorbed, absorbance } = look;
        Ok(Inspected {
            method: options.method.name().to_owned(),
            exec: drawn.report.exec.clone(),
            k: k_of(&options, &drawn),
            color,
            difference: difference(color, exact.color),
            absorbed,
            records,
            fates,
            extra,
            absorbance,
            warnings: drawn.report.warnings,
            violations: drawn.report.violations,
        })
    }
}

/// Do something with what a method promises, if it keeps lists of fragments.
pub(super) fn with_promises<T>(
    scene: &Scene,
    options: &Options,
    kept: &Kept,
    then: impl FnOnce(Option<&Promises<'_>>) -> T,
) -> Result<T> {
    match kept {
        Kept::Fragments(_) => promising(scene, options, |promises| then(Some(promises))),
        _ => Ok(then(None)),
    }
}

/// The k that a frame was drawn with, if it decides what the method keeps.
pub(super) fn k_of(options: &Options, drawn: &Rendering) -> Option<u32> {
    drawn.report.k.filter(|&k| takes_k(options.method.contract(), k))
}

/// Whether k decides what the method keeps.
fn takes_k(contract: &Contract, k: u32) -> bool {
    let slots = contract.demand == Demand::MaxDepthComplexity;
    slots || contract.default_k.is_some() || contract.reference_k(Some(k)).is_some()
}

/// The largest difference of a channel.
fn difference(a: [u8; 4], b: [u8; 4]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}
