//! CSG against intervals: an object is, along a ray, the set of depths between its 1st and 2nd fragment, its 3rd and
//! 4th, and so on; an expression is algebra on such sets.

use std::sync::Arc;

use fragloom::effect::csg::{Expression, walk};
use fragloom::render::{Data, Effect, Lists, Options, Rendering};
use fragloom::scene::{Bounds, Camera, Object, Scene};
use glam::{DMat4, DVec3};
use proptest::prelude::*;

use super::support::model;
use super::support::{draw, lists, method, options, scene};
use super::{effect, runs, srgb, toml};

/// An expression as a test writes it.
#[derive(Clone, Debug)]
enum Tree {
    Object(usize),
    Not(Box<Tree>),
    Binary(char, Box<Tree>, Box<Tree>),
}

/// Half-open intervals of depth, sorted, apart from each other and not empty.
type Set = Vec<(u64, u64)>;

/// Beyond every depth.
const END: u64 = 1 << 40;

fn complement(set: &Set) -> Set {
    let mut gaps = Vec::new();
    let mut from = 0;
    for &(start, end) in set {
        gaps.push((from, start));
        from = end;
    }
    gaps.push((from, END));
    gaps.retain(|&(start, end)| start < end);
    gaps
}

fn intersection(a: &Set, b: &Set) -> Set {
    let each = a.iter().flat_map(|&(s, e)| b.iter().map(move |&(t, f)| (s.max(t), e.min(f))));
    let mut both: Set = each.filter(|&(start, end)| start < end).collect();
    both.sort_unstable();
    both
}

fn union(a: &Set, b: &Set) -> Set {
    complement(&intersection(&complement(a), &complement(b)))
}

impl Tree {
    fn object(i: usize) -> Box<Self> {
        Box::new(Self::Object(i))
    }

    fn of(sign: char, left: Box<Self>, right: Box<Self>) -> Box<Self> {
        Box::new(Self::Binary(sign, left, right))
    }

    /// With a parenthesis around everything.
    fn text(&self, names: &[&str]) -> String {
        match self {
            Self::Object(i) => names[*i].to_owned(),
            Self::Not(inner) => format!("~({})", inner.text(names)),
            Self::Binary(sign, a, b) => format!("({} {sign} {})", a.text(names), b.text(names)),
        }
    }

    fn set(&self, objects: &[Set]) -> Set {
        match self {
            Self::Object(i) => objects[*i].clone(),
            Self::Not(inner) => complement(&inner.set(objects)),
            Self::Binary(sign, a, b) => {
                let (a, b) = (a.set(objects), b.set(objects));
                match sign {
                    '|' => union(&a, &b),
                    '&' => intersection(&a, &b),
                    '-' => intersection(&a, &complement(&b)),
                    _ => union(
                        &intersection(&a, &complement(&b)),
                        &intersection(&b, &complement(&a)),
                    ),
                }
            }
        }
    }
}

/// Pairs of sorted depths, as a set.
fn intervals(depths: &[u64]) -> Set {
    let pairs = depths.chunks_exact(2).map(|pair| vec![(pair[0], pair[1])]);
    let apart = pairs.filter(|pair| pair[0].0 < pair[0].1);
    apart.fold(Vec::new(), |sum, pair| union(&sum, &pair))
}

/// Depths at which a set begins or ends, and whether it begins.
fn boundaries(set: &Set) -> Vec<(u64, bool)> {
    let ends = set.iter().flat_map(|&(start, end)| [(start, true), (end, false)]);
    ends.filter(|&(at, _)| at > 0 && at < END).collect()
}

/// The objects' names, and which object has a global triangle index.
fn objects(scene: &Scene) -> (Vec<&str>, impl Fn(u32) -> usize) {
    let counts: Vec<_> = scene.objects.iter().map(|object| object.mesh.triangles.len()).collect();
    let names = scene.objects.iter().map(|object| object.name.as_str()).collect();
    (names, move |triangle| {
        let mut rest = triangle as usize;
        counts
            .iter()
            .position(|&count| {
                rest < count || {
                    rest -= count;
                    false
                }
            })
            .expect("an object")
    })
}

