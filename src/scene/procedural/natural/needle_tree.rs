//! A fir: a trunk, whorls of branches that shorten towards the top, and needles all around them.

use std::f64::consts::TAU;

use glam::DVec3;

use super::super::super::{Material, Mesh, Model};
use super::super::shape::{place, turned};
use super::super::{Builtin, Key, Keys, Range};
use super::strand::Tube;
use crate::error::Result;
use crate::num::random::Random;

/// The most triangles.
const MAX_TRIANGLES: u64 = 1 << 24;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "needle-tree",
    about: "a fir, 2 high, with whorls of branches full of needles",
    in_pixels: false,
    keys: &[
        Key {
            name: "whorls",
            default: "20",
            range: Range::Count(1, 256),
            about: "from bottom to top",
        },
        Key { name: "branches", default: "12", range: Range::Count(1, 256), about: "of a whorl" },
        Key {
            name: "needles",
            default: "170",
            range: Range::Count(1, 10_000),
            about: "of a branch",
        },
        Key {
            name: "needle",
            default: "0.1",
            range: Range::Real(1e-3, 1.0),
            about: "length of a needle",
        },
        Key::alpha("0.4"),
        Key::SEED,
    ],
    generate,
};

const NEEDLES: [(&str, [f32; 3]); 3] = [
    ("dark needles", [0.02, 0.1, 0.05]),
    ("needles", [0.05, 0.2, 0.08]),
    ("young needles", [0.2, 0.36, 0.12]),
];

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (whorls, branches) = (keys.count("whorls")?, keys.count("branches")?);
    let (needles, length) = (keys.count("needles")?, keys.real("needle")?);
    let (alpha, seed) = (keys.alpha()?, keys.seed()?);
    if u64::from(whorls * branches) * u64::from(needles + 12) > MAX_TRIANGLES {
        let problem = format!("whorls x branches x needles exceed {MAX_TRIANGLES} triangles");
        return Err(keys.wrong("needles", &problem));
    }
    let mut wood = Mesh::default();
    let trunk = Tube { sides: 8, radius: 0.045, taper: 0.85 };
    trunk.add(&[DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 0.98, 0.0)], &mut wood);
    let mut meshes: Vec<Mesh> = NEEDLES.iter().map(|_| Mesh::default()).collect();
    for i in 0..whorls * branches {
        let mut random = Random::new(seed, u64::from(i));
        let (whorl, place) = (i / branches, i % branches);
        let up = (f64::from(whorl) + random.range(0.0, 0.5)) / f64::from(whorls);
        let long = 0.78 * (1.0 - up) + 0.06;
        let golden = 2.399_963_229_728_653 * f64::from(whorl);
        let angle =
            golden + TAU * (f64::from(place) + random.range(-0.2, 0.2)) / f64::from(branches);
        let (c, s) = turned(angle);
        let root = DVec3::new(0.0, -0.8 + 1.75 * up, 0.0);
        let droop = DVec3::new(0.0, -0.22 + 0.5 * up, 0.0);
        let tip = root + (DVec3::new(c, 0.0, s) + droop) * long;
        let bend = (root + tip) * 0.5 + DVec3::Y * (0.05 * long);
        let path = [root, bend, tip];
        Tube { sides: 3, radius: 0.009 * (1.1 - up), taper: 0.7 }.add(&path, &mut wood);
        for needle in 0..needles {
            let part = (f64::from(needle) + random.unit()) / f64::from(needles);
            add(&mut random, path, part, length, &mut meshes);
        }
    }
    let mut model = Model::default();
    let bark = model.add_material(Material::new("bark", [0.16, 0.1, 0.06], alpha.max(0.8)));
    model.add_mesh(wood, bark);
    for (mesh, (name, color)) in meshes.into_iter().zip(NEEDLES) {
        let material = model.add_material(Material::new(name, color, alpha));
        model.add_mesh(mesh, material);
    }
    Ok(model)
}

/// Adds a needle at a part of a branch: a thin triangle, outwards and towards the tip.
fn add(
    random: &mut Random,
    [root, bend, tip]: [DVec3; 3],
    part: f64,
    length: f64,
    meshes: &mut [Mesh],
) {
    let at = if part < 0.5 {
        root + (bend - root) * (2.0 * part)
    } else {
        bend + (tip - bend) * (2.0 * part - 1.0)
    };
    let along = (tip - root).normalize_or(DVec3::X);
    let across = along.any_orthonormal_vector();
    let (c, s) = turned(random.range(0.0, TAU));
    let out = across * c + along.cross(across) * s;
    let heading = (out + along * 0.6).normalize();
    let wide = along.cross(out) * (0.032 * length);
    let kind = if part > 0.85 { 2 } else { random.below(2) as usize };
    let mesh = &mut meshes[kind];
    let first = mesh.positions.len() as u32;
    let end = at + heading * (length * random.range(0.7, 1.0));
    mesh.positions.extend([at - wide, at + wide, end].map(place));
    mesh.triangles.push([first, first + 1, first + 2]);
}
