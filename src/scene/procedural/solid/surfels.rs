//! Surfels: a point set whose discs overlap, on a ball, or in sheets one behind the other.

use std::f64::consts::PI;

use glam::DVec3;

use super::super::super::{Disc, Material, Mesh, Model};
use super::super::shape::{place, point, turned};
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "surfels",
    about: "a point set: overlapping discs, each lighter or darker, on a ball or in sheets one behind the other",
    in_pixels: false,
    keys: &[
        Key {
            name: "shape",
            default: "ball",
            range: Range::Choice(&["ball", "sheets"]),
            about: "a ball of radius 1, or squares of edge 2 from z = 1 to -1",
        },
        Key {
            name: "count",
            default: "800",
            range: Range::Count(1, 100_000),
            about: "of discs on the ball, or in each sheet",
        },
        Key { name: "sheets", default: "10", range: Range::Count(1, 64), about: "not of a ball" },
        Key {
            name: "radius",
            default: "0.2",
            range: Range::Real(1e-4, 2.0),
            about: "of a disc, world units",
        },
        Key {
            name: "jitter",
            default: "0.01",
            range: Range::Real(0.0, 1.0),
            about: "how far a disc may lie before or behind its surface, world units",
        },
        Key {
            name: "color",
            default: "0.9/0.8/0.6",
            range: Range::Color,
            about: "linear colour, 0..1; as r/g/b on the command line",
        },
        Key::alpha("0.5"),
        Key::SEED,
    ],
    generate,
};

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (count, sheets) = (keys.count("count")?, keys.count("sheets")?);
    let (radius, jitter, seed) = (keys.real("radius")?, keys.real("jitter")?, keys.seed()?);
    let mut model = Model::default();
    let material = Material::new("surfels", keys.color("color")?, keys.alpha()?);
    let material = model.add_material(material);
    if keys.choice("shape")? == "ball" {
        let mut mesh = Mesh::default();
        for i in 0..count {
            let mut random = Random::new(seed, u64::from(i));
            let outwards = on_ball(i, count);
            let center = outwards * (1.0 + jitter * random.range(-1.0, 1.0));
            add(&mut mesh, center, outwards, radius, &mut random);
        }
        model.add_mesh(mesh, material);
        return Ok(model);
    }
    for sheet in 0..sheets {
        let z = 1.0 - 2.0 * (f64::from(sheet) + 0.5) / f64::from(sheets);
        let mut mesh = Mesh::default();
        for i in 0..count {
            let mut random = Random::new(seed, u64::from(sheet * count + i));
            let [x, y] = [(); 2].map(|()| random.range(-1.0, 1.0));
            let center = DVec3::new(x, y, z + jitter * random.range(-1.0, 1.0));
            add(&mut mesh, center, DVec3::Z, radius, &mut random);
        }
        model.add_mesh(mesh, material);
    }
    Ok(model)
}

/// Point `i` of `n` that lie evenly on the unit sphere, by the golden angle.
fn on_ball(i: u32, n: u32) -> DVec3 {
    let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
    let around = (1.0 - y * y).sqrt();
    let (c, s) = turned(f64::from(i) * PI * (3.0 - 5.0_f64.sqrt()));
    DVec3::new(around * c, y, around * s)
}

/// Adds a disc of a random brightness.
fn add(mesh: &mut Mesh, center: DVec3, facing: DVec3, radius: f64, random: &mut Random) {
    let brightness = random.range(0.35, 1.0) as f32;
    let across = facing.any_orthonormal_vector();
    mesh.discs.push(Disc {
        center: place(center),
        axes: [across, facing.cross(across)].map(|axis| point(axis * radius)),
        color: [brightness; 3],
        alpha: 1.0,
        sigmas: 0.0,
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_on_the_ball_and_evenly() {
        let all: Vec<DVec3> = (0..500).map(|i| on_ball(i, 500)).collect();
        assert!(all.iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
        let middle = all.iter().fold(DVec3::ZERO, |sum, p| sum + *p) / 500.0;
        assert!(middle.length() < 0.01, "{middle}");
    }

    #[test]
    fn every_disc_faces_outwards() {
        let mut mesh = Mesh::default();
        let outwards = on_ball(17, 50);
        add(&mut mesh, outwards, outwards, 0.2, &mut Random::new(1, 0));
        let [across, up] = mesh.discs[0].axes.map(|axis| glam::Vec3::from(axis).as_dvec3());
        assert!((across.cross(up) / 0.04 - outwards).length() < 1e-6);
    }
}