/// Every object's set along one pixel's ray.
fn sets(keys: &[u64], count: usize, of: &impl Fn(u32) -> usize) -> Vec<Set> {
    let depths = |object| {
        let own = keys.iter().filter(|&&key| of(key as u32) == object);
        intervals(&own.map(|key| key >> 32).collect::<Vec<_>>())
    };
    (0..count).map(depths).collect()
}

fn render(scene: &Scene, text: &str) -> Rendering {
    draw(scene, &effect("ab-ll", Effect::Csg(Expression::parse(text).expect("right"))))
}

/// The number of pixels whose surfaces, front to back, are not the expected set's boundaries.
fn differing(scene: &Scene, tree: &Tree, surfaces: &Lists) -> usize {
    let exact = lists(scene, &Options { data: Data::Primitive, ..options("exact", None) });
    let (names, of) = objects(scene);
    let pixels = (0..exact.height).flat_map(|y| (0..exact.width).map(move |x| (x, y)));
    let differs = |&(x, y): &(u32, u32)| {
        let expected = boundaries(&tree.set(&sets(exact.pixel(x, y), names.len(), &of)));
        let found = surfaces.pixel(x, y).iter().map(|key| key >> 32);
        !expected.iter().map(|&(depth, _)| depth).eq(found)
    };
    pixels.filter(differs).count()
}

/// Surfaces are the boundaries; the picture has the colour of a fragment at the first that begins, opaque.
#[track_caller]
fn agrees(scene: &Scene, tree: &Tree) {
    let (names, of) = objects(scene);
    let drawn = render(scene, &tree.text(&names));
    let surfaces = drawn.surfaces.as_ref().expect("surfaces");
    assert_eq!(differing(scene, tree, surfaces), 0, "{}", tree.text(&names));
    assert!(drawn.report.open_pixels.is_empty(), "{:?}", drawn.report.warnings);
    let colors = lists(scene, &options("exact", None));
    let exact = lists(scene, &Options { data: Data::Primitive, ..options("exact", None) });
    let background = scene.background.map(|c| srgb((f64::from(c) * 65_535.0).round() as u64));
    let mut seen = 0;
    for (x, y) in (0..exact.height).flat_map(|y| (0..exact.width).map(move |x| (x, y))) {
        let [r, g, b, alpha] = drawn.image.pixel(x, y);
        assert_eq!(alpha, 255);
        let set = boundaries(&tree.set(&sets(exact.pixel(x, y), names.len(), &of)));
        let Some(&(depth, _)) = set.iter().find(|(_, begins)| *begins) else {
            assert_eq!([r, g, b], background, "{x} {y}");
            continue;
        };
        seen += 1;
        let at = colors.pixel(x, y).iter().filter(|&&key| key >> 32 == depth);
        let mut shown = at.map(|&key| {
            let [r, g, b, _] = (key as u32).to_le_bytes();
            [r, g, b].map(|c| srgb(u64::from(c) * 257))
        });
        assert!(shown.any(|color| color == [r, g, b]), "{x} {y}: {r} {g} {b}");
    }
    assert!(seen > 200, "only {seen} pixels see anything of {}", tree.text(&names));
}

/// Red box, green, blue (same front), yellow (same floor and side), violet (inside), ball.
fn trees() -> Vec<Tree> {
    let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(Tree::object);
    let all = [a.clone(), b.clone(), c.clone(), d.clone(), e.clone(), f.clone()];
    let sum = all.into_iter().reduce(|x, y| Tree::of('|', x, y)).expect("six");
    let trees = [
        sum.clone(),
        Tree::of('-', a.clone(), d.clone()),
        Tree::of('-', Tree::of('|', a.clone(), c.clone()), f.clone()),
        Tree::of('&', a.clone(), f.clone()),
        Tree::of('^', Tree::of('^', a.clone(), b), f.clone()),
        Tree::of('-', a.clone(), Tree::of('-', f.clone(), e)),
        Tree::of('&', Box::new(Tree::Not(f)), Tree::of('|', a, Tree::of('-', d, c))),
        *Box::new(Tree::of('&', Box::new(Tree::Not(Tree::object(0))), sum)),
    ];
    trees.into_iter().map(|tree| *tree).collect()
}

