//! Kinds of wrong pictures, made from the lists of a scene by code of their own.

use std::collections::BTreeMap;

use fragloom::image::Image;
use fragloom::judge::{Answer, Class, Entry};
use fragloom::render::{Options, render};
use fragloom::scene::Scene;

use super::confusion::exact;
use super::wrong::{Light, byte, changed, color, decode, encode, over, painted, seen};

/// What a wrong picture is made from.
pub(super) struct Source<'a> {
    pub(super) scene: &'a Scene,
    pub(super) answer: &'a Answer<'a>,
    pub(super) backs: BTreeMap<u32, bool>,
    pub(super) seen: Vec<u32>,
}

/// A kind of wrong picture: how it is made, and the classes that it is rightly given.
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) made: fn(&Source<'_>) -> Option<Image>,
    pub(super) classes: &'static [Class],
}

fn drawn(scene: &Scene, options: &Options) -> Image {
    render(scene, options).expect("a picture").image
}

/// The scene with its triangles in pixels moved; none if it has others.
fn moved(scene: &Scene, by: [f64; 2]) -> Option<Scene> {
    if !scene.objects.is_empty() {
        return None;
    }
    let mut scene = scene.clone();
    for point in scene.screen.iter_mut().flat_map(|triangle| &mut triangle.points) {
        point[0] += by[0];
        point[1] += by[1];
    }
    Some(scene)
}

/// Lists changed at every pixel.
fn with(source: &Source<'_>, change: impl Fn(&mut Vec<Entry>)) -> Option<Image> {
    Some(changed(source.answer, source.scene, &change))
}

fn paint(source: &Source<'_>, paint: impl Fn(&[Entry], Light) -> [u8; 3]) -> Option<Image> {
    Some(painted(source.answer, source.scene, &paint))
}

/// Back to front: what `step` makes of a channel's light, and a fragment's channel and opacity.
fn blended(list: &[Entry], background: Light, step: impl Fn(f64, f64, f64) -> f64) -> Light {
    let mut light = background;
    for (c, a) in list.iter().rev().map(color) {
        for i in 0..3 {
            light[i] = step(light[i], c[i], a);
        }
    }
    light
}

/// Pixels of the exact picture from elsewhere.
fn placed(source: &Source<'_>, from: impl Fn(u32, u32) -> (u32, u32)) -> Option<Image> {
    let exact = source.answer.picture();
    let mut image = exact.clone();
    for y in 0..image.height {
        for x in 0..image.width {
            let (fx, fy) = from(x, y);
            image.pixels[(y * image.width + x) as usize] = exact.pixel(fx, fy);
        }
    }
    Some(image)
}

