//! One pixel: its fragments, what becomes of each of them with several methods, and how much light is absorbed on the
//! way along the ray.

mod absorbance;
mod fates;
mod gone;
mod plot;
mod records;

use serde::Serialize;

use crate::effect::Effect;
use crate::effect::lens::Lens;
use crate::effect::solids::Solids;
use crate::error::{Error, Result};
use crate::fragment::{Data, data_of, depth_of, key};
use crate::num::color::word16;
use crate::num::depth::Format;
use crate::raster::{FrontEnd, Grid, Record as Words};
use crate::render::{Kept, Options, promised, render};
use crate::resolve::composite::Ray;
use crate::scene::Scene;
use crate::scheme::{Held, HeldKind, Record};
use absorbance::{Slab, share};
use gone::Facts;

/// A pixel's fragments before and after each method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Column and row from the top left.
    pub pixel: [u32; 2],
    /// The scene's name.
    pub scene: String,
    /// Pixels of the picture across.
    pub width: u32,
    /// Pixels of the picture down.
    pub height: u32,
    /// Linear RGB, 0 to 1.
    pub background: [f32; 3],
    /// What a depth word is.
    pub depth_format: Format,
    /// All fragments in canonical order.
    pub fragments: Vec<PixelFragment>,
    /// What they give, one over the other.
    pub exact: Exact,
    /// In the order in which they were given.
    pub methods: Vec<Inspected>,
}

/// A fragment as it was generated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PixelFragment {
    /// Its place in canonical order, from 0.
    pub index: usize,
    /// The object's name; none for triangles given in pixels.
    pub object: Option<String>,
    /// The global triangle index.
    pub triangle: u32,
    /// The stored depth word.
    pub depth: u32,
    /// From the eye's plane along the line of sight, in world units.
    pub distance: f64,
    /// Linear colour and opacity, each 0 to 255.
    pub rgba: [u8; 4],
}

/// The exact answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exact {
    /// sRGB.
    pub color: [u8; 4],
    /// The share of the background's light that is absorbed.
    pub absorbed: f64,
    /// As [`Inspected::absorbance`].
    pub absorbance: Vec<[f64; 2]>,
}

/// What one method makes of the pixel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspected {
    /// Its name.
    pub method: String,
    /// The executor.
    pub exec: String,
    /// Fragments kept per pixel; none is all, or another number for each pixel.
    pub k: Option<u32>,
    /// sRGB.
    pub color: [u8; 4],
    /// The largest difference of a channel from the exact colour.
    pub difference: u8,
    /// The share of the background's light that is absorbed.
    pub absorbed: f64,
    /// Merged records, front to back; none where the method keeps fragments or a colour.
    pub records: Vec<PixelRecord>,
    /// What became of each fragment.
    pub fates: Vec<Fate>,
    /// What the pixel's list holds besides.
    pub extra: Vec<Extra>,
    /// Corners of the absorbance as a function of the distance, front to back: 1 minus the transmittance, which a
    /// fragment raises at once and a merged record along its thickness. None where the pixel holds a colour alone.
    pub absorbance: Vec<[f64; 2]>,
    /// What was tolerated in the whole frame.
    pub warnings: Vec<String>,
    /// What the method promised and did not keep in the whole frame.
    pub violations: Vec<String>,
}

/// A merged record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PixelRecord {
    /// The stored depth word of its far end.
    pub depth: u32,
    /// Of its far end, in world units.
    pub distance: f64,
    /// How far it reaches from there towards the eye, in world units.
    pub thickness: f64,
    /// Linear, multiplied by the opacity, and the opacity: all 0 to 1.
    pub rgba: [f64; 4],
    /// How many fragments it stands for.
    pub weight: f64,
}

/// What became of a fragment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fate {
    /// In a word.
    pub fate: Became,
    /// What is known besides.
    pub reason: Option<String>,
    /// The record that it is, or is part of, from 0.
    pub record: Option<usize>,
}

/// The fate of a fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Became {
    /// It is in the pixel's list.
    Kept,
    /// It is part of a record, or of the pixel's colour.
    Merged,
    /// Rejected before it was stored.
    Culled,
    /// Stored, and pushed out later.
    Evicted,
    /// There was no room for it, for the reason that is given.
    Dropped,
    /// The method promises to keep it, and it is gone.
    Lost,
    /// It is gone, as the method allows; how is not known.
    NotKept,
}

impl Became {
    /// The name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Merged => "merged",
            Self::Culled => "culled",
            Self::Evicted => "evicted",
            Self::Dropped => "dropped",
            Self::Lost => "lost",
            Self::NotKept => "not-kept",
        }
    }
}

/// An entry of a pixel's list that is not one of its fragments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Extra {
    /// `duplicated`: it is there more often than it was generated; `torn`: it was never generated.
    pub what: &'static str,
    /// The stored depth word.
    pub depth: u32,
    /// In world units.
    pub distance: f64,
    /// The stored data word.
    pub data: u32,
}

