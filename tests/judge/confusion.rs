//! The confusion table: kinds of wrong pictures against the classes that they are given.

use std::collections::BTreeMap;

use fragloom::image::Image;
use fragloom::image::foreign::{Foreign, Opacity, Space};
use fragloom::judge::{Answer, Class, Entry, Settings, Verdict, judge};
use fragloom::render::{CullFace, Options, render};
use fragloom::scene::Scene;

use super::support::{options, scene};
use super::wrong::{Light, byte, changed, color, decode, encode, most_seen, over, painted, seen};

/// A scene, its exact answer, and what it is for.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) scene: Scene,
}

pub(crate) fn exact() -> Options {
    options("exact", None)
}

/// A picture as a PNG file has it.
pub(crate) fn foreign(image: &Image) -> Foreign {
    let pixels = image.pixels.iter().map(|p| p.map(|c| f64::from(c) / 255.0)).collect();
    let size = [image.width, image.height];
    Foreign { size, pixels, space: Space::Srgb, opacity: Opacity::Straight }
}

pub(crate) fn verdict(answer: &Answer<'_>, image: &Image) -> Verdict {
    judge(answer, &foreign(image), "picture.png", &Settings::default()).expect("a verdict")
}

fn suite(name: &str) -> Scene {
    let path = format!("{}/suite/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    fragloom::scene::load(&path, &fragloom::scene::Overrides::default()).expect("a scene")
}

/// Scenes of different character.
pub(crate) fn cases() -> Vec<Case> {
    let case = |name, scene| Case { name, scene };
    vec![
        case("synthetic", scene("synthetic:n=14,tessellation=3", [64, 48])),
        case("cubes", scene("cubes", [64, 48])),
        case("hairball", scene("hairball:strands=60", [64, 48])),
        case("screen", scene(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/screen.toml"), [64, 48])),
        case("stairs", suite("stairs")),
        case("shuffled", suite("shuffled")),
        case("interpenetrating", suite("interpenetrating")),
        case("equal-depths", suite("equal-depths")),
        case("nested-boxes", suite("nested-boxes")),
        case("far-plane", suite("far-plane")),
        case("alpha-steps", suite("alpha-steps")),
    ]
}

/// What a wrong picture is made from.
struct Source<'a> {
    scene: &'a Scene,
    answer: &'a Answer<'a>,
    backs: BTreeMap<u32, bool>,
    seen: Vec<u32>,
}

/// A kind of wrong picture: how it is made, and the classes that it is rightly given.
struct Kind {
    name: &'static str,
    made: fn(&Source<'_>) -> Option<Image>,
    classes: &'static [Class],
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

const KINDS: &[Kind] = &[
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
                let mut out = background.map(encode);
                for entry in list.iter().rev() {
                    let (c, a) = color(entry);
                    for i in 0..3 {
                        out[i] = encode(c[i]) * a + out[i] * (1.0 - a);
                    }
                }
                out.map(byte)
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
                let mut light = background;
                for entry in list.iter().rev() {
                    let (c, a) = color(entry);
                    for i in 0..3 {
                        light[i] = (c[i] + light[i] * (1.0 - a)).min(1.0);
                    }
                }
                seen(light)
            })
        },
        classes: &[Class::Premultiplication],
    },
    Kind {
        name: "multiplied by opacity twice",
        made: |s| {
            paint(s, |list, background| {
                let mut light = background;
                for entry in list.iter().rev() {
                    let (c, a) = color(entry);
                    for i in 0..3 {
                        light[i] = c[i] * a * a + light[i] * (1.0 - a);
                    }
                }
                seen(light)
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

/// Kinds that are rightly given another class on a scene, and why.
const ALIKE: &[(&str, &str, Class, &str)] = &[
    ("nearest 2", "synthetic", Class::DepthTest, SAME),
    ("nearest 2", "shuffled", Class::DepthTest, SAME),
    ("added up", "synthetic", Class::Premultiplication, WHITE),
    ("added up", "shuffled", Class::Premultiplication, WHITE),
    ("back faces left out", "screen", Class::Blending, WHITE),
    ("back faces left out", "stairs", Class::Blending, WHITE),
    ("back faces left out", "shuffled", Class::Premultiplication, WHITE),
    ("back faces left out", "interpenetrating", Class::Blending, WHITE),
    ("back faces left out", "equal-depths", Class::Blending, WHITE),
    ("back faces left out", "far-plane", Class::Blending, WHITE),
    ("back faces left out", "alpha-steps", Class::Blending, WHITE),
    ("back to front taken for front to back", "interpenetrating", Class::Placement, SAME),
    ("back to front taken for front to back", "equal-depths", Class::Tie, SAME),
    ("blended unsorted", "equal-depths", Class::Tie, SAME),
    ("first 2 submitted", "equal-depths", Class::BeyondK, SAME),
    ("first 2 submitted", "far-plane", Class::BeyondK, SAME),
    ("a triangle dropped", "hairball", Class::Edge, THIN),
    ("a triangle drawn twice", "hairball", Class::Edge, THIN),
    ("4 sub-pixel bits", "cubes", Class::Swapped, FEW),
    ("moved by half a pixel", "interpenetrating", Class::Order, CROSSING),
    ("red and blue exchanged", "synthetic", Class::Faint, PALE),
];

const SAME: &str = "the picture is the same, byte by byte or within the tolerance";
const WHITE: &str =
    "all triangles are backs, or light adds up beyond white: what is seen is the white background";
const THIN: &str =
    "it is thinner than a pixel: an edge is near to the centre of each of its pixels";
const CROSSING: &str =
    "only the line where triangles cross moves: there, two fragments change places";
const PALE: &str = "its colours are so pale that no channel differs by more than 3 of 255";
const FEW: &str =
    "depths move with the corners, and few pixels differ at all: faces that cross change places";

/// The class of most pixels that are wrong; of a right picture, the one of most pixels that differ at all.
pub(crate) fn main_class(verdict: &Verdict) -> Class {
    let wrong = verdict.classes.iter().filter(|count| !count.class.is_right());
    let most = wrong.max_by_key(|count| count.pixels).map(|count| count.class);
    let rounded = verdict.classes.iter().any(|count| count.class == Class::Rounding);
    most.unwrap_or(if rounded { Class::Rounding } else { Class::Equal })
}

#[test]
fn every_kind_is_given_its_class() {
    let mut table: BTreeMap<usize, BTreeMap<Class, u32>> = BTreeMap::new();
    let mut problems = Vec::new();
    let mut told = std::collections::BTreeSet::new();
    for case in cases() {
        let answer = Answer::new(&case.scene, &exact()).expect("an answer");
        let backs = {
            let [width, height] = case.scene.size;
            let grid = fragloom::raster::Grid { width, height, tile: 64 };
            let front = fragloom::raster::FrontEnd::new(&case.scene, grid, 8, CullFace::None);
            (0..front.triangles as u32).map(|t| (t, front.is_back(t).unwrap_or(false))).collect()
        };
        let seen = most_seen(&answer, &case.scene);
        let source = Source { scene: &case.scene, answer: &answer, backs, seen };
        for (row, kind) in KINDS.iter().enumerate() {
            let Some(image) = (kind.made)(&source) else { continue };
            let found = verdict(&answer, &image);
            // What does not show is right.
            if found.right && !kind.classes.contains(&Class::Rounding) {
                assert_eq!(found.metrics.pixels_beyond, 0);
                continue;
            }
            let class = main_class(&found);
            *table.entry(row).or_default().entry(class).or_default() += 1;
            let as_if = found.hypothesis.as_ref().map_or("-", |held| &held.as_if);
            let counts: Vec<String> = found
                .classes
                .iter()
                .filter(|count| !count.class.is_right())
                .map(|count| format!("{} {}", count.class.name(), count.pixels))
                .collect();
            let alike = ALIKE.iter().any(|(k, scene, other, _)| {
                (*k, *scene, *other) == (kind.name, case.name, class) && told.insert((*k, *scene))
            });
            if !kind.classes.contains(&class) && !alike {
                problems.push(format!(
                    "{} on {}: {} [{as_if}]",
                    kind.name,
                    case.name,
                    counts.join(", ")
                ));
            }
        }
    }
    println!("| kind | scenes | called |\n|---|--:|---|");
    for (row, classes) in &table {
        let called: Vec<String> =
            classes.iter().map(|(class, n)| format!("{} {n}", class.name())).collect();
        let scenes: u32 = classes.values().sum();
        println!("| {} | {scenes} | {} |", KINDS[*row].name, called.join(", "));
    }
    assert!(problems.is_empty(), "{} cells are off:\n{}", problems.len(), problems.join("\n"));
    let unused: Vec<_> =
        ALIKE.iter().filter(|(k, scene, ..)| !told.contains(&(*k, *scene))).collect();
    assert!(unused.is_empty(), "{unused:?}");
    // Rounding to sRGB after each fragment stays within the tolerance here.
    assert!(table.len() + 1 >= KINDS.len(), "every kind but one shows somewhere");
}

/// A missing triangle is named, with its pixels.
#[test]
fn what_is_missing_is_named() {
    let mut named = 0;
    for case in cases().into_iter().take(4) {
        let answer = Answer::new(&case.scene, &exact()).expect("an answer");
        for &gone in most_seen(&answer, &case.scene).iter().take(3) {
            let image = changed(&answer, &case.scene, &|list| list.retain(|e| e.triangle != gone));
            let found = verdict(&answer, &image);
            // Thin ones lie at edges all over, and what a hypothesis explains is nobody's fault.
            let Some(first) = found.culprits.first() else {
                assert!(!found.right, "{}", case.name);
                continue;
            };
            named += 1;
            assert_eq!(first.triangle, Some(gone), "{}: {:?}", case.name, found.culprits);
            assert_eq!(first.class, Class::Missing);
            let entries = &answer.lists().entries;
            let total = entries.iter().filter(|e| e.triangle == gone).count() as u64;
            assert_eq!(first.of, Some(total));
            let [x, y] = first.first;
            let list = answer.lists().pixel(x, y);
            let index = first.index.expect("a place") as usize;
            assert_eq!((list[index].triangle, Some(list[index].depth)), (gone, first.depth));
        }
    }
    assert!(named >= 8, "{named} of 12");
}
