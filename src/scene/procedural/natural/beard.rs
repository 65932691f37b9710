//! A head with a full beard of thousands of fine, curled hairs: hardly any depth on the forehead, and a hundred layers
//! at the chin.

use std::f64::consts::TAU;

use glam::DVec3;

use super::super::super::{Material, Mesh, Model};
use super::super::shape::{place, point, sphere, turned};
use super::super::{Builtin, Key, Keys, Range};
use super::strand::{Tube, direction};
use crate::error::Result;
use crate::num::random::Random;

/// The most triangles.
const MAX_TRIANGLES: u64 = 1 << 24;

/// Half the head's width, height and depth.
const HEAD: DVec3 = DVec3::new(0.72, 1.0, 0.8);

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "beard",
    about: "a head, 2 high, with a full beard of fine curled hairs",
    in_pixels: false,
    keys: &[
        Key {
            name: "hairs",
            default: "7000",
            range: Range::Count(1, 200_000),
            about: "of the beard",
        },
        Key {
            name: "segments",
            default: "18",
            range: Range::Count(1, 256),
            about: "straight pieces of a hair",
        },
        Key { name: "length", default: "1.1", range: Range::Real(0.01, 10.0), about: "of a hair" },
        Key {
            name: "radius",
            default: "0.0035",
            range: Range::Real(1e-6, 0.1),
            about: "of a hair at its root",
        },
        Key {
            name: "curl",
            default: "0.035",
            range: Range::Real(0.0, 1.0),
            about: "radius of curls",
        },
        Key::alpha("0.35"),
        Key::SEED,
    ],
    generate,
};

/// From grey to brown.
const HAIR: [(&str, [f32; 3]); 4] = [
    ("dark hair", [0.12, 0.06, 0.03]),
    ("brown hair", [0.25, 0.12, 0.05]),
    ("red hair", [0.38, 0.15, 0.05]),
    ("grey hair", [0.42, 0.38, 0.34]),
];

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (hairs, segments) = (keys.count("hairs")?, keys.count("segments")?);
    let (length, curl) = (keys.real("length")?, keys.real("curl")?);
    let tube = Tube { sides: 3, radius: keys.real("radius")?, taper: 0.7 };
    let (alpha, seed) = (keys.alpha()?, keys.seed()?);
    if 6 * u64::from(hairs) * u64::from(segments) > MAX_TRIANGLES {
        let problem = format!("hairs x segments x 6 exceeds {MAX_TRIANGLES} triangles");
        return Err(keys.wrong("hairs", &problem));
    }
    let mut meshes: Vec<Mesh> = HAIR.iter().map(|_| Mesh::default()).collect();
    for hair in 0..hairs {
        let mut random = Random::new(seed, u64::from(hair));
        let kind = [0, 1, 1, 1, 1, 2, 2, 3][random.below(8) as usize];
        let path = grow(&mut random, segments, length, curl);
        tube.add(&path, &mut meshes[kind]);
    }
    let mut model = Model::default();
    face(&mut model, alpha.max(0.6));
    for (mesh, (name, color)) in meshes.into_iter().zip(HAIR) {
        let material = model.add_material(Material::new(name, color, alpha));
        model.add_mesh(mesh, material);
    }
    Ok(model)
}

/// Head, nose, ears and eyes.
fn face(model: &mut Model, alpha: f32) {
    let skin = model.add_material(Material::new("skin", [0.72, 0.5, 0.38], alpha));
    let white = model.add_material(Material::new("eye", [0.9, 0.9, 0.86], alpha));
    let dark = model.add_material(Material::new("pupil", [0.06, 0.05, 0.05], alpha));
    model.add_mesh(ellipsoid(DVec3::ZERO, HEAD, 64), skin);
    model.add_mesh(ellipsoid(DVec3::new(0.0, 0.02, 0.84), DVec3::new(0.11, 0.19, 0.15), 32), skin);
    for side in [-1.0, 1.0] {
        let ear = DVec3::new(side * 0.72, 0.05, 0.0);
        model.add_mesh(ellipsoid(ear, DVec3::new(0.07, 0.19, 0.12), 24), skin);
        let eye = DVec3::new(side * 0.26, 0.22, 0.68);
        model.add_mesh(ellipsoid(eye, DVec3::splat(0.1), 32), white);
        model.add_mesh(ellipsoid(eye + DVec3::new(0.0, -0.01, 0.08), DVec3::splat(0.04), 24), dark);
    }
}

/// A ball, stretched along the axes and moved.
fn ellipsoid(center: DVec3, half: DVec3, sides: u32) -> Mesh {
    let mut mesh = sphere(1.0, sides);
    for (position, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        let at = center + DVec3::from(*position) * half;
        *position = place(at);
        *normal = point(DVec3::from(normal.map(f64::from)) / half);
    }
    mesh
}

/// A hair from a root on the jaw, upper lip or cheek: out of the skin, then down, in curls.
fn grow(random: &mut Random, segments: u32, length: f64, curl: f64) -> Vec<DVec3> {
    // From ear to ear around the front, and from the mouth to the throat.
    let across = random.range(-1.0, 1.0);
    let (side, front) = turned(TAU * 0.25 * (1.0 - across * 0.85));
    let height = -0.15 - 0.6 * random.unit() - 0.15 * (1.0 - across * across);
    let ring = libm::sqrt(1.0 - height * height);
    let out = DVec3::new(side * ring, height, front * ring);
    let root = out * HEAD;
    let reach = length * random.range(0.55, 1.0);
    let step = reach / f64::from(segments);
    let (phase, turns) = (random.range(0.0, TAU), random.range(2.0, 5.0));
    let down = (DVec3::new(0.0, -1.0, 0.15) + direction(random) * 0.16).normalize();
    let mut spine = root;
    let mut path = Vec::with_capacity(segments as usize + 1);
    for i in 0..=segments {
        let part = f64::from(i) / f64::from(segments);
        let (c, s) = turned(phase + turns * TAU * part);
        path.push(spine + DVec3::new(c, 0.0, s) * (curl * part));
        // Hairs leave the skin, and gather below the chin.
        let heading =
            out * (1.0 - part) * 0.9 + down * (0.35 + part) - DVec3::X * (spine.x * 0.5 * part);
        spine += heading.normalize_or(down) * step;
    }
    path
}
