//! One pixel: its fragments, what becomes of each of them with several methods, and how much light is absorbed on the
//! way along the ray.

mod absorbance;
mod fates;
mod found;
pub mod frame;
mod gone;
mod plot;
mod records;
mod sight;

use crate::effect::Effect;
use crate::error::{Error, Result};
use crate::render::Options;
use crate::scene::Scene;
use crate::scheme::HeldKind;
use sight::Sight;

pub use found::{
    Became, Exact, Extra, Fate, Generated, Inspected, Inspection, PixelFragment, PixelRecord,
};
pub use sight::Look;

/// Draw `scene` with each of `methods`, and look at one pixel. The whole frame is drawn: what becomes of a pixel may
/// depend on all others, in a race, a pool or a table.
///
/// # Errors
/// As [`render()`](crate::render::render); a pixel outside of the picture, a method that gives depths and no lists, an effect or shadows, or
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