#[test]
fn boxes_and_a_ball_agree_with_intervals() {
    let scene = scene("cubes:sides=24", [56, 48]);
    trees().iter().for_each(|tree| agrees(&scene, tree));
}

/// A model, and a closed shape around the point at a share of its bounding box.
fn beside(model: Option<Scene>, shape: &str, share: f64) -> Option<Scene> {
    let mut whole = model?;
    let bounds = Bounds::of(&whole.objects);
    let radius = bounds.diagonal() * 0.25;
    let place = bounds.min + (bounds.max - bounds.min) * share;
    let source = shape.replace("SIZE", &format!("{radius}"));
    let Object { mesh, .. } = scene(&source, [8, 8]).objects.remove(0);
    let transform = DMat4::from_translation(place);
    whole.objects.push(Object {
        name: "b".to_owned(),
        mesh: Arc::clone(&mesh),
        transform,
        material: 0,
        thickness: None,
    });
    whole.camera = Camera::frame(Bounds::of(&whole.objects), whole.size);
    Some(whole)
}

#[test]
fn models_agree_with_intervals() {
    let minus = Tree::of('-', Tree::object(0), Tree::object(1));
    for whole in [
        beside(model("spot.obj", [96, 96]), "sphere:radius=SIZE", 0.8),
        beside(model("dragon.obj", [96, 96]), "box:x=SIZE,y=SIZE,z=SIZE", 0.5),
    ]
    .iter()
    .flatten()
    {
        assert_eq!(whole.objects.len(), 2, "{}", whole.name);
        agrees(whole, &minus);
        agrees(whole, &Tree::of('&', Tree::object(0), Tree::object(1)));
        agrees(whole, &Tree::of('^', minus.clone(), Tree::object(1)));
    }
}

#[test]
fn every_method_and_executor_gives_the_same() {
    let scene = scene("cubes:sides=16", [40, 32]);
    let effect = effect("exact", Effect::Csg(Expression::parse("(a | b | c) - f").expect("right")));
    let first = draw(&scene, &effect);
    for (method, exec) in runs() {
        // At most 12 fragments are on a pixel; k-buffers keep that many.
        let k = (method == "kplus-array").then_some(16);
        let drawn =
            draw(&scene, &Options { method: self::method(method), exec, k, ..effect.clone() });
        assert_eq!(drawn.surfaces, first.surfaces, "{method}");
        assert_eq!(drawn.image, first.image, "{method}");
        assert!(drawn.report.warnings.is_empty(), "{method}: {:?}", drawn.report.warnings);
    }
}

/// Negative controls: a difference that is drawn as a union; equal depths that are taken one after another.
#[test]
fn wrong_walkers_are_seen() {
    // Two boxes with one front, seen straight on.
    let scene = toml(
        "size = [32, 32]\n[camera]\neye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\northo_height = 4.0\n\
         [[object]]\nprocedural = \"box\"\nx = 2.0\ny = 2.0\nz = 2.0\n\
         [[object]]\nprocedural = \"box\"\ntranslate = [0.0, 0.0, 0.5]\n",
    );
    let tree = *Tree::of('-', Tree::object(0), Tree::object(1));
    let surfaces = |text: &str| render(&scene, text).surfaces.expect("surfaces");
    assert_eq!(differing(&scene, &tree, &surfaces("a - b")), 0);
    assert_eq!(differing(&scene, &tree, &surfaces("a | b")), 8 * 8, "the hole is filled");

    let expression = Expression::parse("a - b").expect("right");
    let (_, of) = objects(&scene);
    let exact = lists(&scene, &Options { data: Data::Primitive, ..options("exact", None) });
    let one_by_one = exact.cut(|_, keys| {
        let mut inside = 0;
        keys.retain(|&key| {
            let before = expression.evaluate(inside);
            inside ^= 1 << of(key as u32);
            expression.evaluate(inside) != before
        });
    });
    assert_eq!(differing(&scene, &tree, &one_by_one), 8 * 8, "a sliver of a before the hole");
}

