//! A puff of smoke: faint discs that rise, spread and turn, more of them in its middle.

use std::f64::consts::TAU;

use glam::DVec3;

use super::super::super::{Material, Mesh, Model};
use super::super::shape::{on_circle, place};
use super::super::{Builtin, Key, Keys, Range};
use super::strand::direction;
use crate::error::Result;
use crate::num::random::Random;

/// Corners of a disc.
const CORNERS: u32 = 12;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "smoke",
    about: "a rising puff of faint discs, 2 high",
    in_pixels: false,
    keys: &[
        Key { name: "discs", default: "88", range: Range::Count(1, 1_000_000), about: "of smoke" },
        Key {
            name: "radius",
            default: "0.32",
            range: Range::Real(1e-4, 2.0),
            about: "of a large disc",
        },
        Key::alpha("0.1"),
        Key::SEED,
    ],
    generate,
};

/// From thin to thick.
const SMOKE: [(&str, [f32; 3]); 3] = [
    ("light smoke", [0.62, 0.63, 0.66]),
    ("smoke", [0.38, 0.39, 0.42]),
    ("warm smoke", [0.5, 0.36, 0.27]),
];

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (discs, radius) = (keys.count("discs")?, keys.real("radius")?);
    let (alpha, seed) = (keys.alpha()?, keys.seed()?);
    let mut meshes: Vec<Mesh> = SMOKE.iter().map(|_| Mesh::default()).collect();
    for disc in 0..discs {
        let mut random = Random::new(seed, u64::from(disc));
        // The plume widens as it rises, and curls about its axis.
        let rise = random.unit();
        let width = 0.12 + 0.55 * rise;
        let angle = random.range(0.0, TAU) + 4.0 * rise;
        let off = width * random.unit();
        let axis =
            DVec3::new(0.18 * libm::sin(5.0 * rise), 2.0 * rise - 1.0, 0.1 * libm::sin(3.0 * rise));
        let center = axis
            + DVec3::new(
                off * libm::cos(angle),
                0.12 * random.range(-1.0, 1.0),
                off * libm::sin(angle),
            );
        let size = radius * (0.45 + 0.75 * rise) * random.range(0.6, 1.0);
        let facing = (DVec3::Z + direction(&mut random) * 0.5).normalize();
        let kind = if rise < 0.25 { 2 } else { random.below(2) as usize };
        add(&mut meshes[kind], center, facing, size);
    }
    let mut model = Model::default();
    for (mesh, (name, color)) in meshes.into_iter().zip(SMOKE) {
        let material = model.add_material(Material::new(name, color, alpha));
        model.add_mesh(mesh, material);
    }
    Ok(model)
}

/// Adds a disc.
fn add(mesh: &mut Mesh, center: DVec3, facing: DVec3, radius: f64) {
    let first = mesh.positions.len() as u32;
    let across = facing.any_orthonormal_vector();
    let other = facing.cross(across);
    for (c, s) in (0..CORNERS).map(|corner| on_circle(corner, CORNERS)) {
        mesh.positions.push(place(center + (across * c + other * s) * radius));
    }
    mesh.triangles.extend((1..CORNERS - 1).map(|i| [first, first + i, first + i + 1]));
}
