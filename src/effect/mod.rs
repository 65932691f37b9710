//! What is made from sorted lists of fragments, other than transparency: translucent media, constructive solid
//! geometry, layered depth images and voxels, shadows (HA-buffer paper, Lefebvre, Hornus, Lasram 2013, section 6).
//!
//! An effect takes the resolved lists of a frame, so it is the same for every method, executor and schedule that gives
//! the same lists. An effect does not see what a method did not keep; the caller that draws reports the loss.
//!
//! * [`media`]: absorption between the faces where a ray enters an object and where it leaves it.
//! * [`csg`]: a Boolean expression over closed objects.
//! * [`ldi`]: depths alone; what is solid by parity.
//! * [`screen`]: ambient occlusion and depth of field over all layers, also merged ones.
//! * [`volume`]: volumes between the surfaces of a transparent picture.
//! * [`shadow`]: lists seen from the light attenuate the shading of the view's fragments. It is not an [`Effect`], but
//!   combines with any of them.

pub mod csg;
pub mod layers;
pub mod ldi;
pub mod lens;
pub mod media;
pub mod screen;
pub mod shadow;
pub mod solids;
pub mod volume;

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::image::Image;
use crate::num::color::{srgb, word16};
use crate::num::depth::Format;
use crate::raster::FrontEnd;
use crate::resolve::Lists;
use crate::scene::Scene;
use crate::scheme::Record;
use layers::Layers;
use screen::Screen;
use volume::{Marching, Scenery};

/// What is made from a frame's lists.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Effect {
    /// Order-independent transparency: the surfaces composited over each other, as executors do it.
    #[default]
    Transparency,
    /// Media that fill objects.
    Media {
        /// Multiplies all absorption: what a material's colour and opacity do to light over one world unit, they do
        /// over 1 / density. 0 or more.
        density: f64,
    },
    /// A Boolean expression over closed objects.
    Csg(csg::Expression),
    /// A layered depth image.
    Ldi {
        /// Cut the image's depth into this many slices of voxels as well.
        voxels: Option<u32>,
    },
    /// Ambient occlusion, depth of field, or both.
    Screen(Screen),
}

impl Effect {
    /// The name on the command line.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Transparency => "oit",
            Self::Media { .. } => "media",
            Self::Csg(_) => "csg",
            Self::Ldi { .. } => "ldi",
            Self::Screen(screen) => screen.name(),
        }
    }

    /// Whether it needs the triangles of fragments.
    #[must_use]
    pub fn needs_primitives(&self) -> bool {
        matches!(self, Self::Media { .. } | Self::Csg(_))
    }

    /// Whether it walks through solids, and so needs both their faces and all their fragments.
    #[must_use]
    pub fn needs_solids(&self) -> bool {
        !self.takes_layers()
    }

    /// Whether merged records will do, and the scene's volumes can be seen (but for depth of field).
    #[must_use]
    pub fn takes_layers(&self) -> bool {
        matches!(self, Self::Transparency | Self::Screen(_))
    }

    /// Check numbers, and what the scene must have, before anything is drawn.
    ///
    /// # Errors
    /// The option that is out of range, a scene without objects, points where objects must enclose something, or a name
    /// that no object has.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        let fills = !matches!(self, Self::Transparency | Self::Ldi { voxels: None });
        let mut points = scene.objects.iter().filter(|object| !object.mesh.discs.is_empty());
        if let Some(object) = points.next().filter(|_| fills) {
            let problem = format!(
                "{} needs closed objects, but '{}' has points, which enclose nothing",
                self.name(),
                object.name
            );
            return Err(Error::new("--effect", problem));
        }
        match self {
            Self::Media { density } if !(density.is_finite() && *density >= 0.0) => {
                Err(Error::new("--density", format!("{density} must be 0 or more, and finite")))
            }
            Self::Screen(screen) => screen.check(),
            Self::Ldi { voxels: Some(slices) } => ldi::check(*slices),
            Self::Media { .. } | Self::Csg(_) if scene.objects.is_empty() => {
                let problem = format!(
                    "{} needs objects, but {} has only triangles given in pixels, which enclose nothing",
                    self.name(),
                    scene.name
                );
                Err(Error::new("--effect", problem))
            }
            Self::Csg(expression) => expression.bind(solids::Solids::new(scene).names()).map(drop),
            _ => Ok(()),
        }
    }
}