pub(super) const KINDS: &[Kind] = &[
    Kind {
        name: "right, blended in f64",
        made: |s| with(s, |_| ()),
        classes: &[Class::Equal, Class::Rounding],
    },
    Kind {
        name: "noise of 1/255",
        made: |s| {
            let mut image = s.answer.picture().clone();
            for (i, pixel) in image.pixels.iter_mut().enumerate() {
                let c = i % 3;
                pixel[c] = if i % 2 == 0 {
                    pixel[c].saturating_add(1)
                } else {
                    pixel[c].saturating_sub(1)
                };
            }
            Some(image)
        },
        classes: &[Class::Equal, Class::Rounding],
    },
    Kind {
        name: "edges moved by 1/16 pixel",
        made: |s| Some(drawn(&moved(s.scene, [0.0625, 0.0])?, &exact())),
        classes: &[Class::Edge],
    },
    Kind {
        name: "4 sub-pixel bits",
        made: |s| Some(drawn(s.scene, &Options { sub_pixel_bits: 4, ..exact() })),
        classes: &[Class::Edge],
    },
    Kind {
        name: "moved by half a pixel",
        made: |s| Some(drawn(&moved(s.scene, [0.5, 0.5])?, &exact())),
        classes: &[Class::Placement],
    },
    Kind {
        name: "upside down",
        made: |s| placed(s, |x, y| (x, s.scene.size[1] - 1 - y)),
        classes: &[Class::Placement],
    },
    Kind {
        name: "mirrored",
        made: |s| placed(s, |x, y| (s.scene.size[0] - 1 - x, y)),
        classes: &[Class::Placement],
    },
    Kind {
        name: "nearest 2",
        made: |s| with(s, |list| list.truncate(2)),
        classes: &[Class::BeyondK],
    },
    Kind {
        name: "first 2 submitted",
        made: |s| {
            with(s, |list| {
                let mut order: Vec<u32> = list.iter().map(|e| e.triangle).collect();
                order.sort_unstable();
                list.retain(|e| order.iter().position(|t| *t == e.triangle) < Some(2));
            })
        },
        classes: &[Class::Order],
    },
    Kind {
        name: "back to front taken for front to back",
        made: |s| with(s, |list| list.reverse()),
        classes: &[Class::Order],
    },
    Kind {
        name: "blended unsorted",
        made: |s| with(s, |list| list.sort_by_key(|e| std::cmp::Reverse(e.triangle))),
        classes: &[Class::Order],
    },
    Kind {
        name: "depth buffer written",
        made: |s| {
            with(s, |list| {
                list.sort_by_key(|e| e.triangle);
                let mut passed: Vec<Entry> = Vec::new();
                for entry in list.iter() {
                    if passed.iter().all(|other| entry.depth < other.depth) {
                        passed.insert(0, *entry);
                    }
                }
                *list = passed;
            })
        },
        classes: &[Class::DepthTest],
    },
    Kind {
        name: "last submitted in front at equal depth",
        made: |s| with(s, |list| list.sort_by_key(|e| (e.depth, std::cmp::Reverse(e.triangle)))),
        classes: &[Class::Tie],
    },
    Kind {
        name: "a triangle dropped",
        made: |s| {
            let gone = *s.seen.first()?;
            with(s, |list| list.retain(|e| e.triangle != gone))
        },
        classes: &[Class::Missing],
    },
    Kind {
        name: "a triangle drawn twice",
        made: |s| {
            let twice = *s.seen.first()?;
            with(s, |list| {
                if let Some(place) = list.iter().position(|e| e.triangle == twice) {
                    list.insert(place, list[place]);
                }
            })
        },
        classes: &[Class::Duplicated],
    },
    Kind {
        name: "two triangles swapped",
        made: |s| {
            let first = *s.seen.first()?;
            // With the one that is next to it most often.
            let mut next = BTreeMap::new();
            for window in s.answer.lists().entries.windows(2) {
                if window[0].triangle == first && window[1].depth > window[0].depth {
                    *next.entry(window[1].triangle).or_insert(0) += 1;
                }
            }
            let second = *next.iter().max_by_key(|(_, n)| **n)?.0;
            with(s, |list| {
                let place = |t| list.iter().position(|e| e.triangle == t);
                if let (Some(a), Some(b)) = (place(first), place(second)) {
                    list.swap(a, b);
                }
            })
        },
        classes: &[Class::Swapped],
    },
    Kind {
        name: "back faces left out",
        made: |s| {
            with(s, |list| list.retain(|e| !s.backs.get(&e.triangle).copied().unwrap_or(false)))
        },
        classes: &[Class::Culling],
    },
    Kind {
        name: "nothing on the far plane",
        made: |s| with(s, |list| list.retain(|e| e.depth < u32::MAX - 1)),
        classes: &[Class::Clipping],
    },
    Kind {
        name: "blended in sRGB",
        made: |s| {
            paint(s, |list, background| {
                let over = |light: f64, c: f64, a: f64| encode(c) * a + light * (1.0 - a);
                blended(list, background.map(encode), over).map(byte)
            })
        },
        classes: &[Class::ColorSpace],
    },
    Kind {
        name: "linear written as sRGB",
        made: |s| paint(s, |list, background| over(list, background).map(byte)),
        classes: &[Class::ColorSpace],
    },
    Kind {
        name: "encoded twice",
        made: |s| {
            paint(s, |list, background| over(list, background).map(|c| byte(encode(encode(c)))))
        },
        classes: &[Class::ColorSpace],
    },
    Kind {
        name: "straight taken for premultiplied",
        made: |s| {
            paint(s, |list, background| {
                seen(blended(list, background, |light, c, a| (c + light * (1.0 - a)).min(1.0)))
            })
        },
        classes: &[Class::Premultiplication],
    },
    Kind {
        name: "multiplied by opacity twice",
        made: |s| {
            paint(s, |list, background| {
                seen(blended(list, background, |light, c, a| c * a * a + light * (1.0 - a)))
            })
        },
        classes: &[Class::Premultiplication],
    },
    Kind {
        name: "added up",
        made: |s| {
            paint(s, |list, background| {
                let mut light = background;
                for (c, a) in list.iter().map(color) {
                    for i in 0..3 {
                        light[i] = (light[i] + c[i] * a).min(1.0);
                    }
                }
                seen(light)
            })
        },
        classes: &[Class::Blending],
    },
    Kind {
        name: "weighted average",
        made: |s| {
            paint(s, |list, background| {
                let weight: f64 = list.iter().map(|e| color(e).1).sum();
                if weight == 0.0 {
                    return seen(background);
                }
                let n = list.len() as f64;
                let passes = libm::pow(1.0 - weight / n, n);
                let mut light = background.map(|c| c * passes);
                for (c, a) in list.iter().map(color) {
                    for i in 0..3 {
                        light[i] += c[i] * a / weight * (1.0 - passes);
                    }
                }
                seen(light)
            })
        },
        classes: &[Class::Blending],
    },
    Kind {
        name: "blending off",
        made: |s| {
            paint(s, |list, background| seen(list.first().map_or(background, |e| color(e).0)))
        },
        classes: &[Class::Blending],
    },
    Kind {
        name: "8 bits after each fragment",
        made: |s| {
            paint(s, |list, background| {
                let mut stored = background.map(byte);
                for (c, a) in list.iter().rev().map(color) {
                    for i in 0..3 {
                        stored[i] = byte(c[i] * a + f64::from(stored[i]) / 255.0 * (1.0 - a));
                    }
                }
                seen(stored.map(|c| f64::from(c) / 255.0))
            })
        },
        classes: &[Class::Precision],
    },
    Kind {
        name: "8 bits of sRGB after each fragment",
        made: |s| {
            paint(s, |list, background| {
                let mut stored = seen(background);
                for (c, a) in list.iter().rev().map(color) {
                    for i in 0..3 {
                        let light = decode(f64::from(stored[i]) / 255.0);
                        stored[i] = byte(encode(c[i] * a + light * (1.0 - a)));
                    }
                }
                stored
            })
        },
        classes: &[Class::Precision],
    },
    Kind {
        name: "black background",
        made: |s| paint(s, |list, _| seen(over(list, [0.0; 3]))),
        classes: &[Class::Background],
    },
    Kind {
        name: "red and blue exchanged",
        made: |s| {
            paint(s, |list, background| {
                let [r, g, b] = seen(over(list, background));
                [b, g, r]
            })
        },
        classes: &[Class::Channels],
    },
    Kind {
        name: "four samples a pixel",
        made: |s| {
            let offsets = [[-0.125, -0.375], [0.375, -0.125], [-0.375, 0.125], [0.125, 0.375]];
            let mut sums = vec![[0.0; 3]; s.answer.picture().pixels.len()];
            for offset in offsets {
                let image = drawn(&moved(s.scene, offset)?, &exact());
                for (sum, pixel) in sums.iter_mut().zip(&image.pixels) {
                    for c in 0..3 {
                        sum[c] += decode(f64::from(pixel[c]) / 255.0) / 4.0;
                    }
                }
            }
            let mut image = s.answer.picture().clone();
            for (pixel, sum) in image.pixels.iter_mut().zip(sums) {
                pixel[..3].copy_from_slice(&seen(sum));
            }
            Some(image)
        },
        classes: &[Class::Partial],
    },
];
