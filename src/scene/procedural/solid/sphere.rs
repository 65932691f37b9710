//! One ball: a closed surface.

use super::super::super::{Material, Model};
use super::super::shape::sphere;
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "sphere",
    about: "a ball around the origin, closed",
    in_pixels: false,
    keys: &[
        Key { name: "radius", default: "1", range: Range::Real(1e-6, 1e6), about: "world units" },
        Key { name: "sides", default: "64", range: Range::Count(4, 1024), about: "around it" },
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
    let mut model = Model::default();
    let material = Material::new("sphere", keys.color("color")?, keys.alpha()?);
    let material = model.add_material(material);
    model.add_mesh(sphere(keys.real("radius")?, keys.count("sides")?), material);
    Ok(model)
}