#[test]
fn open_meshes_are_counted_per_object() {
    let mut open = scene("cubes", [56, 48]);
    Arc::make_mut(&mut open.objects[1].mesh).triangles.pop();
    let drawn = render(&open, "(a | b) - c");
    let (name, &pixels) = drawn.report.open_pixels.first_key_value().expect("one is open");
    assert_eq!((name.as_str(), drawn.report.open_pixels.len()), ("b", 1));
    let warning = format!("object 'b' is not closed: {pixels} pixels have odd parity");
    assert!(pixels > 5 && drawn.report.warnings == [warning]);
    assert!(render(&open, "a - c").report.open_pixels.is_empty(), "b is not in it");
}

/// Meshes of one name are one object, and a camera inside of one is reported.
#[test]
fn objects_by_name() {
    let mut scene = scene("cubes", [40, 32]);
    scene.objects.truncate(2);
    scene.objects[1].transform = DMat4::from_translation(DVec3::new(9.0, 0.0, 0.0));
    let apart = render(&scene, "a | b");
    scene.objects[1].name = "a".to_owned();
    assert_eq!(render(&scene, "a").surfaces, apart.surfaces);
    scene.camera.eye = DVec3::new(0.0, 0.0, 0.5);
    scene.camera.near = 0.01;
    scene.camera.target = DVec3::ZERO;
    assert_eq!(render(&scene, "a").report.open_pixels, [("a".to_owned(), 40 * 32)].into());
}

fn tree(objects: usize) -> impl Strategy<Value = Tree> {
    (0..objects).prop_map(Tree::Object).prop_recursive(6, 40, 2, |inner| {
        let sign = prop::sample::select(vec!['|', '&', '-', '^']);
        prop_oneof![
            inner.clone().prop_map(|tree| Tree::Not(Box::new(tree))),
            (sign, inner.clone(), inner).prop_map(|(sign, a, b)| *Tree::of(
                sign,
                a.into(),
                b.into()
            )),
        ]
    })
}

const NAMES: [&str; 5] = ["a", "b2", "_c", "Dd", "e_"];

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Depths are few, so that many coincide.
    #[test]
    fn walks_are_algebra_on_intervals(
        tree in tree(5),
        faces in prop::collection::vec(prop::collection::vec(1..20u64, 0..4), 5),
    ) {
        let mut keys = Vec::new();
        let mut objects = Vec::new();
        for (i, half) in faces.iter().enumerate() {
            // An even number, in pairs that may have no thickness.
            let mut depths: Vec<u64> = half.iter().flat_map(|&d| [d, (d * 7 + i as u64) % 19 + 1]).collect();
            depths.sort_unstable();
            keys.extend(depths.iter().map(|depth| depth << 32 | i as u64));
            objects.push(intervals(&depths));
        }
        keys.sort_unstable();
        let text = tree.text(&NAMES);
        let expression = Expression::parse(&text).unwrap();
        let bits: Vec<Option<u32>> = NAMES
            .iter()
            .map(|name| expression.names().position(|known| known == *name).map(|bit| bit as u32))
            .collect();
        let mut found = Vec::new();
        let odd = walk(&expression, &keys, |data| bits[data as usize], |change| {
            found.push((change.key >> 32, change.inside));
        });
        prop_assert_eq!(odd, 0);
        prop_assert_eq!(found, boundaries(&tree.set(&objects)), "{}", text);
    }

    #[test]
    fn what_is_shown_reads_back(tree in tree(5)) {
        let expression = Expression::parse(&tree.text(&NAMES)).unwrap();
        let shown = expression.to_string();
        prop_assert_eq!(Expression::parse(&shown).unwrap(), expression.clone(), "{}", &shown);
        let tight: String = shown.chars().filter(|c| !c.is_whitespace()).collect();
        prop_assert_eq!(Expression::parse(&tight.replace('~', " ! ")).unwrap(), expression);
    }

    #[test]
    fn no_text_is_too_much(text in "[a-c~!()|&^ \\-]{0,40}|\\PC{0,20}") {
        if let Err(error) = Expression::parse(&text) {
            let column = error.problem().strip_prefix("csg: column ").and_then(|rest| rest.split(':').next());
            let column: usize = column.unwrap().parse().unwrap();
            prop_assert!((1..=text.chars().count() + 1).contains(&column), "{:?}: {}", text, error);
        }
    }
}
