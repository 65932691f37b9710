//! Layered depth images and voxels: effects that need only a fragment's depth (HA-buffer paper, section 6: its 32-bit
//! form stores nothing else).
//!
//! A layered depth image is a frame's lists without their data. Parity decides what is solid: a point is inside if an
//! odd number of fragments lies in front of it. So meshes must be closed, and the overlap of two meshes counts as
//! outside. The slices of a voxel grid have equal thickness in depth, which from the near to the far plane goes from 0
//! to 1: for parallel rays, that is equal thickness in the world, too. Slice s of n has its centres at (s + 1/2) / n.
//!
//! The picture shows how much of 0..1 is solid, as a linear grey, white where there is most; pixels of odd parity are
//! red.

use rayon::prelude::*;

use super::{Made, Stage};
use crate::error::{Error, Result};
use crate::fragment::depth_of;
use crate::num::color::srgb;
use crate::num::depth::Format;
use crate::resolve::Lists;

/// The most slices.
pub const MAX_SLICES: u32 = 16_384;

/// The colour of pixels of odd parity.
pub const ODD: [u8; 4] = [255, 0, 0, 255];

/// A grid of what is solid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Voxels {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Slices in depth.
    pub slices: u32,
    /// 1 inside and 0 outside; slice after slice from the near plane, in each row after row from the top.
    pub inside: Vec<u8>,
}

/// Whether a number of slices is valid.
pub(super) fn check(slices: u32) -> Result<()> {
    if (1..=MAX_SLICES).contains(&slices) {
        return Ok(());
    }
    Err(Error::new("--voxels", format!("{slices} slices: must be 1 to {MAX_SLICES}")))
}

impl Voxels {
    /// Cut lists whose depths are stored in `format`.
    ///
    /// # Examples
    /// ```
    /// use fragloom::effect::ldi::Voxels;
    /// use fragloom::num::depth::{Format, code};
    /// use fragloom::resolve::Lists;
    ///
    /// // One pixel, solid from 0.25 to 0.75.
    /// let keys = [0.25, 0.75].map(|z| u64::from(code(z)) << 32).to_vec();
    /// let lists = Lists { width: 1, height: 1, offsets: vec![0, 2], entries: keys };
    /// assert_eq!(Voxels::new(&lists, Format::D32, 4).inside, [0, 1, 1, 0]);
    /// ```
    #[must_use]
    pub fn new(lists: &Lists, format: Format, slices: u32) -> Self {
        let Lists { width, height, .. } = *lists;
        let plane = width as usize * height as usize;
        let mut inside = vec![0; plane * slices as usize];
        inside.par_chunks_mut(plane.max(1)).enumerate().for_each(|(slice, voxels)| {
            let centre = (slice as f64 + 0.5) / f64::from(slices);
            for (voxel, ends) in voxels.iter_mut().zip(lists.offsets.windows(2)) {
                let keys = &lists.entries[ends[0] as usize..ends[1] as usize];
                let before = keys.partition_point(|&key| format.decode(depth_of(key)) < centre);
                *voxel = (before % 2) as u8;
            }
        });
        Self { width, height, slices, inside }
    }

    /// How many voxels are inside.
    #[must_use]
    pub fn solid(&self) -> u64 {
        self.inside.iter().map(|&voxel| u64::from(voxel)).sum()
    }
}

/// The picture of what is solid, and its voxels if requested.
pub(super) fn draw(stage: &Stage<'_>, slices: Option<u32>) -> Made {
    let lists = stage.lists;
    let pixels = || {
        lists.offsets.par_windows(2).map(|ends| &lists.entries[ends[0] as usize..ends[1] as usize])
    };
    let thickness = |keys: &[u64]| {
        let pairs = keys.chunks_exact(2).map(|pair| {
            stage.format.decode(depth_of(pair[1])) - stage.format.decode(depth_of(pair[0]))
        });
        pairs.fold(0.0, |sum, part| sum + part)
    };
    // A maximum is the same in any order.
    let most = pixels().map(thickness).reduce(|| 0.0, f64::max);
    let color = |keys: &[u64]| {
        if keys.len() % 2 == 1 {
            return ODD;
        }
        let share = if most > 0.0 { thickness(keys) / most } else { 0.0 };
        let grey = srgb((share * 65_535.0 + 0.5) as u16);
        [grey, grey, grey, 255]
    };
    let colors: Vec<[u8; 4]> = pixels().map(color).collect();
    let mut made = Made::default();
    let odd = pixels().filter(|keys| keys.len() % 2 == 1).count() as u64;
    if odd > 0 {
        made.open.insert("scene".to_owned(), odd);
        made.warnings.push(format!("the scene is not closed: {odd} pixels have odd parity"));
    }
    made.picture(stage, colors);
    made.voxels = slices.map(|slices| Voxels::new(lists, stage.format, slices));
    made
}
