//! Several frames of a camera that circles the scene once, and hash tables that grow and shrink with their contents
//! (HA-buffer paper, section 4.1.3).
//!
//! A frame's fragments are counted when the table is cleared for the next one, so that its size follows with a delay of
//! one frame, and the frame that overflows is lost: [`Resize::Latent`]. [`Resize::AtOnce`] draws such a frame again,
//! with a larger table, until nothing is lost.

use glam::DVec3;

use super::importance::fresnel;
use super::{Options, Rendering, render};
use crate::error::{Error, Result};
use crate::num::random;
use crate::scene::Scene;
use crate::scheme::contract::Demand;
use crate::scheme::hash_table::table::{MOST_CELLS, Offsets, size_for};

/// Load, in per cent, from which a table grows.
const GROWS_AT: u64 = 80;

/// Load, in per cent, up to which it shrinks.
const SHRINKS_AT: u64 = 30;

/// By how much it does either, in per cent.
const STEP: u64 = 25;

/// The most frames.
pub const MAX_FRAMES: u32 = 100_000;

/// Stream of the frames' seeds.
const FRAMES: u64 = 0xF3A3;

/// When a hash table changes its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Resize {
    /// At the beginning of the next frame, as published.
    #[default]
    Latent,
    /// In addition, a frame that lost fragments for lack of room is drawn again with a larger table.
    AtOnce,
}

/// A sequence of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Animation {
    /// How many, 1 to [`MAX_FRAMES`]: the camera stands at as many places on its circle.
    pub frames: u32,
    /// When hash tables change their size.
    pub resize: Resize,
}

/// One of them.
#[derive(Clone, Debug)]
pub struct AnimatedFrame {
    /// Its number, from 0.
    pub number: u32,
    /// How often it was drawn again.
    pub retries: u32,
    /// The final result.
    pub rendering: Rendering,
}

/// Draw a sequence of frames, and hand each to `take` when it is done.
///
/// A hash table starts with as many cells as there are pixels (`options.table.size`, if given), and then grows by a
/// quarter at a load of 80 %, and shrinks by a quarter at 30 %, never below the image on either axis. With
/// `options.table.load`, it is sized for that load in every frame instead. Random offsets are drawn anew for every
/// frame.
///
/// # Errors
/// As [`render()`]; a number of frames out of range; a frame that loses fragments whatever its table's size; an error
/// from `take`.
pub fn animate(
    scene: &Scene,
    options: &Options,
    animation: &Animation,
    mut take: impl FnMut(AnimatedFrame) -> Result<()>,
) -> Result<()> {
    let frames = animation.frames;
    if !(1..=MAX_FRAMES).contains(&frames) {
        let problem = format!("is {frames}, but must be 1 to {MAX_FRAMES}");
        return Err(Error::new("--frames", problem));
    }
    let contract = options.method.contract();
    let follows =
        contract.crosses() && options.table.load.is_none() && options.memory_budget.is_none();
    let mut size = follows.then(|| options.table.size.unwrap_or(scene.size));
    // What the next frame's importance takes from this one.
    let looks_back = contract.demand == Demand::Records && options.importance.factors.fresnel;
    let mut fresnel_before = None;
    for number in 0..frames {
        let scene = seen_from(scene, f64::from(number) / f64::from(frames));
        let mut frame = Options { table: options.table.clone(), ..options.clone() };
        frame.importance.frame = number;
        frame.importance.fresnel = fresnel_before.take();
        if frame.table.offsets == Offsets::Random {
            frame.table.seed = random::bits(options.table.seed, FRAMES, number.into());
        }
        let mut retries = 0;
        let rendering = loop {
            frame.table.size = size.or(options.table.size);
            let drawn = render(&scene, &frame)?;
            let lost =
                ["age", "full"].iter().any(|reason| drawn.report.dropped.contains_key(*reason));
            match size {
                Some(now) if lost && animation.resize == Resize::AtOnce => {
                    let enough = enough(drawn.report.generated);
                    if cells(now) >= enough {
                        let [w, h] = now;
                        let problem = format!(
                            "is {}, and frame {number} loses fragments beyond it even with {w}x{h} cells",
                            frame.table.ages
                        );
                        return Err(Error::new("--age-limit", problem));
                    }
                    size = Some(size_for(grown(cells(now)), scene.size));
                    retries += 1;
                }
                _ => break drawn,
            }
        };
        if let (Some(now), Some(table)) = (size, &rendering.report.table) {
            size = Some(next(now, table.stored, scene.size));
        }
        if looks_back && number + 1 < frames {
            fresnel_before = Some((scene.size, fresnel(&scene, &frame)));
        }
        take(AnimatedFrame { number, retries, rendering })?;
    }
    Ok(())
}

