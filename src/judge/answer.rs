//! The exact answer: every fragment of every pixel, with the triangle that it comes from, and the picture.

use rayon::prelude::*;

use crate::effect::lens::Lens;
use crate::effect::solids::Solids;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::num::depth::Format;
use crate::raster::{Batch, FrontEnd, Grid, Record};
use crate::render::{Data, Effect, Options, Wanted, render};
use crate::resolve::Lists;
use crate::scene::Scene;

/// A fragment, ordered as the exact answer has it: by depth, then by colour word, then by triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// The depth word.
    pub depth: u32,
    /// Linear, straight-alpha RGBA8, red lowest.
    pub color: u32,
    /// The global triangle index: the order of submission.
    pub triangle: u32,
}

/// What a scene must look like, and why.
#[derive(Debug)]
pub struct Answer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) options: Options,
    pub(super) front: FrontEnd,
    pub(super) solids: Solids,
    pub(super) lens: Lens,
    /// All fragments, also those beyond k.
    pub(super) lists: Lists<Entry>,
    pub(super) picture: Image,
    /// By triangle: whether its back is seen, and how far its middle and its object's are. See [`super::rule::order`].
    pub(super) facts: Vec<Facts>,
}

/// What orders and selections ask of a triangle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Facts {
    pub(super) back: bool,
    /// Depth of the middle of its corners.
    pub(super) middle: f64,
    /// The same of its whole object.
    pub(super) object: f64,
}

impl<'a> Answer<'a> {
    /// Draw `scene` with the exact method: `options` say the size of the grid, the faces, the format of depths, and k, of
    /// which the nearest are kept (all, if there is none). The method, its storage and its executor do not matter.
    ///
    /// # Errors
    /// As [`render()`]; a scene with volumes, or more memory than `options.max_memory` for the fragments.
    pub fn new(scene: &'a Scene, options: &Options) -> Result<Self> {
        if !scene.volumes.is_empty() {
            let problem = "has volumes: only surfaces are judged, since only they are fragments";
            return Err(Error::new(&scene.name[..], problem));
        }
        let options = Options {
            data: Data::Color,
            effect: Effect::default(),
            shadows: None,
            counters: false,
            wanted: Wanted::Picture,
            transparent: false,
            linear: false,
            ..options.exact(options.k)
        };
        let drawn = render(scene, &options)?;
        let needed = drawn.report.generated * 2 * size_of::<Entry>() as u64;
        if needed > options.max_memory {
            let (most, generated) = (options.max_memory, drawn.report.generated);
            let problem =
                format!("{most} bytes, but {generated} fragments need {needed} to be judged");
            return Err(Error::new("--max-memory", problem));
        }
        let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
        let front = FrontEnd::outlined(scene, grid, options.sub_pixel_bits, options.cull_face);
        let format = options.record().depth;
        let lists = gather(&front, format);
        let facts = facts(scene, &front);
        let lens = Lens::new(&scene.camera, scene.size, format);
        let (picture, solids) = (drawn.image, Solids::new(scene));
        Ok(Self { scene, options, front, solids, lens, lists, picture, facts })
    }

    /// The picture that is right.
    #[must_use]
    pub fn picture(&self) -> &Image {
        &self.picture
    }

    /// All fragments of every pixel, front to back, also those beyond k.
    #[must_use]
    pub fn lists(&self) -> &Lists<Entry> {
        &self.lists
    }

    /// The object that a triangle belongs to; none for triangles given in pixels.
    #[must_use]
    pub fn object(&self, triangle: u32) -> Option<&str> {
        Some(&self.solids.names()[self.solids.part(triangle)?.solid])
    }

    /// The entries of a pixel by its number, row by row.
    pub(super) fn list(&self, pixel: usize) -> &[Entry] {
        of(&self.lists, pixel)
    }
}

/// The entries of a pixel by its number, row by row.
pub(super) fn of(lists: &Lists<Entry>, pixel: usize) -> &[Entry] {
    &lists.entries[lists.offsets[pixel] as usize..lists.offsets[pixel + 1] as usize]
}

/// All fragments of a front end.
pub(super) fn gather(front: &FrontEnd, format: Format) -> Lists<Entry> {
    let grid = &front.grid;
    let record = Record { depth: format, data: Data::Color };
    let tile = |tile: usize| {
        let (mut found, mut batch) = (Vec::new(), Batch::default());
        front.packets(tile, |packet| {
            front.fragments(packet, record, 0, &mut batch);
            let triangle = front.primitive(packet.primitive).triangle;
            let (x, y) = (u32::from(packet.column) * 8, u32::from(packet.row) * 8);
            for fragment in batch.iter() {
                let pixel = (y + fragment.pixel / 8) * grid.width + x + fragment.pixel % 8;
                let (depth, color) = (fragment.depth, fragment.data);
                found.push((pixel, Entry { depth, color, triangle }));
            }
        });
        found.sort_unstable();
        found
    };
    let tiles: Vec<_> = (0..grid.tiles()).into_par_iter().map(tile).collect();
    join(grid, &tiles)
}

/// From parts, each sorted by pixel and holding whole pixels, to lists row by row.
pub(super) fn join(grid: &Grid, parts: &[Vec<(u32, Entry)>]) -> Lists<Entry> {
    let pixels = grid.width as usize * grid.height as usize;
    let mut offsets = vec![0_u64; pixels + 1];
    for (pixel, _) in parts.iter().flatten() {
        offsets[*pixel as usize + 1] += 1;
    }
    for pixel in 0..pixels {
        offsets[pixel + 1] += offsets[pixel];
    }
    let none = Entry { depth: 0, color: 0, triangle: 0 };
    let mut entries = vec![none; offsets[pixels] as usize];
    for part in parts {
        for run in part.chunk_by(|a, b| a.0 == b.0) {
            let start = offsets[run[0].0 as usize] as usize;
            for (place, (_, entry)) in entries[start..].iter_mut().zip(run) {
                *place = *entry;
            }
        }
    }
    Lists { width: grid.width, height: grid.height, offsets, entries }
}

/// By triangle. Middles are measured as depth in eye space; for triangles in pixels, by their z.
fn facts(scene: &Scene, front: &FrontEnd) -> Vec<Facts> {
    let view = scene.camera.view();
    let mut facts = Vec::with_capacity(front.triangles as usize);
    for object in &scene.objects {
        let (mesh, to_eye) = (&object.mesh, view * object.transform);
        let ahead = |p: [f64; 3]| -to_eye.transform_point3(p.into()).z;
        let depths: Vec<f64> = mesh.positions.iter().map(|&p| ahead(p)).collect();
        let triangles =
            mesh.triangles.iter().map(|t| t.map(|v| depths[v as usize]).iter().sum::<f64>() / 3.0);
        let middles = triangles.chain(mesh.discs.iter().map(|disc| ahead(disc.center)));
        let start = facts.len();
        facts.extend(middles.map(|middle| Facts { middle, ..Facts::default() }));
        let own = &mut facts[start..];
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for fact in &*own {
            (least, most) = (least.min(fact.middle), most.max(fact.middle));
        }
        own.iter_mut().for_each(|fact| fact.object = (least + most) / 2.0);
    }
    for triangle in &scene.screen {
        let middle = triangle.points.iter().map(|p| p[2]).sum::<f64>() / 3.0;
        facts.push(Facts { middle, object: middle, back: false });
    }
    for (triangle, fact) in (0..).zip(&mut facts) {
        fact.back = front.is_back(triangle).unwrap_or(false);
    }
    facts
}
