//! Built-in scenes, made by rule from keys and a seed: the same bytes on every machine.
//!
//! A generator is a file with its description (a [`Builtin`]) and a function from [`Keys`] to a [`Model`]; the
//! list [`builtin`] is the catalogue. Numbers come from + - * /, square roots, `libm` and `num::random`.

mod keys;
mod natural;
mod screen;
mod shape;
mod solid;

use std::collections::BTreeMap;

pub use self::keys::{Key, Keys, Range};
use self::natural::{beard, greenhouse, hairball, needle_tree, smoke};
use self::screen::{layers, stack, synthetic};
use self::solid::{bottles, cubes, cuboid, gears, sphere, surfels};
use super::Model;
use crate::error::{Error, Result};

/// A procedural scene's entry in the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// The name that SCENE and `procedural` use.
    pub name: &'static str,
    /// One line about it.
    pub about: &'static str,
    /// Whether it is made of `screen` triangles, in pixels, rather than of meshes in the world.
    pub in_pixels: bool,
    /// Its settings.
    pub keys: &'static [Key],
    /// Its triangles for an image of `size` pixels, which only those in pixels look at.
    generate: fn(keys: &Keys<'_>, size: [u32; 2]) -> Result<Model>,
}

const BUILTINS: [Builtin; 14] = [
    synthetic::BUILTIN,
    layers::BUILTIN,
    hairball::BUILTIN,
    bottles::BUILTIN,
    gears::BUILTIN,
    cubes::BUILTIN,
    stack::BUILTIN,
    sphere::BUILTIN,
    cuboid::BUILTIN,
    surfels::BUILTIN,
    beard::BUILTIN,
    smoke::BUILTIN,
    greenhouse::BUILTIN,
    needle_tree::BUILTIN,
];

/// All procedural scenes.
#[must_use]
pub fn builtin() -> &'static [Builtin] {
    &BUILTINS
}

/// The model of the procedural scene `name` for an image of `size` pixels. Keys left out have their defaults.
///
/// # Errors
/// Names the scene and the key: unknown, of the wrong type or out of range.
pub fn generate(name: &str, keys: &BTreeMap<String, toml::Value>, size: [u32; 2]) -> Result<Model> {
    let builtin = find(name)?;
    let keys = Keys::new(builtin.name, builtin.keys, keys)?;
    (builtin.generate)(&keys, size)
}

/// The catalogue's entry for `name`.
///
/// # Errors
/// Lists the known names.
pub fn find(name: &str) -> Result<&'static Builtin> {
    BUILTINS.iter().find(|builtin| builtin.name == name).ok_or_else(|| {
        let names = BUILTINS.map(|builtin| builtin.name).join(", ");
        Error::new(name, format!("scene: is neither a file nor one of the built-in scenes {names}"))
    })
}

/// Reads `key=value,key=value`; colours are written `r/g/b`.
///
/// # Errors
/// Names the scene and the part that is not `key=value`.
pub fn parse_keys(name: &str, text: &str) -> Result<BTreeMap<String, toml::Value>> {
    let mut keys = BTreeMap::new();
    for part in text.split(',').filter(|part| !part.trim().is_empty()) {
        let wrong = |problem: &str| Error::new(name, format!("{}: {problem}", part.trim()));
        let (key, value) = part.split_once('=').ok_or_else(|| wrong("must be key=value"))?;
        if keys.insert(key.trim().to_owned(), value_of(value.trim())).is_some() {
            return Err(wrong("is set twice"));
        }
    }
    Ok(keys)
}

fn value_of(text: &str) -> toml::Value {
    if text.contains('/') {
        return toml::Value::Array(text.split('/').map(value_of).collect());
    }
    let integer = text.parse().map(toml::Value::Integer);
    let number = integer.or_else(|_| text.parse().map(toml::Value::Float));
    number.unwrap_or_else(|_: std::num::ParseFloatError| toml::Value::String(text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_valid_and_every_scene_has_triangles() {
        for builtin in builtin() {
            let keys = BTreeMap::new();
            let model = generate(builtin.name, &keys, [64, 48]).unwrap();
            assert!(model.triangles() > 0, "{}", builtin.name);
            assert_eq!(builtin.in_pixels, model.objects.is_empty(), "{}", builtin.name);
            assert_eq!(builtin.in_pixels, !model.screen.is_empty(), "{}", builtin.name);
            for material in &model.materials {
                super::super::check::color("test", "color", material.color).unwrap();
                super::super::check::fraction("test", "alpha", material.alpha).unwrap();
            }
            for object in &model.objects {
                super::super::check::mesh("test", &object.mesh).unwrap();
            }
        }
    }

    #[test]
    fn keys_are_told_apart_by_what_is_wrong() {
        let error = |source: &str| {
            let (name, keys) = source.split_once(':').unwrap();
            let keys = parse_keys(name, keys);
            keys.and_then(|keys| generate(name, &keys, [8, 8])).unwrap_err().to_string()
        };
        assert_eq!(error("layers:count"), "layers: count: must be key=value");
        assert_eq!(error("layers:count=1,count=2"), "layers: count=2: is set twice");
        assert!(
            error("layers:cuont=1").starts_with("layers: cuont: is not a key; there are count")
        );
        assert_eq!(error("layers:count=0"), "layers: count: 0 is not within 1 to 65536");
        assert_eq!(error("layers:count=x"), "layers: count: must be a whole number");
        assert_eq!(error("layers:alpha=2"), "layers: alpha: 2 is not within 0 to 1");
        assert_eq!(error("layers:alpha=nan"), "layers: alpha: NaN is not within 0 to 1");
        assert!(error("layers:color=1/2/3").starts_with("layers: color: must be three numbers"));
        assert!(error("synthetic:order=up").starts_with("synthetic: order: must be one of random"));
        assert!(error("layres:").starts_with("layres: scene: is neither a file nor one of"));
    }
}
