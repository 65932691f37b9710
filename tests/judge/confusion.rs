//! The confusion table: kinds of wrong pictures against the classes that they are given.

use std::collections::BTreeMap;

use fragloom::image::Image;
use fragloom::image::foreign::{Foreign, Opacity, Space};
use fragloom::judge::{Answer, Class, Settings, Verdict, judge};
use fragloom::render::{CullFace, Options};
use fragloom::scene::Scene;

use super::kinds::{KINDS, Source};
use super::support::{options, scene};
use super::wrong::{changed, most_seen};

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