/// What effects work on.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// What is drawn.
    pub scene: &'a Scene,
    /// Its primitives.
    pub front: &'a FrontEnd,
    /// How depths are stored.
    pub format: Format,
    /// The kept fragments, front to back.
    pub lists: &'a Lists,
}

impl Stage<'_> {
    fn background(&self) -> [u16; 3] {
        self.scene.background.map(word16)
    }

    fn background_pixel(&self) -> [u8; 4] {
        let [r, g, b] = self.background().map(srgb);
        [r, g, b, 255]
    }
}

/// The result of an effect.
#[derive(Clone, Debug, Default)]
pub struct Made {
    /// The picture, unless it is the one that was composited.
    pub image: Option<Image>,
    /// The fragments that are surfaces of a Boolean combination.
    pub surfaces: Option<Lists>,
    /// What is solid.
    pub voxels: Option<ldi::Voxels>,
    /// For every object, at how many pixels its faces do not pair; without objects, under the name `scene`.
    pub open: BTreeMap<String, u64>,
    /// What was tolerated.
    pub warnings: Vec<String>,
}

impl Made {
    fn picture(&mut self, stage: &Stage<'_>, pixels: Vec<[u8; 4]>) {
        let Lists { width, height, .. } = *stage.lists;
        self.image = Some(Image { width, height, pixels });
    }

    /// Report an object that is not closed.
    fn open(&mut self, name: &str, pixels: u64, how: &str) {
        if pixels > 0 {
            self.open.insert(name.to_owned(), pixels);
            self.warnings
                .push(format!("object '{name}' is not closed: {pixels} pixels have {how}"));
        }
    }
}

/// Apply an effect that takes layers, with the scene's volumes, to a frame whose picture was composited; `beta` is where
/// slabs are cut.
#[must_use]
pub fn make_of_layers(
    effect: &Effect,
    layers: &Layers<'_>,
    marching: &Marching,
    beta: f64,
    composited: &Image,
) -> Made {
    let mut made = Made::default();
    let (scene, format) = (layers.scene, layers.format);
    let mut shaded = None;
    if let Effect::Screen(screen) = effect {
        let (lists, image) = screen.draw(layers, beta);
        made.image = Some(image);
        shaded = Some(lists);
        if screen.focus.is_some() {
            made.warnings.extend(without_volumes(effect, scene));
            return made;
        }
    }
    if scene.volumes.is_empty() {
        return made;
    }
    let mut picture = made.image.take().unwrap_or_else(|| composited.clone());
    match &shaded {
        Some(lists) => {
            let of = |x, y, out: &mut Vec<Record>| out.extend_from_slice(lists.pixel(x, y));
            Scenery { scene, format, beta, layers: of }.draw(marching, &mut picture);
        }
        None => {
            let of = |x, y, out: &mut Vec<Record>| layers.pixel(x, y, out);
            Scenery { scene, format, beta, layers: of }.draw(marching, &mut picture);
        }
    }
    made.image = Some(picture);
    made
}

/// What to say of an effect that does not draw volumes, where there are any.
#[must_use]
pub fn without_volumes(effect: &Effect, scene: &Scene) -> Option<String> {
    let there = !scene.volumes.is_empty();
    there.then(|| format!("{}: the scene's volumes are not drawn", effect.name()))
}

/// Apply any other effect to a stage whose scene it has checked.
///
/// # Errors
/// As [`Effect::check`].
pub fn make(effect: &Effect, stage: &Stage<'_>) -> Result<Made> {
    match effect {
        Effect::Transparency | Effect::Screen(_) => Ok(Made::default()),
        Effect::Media { density } => Ok(media::draw(stage, *density)),
        Effect::Csg(expression) => csg::draw(stage, expression),
        Effect::Ldi { voxels } => Ok(ldi::draw(stage, *voxels)),
    }
}

/// Sum counts that rows found, position by position.
fn sums<'a>(rows: impl Iterator<Item = &'a Vec<u64>>, length: usize) -> Vec<u64> {
    let mut sums = vec![0; length];
    for row in rows {
        sums.iter_mut().zip(row).for_each(|(sum, count)| *sum += count);
    }
    sums
}
