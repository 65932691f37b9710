//! The picture in 16 bits of linear light, from what the pixels hold.
//!
//! Executors composite while they resolve, and keep 8 bits. What they kept, composited again by the same rule, gives the
//! same light, so runs that do not ask for it pay nothing.

use rayon::prelude::*;

use crate::effect::layers::Layers;
use crate::error::{Error, Result};
use crate::image::linear::Linear;
use crate::num::color::word16;
use crate::render::{Effect, Options};
use crate::resolve::Kept;
use crate::resolve::composite::Ray;
use crate::scene::Scene;
use crate::scheme::Record;

/// Refuse what is not composited from what pixels hold.
pub(super) fn check(options: &Options, scene: &Scene) -> Result<()> {
    let what = match (&options.effect, scene.volumes.is_empty()) {
        _ if !options.needs_light() => return Ok(()),
        (Effect::Transparency, true) => return Ok(()),
        (Effect::Transparency, false) => "a scene with volumes".to_owned(),
        (effect, _) => format!("--effect {}", effect.name()),
    };
    if options.transparent {
        let problem = format!("{what} gives no opacity: only composited surfaces do");
        return Err(Error::new("--transparent", problem));
    }
    let problem = format!("{what} gives 8 bits a channel: write .ppm, or .png with --bits 8");
    Err(Error::new("-o", problem))
}

/// The light of every pixel: before the background, or without one and with opacity.
pub(in crate::render) fn picture(layers: &Layers<'_>, transparent: bool) -> Linear {
    let Scene { size: [width, height], background, .. } = *layers.scene;
    let background = background.map(word16);
    let row = |y: u32| {
        let mut records = Vec::new();
        let pixel = |x: u32| {
            let ray = ray(layers, x, y, &mut records);
            if transparent {
                return ray.alone();
            }
            let [r, g, b] = ray.before(background);
            [r, g, b, u16::MAX]
        };
        (0..width).map(pixel).collect::<Vec<_>>()
    };
    let rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
    Linear { width, height, pixels: rows.concat() }
}

/// The light of one pixel; `records` is room for its layers.
fn ray(layers: &Layers<'_>, x: u32, y: u32, records: &mut Vec<Record>) -> Ray {
    let place = y as usize * layers.scene.size[0] as usize + x as usize;
    match layers.kept {
        Kept::Color(lights) => Ray::of_light(&lights[place]),
        Kept::Depths(depths) => Ray::of_depth(depths[place]),
        Kept::Fragments(_) | Kept::Records(_) | Kept::Gone(_) => {
            records.clear();
            layers.pixel(x, y, records);
            let mut ray = Ray::default();
            records.iter().for_each(|record| ray.over_record(record));
            ray
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Catalogue;
    use crate::exec::Method;
    use crate::render::{Data, Exec, Rendering, Sim, render};
    use crate::scene::{self, Overrides};

    fn drawn(name: &str, options: &Options) -> Rendering {
        let size = Some([40, 28]);
        let scene = scene::load(name, &Overrides { size, ..Overrides::default() }).unwrap();
        render(&scene, &Options { linear: true, counters: false, ..options.clone() }).unwrap()
    }

    #[track_caller]
    fn agrees(name: &str, options: &Options) {
        let Rendering { image, linear, .. } = drawn(name, options);
        assert_eq!(linear.unwrap().srgb8(), image, "{name} {options:?}");
    }

    #[test]
    fn every_method_gives_the_light_of_its_picture() {
        for method in Catalogue::built_in().methods() {
            for name in ["cubes", "hairball:strands=40"] {
                let exec = Exec::Threads;
                agrees(name, &Options { method: *method, exec, ..Options::default() });
            }
        }
    }

    #[test]
    fn so_do_other_words_executors_and_shadows() {
        let base = Options { method: Method::EXACT, ..Options::default() };
        agrees("bottles", &Options { data: Data::Primitive, ..base.clone() });
        agrees("bottles", &Options { shadows: Some(Default::default()), ..base.clone() });
        agrees(
            "layers:count=9",
            &Options { exec: Exec::Sim(Sim::default()), ..Options::default() },
        );
        agrees("layers:count=9", &Options { tile: 16, k: Some(2), ..base });
    }

    #[test]
    fn nothing_is_made_unless_it_is_asked_for() {
        let scene = scene::load("cubes", &Overrides::default()).unwrap();
        let scene = Scene { size: [8, 8], ..scene };
        assert_eq!(render(&scene, &Options::default()).unwrap().linear, None);
    }

    #[test]
    fn a_transparent_picture_over_the_background_is_the_opaque_one() {
        let base = Options { method: Method::EXACT, ..Options::default() };
        let opaque = drawn("bottles", &base).linear.unwrap();
        let drawn = drawn("bottles", &Options { transparent: true, ..base });
        let alone = drawn.linear.unwrap();
        assert_eq!(alone.srgb8(), drawn.image);
        // The background of a scene that gives none is white.
        let over = |light: u16, opacity: u16| light.saturating_add(u16::MAX - opacity);
        for (&[r, g, b, a], whole) in alone.pixels.iter().zip(&opaque.pixels) {
            assert_eq!([over(r, a), over(g, a), over(b, a), u16::MAX], *whole);
        }
        let opacities = alone.pixels.iter().map(|pixel| pixel[3]);
        assert!(opacities.clone().any(|a| a == 0) && opacities.clone().any(|a| a > 50_000));
    }

    #[test]
    fn its_bytes_are_limited_too() {
        let scene = scene::load("layers:count=1", &Overrides::default()).unwrap();
        let scene = Scene { size: [8, 8], ..scene };
        let needed = |linear| {
            let options = Options { linear, max_memory: 2_000, threads: 1, ..Options::default() };
            let problem = render(&scene, &options).unwrap_err().problem().to_owned();
            let numbers = problem.split(' ').filter_map(|word| word.parse::<u64>().ok());
            numbers.max().unwrap()
        };
        assert_eq!(needed(true) - needed(false), 8 * 64 * 64, "a whole tile");
    }
}
