//! One box: a closed surface.

use glam::DVec3;

use super::super::super::{Material, Model};
use super::super::shape::cuboid;
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;

/// An edge's length.
const EDGE: Range = Range::Real(1e-6, 1e6);

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "box",
    about: "a box around the origin, closed",
    in_pixels: false,
    keys: &[
        Key { name: "x", default: "1", range: EDGE, about: "width, world units" },
        Key { name: "y", default: "1", range: EDGE, about: "height, world units" },
        Key { name: "z", default: "1", range: EDGE, about: "depth, world units" },
        Key {
            name: "color",
            default: "0.7/0.7/0.75",
            range: Range::Color,
            about: "linear colour, 0..1; as r/g/b on the command line",
        },
        Key::alpha("0.5"),
    ],
    generate,
};

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let half = DVec3::new(keys.real("x")?, keys.real("y")?, keys.real("z")?) * 0.5;
    let mut model = Model::default();
    let material = Material::new("box", keys.color("color")?, keys.alpha()?);
    let material = model.add_material(material);
    model.add_mesh(cuboid(-half, half), material);
    Ok(model)
}
