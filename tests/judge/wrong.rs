//! Pictures made from the exact lists by plain code: floating point, one pixel after the other, nothing of the judge.

use fragloom::image::Image;
use fragloom::judge::{Answer, Entry};
use fragloom::scene::Scene;

pub(crate) type Light = [f64; 3];

/// One pixel: its fragments front to back, and the background, linear.
pub(crate) type Paint<'a> = &'a dyn Fn(&[Entry], Light) -> [u8; 3];

pub(crate) fn encode(c: f64) -> f64 {
    let c = c.clamp(0.0, 1.0);
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 }
}

pub(crate) fn decode(c: f64) -> f64 {
    if c <= 0.040_45 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}

pub(crate) fn byte(c: f64) -> u8 {
    (c.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Linear light as the picture has it.
pub(crate) fn seen(light: Light) -> [u8; 3] {
    light.map(|c| byte(encode(c)))
}

pub(crate) fn color(entry: &Entry) -> (Light, f64) {
    let [r, g, b, a] = entry.color.to_le_bytes().map(|c| f64::from(c) / 255.0);
    ([r, g, b], a)
}

/// From back to front, each over what is there.
pub(crate) fn over(list: &[Entry], background: Light) -> Light {
    let mut light = background;
    for entry in list.iter().rev() {
        let (c, a) = color(entry);
        for i in 0..3 {
            light[i] = c[i] * a + light[i] * (1.0 - a);
        }
    }
    light
}

/// Every pixel, by `paint`.
pub(crate) fn painted(answer: &Answer<'_>, scene: &Scene, paint: Paint<'_>) -> Image {
    let [width, height] = scene.size;
    let background = scene.background.map(f64::from);
    let mut pixels = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let [r, g, b] = paint(answer.lists().pixel(x, y), background);
            pixels.push([r, g, b, 255]);
        }
    }
    Image { width, height, pixels }
}

/// As [`painted`], with lists that `change` has changed, blended as they should be.
pub(crate) fn changed(
    answer: &Answer<'_>,
    scene: &Scene,
    change: &dyn Fn(&mut Vec<Entry>),
) -> Image {
    painted(answer, scene, &|list, background| {
        let mut list = list.to_vec();
        change(&mut list);
        seen(over(&list, background))
    })
}

/// The triangle with the most fragments that show.
pub(crate) fn most_seen(answer: &Answer<'_>, scene: &Scene) -> Vec<u32> {
    let mut counts = std::collections::BTreeMap::new();
    for y in 0..scene.size[1] {
        for x in 0..scene.size[0] {
            let list = answer.lists().pixel(x, y);
            for (i, entry) in list.iter().enumerate() {
                let mut without = list.to_vec();
                without.remove(i);
                let background = scene.background.map(f64::from);
                let [a, b] = [list, &without[..]].map(|list| seen(over(list, background)));
                if a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 6) {
                    *counts.entry(entry.triangle).or_insert(0_u32) += 1;
                }
            }
        }
    }
    let mut triangles: Vec<(u32, u32)> = counts.into_iter().map(|(t, n)| (n, t)).collect();
    triangles.sort_by_key(|&(n, t)| (std::cmp::Reverse(n), t));
    triangles.into_iter().map(|(_, triangle)| triangle).collect()
}
