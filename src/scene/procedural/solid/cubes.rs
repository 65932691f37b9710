//! Boxes that intersect, share planes and lie inside each other, and a ball through all of them: what sorting
//! by object cannot draw, with equal depths on the shared planes.

use glam::{DMat4, DVec3};

use super::super::super::{Material, Model};
use super::super::shape::{cuboid, sphere};
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "cubes",
    about: "five intersecting, coplanar and nested boxes with a ball through them",
    in_pixels: false,
    keys: &[
        Key { name: "sides", default: "64", range: Range::Count(4, 1024), about: "of the ball" },
        Key::alpha("0.5"),
    ],
    generate,
};

/// Name, colour, least and greatest corner.
type Cuboid = (&'static str, [f32; 3], [f64; 3], [f64; 3]);

const BOXES: [Cuboid; 5] = [
    ("red box", [0.8, 0.1, 0.1], [-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
    ("green box", [0.1, 0.6, 0.15], [0.25, 0.0, 0.0], [1.5, 1.25, 1.5]),
    ("blue box, same front", [0.1, 0.2, 0.8], [-1.75, -0.75, 0.25], [-0.5, 0.5, 1.0]),
    ("yellow box, same floor and side", [0.8, 0.7, 0.1], [0.25, -1.0, -1.5], [1.0, -0.25, 0.5]),
    ("violet box, inside", [0.5, 0.1, 0.6], [-0.5, -0.5, -0.5], [0.25, 0.25, 0.25]),
];

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (sides, alpha) = (keys.count("sides")?, keys.alpha()?);
    let mut model = Model::default();
    for (name, color, min, max) in BOXES {
        let material = model.add_material(Material::new(name, color, alpha));
        model.add_mesh(cuboid(DVec3::from(min), DVec3::from(max)), material);
    }
    let material = model.add_material(Material::new("ball", [0.7, 0.7, 0.75], alpha));
    let place = DMat4::from_translation(DVec3::new(0.0, 0.5, 0.0));
    model.add_placed(std::sync::Arc::new(sphere(1.125, sides)), place, material);
    Ok(model)
}
