//! Constructive solid geometry: the picture of a Boolean combination of closed meshes (HA-buffer paper, section 6.3).
//!
//! A pixel's list is walked front to back with a bit per object, which says whether the walk is inside of it. A
//! fragment of an object toggles its bit: by parity, as in the paper, so that it does not matter how meshes are wound.
//! The combination has a surface wherever the expression's value changes. Fragments of equal depth are one step, all
//! bits first and the expression after them, so that faces which lie in one plane leave no sliver between them. (Depths
//! of different triangles of one sloping plane may differ by a unit of their last place, where each is rounded; with
//! `--depth-format d24` few such pairs are left.)
//!
//! The picture shows the first surface at which the value becomes true, opaque, in the colour of its fragment. An
//! expression that is true outside of all objects, such as `~a`, is true at the eye: the solid that contains the eye is
//! not seen.

mod expression;
mod walk;

pub use expression::{Expression, MAX_NESTING, MAX_OBJECTS};
pub use walk::{Change, walk};

use rayon::prelude::*;

use super::{Made, Stage, solids::Solids};
use crate::error::Result;
use crate::fragment::{data_of, depth_of};
use crate::num::color::srgb;
use crate::resolve::Lists;

/// One row of the picture.
#[derive(Default)]
struct Scanline {
    colors: Vec<[u8; 4]>,
    counts: Vec<u64>,
    keys: Vec<u64>,
    /// Pixels of odd parity by object.
    open: Vec<u64>,
}

/// Draw what the expression describes; its surfaces are the lists that are returned.
///
/// # Errors
/// A name that no object has.
pub(super) fn draw(stage: &Stage<'_>, expression: &Expression) -> Result<Made> {
    let solids = Solids::new(stage.scene);
    let bound = expression.bind(solids.names())?;
    let bit = |triangle: u32| {
        let solid = solids.part(triangle)?.solid;
        bound.iter().position(|&known| known == solid).map(|bit| bit as u32)
    };
    let background = stage.background_pixel();
    let row = |y: u32| {
        let mut row = Scanline { open: vec![0; bound.len()], ..Scanline::default() };
        for x in 0..stage.lists.width {
            let (first, mut seen) = (row.keys.len(), None);
            let odd = walk(expression, stage.lists.pixel(x, y), bit, |change| {
                row.keys.push(change.key);
                seen = seen.or(change.inside.then_some(change.key));
            });
            row.open.iter_mut().enumerate().for_each(|(bit, open)| *open += odd >> bit & 1);
            row.counts.push((row.keys.len() - first) as u64);
            row.colors.push(seen.map_or(background, |key| {
                let word = stage.front.color_of(data_of(key), x, y, depth_of(key));
                let [r, g, b, _] = word.to_le_bytes().map(|byte| srgb(u16::from(byte) * 257));
                [r, g, b, 255]
            }));
        }
        row
    };
    let rows: Vec<Scanline> = (0..stage.lists.height).into_par_iter().map(row).collect();
    let mut made = Made::default();
    for (bit, name) in expression.names().enumerate() {
        let open = rows.iter().map(|row| row.open[bit]).sum();
        made.open(name, open, "odd parity");
    }
    let (width, height) = (stage.lists.width, stage.lists.height);
    let mut surfaces = Lists { width, height, offsets: vec![0], entries: Vec::new() };
    let mut colors = Vec::with_capacity(surfaces.offsets.capacity());
    for row in rows {
        let mut end = surfaces.entries.len() as u64;
        surfaces.offsets.extend(row.counts.iter().map(|count| {
            end += count;
            end
        }));
        surfaces.entries.extend(row.keys);
        colors.extend(row.colors);
    }
    made.picture(stage, colors);
    made.surfaces = Some(surfaces);
    Ok(made)
}