fn cells([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

fn grown(cells: u64) -> u64 {
    (cells * (100 + STEP)).div_ceil(100).min(MOST_CELLS)
}

/// Cells beyond which no table helps: a load of a few per cent.
fn enough(fragments: u64) -> u64 {
    (32 * fragments).min(MOST_CELLS)
}

/// The size after a frame that stored this many records.
fn next(size: [u32; 2], stored: u64, screen: [u32; 2]) -> [u32; 2] {
    let now = cells(size);
    if 100 * stored >= GROWS_AT * now {
        return size_for(grown(now), screen);
    }
    if 100 * stored <= SHRINKS_AT * now {
        let smaller = size_for(now * (100 - STEP) / 100, screen);
        // If the screen allows no smaller size, the size stays.
        return if cells(smaller) < now { smaller } else { size };
    }
    size
}

/// The scene with the camera moved a part of the way around its target. Near and far planes are widened for what is
/// drawn.
fn seen_from(scene: &Scene, part: f64) -> Scene {
    let mut scene = scene.clone();
    if part == 0.0 {
        return scene;
    }
    let bounds = scene.bounds();
    let camera = &mut scene.camera;
    let Some(axis) = camera.up.try_normalize() else { return scene };
    let offset = camera.eye - camera.target;
    camera.eye = camera.target + turned(offset, axis, part * std::f64::consts::TAU);
    if !(scene.objects.is_empty() && scene.volumes.is_empty()) {
        let (near, far) = camera.planes_around(bounds);
        (camera.near, camera.far) = (camera.near.min(near), camera.far.max(far));
    }
    scene
}

/// Rodrigues' rotation about a unit vector.
fn turned(vector: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    vector * cos + axis.cross(vector) * sin + axis * (axis.dot(vector) * (1.0 - cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_follow_their_load() {
        let screen = [100, 100];
        assert_eq!(next(screen, 7_999, screen), screen, "79.99 %");
        let grown = next(screen, 8_000, screen);
        assert!((12_500..12_700).contains(&cells(grown)), "{grown:?}");
        assert_eq!(next(screen, 0, screen), screen, "never below the screen");
        let large = [200, 200];
        assert_eq!(next(large, 12_001, screen), large, "30.0025 %");
        let shrunk = next(large, 12_000, screen);
        assert!((30_000..30_300).contains(&cells(shrunk)), "{shrunk:?}");
        let tight = [101, 100];
        assert!(cells(next(tight, 0, screen)) <= cells(tight));
    }

    #[test]
    fn a_turn_keeps_the_distance() {
        let axis = DVec3::new(0.6, 0.0, 0.8);
        let vector = DVec3::new(1.0, 2.0, -3.0);
        let quarter = turned(vector, axis, std::f64::consts::FRAC_PI_2);
        assert!((quarter.length() - vector.length()).abs() < 1e-12);
        assert!((axis.dot(quarter) - axis.dot(vector)).abs() < 1e-12);
        let round = (0..4).fold(vector, |v, _| turned(v, axis, std::f64::consts::FRAC_PI_2));
        assert!((round - vector).length() < 1e-12);
    }
}
