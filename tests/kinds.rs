//! Methods of every kind, by the tests' own schemes: one that merges, one that blends without lists, one that reads an
//! image. (The battery has them too.) What they draw is compared with references. Effects that need lists say so, the
//! explorer verifies the schemes, and a token of a method with inputs carries the inputs.

mod support;
#[path = "support/toys/mod.rs"]
mod toys;

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;
use fragloom::explore::replay::replay_of;
use fragloom::explore::sample::{Executions, replay_scene};
use fragloom::explore::{Limits, Plan, Profile, Progress, Subject, Token, Verdict, check};
use fragloom::explore::{MemoryModel, properties};
use fragloom::fragment::{Fragment, data_of, depth_of};
use fragloom::memory::{Atomic, Pixel, Words};
use fragloom::memory::{Declared, Input, Inputs, Layout, Memory, Order, Per};
use fragloom::render::{Data, Effect, Exec, Given, Kept, Options, Policy, Sim, render};
use fragloom::scheme::{Config, Contract, HeldKind, Keeps, Light, Outcome, Record, Scheme};
use support::{draw, lists, options, policies, scene, sim, small_scenes};
use toys::blend::BlendAverage;
use toys::blend_nearest::BlendNearest;
use toys::k_from_image::KFromImage;
use toys::merge_two::MergeTwo;

const LIMITS: Limits<'_> = Limits { states: 3_000_000, cancelled: &|| false };

fn with<S: Scheme>(exec: Exec) -> Options {
    Options { method: Method::of::<S>(), exec, threads: 2, ..Options::default() }
}

fn executors() -> impl Iterator<Item = Exec> {
    [Exec::Tile, Exec::Threads].into_iter().chain(policies().map(|policy| sim(policy, 5)))
}

/// Against the exact lists, cut pixel by pixel.
#[test]
fn an_image_says_how_many_are_kept() {
    for scene in small_scenes() {
        let [width, height] = scene.size;
        let k = |x: u32, y: u32| (x + 3 * y) % 6;
        let words = (0..width * height).map(|i| k(i % width, i / width)).collect();
        let image = Given::Image { size: scene.size, words };
        let all = lists(&scene, &options("exact", None));
        for exec in executors() {
            let inputs = vec![("k".to_owned(), image.clone())];
            let drawn = draw(&scene, &Options { inputs, ..with::<KFromImage<true>>(exec.clone()) });
            let kept = drawn.lists().expect("lists");
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let all = all.pixel(x, y);
                let nearest = &all[..all.len().min(k(x, y) as usize)];
                assert_eq!(kept.pixel(x, y), nearest, "{} {exec:?} {x},{y}", scene.name);
            }
            assert_eq!(drawn.report.violations, Vec::<String>::new());
        }
    }
}

#[test]
fn wrong_inputs_are_named() {
    let scene = scene("layers:count=3", [16, 8]);
    let image =
        |size: [u32; 2]| Given::Image { size, words: vec![1; (size[0] * size[1]) as usize] };
    let cases = [
        ("q", Given::Every(1), "no such input"),
        ("k", image([8, 16]), "8x16"),
        ("k", Given::Image { size: [16, 8], words: vec![1; 5] }, "5 words"),
        ("k", Given::ByPrimitive(vec![1; 6]), "every pixel"),
        ("k", Given::ByObject(vec![1]), "every pixel"),
        ("k", Given::Frame(vec![1]), "every pixel"),
    ];
    for (name, given, told) in cases {
        let inputs = vec![(name.to_owned(), given)];
        let wrong = render(&scene, &Options { inputs, ..with::<KFromImage<true>>(Exec::Tile) });
        let wrong = wrong.map(|_| ()).expect_err(told);
        assert_eq!(wrong.place(), format!("input '{name}'"));
        assert!(wrong.problem().contains(told), "{wrong}");
    }
}

/// A table by object is a table by triangle with each object's word for all of its triangles.
#[test]
fn tables_by_object_and_by_triangle() {
    let scene = scene("cubes", [24, 20]);
    let triangles: Vec<usize> = scene.objects.iter().map(|o| o.mesh.triangles.len()).collect();
    assert!(triangles.len() > 2, "the scene has objects");
    let of_object: Vec<u32> = (0..triangles.len() as u32).map(|object| object % 2).collect();
    let by_triangle: Vec<u32> = of_object
        .iter()
        .zip(&triangles)
        .flat_map(|(&word, &count)| std::iter::repeat_n(word, count))
        .collect();
    let all = lists(&scene, &Options { data: Data::Primitive, ..options("exact", None) });
    for given in [Given::ByObject(of_object), Given::ByPrimitive(by_triangle.clone())] {
        for exec in executors() {
            let inputs = vec![("shown".to_owned(), given.clone())];
            let drawn = draw(&scene, &Options { inputs, ..with::<Counts>(exec) });
            let Kept::Color(pixels) = &drawn.kept else { panic!("colours") };
            for (i, light) in (0..).zip(pixels) {
                let shown = |key: &&u64| by_triangle[data_of(**key) as usize] == 1;
                let count = all.pixel(i % 24, i / 24).iter().filter(shown).count();
                assert_eq!(light.color[0], count as f64 / 256.0);
            }
        }
    }
}

