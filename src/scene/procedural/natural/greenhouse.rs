//! A greenhouse: panes of glass in gables, bay behind bay, and beds of leafy plants between them.

use std::f64::consts::TAU;

use glam::DVec3;

use super::super::super::{Material, Mesh, Model};
use super::super::shape::{cuboid, place, turned};
use super::super::{Builtin, Key, Keys, Range};
use super::strand::{Tube, direction};
use crate::error::Result;
use crate::num::random::Random;

/// The most triangles.
const MAX_TRIANGLES: u64 = 1 << 24;

/// Half the width, the walls' height, the ridge's height, and the length of a bay.
const HALF: f64 = 1.2;
const WALL: f64 = 1.0;
const RIDGE: f64 = 1.6;
const BAY: f64 = 0.8;

/// Leaves along a stem.
const LEAVES: u32 = 10;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "greenhouse",
    about: "a glass house, 2.4 wide and 1.6 high, with beds of leafy plants",
    in_pixels: false,
    keys: &[
        Key {
            name: "bays",
            default: "5",
            range: Range::Count(1, 64),
            about: "of panes, front to back",
        },
        Key { name: "plants", default: "60", range: Range::Count(0, 4096), about: "in every bay" },
        Key { name: "stems", default: "9", range: Range::Count(1, 256), about: "of a plant" },
        Key {
            name: "leaf",
            default: "0.18",
            range: Range::Real(1e-3, 1.0),
            about: "length of a leaf",
        },
        Key::alpha("0.3"),
        Key::SEED,
    ],
    generate,
};

const LEAF: [(&str, [f32; 3]); 4] = [
    ("dark leaf", [0.03, 0.16, 0.04]),
    ("leaf", [0.08, 0.3, 0.05]),
    ("light leaf", [0.25, 0.45, 0.08]),
    ("blossom", [0.75, 0.2, 0.3]),
];

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (bays, plants, stems) = (keys.count("bays")?, keys.count("plants")?, keys.count("stems")?);
    let (leaf, alpha, seed) = (keys.real("leaf")?, keys.alpha()?, keys.seed()?);
    if 4 * u64::from(bays * plants) * u64::from(stems * LEAVES) > MAX_TRIANGLES {
        let problem =
            format!("bays x plants x stems x {LEAVES} leaves exceed {MAX_TRIANGLES} triangles");
        return Err(keys.wrong("plants", &problem));
    }
    let mut model = Model::default();
    let earth = model.add_material(Material::new("earth", [0.2, 0.13, 0.08], 1.0));
    let long = f64::from(bays) * BAY;
    let bed = |x: f64| cuboid(DVec3::new(x - 0.5, 0.0, -long), DVec3::new(x + 0.5, 0.12, 0.0));
    for x in [-0.65, 0.65] {
        model.add_mesh(bed(x), earth);
    }
    let mut meshes: Vec<Mesh> = LEAF.iter().map(|_| Mesh::default()).collect();
    let mut stalks = Mesh::default();
    for plant in 0..bays * plants {
        let mut random = Random::new(seed, u64::from(plant));
        let side = if random.below(2) == 0 { -0.65 } else { 0.65 };
        let z = -f64::from(plant / plants) * BAY - random.unit() * BAY;
        let root = DVec3::new(side + random.range(-0.45, 0.45), 0.12, z);
        grow(&mut random, root, stems, leaf, &mut stalks, &mut meshes);
    }
    let green = model.add_material(Material::new("stalk", [0.12, 0.22, 0.06], alpha.max(0.5)));
    model.add_mesh(stalks, green);
    for (mesh, (name, color)) in meshes.into_iter().zip(LEAF) {
        let material = model.add_material(Material::new(name, color, alpha));
        model.add_mesh(mesh, material);
    }
    glaze(&mut model, bays, alpha);
    Ok(model)
}

