//! A train of meshing gears along a zigzag, each made of fifteen parts (disc, hub, axle, twelve teeth) and each
//! part in a colour of its own, as in the papers' engine of many parts.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4};

use super::super::{Material, Mesh, Model};
use super::shape::{prism, random_color, revolve, turn_and_move, turned};
use super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

pub(super) const BUILTIN: Builtin = Builtin {
    name: "gears",
    about: "a train of meshing gears, each of 15 parts in random colours (13 gears are 195 parts)",
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

/// How far the line between neighbours is from the train's direction, to either side: far enough that the next
/// but one gear is out of reach.
const ZIGZAG: f64 = PI / 4.0;

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
    let mut colors = Random::new(keys.seed()?, 1);
    let mut model = Model::default();
    let (mut at, mut phase) = (DVec3::ZERO, 0.0);
    for gear in 0..count {
        for (name, mesh, transform) in shapes.parts(at, phase) {
            let name = format!("gear {gear} {name}");
            let material =
                model.add_material(Material::new(name, random_color(&mut colors), alpha));
            model.add_placed(mesh, transform, material);
        }
        let angle = if gear % 2 == 0 { ZIGZAG } else { -ZIGZAG };
        let (c, s) = turned(angle);
        at += DVec3::new(c, s, 0.0) * (2.0 * PITCH_RADIUS);
        // Where one has a tooth, the other, which turns the other way, has a gap.
        phase = 2.0 * angle + PI - phase + 0.5 * PITCH;
    }
    Ok(model)
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
        let tooth = [(root, -0.16), (tip, -0.09), (tip, 0.09), (root, 0.16)];
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
