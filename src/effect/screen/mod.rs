//! Effects in screen space over all layers ("Fragment merging with z-thickness", section 5.4): ambient occlusion
//! ([`occlusion`]), whose values multiply the layers' colours, and depth of field ([`focus`]) over layers as they then
//! are. Both take fragments, or merged records; of a record thicker than 10 P(z), they see the front and the back.

pub mod focus;
pub mod occlusion;

use rayon::prelude::*;

use self::focus::Focus;
use self::occlusion::Occlusion;
use super::layers::Layers;
use crate::error::Result;
use crate::image::Image;
use crate::num::color::word16;
use crate::resolve::Lists;
use crate::resolve::composite::Ray;
use crate::scene::Scene;
use crate::scheme::Record;

/// What is made of a frame's layers in screen space; at least one of both.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Screen {
    /// Ambient occlusion, first.
    pub occlusion: Option<Occlusion>,
    /// Depth of field, of what it has shaded.
    pub focus: Option<Focus>,
}

impl Screen {
    /// The name on the command line.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match (self.occlusion, self.focus) {
            (Some(_), Some(_)) => "ao+dof",
            (None, Some(_)) => "dof",
            _ => "ao",
        }
    }

    /// Check numbers.
    ///
    /// # Errors
    /// The option that is out of range.
    pub fn check(&self) -> Result<()> {
        self.occlusion.map_or(Ok(()), |occlusion| occlusion.check())?;
        self.focus.map_or(Ok(()), |focus| focus.check())
    }

    /// The layers with their shading, and the picture of them; `beta` is where slabs are cut.
    pub(super) fn draw(&self, layers: &Layers<'_>, beta: f64) -> (Lists<Record>, Image) {
        let mut lists = layers.lists();
        if let Some(occlusion) = &self.occlusion {
            occlusion.shade(layers, &mut lists);
        }
        let image = match &self.focus {
            Some(focus) => focus.draw(layers, &lists, beta),
            None => composited(layers.scene, &lists),
        };
        (lists, image)
    }
}

/// The picture of lists of records, as executors make it.
fn composited(scene: &Scene, lists: &Lists<Record>) -> Image {
    let Lists { width, height, .. } = *lists;
    let background = scene.background.map(word16);
    let pixel = |ends: &[u64]| {
        let mut ray = Ray::default();
        lists.entries[ends[0] as usize..ends[1] as usize].iter().for_each(|r| ray.over_record(r));
        ray.finish(background)
    };
    Image { width, height, pixels: lists.offsets.par_windows(2).map(pixel).collect() }
}
