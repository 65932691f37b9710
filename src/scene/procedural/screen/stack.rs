//! Squares of one size at random places, brought together until they lie on each other: the number of fragments stays,
//! and depth complexity grows (the stress test of the HA-buffer paper, figure 8).

use super::super::super::Model;
use super::super::shape::{layer_depth, rectangle};
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "stack",
    about: "squares of one size, brought together until they lie on each other",
    in_pixels: true,
    keys: &[
        Key { name: "count", default: "64", range: Range::Count(1, 65_536), about: "squares" },
        Key {
            name: "edge",
            default: "0.25",
            range: Range::Real(0.0, 1.0),
            about: "a square's edge, as a part of the image's shorter one; at least a pixel",
        },
        Key {
            name: "together",
            default: "0.5",
            range: Range::Real(0.0, 1.0),
            about: "0: at random places; 1: all in the middle",
        },
        Key::alpha("0.25"),
        Key::SEED,
    ],
    generate,
};

fn generate(keys: &Keys<'_>, size: [u32; 2]) -> Result<Model> {
    let (count, alpha) = (keys.count("count")?, keys.alpha()?);
    let (edge, together) = (keys.real("edge")?, keys.real("together")?);
    let shorter = f64::from(size[0].min(size[1]));
    // Whole pixels, so that every square has as many fragments wherever it lies.
    let edge = (edge * shorter).round().clamp(1.0, shorter);
    let mut random = Random::new(keys.seed()?, 2);
    let mut order: Vec<u32> = (0..count).collect();
    random.shuffle(&mut order);
    let square = |i: u32| {
        let mut corner = |size: u32| {
            let room = f64::from(size) - edge;
            let (free, middle) = (random.unit() * room, room * 0.5);
            (free + (middle - free) * together).round()
        };
        let (x, y) = (corner(size[0]), corner(size[1]));
        let color = std::array::from_fn(|_| random.unit() as f32);
        let [r, g, b] = color;
        rectangle([x, y, x + edge, y + edge], layer_depth(i, count), [r, g, b, alpha])
    };
    Ok(Model { screen: order.into_iter().flat_map(square).collect(), ..Model::default() })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::super::{generate, parse_keys};

    #[test]
    fn squares_keep_their_size_and_meet_in_the_middle() {
        for (together, distinct) in [("0", 9), ("1", 1)] {
            let keys = parse_keys("stack", &format!("count=9,together={together}")).unwrap();
            let model = generate("stack", &keys, [64, 48]).unwrap();
            assert_eq!(model.screen.len(), 18);
            let corner = |t: &crate::scene::ScreenTriangle| {
                let low = |axis: usize| t.points.iter().map(|p| p[axis] as i64).min().unwrap();
                let high = |axis: usize| t.points.iter().map(|p| p[axis] as i64).max().unwrap();
                assert_eq!((high(0) - low(0), high(1) - low(1)), (12, 12));
                (low(0), low(1))
            };
            let mut corners: Vec<_> = model.screen.iter().map(corner).collect();
            corners.sort_unstable();
            corners.dedup();
            assert_eq!(corners.len(), distinct);
        }
        let empty = BTreeMap::new();
        assert!(generate("stack", &empty, [1, 1]).is_ok());
    }
}