/// Draw `scene` with each of `methods`, and look at one pixel. The whole frame is drawn: what becomes of a pixel may
/// depend on all others, in a race, a pool or a table.
///
/// # Errors
/// As [`render()`]; a pixel outside of the picture, a method that gives depths and no lists, an effect or shadows, or
/// methods that are given different depth formats or rasterizers.
///
/// # Examples
/// ```
/// use fragloom::inspect::{Became, inspect};
/// use fragloom::render::Options;
/// use fragloom::scene::{self, Overrides};
///
/// let scene = scene::load("layers:count=6", &Overrides { size: Some([16, 16]), ..Overrides::default() })?;
/// let kplus = Options { k: Some(3), ..Options::default() };
/// let found = inspect(&scene, &[kplus], [5, 5])?;
/// assert_eq!(found.fragments.len(), 6);
/// assert_eq!(found.methods[0].fates.iter().filter(|fate| fate.fate == Became::Kept).count(), 3);
/// # Ok::<(), fragloom::error::Error>(())
/// ```
pub fn inspect(scene: &Scene, methods: &[Options], pixel: [u32; 2]) -> Result<Inspection> {
    check(scene, methods, pixel)?;
    let first = methods.first().cloned().unwrap_or_default();
    let (ray, exact) = Sight::new(scene, &first, pixel);
    let inspected = methods.iter().map(|options| ray.inspect(options, &exact));
    Ok(Inspection {
        pixel,
        scene: scene.name.clone(),
        width: scene.size[0],
        height: scene.size[1],
        background: scene.background,
        depth_format: first.record().depth,
        fragments: ray.fragments(),
        methods: inspected.collect::<Result<_>>()?,
        exact,
    })
}

fn check(scene: &Scene, methods: &[Options], [x, y]: [u32; 2]) -> Result<()> {
    let [width, height] = scene.size;
    let wrong = |place: &str, problem: String| Err(Error::new(place, problem));
    if x >= width || y >= height {
        let picture = format!("{width}x{height}");
        return wrong("--pixel", format!("{x},{y} is outside of the picture of {picture}"));
    }
    let Some(first) = methods.first() else { return Ok(()) };
    for options in methods {
        let method = options.method;
        if method.holds() == HeldKind::Depth {
            let gives = method.holds().name();
            return wrong("-m", format!("{method} gives {gives}: no fragment is left to look at"));
        }
        if options.effect != Effect::Transparency {
            return wrong("--effect", "must be transparency to inspect a pixel".to_owned());
        }
        if options.shadows.is_some() {
            return wrong("--shadows", "are drawn as a frame of their own: not here".to_owned());
        }
        let [depth, other] = [first, options].map(|options| options.record().depth.name());
        if depth != other {
            let problem =
                format!("{} stores {depth}, but {method} {other}: give one", first.method);
            return wrong("--depth-format", problem);
        }
        let rasterizer = |options: &Options| (options.sub_pixel_bits, options.cull_face);
        if rasterizer(first) != rasterizer(options) {
            let problem = format!("{method} and {} have different fragments", first.method);
            return wrong("--sub-pixel-bits or --cull-face", problem);
        }
    }
    Ok(())
}

/// A fragment as all methods get it.
#[derive(Clone, Copy, Debug)]
struct Generated {
    triangle: u32,
    depth: u32,
    /// RGBA8.
    color: u32,
}

impl Generated {
    /// What a method stores that stores this data word.
    fn key(&self, data: Data) -> u64 {
        let word = match data {
            Data::Color => self.color,
            Data::Primitive => self.triangle,
            Data::Nothing => 0,
        };
        key(self.depth, word)
    }
}

/// What is seen at the pixel.
struct Sight<'a> {
    scene: &'a Scene,
    front: FrontEnd,
    lens: Lens,
    pixel: [u32; 2],
    /// In canonical order.
    generated: Vec<Generated>,
}

impl<'a> Sight<'a> {
    /// With the exact answer.
    fn new(scene: &'a Scene, options: &Options, pixel: [u32; 2]) -> (Self, Exact) {
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

    fn fragments(&self) -> Vec<PixelFragment> {
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
    fn inspect(&self, options: &Options, exact: &Exact) -> Result<Inspected> {
        let options = Options { counters: false, ..options.clone() };
        let drawn = render(self.scene, &options)?;
        let [x, y] = self.pixel;
        let place = y as usize * self.scene.size[0] as usize + x as usize;
        let facts = Facts { options: &options, report: &drawn.report };
        let color = drawn.image.pixel(x, y);
        let mut found = Inspected {
            method: options.method.name().to_owned(),
            exec: drawn.report.exec.clone(),
            k: drawn.report.k,
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
            Kept::Depths(_) => {}
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

/// The largest difference of a channel.
fn difference(a: [u8; 4], b: [u8; 4]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}