/// A plant: stems from one root, and leaves along them.
fn grow(
    random: &mut Random,
    root: DVec3,
    stems: u32,
    leaf: f64,
    stalks: &mut Mesh,
    meshes: &mut [Mesh],
) {
    let tube = Tube { sides: 3, radius: 0.006, taper: 0.6 };
    let tall = random.range(0.35, 0.95);
    for _ in 0..stems {
        let lean = direction(random) * 0.3;
        let tip = root + DVec3::new(lean.x, tall * random.range(0.7, 1.0), lean.z);
        let bend = root + DVec3::new(lean.x * 0.3, tall * 0.5, lean.z * 0.3);
        tube.add(&[root, bend, tip], stalks);
        for i in 0..LEAVES {
            let part = (f64::from(i) + random.unit()) / f64::from(LEAVES);
            let at = if part < 0.5 {
                root + (bend - root) * (2.0 * part)
            } else {
                bend + (tip - bend) * (2.0 * part - 1.0)
            };
            let (c, s) = turned(random.range(0.0, TAU));
            let along = DVec3::new(c, random.range(-0.3, 0.5), s).normalize();
            let kind =
                if i + 1 == LEAVES && random.below(4) == 0 { 3 } else { random.below(3) as usize };
            add_leaf(
                &mut meshes[kind],
                at,
                along,
                direction(random),
                leaf * random.range(0.5, 1.0),
            );
        }
    }
}

/// A leaf: two triangles that meet at a fold along its middle, twice over for its width.
fn add_leaf(mesh: &mut Mesh, at: DVec3, along: DVec3, about: DVec3, length: f64) {
    let side = along.cross(about).normalize_or(along.any_orthonormal_vector());
    let fold = side.cross(along) * (0.12 * length);
    let (middle, tip) = (at + along * (0.5 * length), at + along * length);
    let first = mesh.positions.len() as u32;
    let wide = side * (0.34 * length);
    for corner in [at, middle + wide + fold, tip, middle - wide + fold] {
        mesh.positions.push(place(corner));
    }
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

/// Walls, roofs, and a gable of panes between any two bays.
fn glaze(model: &mut Model, bays: u32, alpha: f32) {
    let glass = model.add_material(Material::new("glass", [0.55, 0.72, 0.75], alpha * 0.6));
    let frame = model.add_material(Material::new("frame", [0.85, 0.86, 0.84], alpha.max(0.7)));
    let (mut panes, mut bars) = (Mesh::default(), Mesh::default());
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    for bay in 0..bays {
        let (near, far) = (-f64::from(bay) * BAY, -f64::from(bay + 1) * BAY);
        for side in [-1.0, 1.0] {
            let x = side * HALF;
            quad(
                &mut panes,
                [at(x, 0.0, near), at(x, 0.0, far), at(x, WALL, far), at(x, WALL, near)],
            );
            let [low, high] = [(x, WALL), (0.0, RIDGE)];
            quad(
                &mut panes,
                [
                    at(low.0, low.1, near),
                    at(low.0, low.1, far),
                    at(high.0, high.1, far),
                    at(high.0, high.1, near),
                ],
            );
        }
    }
    let bar = Tube { sides: 4, radius: 0.012, taper: 0.0 };
    for gable in 0..=bays {
        let z = -f64::from(gable) * BAY;
        let corners = [
            at(-HALF, 0.0, z),
            at(-HALF, WALL, z),
            at(0.0, RIDGE, z),
            at(HALF, WALL, z),
            at(HALF, 0.0, z),
        ];
        for pair in corners.windows(2) {
            bar.add(pair, &mut bars);
        }
        // Four panes, and a triangle on either side of the ridge.
        for i in 0..4 {
            let x = |i: f64| -HALF + 0.5 * HALF * i;
            let (a, b) = (x(f64::from(i)), x(f64::from(i) + 1.0));
            quad(&mut panes, [at(a, 0.0, z), at(b, 0.0, z), at(b, WALL, z), at(a, WALL, z)]);
        }
        for side in [-1.0, 1.0] {
            let first = panes.positions.len() as u32;
            for corner in [at(side * HALF, WALL, z), at(0.0, WALL, z), at(0.0, RIDGE, z)] {
                panes.positions.push(place(corner));
            }
            panes.triangles.push([first, first + 1, first + 2]);
        }
    }
    for (x, y) in [(-HALF, WALL), (0.0, RIDGE), (HALF, WALL)] {
        bar.add(&[at(x, y, 0.0), at(x, y, -f64::from(bays) * BAY)], &mut bars);
    }
    model.add_mesh(bars, frame);
    model.add_mesh(panes, glass);
}

fn quad(mesh: &mut Mesh, corners: [DVec3; 4]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners.map(place));
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}