/// Counts fragments of triangles that a table shows.
struct Counts {
    count: Words<Pixel, Atomic, u32>,
    shown: Input,
}

impl Scheme for Counts {
    const CONTRACT: Contract = Contract {
        words: "1",
        data: Some(Data::Primitive),
        ..Contract::new("counts", Keeps::Approximate(fragloom::scheme::contract::Limit::Nowhere))
    };

    type Holds = Light;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        let shown = Declared { name: "shown", per: Per::Primitive, default: 1, tried: &[] };
        Self { count: layout.pixel(1), shown: layout.input(shown) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.count.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let shown = mem.input(self.shown.at(fragment.data));
        mem.add(self.count.at(fragment.pixel, 0), shown, Order::Relaxed).await;
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, light: &mut Light) {
        let count = mem.load(self.count.at(pixel, 0), Order::Relaxed).await;
        *light = Light { color: [f64::from(count) / 256.0; 3], ..Light::default() };
    }

    fn expected(&self, inputs: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        let shown = |f: &Fragment| u64::from(inputs.get(self.shown.at(f.data)));
        let count: u64 = generated.iter().map(shown).sum();
        Some(Light { color: [count as f64 / 256.0; 3], ..Light::default() })
    }
}

/// One layer is its own average, and one fragment has nothing to be merged with: the pictures are the exact one.
#[test]
fn one_layer_is_exact() {
    let scene = scene("layers:count=1", [33, 17]);
    let exact = draw(&scene, &options("exact", None)).image;
    for exec in executors() {
        assert_eq!(
            draw(&scene, &with::<BlendAverage<true>>(exec.clone())).image,
            exact,
            "{exec:?}"
        );
        assert_eq!(draw(&scene, &with::<MergeTwo>(exec.clone())).image, exact, "{exec:?}");
    }
}

/// What is behind shows through what is in front by the same share, whether both are one record or two: only the last
/// rounding can differ.
#[test]
fn two_merged_records_look_like_both() {
    const ROUNDING: u8 = 1;
    let mut all = 0;
    for scene in small_scenes() {
        let exact = draw(&scene, &options("exact", None)).image;
        let drawn = draw(&scene, &with::<MergeTwo>(Exec::Tile));
        let bytes = exact.pixels.iter().zip(&drawn.image.pixels);
        assert!(
            bytes
                .clone()
                .all(|(a, b)| { a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= ROUNDING) })
        );
        let Kept::Records(records) = &drawn.kept else { panic!("records") };
        let merged = records.entries.iter().filter(|r| r.weight == 2.0).count() as u64;
        assert_eq!(drawn.report.merged, merged);
        assert_eq!(drawn.report.kept + merged, drawn.report.generated);
        all += merged;
    }
    assert!(all > 1_000, "{all} pixels had two fragments to merge");
}

/// Records of one pixel, by hand.
#[test]
fn records_of_a_pixel() {
    let scene = scene("layers:count=3", [9, 9]);
    let exact = lists(&scene, &options("exact", None));
    let [a, b, c] = *exact.pixel(4, 4) else { panic!("three layers") };
    let drawn = draw(&scene, &with::<MergeTwo>(sim(Policy::Random, 3)));
    let Kept::Records(records) = &drawn.kept else { panic!("records") };
    let surface = |key| Record::surface(depth_of(key), data_of(key));
    let [first, second] = records.pixel(4, 4) else { panic!("two records") };
    assert_eq!(*second, surface(c));
    let (front, back) = (surface(a), surface(b));
    let rest = 1.0 - front.rgba[3];
    let rgba = [0, 1, 2, 3].map(|i| front.rgba[i] + rest * back.rgba[i]);
    assert_eq!(*first, Record { depth: back.depth, thickness: 0.0, rgba, weight: 2.0 });
}

