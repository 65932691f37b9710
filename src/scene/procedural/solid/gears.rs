//! Two plates of meshing gears, each gear made of fifteen parts (disc, hub, axle, twelve teeth) and each part in a
//! colour of its own, as in the papers' engine of many parts.
//!
//! Gears stand on a square lattice. Twelve teeth make a quarter turn three whole pitches, so a gear that is
//! half a pitch ahead of its neighbour on one side is so on all four.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4};

use super::super::super::{Material, Mesh, Model};
use super::super::shape::{prism, random_color, revolve, turn_and_move};
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "gears",
    about: "two plates of meshing gears, each of 15 parts in random colours (13 gears are 195 parts)",
    in_pixels: false,
    keys: &[
        Key { name: "count", default: "13", range: Range::Count(1, 4096), about: "gears" },
        Key {
            name: "sides",
            default: "48",
            range: Range::Count(8, 256),
            about: "of discs and axles",
        },
        Key::alpha("0.4"),
        Key::SEED,
    ],
    generate,
};

const TEETH: u32 = 12;

/// The angle from one tooth to the next.
const PITCH: f64 = TAU / TEETH as f64;

/// Where teeth of two gears meet; gears are twice this apart.
const PITCH_RADIUS: f64 = 1.0;

/// From one plate to the next: axles end before they meet.
const PLATE_DISTANCE: f64 = 1.0;

/// The y axis, around which surfaces revolve, onto z, around which gears turn.
const UPRIGHT: DMat4 = DMat4::from_cols(DVec4::X, DVec4::Z, DVec4::NEG_Y, DVec4::W);

/// The meshes that all gears share.
struct Shapes {
    round: [(&'static str, Arc<Mesh>); 3],
    tooth: Arc<Mesh>,
}

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (count, alpha) = (keys.count("count")?, keys.alpha()?);
    let shapes = Shapes::new(keys.count("sides")?);
    // Two plates of this many gears along each side hold them all.
    let side = libm::ceil(libm::sqrt(f64::from(count) * 0.5)) as u32;
    let mut colors = Random::new(keys.seed()?, 1);
    let mut model = Model::default();
    for gear in 0..count {
        let (at, phase) = place(gear, side);
        for (name, mesh, transform) in shapes.parts(at, phase) {
            let name = format!("gear {gear} {name}");
            let material =
                model.add_material(Material::new(name, random_color(&mut colors), alpha));
            model.add_placed(mesh, transform, material);
        }
    }
    Ok(model)
}

/// The middle of a gear and the angle of its first tooth.
fn place(gear: u32, side: u32) -> (DVec3, f64) {
    let (x, y, plate) = (gear % side, gear / side % side, gear / (side * side));
    let [x_place, y_place] = [x, y].map(|i| f64::from(i) * 2.0 * PITCH_RADIUS);
    let at = DVec3::new(x_place, y_place, -f64::from(plate) * PLATE_DISTANCE);
    (at, if (x + y) % 2 == 0 { 0.0 } else { 0.5 * PITCH })
}

impl Shapes {
    fn new(sides: u32) -> Self {
        let ring = |inner: f64, outer: f64, half: f64| {
            let profile =
                [[inner, -half], [outer, -half], [outer, half], [inner, half], [inner, -half]];
            Arc::new(revolve(&profile, sides, false))
        };
        let axle = [[0.0, -0.45], [0.12, -0.45], [0.12, 0.45], [0.0, 0.45]];
        let [root, tip] = [0.84, 1.14];
        let tooth = [(root, -0.13), (tip, -0.06), (tip, 0.06), (root, 0.13)];
        Self {
            round: [
                ("disc", ring(0.3, 0.86, 0.12)),
                ("hub", ring(0.13, 0.3, 0.25)),
                ("axle", Arc::new(revolve(&axle, sides, false))),
            ],
            tooth: Arc::new(prism(tooth, -0.15, 0.15)),
        }
    }

    /// The parts of a gear whose first tooth is at angle `phase`.
    fn parts(&self, at: DVec3, phase: f64) -> Vec<(&'static str, Arc<Mesh>, DMat4)> {
        let placed = turn_and_move(phase, at) * UPRIGHT;
        let round = self.round.iter().map(|(name, mesh)| (*name, Arc::clone(mesh), placed));
        let teeth = (0..TEETH).map(|tooth| {
            let angle = phase + f64::from(tooth) * PITCH;
            ("tooth", Arc::clone(&self.tooth), turn_and_move(angle, at))
        });
        round.chain(teeth).collect()
    }
}
