//! Equal layers over the whole image, whose blended colour has a closed form: with colour c, opacity a and
//! background b, `count` layers make c (1 - (1 - a)^count) + b (1 - a)^count, in whatever order they are drawn.
//! (With 8-bit data words, a is the opacity's byte over 255.)

use super::super::super::Model;
use super::super::shape::{ORDER, in_order, layer_depth, rectangle};
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "layers",
    about: "equal layers over the whole image: c (1 - (1 - a)^count) + background (1 - a)^count",
    in_pixels: true,
    keys: &[
        Key { name: "count", default: "16", range: Range::Count(1, 65_536), about: "layers" },
        Key::alpha("0.25"),
        Key {
            name: "color",
            default: "0.2/0.6/0.9",
            range: Range::Color,
            about: "linear colour, 0..1; as r/g/b on the command line",
        },
        ORDER,
        Key::SEED,
    ],
    generate,
};

fn generate(keys: &Keys<'_>, size: [u32; 2]) -> Result<Model> {
    let count = keys.count("count")?;
    let ([r, g, b], alpha) = (keys.color("color")?, keys.alpha()?);
    let [width, height] = size.map(f64::from);
    let random = Random::new(keys.seed()?, 1);
    let order = in_order(keys.choice("order")?, random, (0..count).collect::<Vec<u32>>());
    let layer = |i| rectangle([0.0, 0.0, width, height], layer_depth(i, count), [r, g, b, alpha]);
    Ok(Model { screen: order.into_iter().flat_map(layer).collect(), ..Model::default() })
}

#[cfg(test)]
mod tests {
    use super::super::super::{generate, parse_keys};

    #[test]
    fn layers_come_in_the_order_that_is_asked_for() {
        let depths = |order: &str| {
            let keys = parse_keys("layers", &format!("count=9,order={order}")).unwrap();
            let screen = generate("layers", &keys, [4, 4]).unwrap().screen;
            screen.iter().step_by(2).map(|triangle| triangle.points[0][2]).collect::<Vec<_>>()
        };
        let front = depths("front-to-back");
        assert!(front.len() == 9 && front.is_sorted() && front[0] < front[8]);
        let mut back = depths("back-to-front");
        assert_ne!(back, front);
        back.reverse();
        assert_eq!(back, front);
        let mut random = depths("random");
        assert!(random != front && random != back);
        random.sort_by(f64::total_cmp);
        assert_eq!(random, front);
    }
}
