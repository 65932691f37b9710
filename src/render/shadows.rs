//! The frame from the light: the same scene, method and executor, seen along the light.

use super::{Exec, Options, Report, ShadowReport, Sim, TableOptions, Wanted};
use crate::effect::Effect;
use crate::effect::lens::Lens;
use crate::effect::shadow::{self, ShadowMap};
use crate::error::{Error, Result};
use crate::exec::Kit;
use crate::fragment::Data;
use crate::raster::CullFace;
use crate::scene::{Bounds, Camera, Scene, Shading};

/// The opacity of a colour word.
const OPAQUE: u64 = 0xFF00_0000;

/// A shadow map and how it was made, or nothing.
#[derive(Default)]
pub(super) struct Shadow {
    pub(super) map: Option<ShadowMap>,
    pub(super) outcome: Option<Outcome>,
}

/// What the frame from the light adds to the view's report.
pub(super) struct Outcome {
    report: ShadowReport,
    deterministic: Vec<String>,
    violations: Vec<String>,
}

/// Draw the shadow map, if `options` ask for shadows.
pub(super) fn draw(scene: &Scene, options: &Options, threads: usize) -> Result<Shadow> {
    let Some(asked) = options.shadows else { return Ok(Shadow::default()) };
    if scene.objects.is_empty() {
        let problem = format!(
            "{} has no objects, only triangles given in pixels, which the light does not see",
            scene.name
        );
        return Err(Error::new("--shadows", problem));
    }
    let size = asked.size.unwrap_or(scene.size[0].max(scene.size[1]));
    let camera = Camera::of_light(Bounds::of(&scene.objects), scene.light.towards);
    camera.check("--shadows")?;
    let bias = asked.bias.unwrap_or_else(|| shadow::default_bias(&camera, size));
    let kit = Kit::default();
    let drawn = super::draw(&lit(scene, camera, size), &plain(options), threads, &kit)?;
    let report = ShadowReport {
        size,
        bias,
        generated: drawn.report.generated,
        kept: drawn.report.kept,
        fragments_hash: drawn.report.fragments_hash.clone(),
    };
    let format = options.record().depth;
    let view = Lens::new(&scene.camera, scene.size, format);
    // What is cut away casts no shadow, and what is left is opaque.
    let lists = match &drawn.surfaces {
        Some(surfaces) => surfaces.cut(|_, keys| keys.iter_mut().for_each(|key| *key |= OPAQUE)),
        None => drawn.lists()?.clone(),
    };
    let (deterministic, violations) = (drawn.report.deterministic, drawn.report.violations);
    let map = ShadowMap::new(view, &camera, format, lists, bias);
    let outcome = Outcome { report, deterministic, violations };
    Ok(Shadow { map: Some(map), outcome: Some(outcome) })
}

/// The scene as the light sees it: unlit colours, and only what has a place in the world.
fn lit(scene: &Scene, camera: Camera, size: u32) -> Scene {
    let mut scene = Scene { camera, size: [size; 2], ..scene.clone() };
    scene.materials.iter_mut().for_each(|material| material.shading = Shading::Flat);
    scene.screen.clear();
    scene.volumes.clear();
    scene
}

/// The options of a frame that is drawn for its lists of colours, or for the surfaces of a Boolean combination.
fn plain(options: &Options) -> Options {
    let (effect, data) = match &options.effect {
        csg @ Effect::Csg(_) => (csg.clone(), Data::Primitive),
        _ => (Effect::Transparency, Data::Color),
    };
    // A table that is sized for the image need not fit the light's image.
    let table = TableOptions { size: None, ..options.table.clone() };
    let cull_face = CullFace::None;
    // Nobody looks from there.
    let importance = options.importance.elsewhere();
    let shadows = None;
    let mut plain = Options {
        wanted: Wanted::Lists,
        data,
        cull_face,
        effect,
        linear: false,
        transparent: false,
        shadows,
        table,
        importance,
        ..options.clone()
    };
    if let Exec::Sim(Sim { watch, .. }) = &mut plain.exec {
        *watch = None;
    }
    plain
}

impl Outcome {
    /// What depends on the map is as deterministic as the map is.
    pub(super) fn add_to(self, report: &mut Report) {
        if !self.deterministic.iter().any(|field| field == "fragments_hash") {
            report.deterministic.retain(|field| !field.ends_with("_hash"));
        }
        let missing = self.report.generated.saturating_sub(self.report.kept);
        if missing > 0 {
            report.warnings.push(format!(
                "shadows: {} did not keep {missing} of {} fragments that the light sees; these cast no shadow",
                report.method, self.report.generated
            ));
        }
        let violations = self.violations.into_iter();
        report.violations.extend(violations.map(|violation| format!("shadows: {violation}")));
        report.shadows = Some(self.report);
    }
}