#[test]
fn a_hash_is_of_lists_and_an_effect_needs_them() {
    let scene = scene("layers:count=3", [16, 8]);
    let hash = |options: &Options| draw(&scene, options).report.fragments_hash;
    assert!(hash(&with::<MergeTwo>(Exec::Tile)).is_some());
    assert_eq!(hash(&with::<BlendAverage<true>>(Exec::Tile)), None);
    assert_ne!(hash(&with::<MergeTwo>(Exec::Tile)), hash(&options("ab-ll", None)));
    let media = || Effect::Media { density: 1.0 };
    for (method, holds) in [
        (Method::of::<MergeTwo>(), HeldKind::Records),
        (Method::of::<BlendAverage<true>>(), HeldKind::Color),
    ] {
        let options = Options { method, effect: media(), ..Options::default() };
        let refused = render(&scene, &options).map(|_| ()).expect_err("it has no lists");
        let told = format!("needs lists of fragments, but {method} gives {}", holds.name());
        assert_eq!((refused.place(), refused.problem()), ("--effect media", told.as_str()));
    }
}

/// Every property verified, under every interleaving of up to three fragments.
#[test]
fn the_explorer_verifies_them() {
    let memory = [MemoryModel::Sequential, MemoryModel::Relaxed(Profile::Vulkan)];
    let plan = Plan { fragments: Some(3), memory: memory.to_vec(), ..Plan::default() };
    for subject in [
        Subject::of::<BlendNearest>(),
        Subject::of::<MergeTwo>(),
        Subject::of::<BlendAverage<true>>(),
        Subject::of::<KFromImage<true>>(),
    ] {
        let rows = check(&subject, &plan, &LIMITS);
        assert!(rows.len() >= memory.map(|m| properties(&subject, m).len()).iter().sum());
        let (sampled, verified) = rows.split_last().expect("rows");
        assert_eq!(sampled.verdict, Verdict::Sampled, "{sampled:?}");
        for row in verified {
            assert_eq!(row.verdict, Verdict::Verified, "{row:?}");
        }
        let states: u64 = rows.iter().map(|row| row.states).max().unwrap_or(0) as u64;
        println!("{}: {} rows, up to {states} states", subject.method, rows.len());
    }
}

/// A colour is held to what the method says, too: on a scene, a lost term is found, and its token runs again.
#[test]
fn a_lost_term_of_a_colour_is_found_on_a_scene() {
    let scene = scene("synthetic:n=9", [16, 16]);
    // All invocations at once, so that those of a pixel overlap.
    let all = Sim { policy: Policy::RoundRobin, resident: 4_096, ..Sim::default() };
    let executions = |method: Method| Executions {
        name: "synthetic:n=9".to_owned(),
        schedule: "round-robin".to_owned(),
        options: Options { method, exec: Exec::Sim(all.clone()), ..Options::default() },
        count: 2,
    };
    let good = Method::of::<BlendAverage<true>>();
    let rows = executions(good).check(&Subject::of::<BlendAverage<true>>(), &scene, &LIMITS);
    assert!(rows.expect("it draws").iter().all(|row| row.verdict == Verdict::Unknown));
    let broken = Method::of::<BlendAverage<false>>();
    let rows = executions(broken).check(&Subject::of::<BlendAverage<false>>(), &scene, &LIMITS);
    let rows = rows.expect("it draws");
    let keeps = rows.iter().find(|row| row.property.as_deref() == Some("keeps")).expect("a row");
    assert_eq!(keeps.verdict, Verdict::Violated, "{keeps:?}");
    let token = keeps.token.as_ref().expect("a token").parse().expect("one of ours");
    let Token::Scene(mut token) = token else { panic!("a scene's token") };
    let catalogue = Catalogue::built_in().with(broken).expect("a new name");
    assert!(replay_scene(&catalogue, &token).is_ok());
    // Another picture is not the token's.
    token.seed += 1;
    token.schedule = "order".to_owned();
    let other = replay_scene(&catalogue, &token).map(|_| ()).expect_err("another result");
    assert!(other.problem().contains("another result"), "{other}");
}

/// The loss shows only where the input has a k of 1 or more: the token brings the input along.
#[test]
fn a_token_brings_its_inputs() {
    let subject = Subject::of::<KFromImage<false>>();
    let plan = Plan {
        fragments: Some(2),
        memory: vec![MemoryModel::Sequential],
        progress: Some(Vec::<Progress>::new()),
        simt: false,
        ..Plan::default()
    };
    let rows = check(&subject, &plan, &LIMITS);
    let violated = rows.iter().find(|row| row.verdict == Verdict::Violated).expect("it loses one");
    let text = violated.token.as_ref().expect("a token");
    let token: Token = text.parse().expect("a token of ours");
    assert_eq!(token.to_string(), *text);
    let Token::Litmus(token) = token else { panic!("a token of a litmus pixel") };
    assert!(!token.litmus.inputs.is_empty(), "{token:?}");
    let shown = replay_of(&subject, &token).expect("the same operations");
    assert!(shown.run.violations().next().is_some());
    // Without them, it is another instance.
    let mut without = token.clone();
    without.litmus.inputs.clear();
    assert_ne!(Token::Litmus(without).to_string(), *text);
}
