//! A pixel's fragments, and each method drawn and looked at there.

use super::absorbance::{self, Slab, share};
use super::found::{Exact, Extra, Generated, Inspected, PixelFragment, PixelRecord};
use super::gone::Facts;
use super::{fates, records};
use crate::effect::lens::Lens;
use crate::effect::solids::Solids;
use crate::error::Result;
use crate::fragment::{Data, data_of, depth_of};
use crate::num::color::word16;
use crate::raster::{FrontEnd, Grid, Record as Words};
use crate::render::{Kept, Options, promised, render};
use crate::resolve::composite::Ray;
use crate::scene::Scene;
use crate::scheme::contract::{Contract, Demand};
use crate::scheme::{Held, Record};

/// What is seen at the pixel.
pub(super) struct Sight<'a> {
    scene: &'a Scene,
    front: FrontEnd,
    lens: Lens,
    pixel: [u32; 2],
    /// In canonical order.
    generated: Vec<Generated>,
}

impl<'a> Sight<'a> {
    /// With the exact answer.
    pub(super) fn new(scene: &'a Scene, options: &Options, pixel: [u32; 2]) -> (Self, Exact) {
        let format = options.record().depth;
        let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
        let front = FrontEnd::new(scene, grid, options.sub_pixel_bits, options.cull_face);
        let mut generated = Vec::new();
        front.fragments_of_pixel(
            pixel,
            Words { depth: format, data: Data::Color },
            |triangle, fragment| {
                generated.push(Generated { triangle, depth: fragment.depth, color: fragment.data });
            },
        );
        generated.sort_unstable_by_key(|g| (g.key(options.data), g.color, g.triangle));
        let lens = Lens::new(&scene.camera, scene.size, format);
        let mut light = Ray::default();
        generated.iter().for_each(|g| light.over(g.color));
        let surface = |g: &Generated| Slab::surface(lens.along(g.depth), g.color);
        let (absorbance, absorbed) = absorbance::along(generated.iter().map(surface));
        let color = light.finish(scene.background.map(word16));
        let exact = Exact { color, absorbed, absorbance };
        (Self { scene, front, lens, pixel, generated }, exact)
    }

    pub(super) fn fragments(&self) -> Vec<PixelFragment> {
        let solids = Solids::new(self.scene);
        let object = |triangle| Some(solids.names()[solids.part(triangle)?.solid].clone());
        let fragment = |(index, g): (usize, &Generated)| PixelFragment {
            index,
            object: object(g.triangle),
            triangle: g.triangle,
            depth: g.depth,
            distance: self.lens.along(g.depth),
            rgba: g.color.to_le_bytes(),
        };
        self.generated.iter().enumerate().map(fragment).collect()
    }

    /// Draw with one method.
    pub(super) fn inspect(&self, options: &Options, exact: &Exact) -> Result<Inspected> {
        let options = Options { counters: false, ..options.clone() };
        let drawn = render(self.scene, &options)?;
        let [x, y] = self.pixel;
        let place = y as usize * self.scene.size[0] as usize + x as usize;
        let facts = Facts { options: &options, report: &drawn.report };
        let color = drawn.image.pixel(x, y);
        let mut found = Inspected {
            method: options.method.name().to_owned(),
            exec: drawn.report.exec.clone(),
            k: drawn.report.k.filter(|&k| takes_k(options.method.contract(), k)),
            color,
            difference: difference(color, exact.color),
            absorbed: 0.0,
            records: Vec::new(),
            fates: Vec::new(),
            extra: Vec::new(),
            absorbance: Vec::new(),
            warnings: drawn.report.warnings.clone(),
            violations: drawn.report.violations.clone(),
        };
        match &drawn.kept {
            Kept::Fragments(lists) => self.list(&facts, lists.pixel(x, y), &mut found)?,
            Kept::Records(lists) => self.records(&facts, lists.pixel(x, y), &mut found),
            Kept::Color(lights) => {
                let light = &lights[place];
                found.fates = fates::of_color(&facts, self.generated.len(), light.kept);
                found.absorbed = 1.0 - share(light.transmittance);
            }
            Kept::Depths(_) | Kept::Gone => {}
        }
        Ok(found)
    }

    /// A list of fragments.
    fn list(&self, facts: &Facts<'_>, kept: &[u64], found: &mut Inspected) -> Result<()> {
        let data = facts.options.record().data;
        let own: Vec<u64> = self.generated.iter().map(|g| g.key(data)).collect();
        let mut sorted = own.clone();
        sorted.sort_unstable();
        let promised = self.promised(facts, &sorted)?;
        let lists =
            fates::Lists { own: &own, sorted: &sorted, kept, promised: promised.as_deref() };
        found.fates = lists.fates(facts);
        let extra = |(what, key)| Extra {
            what,
            depth: depth_of(key),
            distance: self.lens.along(depth_of(key)),
            data: data_of(key),
        };
        found.extra = lists.extra().into_iter().map(extra).collect();
        let surface = |&key: &u64| {
            let color = match data {
                Data::Color | Data::Nothing => data_of(key),
                Data::Primitive => {
                    let [x, y] = self.pixel;
                    self.front.color_of(data_of(key), x, y, depth_of(key))
                }
            };
            Slab::surface(self.lens.along(depth_of(key)), color)
        };
        (found.absorbance, found.absorbed) = absorbance::along(kept.iter().map(surface));
        Ok(())
    }

    /// What the method must keep of the sorted keys; `None` if it does not say.
    fn promised(&self, facts: &Facts<'_>, sorted: &[u64]) -> Result<Option<Vec<u64>>> {
        let held = promised(self.scene, facts.options, self.pixel, sorted)?;
        Ok(held.and_then(|held| if let Held::Keys(keys) = held { Some(keys) } else { None }))
    }

    /// A list of merged records.
    fn records(&self, facts: &Facts<'_>, records: &[Record], found: &mut Inspected) {
        let distance = |depth| self.lens.along(depth);
        found.fates = records::fates(facts, &self.generated, records, distance);
        let record = |record: &Record| PixelRecord {
            depth: record.depth,
            distance: distance(record.depth),
            thickness: record.thickness,
            rgba: record.rgba,
            weight: record.weight,
        };
        found.records = records.iter().map(record).collect();
        let slab = |record: &Record| Slab::record(distance(record.depth), record);
        (found.absorbance, found.absorbed) = absorbance::along(records.iter().map(slab));
    }
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
