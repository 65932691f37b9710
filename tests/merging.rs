//! Merging by the z-thickness model, against references written for these tests: Algorithm 1 from the paper's text, and
//! the overlap's components by brute force; in every order of arrival, on every executor.

mod support;

use fragloom::exec::one_pixel::OnePixel;
use fragloom::fragment::Fragment;
use fragloom::num::depth::{FARTHEST, Format};
use fragloom::num::orders::orders;
use fragloom::num::planes::{Distances, Planes};
use fragloom::render::{Exec, Kept, Options, Policy, reference};
use fragloom::scene::{Scene, Thickness};
use fragloom::scheme::merging::slab::{OPAQUE, Slab, Visibility, merge_sorted};
use fragloom::scheme::merging::{Blending, Merging};
use fragloom::scheme::{Config, Held, Record};
use proptest::prelude::*;
use support::{draw, method, options, policies, scene, sim, small_scenes};

/// How far f64 may be off after a few dozen operations on numbers up to 1.
const ROUNDING: f64 = 1e-12;

fn one_pixel(name: &str, config: &Config) -> OnePixel {
    OnePixel::new(method(name), config).expect("it has memory")
}

fn right(beta: f64) -> Blending {
    Blending { beta, ..Blending::default() }
}

fn near(a: [f64; 4], b: [f64; 4], bound: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= bound)
}

// ---------------------------------------------------------------------------------------------------------------------
// The model.

fn visibility() -> impl Strategy<Value = Visibility> {
    let opacity = prop_oneof![Just(0.0), Just(1.0), Just(OPAQUE), 0.0..=1.0f64, Just(1.0 / 255.0)];
    (opacity, [0.0..=1.0f64, 0.0..=1.0, 0.0..=1.0])
        .prop_map(|(opacity, color)| Visibility { color: color.map(|c| c * opacity), opacity })
}

fn share() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0f64, Just(1e-9), Just(1.0 - 1e-9)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Front OVER back is the slab again (equation 5), and so are three parts; opacity 1 counts as `OPAQUE`.
    #[test]
    fn parts_over_each_other_are_the_slab(v in visibility(), a in share(), b in share(), beta in share()) {
        let whole = if v.opacity > OPAQUE {
            Visibility { color: v.color.map(|c| c * OPAQUE), opacity: OPAQUE }
        } else { v };
        let (a, b) = (a.min(b), a.max(b));
        let two = v.between(0.0, a, beta).over(v.between(a, 1.0, beta));
        prop_assert!(near(two.rgba(), whole.rgba(), ROUNDING), "{:?} {:?}", two, whole);
        let parts = [v.between(0.0, a, beta), v.between(a, b, beta), v.between(b, 1.0, beta)];
        let three = parts[0].over(parts[1]).over(parts[2]);
        prop_assert!(near(three.rgba(), whole.rgba(), ROUNDING), "{:?} {:?}", three, whole);
        // Every part has the slab's colour.
        for part in parts.iter().filter(|part| part.opacity > 1e-6) {
            for (c, whole_c) in part.color.iter().zip(whole.color) {
                prop_assert!((c / part.opacity - whole_c / whole.opacity).abs() < 1e-6);
            }
        }
    }

    /// Equation (4) is monotone, and meets both ends for every beta.
    #[test]
    fn opacity_grows_with_depth(v in visibility(), a in share(), b in share(), beta in share()) {
        let (a, b) = (a.min(b), a.max(b));
        prop_assert!(v.opacity_to(a, beta) <= v.opacity_to(b, beta) + ROUNDING);
        prop_assert_eq!(v.opacity_to(0.0, beta), 0.0);
        prop_assert_eq!(v.opacity_to(1.0, beta), v.opacity);
    }

    /// What is merged with something invisible looks as before, however both lie.
    #[test]
    fn an_invisible_slab_changes_nothing(
        v in visibility(), beta in share(), at in 1.001..4.0f64, more in 0.001..3.0f64,
    ) {
        let seen = Slab { near: 1.0, far: 2.0, visibility: v, sum: v.opacity, depth: 5, weight: 1.0 };
        let length = (at - 2.0f64).max(0.0) + more;
        let unseen = Slab { near: at - length, far: at, depth: 6, weight: 1.0, ..Slab::default() };
        prop_assert!(seen.overlaps(&unseen, false));
        let merged = if unseen.far >= seen.far { seen.smooth(&unseen, &right(beta)) } else { unseen.smooth(&seen, &right(beta)) };
        let whole = if v.opacity > OPAQUE { v.rgba().map(|c| c * OPAQUE) } else { v.rgba() };
        prop_assert!(near(merged.visibility.rgba(), whole, ROUNDING), "{:?} {:?}", merged, v);
        prop_assert!((merged.sum - v.opacity).abs() < ROUNDING);
        prop_assert_eq!((merged.near, merged.far), (seen.near.min(unseen.near), seen.far.max(unseen.far)));
    }
}

/// The shape of equation (4) by hand.
#[test]
fn opacities_by_hand() {
    let v = Visibility { color: [0.75, 0.0, 0.0], opacity: 0.75 };
    assert_eq!(v.opacity_to(0.5, 1.0), 0.375);
    assert_eq!(v.opacity_to(0.5, 0.0), 0.5, "half of the way lets half of the light through");
    assert_eq!(v.opacity_to(0.5, 0.5), 0.4375);
    // The back of a smooth cut: (0.75 - 0.375) / (1 - 0.375).
    assert!((v.between(0.5, 1.0, 1.0).opacity - 0.6).abs() < ROUNDING);
}

// ---------------------------------------------------------------------------------------------------------------------
// Smooth merging.

/// Algorithm 1 and section 3.3 once more, with nothing from the crate: parts are cut off one after another, first in
/// front, then behind, each from what is left; that is the same only where beta is 0 or 1.
mod paper {
    pub(crate) type V = [f64; 4];

    #[derive(Clone, Copy, Debug)]
    pub(crate) struct F {
        pub(crate) z: f64,
        pub(crate) t: f64,
        pub(crate) v: V,
        pub(crate) a: f64,
    }

    fn over(f: V, b: V) -> V {
        std::array::from_fn(|i| f[i] + (1.0 - f[3]) * b[i])
    }

    fn clamped(v: V) -> V {
        let most = super::OPAQUE;
        if v[3] > most { v.map(|c| c * (most / v[3])) } else { v }
    }

    /// Equations 3 to 5.
    fn split(v: V, part: f64, beta: f64) -> (V, V) {
        let v = clamped(v);
        if part <= 0.0 || v[3] == 0.0 {
            return ([0.0; 4], v);
        }
        if part >= 1.0 {
            return (v, [0.0; 4]);
        }
        let a = beta * part * v[3] + (1.0 - beta) * (1.0 - libm::pow(1.0 - v[3], part));
        let front = v.map(|c| c * (a / v[3]));
        let back = std::array::from_fn(|i| (v[i] - front[i]) / (1.0 - front[3]));
        (front, back)
    }

    fn mix(a: (V, f64), b: (V, f64)) -> V {
        let opacity = 1.0 - (1.0 - a.0[3]) * (1.0 - b.0[3]);
        let sum = a.1 + b.1;
        let part = |(v, s): (V, f64), i: usize| if v[3] > 0.0 { v[i] / v[3] * s } else { 0.0 };
        let c = |i| if sum > 0.0 { (part(a, i) + part(b, i)) / sum * opacity } else { 0.0 };
        [c(0), c(1), c(2), opacity]
    }

    fn sfm(f: F, g: F, beta: f64) -> F {
        let (fn_, gn) = (f.z - f.t, g.z - g.t);
        let (from, to) = (fn_.max(gn), f.z);
        let cut = |x: F, near: f64| {
            let (front, rest) = split(x.v, if x.t > 0.0 { (from - near) / x.t } else { 1.0 }, beta);
            let left = x.z - from;
            let (middle, back) =
                split(rest, if left > 0.0 { (to - from) / left } else { 1.0 }, beta);
            // What the middle adds to the whole: front OVER middle less front.
            let whole = clamped(x.v)[3];
            let share = if whole > 0.0 { x.a * (1.0 - front[3]) * middle[3] / whole } else { 0.0 };
            (front, (middle, share), back)
        };
        let (f_front, f_middle, f_back) = cut(f, fn_);
        let (g_front, g_middle, g_back) = cut(g, gn);
        let front = if fn_ < gn { f_front } else { g_front };
        let back = if f.z > g.z { f_back } else { g_back };
        let v = over(over(front, mix(f_middle, g_middle)), back);
        F { z: g.z, t: g.z - fn_.min(gn), v, a: f.a + g.a }
    }

    /// The listing, with line 20's `F_i` read as `f_i`.
    pub(crate) fn algorithm(input: &[F], m: usize, beta: f64) -> Vec<F> {
        let mut output: Vec<F> = Vec::new();
        let n = input.len();
        let mut fi = input[0];
        let mut c = 0;
        let mut i = 0;
        while i < n {
            let next = if i + 1 < n { Some(input[i + 1]) } else { None };
            let overlap = |next: F| (fi.z - fi.t).max(next.z - next.t) < fi.z.min(next.z);
            let merged = next.filter(|&next| overlap(next)).map(|next| sfm(fi, next, beta));
            match (merged, next) {
                (Some(merged), _) => fi = merged,
                (None, Some(next)) if c < m - 1 => {
                    output.push(fi);
                    c += 1;
                    fi = next;
                }
                (None, Some(next)) => {
                    // A surface may lie in a slab; the paper's slabs are thick, and then its sum is the larger one.
                    let t = (next.z - fi.z + fi.t).max(next.t);
                    fi = F { z: next.z, t, v: over(fi.v, next.v), a: fi.a + next.a };
                }
                (None, None) => output.push(fi),
            }
            i += 1;
        }
        output
    }
}

/// Slabs as (near, length, opacity, colour), with many that touch, coincide or are surfaces.
fn slabs() -> impl Strategy<Value = Vec<Slab>> {
    let place = prop_oneof![(0..8u32).prop_map(|i| f64::from(i) * 0.5), 0.0..4.0f64];
    let length = prop_oneof![Just(0.0), Just(0.5), Just(1.0), 0.0..2.0f64];
    let slab = (place, length, visibility()).prop_map(|(near, length, visibility)| Slab {
        near,
        far: near + length,
        visibility,
        sum: visibility.opacity,
        depth: 0,
        weight: 1.0,
    });
    prop::collection::vec(slab, 1..14).prop_map(|mut slabs| {
        slabs.sort_by(|a, b| a.far.total_cmp(&b.far));
        slabs
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn merging_is_algorithm_1(slabs in slabs(), most in 1usize..10, smooth in any::<bool>()) {
        let beta = if smooth { 1.0 } else { 0.0 };
        let mut out = Vec::new();
        merge_sorted(slabs.iter().copied(), most, &right(beta), &mut out);
        let input: Vec<paper::F> = slabs.iter().map(|s| paper::F {
            z: s.far, t: s.far - s.near, v: s.visibility.rgba(), a: s.sum,
        }).collect();
        let expected = paper::algorithm(&input, most, beta);
        prop_assert_eq!(out.len(), expected.len());
        prop_assert!(out.len() <= most.min(slabs.len()));
        for (slab, expected) in out.iter().zip(&expected) {
            // An opacity near 1 divides by what is left of the light, 2^-17.
            prop_assert!(near(slab.visibility.rgba(), expected.v, 1e-9), "{:?} {:?}", slab, expected);
            prop_assert!((slab.far - expected.z).abs() < ROUNDING);
            prop_assert!((slab.far - slab.near - expected.t).abs() < ROUNDING);
            prop_assert!((slab.sum - expected.a).abs() < ROUNDING);
        }
        let weights: f64 = out.iter().map(|slab| slab.weight).sum();
        prop_assert_eq!(weights, slabs.len() as f64);
    }

    /// What overlaps nothing is not touched, bit for bit, where there is room.
    #[test]
    fn slabs_apart_are_untouched(lengths in prop::collection::vec(0.0..1.0f64, 1..12), v in visibility()) {
        let at = |(i, &length): (usize, &f64)| Slab {
            near: i as f64 + 1.0 - length, far: i as f64 + 1.0, visibility: v, sum: v.opacity, depth: i as u32, weight: 1.0,
        };
        let slabs: Vec<Slab> = lengths.iter().enumerate().map(at).collect();
        let mut out = Vec::new();
        merge_sorted(slabs.iter().copied(), slabs.len(), &right(1.0), &mut out);
        prop_assert_eq!(out, slabs);
    }
}

/// Algorithm 1 takes every slab once: N slabs cost N - 1 steps, each of bounded work.
#[test]
fn merging_is_linear() {
    for n in [1usize, 2, 100, 10_000] {
        let mut taken = 0;
        let slabs = (0..n).map(|i| {
            taken += 1;
            let (near, visibility) = (i as f64 * 0.75, Visibility::new([0.1, 0.1, 0.1, 0.2]));
            Slab { near, far: near + 1.0, visibility, sum: 0.2, depth: i as u32, weight: 1.0 }
        });
        let mut out = Vec::new();
        merge_sorted(slabs, 8, &right(0.5), &mut out);
        assert_eq!((taken, out.len()), (n, 1), "a chain");
    }
}

/// With thickness 0, no slab overlaps another: the picture is `dfb`'s, bit for bit, if all fragments have a record; that
/// of `dfb+sfm` is in any case.
#[test]
fn without_thickness_it_is_an_a_buffer() {
    let mut in_tails = 0;
    for scene in small_scenes() {
        let dfb = draw(&scene, &options("dfb", None));
        let sfm = [1, 2, 3, 4, 64].map(|k| ("dfb+sfm", k));
        for (method, k) in [("dfb+ofm", 64), ("skb+ofm", 64)].into_iter().chain(sfm) {
            for beta in [0.0, 0.3, 1.0] {
                let thickness = Thickness::World(0.0);
                let drawn = draw(&scene, &Options { thickness, beta, ..options(method, Some(k)) });
                assert_eq!(drawn.image, dfb.image, "{method} {k} {}", scene.name);
                let merged = drawn.report.merged;
                assert_eq!(drawn.report.kept + merged, dfb.report.kept, "{method} {k}");
                assert!(k < 64 || merged == 0, "{method}");
                in_tails += merged;
            }
        }
    }
    assert!(in_tails > 1_000, "{in_tails} fragments have no record of their own");
}

// ---------------------------------------------------------------------------------------------------------------------
// Merging by overlap.

/// (near, depth, colour word) of slabs.
type Three = (u32, u32, u32);

fn fragment(&(near, depth, data): &Three) -> Fragment {
    Fragment { pixel: 0, depth, data, extra: near }
}

/// The components of the overlap by brute force: join any two that overlap until none do.
fn components(slabs: &[Three]) -> Vec<Vec<Three>> {
    let mut all: Vec<Vec<Three>> = slabs.iter().map(|&slab| vec![slab]).collect();
    let overlap = |a: &Three, b: &Three| a.0.max(b.0) < a.1.min(b.1);
    loop {
        let pair = (0..all.len())
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .find(|&(i, j)| all[i].iter().any(|a| all[j].iter().any(|b| overlap(a, b))));
        let Some((i, j)) = pair else { break };
        let joined = all.remove(i);
        all[j].extend(joined);
    }
    let last = |component: &Vec<Three>| component.iter().map(|s| (s.1, s.2)).max();
    all.sort_by_key(last);
    all
}

/// What a component looks like, in reals: equations (6) and (7). Where several are mixed, opacity 1 is `OPAQUE`.
fn mixed(component: &[Three]) -> [f64; 4] {
    let bytes = component.iter().map(|s| s.2.to_le_bytes().map(|b| f64::from(b) / 255.0));
    let most = if component.len() > 1 { OPAQUE } else { 1.0 };
    let through: f64 = bytes.clone().map(|[.., a]| 1.0 - a.min(most)).product();
    let sum: f64 = bytes.clone().map(|[.., a]| a).sum();
    let color = |i: usize| {
        let weighted: f64 = bytes.clone().map(|rgba| rgba[i] * rgba[3]).sum();
        if sum > 0.0 { weighted / sum * (1.0 - through) } else { 0.0 }
    };
    [color(0), color(1), color(2), if sum > 0.0 { 1.0 - through } else { 0.0 }]
}

/// Named sets of up to seven slabs.
fn sets() -> Vec<(&'static str, Vec<Three>)> {
    let colors = [
        0x80FF_0000u32,
        0x4000_FF00,
        0xC000_00FF,
        0x2080_8080,
        0xFFFF_FFFF,
        0x0112_3456,
        0x90AB_CDEF,
    ];
    let set = |ends: &[(u32, u32)]| -> Vec<Three> {
        ends.iter().zip(colors).map(|(&(near, depth), data)| (near, depth, data)).collect()
    };
    vec![
        ("disjoint", set(&[(0, 9), (10, 19), (20, 29), (30, 39), (40, 49), (50, 59), (60, 69)])),
        ("touching", set(&[(0, 10), (10, 20), (20, 30), (30, 40), (40, 50)])),
        ("nested", set(&[(0, 100), (10, 90), (20, 80), (30, 70), (40, 60), (45, 55), (49, 51)])),
        ("chain", set(&[(0, 12), (10, 22), (20, 32), (30, 42), (40, 52), (50, 62), (60, 72)])),
        ("bridge", set(&[(0, 10), (20, 30), (40, 50), (60, 70), (80, 90), (5, 85)])),
        (
            "equal depths",
            set(&[(90, 100), (90, 100), (95, 100), (100, 100), (100, 100), (40, 100)]),
        ),
        ("surfaces", set(&[(5, 5), (7, 7), (7, 7), (9, 9), (5, 5), (6, 6), (8, 8)])),
        ("surfaces in a slab", set(&[(0, 100), (20, 20), (50, 50), (100, 100), (0, 0)])),
        (
            "two chains",
            set(&[(0, 12), (10, 22), (20, 32), (50, 62), (60, 72), (70, 82), (200, 201)]),
        ),
        ("ends", set(&[(0, FARTHEST), (FARTHEST - 1, FARTHEST), (0, 1)])),
        ("alike", vec![(3, 9, 0x8010_2030); 6]),
    ]
}

/// The results of all orders: how many differ.
fn results(method: &str, k: u32, slabs: &[Three]) -> Vec<Held> {
    let config = OnePixel::config(slabs.len(), k, Config::default());
    let pixel = one_pixel(method, &config);
    let fragments: Vec<Fragment> = slabs.iter().map(fragment).collect();
    let mut results: Vec<Held> = orders(slabs.len())
        .into_iter()
        .map(|order| {
            let ordered: Vec<Fragment> = order.into_iter().map(|i| fragments[i]).collect();
            pixel.store(&ordered).held
        })
        .collect();
    results.sort();
    results.dedup();
    results
}

/// `dfb+ofm` gives the components, nearest first, and the rest as a tail: in every order of up to seven slabs, with
/// every k.
#[test]
fn merging_by_overlap_gives_the_components_in_every_order() {
    let mut count = 0;
    for (name, slabs) in sets() {
        let all = components(&slabs);
        for k in [1, 2, 3, 8] {
            let found = results("dfb+ofm", k, &slabs);
            count += orders(slabs.len()).len();
            let [Held::Records(records)] = found.as_slice() else { panic!("{name}: {found:?}") };
            let mut expected = all.clone();
            if expected.len() > k as usize {
                let tail = expected.split_off(k as usize - 1).concat();
                expected.push(tail);
            }
            assert_eq!(records.len(), expected.len(), "{name} k {k}");
            // A surface may end where the tail does: records come sorted by depth, then colour.
            let find = |component: &[Three]| {
                let depth = component.iter().map(|s| s.1).max().expect("some");
                let weight = component.len() as f64;
                records.spelt_out().any(|record| {
                    record.depth == depth
                        && record.weight == weight
                        && near(record.rgba, mixed(component), 1e-6)
                })
            };
            assert!(
                expected.iter().all(|component| find(component)),
                "{name} k {k}: {records:?} {expected:?}"
            );
        }
    }
    println!("{count} orders");
}

/// `skb+ofm` gives the same, bit for bit, wherever it says what it gives; else some order gives something else, but for
/// sets whose tail takes all that is apart.
#[test]
fn merging_on_arrival_gives_the_same_where_it_promises_to() {
    let (mut settled, mut open) = (0, 0);
    for (name, slabs) in sets() {
        for k in [1, 2, 3, 8] {
            let config = OnePixel::config(slabs.len(), k, Config::default());
            let fragments: Vec<Fragment> = slabs.iter().map(fragment).collect();
            let found = results("skb+ofm", k, &slabs);
            match one_pixel("skb+ofm", &config).expected(&fragments) {
                Some(expected) => {
                    assert_eq!(found, [expected], "{name} k {k}");
                    assert_eq!(results("dfb+ofm", k, &slabs), found, "{name} k {k}");
                    settled += 1;
                }
                None => {
                    println!("{name} k {k}: {} results", found.len());
                    open += 1;
                }
            }
        }
    }
    assert!(settled >= 30 && open >= 5, "{settled} settled, {open} open");
    // The smallest: with one record and a tail, three slabs.
    let bridge = [(0, 10, 0x8000_00FF), (20, 30, 0x8000_FF00), (5, 25, 0x80FF_0000)];
    assert_eq!(results("skb+ofm", 2, &bridge).len(), 2);
    assert_eq!(results("skb+ofm", 3, &bridge).len(), 1, "with room for both ends");
}

/// What the published and the released forms make of it: rounding, and one overlap at a time.
#[test]
fn published_forms_depend_on_arrival() {
    let coplanar = [(0, 9, 0x3312_3456), (0, 9, 0x66AB_CDEF), (0, 9, 0x9918_2736)];
    let bridge = [(0, 10, 0x8000_00FF), (20, 30, 0x8000_FF00), (5, 25, 0x80FF_0000)];
    let count = |method: &str, slabs: &[Three]| results(method, 8, slabs).len();
    for (method, coplanar_results, bridge_results) in [
        ("skb+ofm", 1, 1),
        ("dfb+ofm", 1, 1),
        ("skb+ofm@published", 2, 0),
        ("skb+ofm@released", 2, 2),
        ("skb+ofm@first-overlap", 1, 2),
    ] {
        let found = [count(method, &coplanar), count(method, &bridge)];
        println!("{method}: {found:?} results of 6 orders");
        if coplanar_results == 1 {
            assert_eq!(found[0], 1, "{method}");
        } else {
            assert!(found[0] > 1, "{method}");
        }
        assert!(bridge_results == 0 || (found[1] > 1) == (bridge_results > 1), "{method}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any set, any order: `dfb+ofm` gives one result, and `skb+ofm` the same where it says so.
    #[test]
    fn any_slabs_in_any_order(
        slabs in prop::collection::vec((0..60u32, 0..20u32, any::<u32>()), 1..12), k in 1..10u32, seed in any::<u64>(),
    ) {
        let slabs: Vec<Three> = slabs.iter().map(|&(near, length, data)| (near, near + length, data)).collect();
        let mut shuffled: Vec<Fragment> = slabs.iter().map(fragment).collect();
        fragloom::num::random::Random::new(seed, 0).shuffle(&mut shuffled);
        let config = OnePixel::config(slabs.len(), k, Config::default());
        let exact = one_pixel("dfb+ofm", &config);
        let expected = exact.expected(&shuffled).expect("it says");
        prop_assert_eq!(&exact.store(&shuffled).held, &expected);
        let arrival = one_pixel("skb+ofm", &config);
        let found = arrival.store(&shuffled).held;
        if let Some(promised) = arrival.expected(&shuffled) {
            prop_assert_eq!(&promised, &expected);
            prop_assert_eq!(&found, &promised);
        }
        let Held::Records(records) = &found else { panic!("records") };
        prop_assert!(records.len() <= k as usize);
        let weights: f64 = records.spelt_out().map(|record| record.weight).sum();
        prop_assert_eq!(weights, slabs.len() as f64, "no fragment is lost");
    }
}

/// Every fault differs from its right form somewhere among these sets.
#[test]
fn faults_show() {
    let sums = |method: &str, k: u32| -> Vec<Vec<Held>> {
        sets().iter().map(|(_, slabs)| results(method, k, slabs)).collect()
    };
    let beta = |method: &str| {
        let merging = Merging { beta: 0.5, ..Merging::default() };
        let of = |slabs: &[Three]| {
            let config = OnePixel::config(slabs.len(), 3, Config { merging, ..Config::default() });
            let fragments: Vec<Fragment> = slabs.iter().map(fragment).collect();
            one_pixel(method, &config).store(&fragments).held
        };
        sets().iter().map(|(_, slabs)| of(slabs)).collect::<Vec<_>>()
    };
    for fault in ["M15", "closed", "front-beta", "squared", "mixed-tail"] {
        let name = format!("dfb+sfm@{fault}");
        assert_ne!(beta(&name), beta("dfb+sfm"), "{name}");
    }
    for fault in ["M10-arrival", "M15", "first-overlap", "closed"] {
        let name = format!("skb+ofm@{fault}");
        assert!([2, 3, 8].iter().any(|&k| sums(&name, k) != sums("skb+ofm", k)), "{name}");
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Scenes.

fn thick(
    scene: &Scene,
    method: &str,
    k: u32,
    thickness: Thickness,
    exec: Exec,
) -> fragloom::render::Rendering {
    draw(scene, &Options { thickness, exec, ..options(method, Some(k)) })
}

/// On every executor and under every policy, what does not depend on arrival is what it must be; what does is so in
/// tiles, whatever the number of threads.
#[test]
fn scenes_are_merged_alike_everywhere() {
    let mut merged = 0;
    for scene in small_scenes() {
        for thickness in [Thickness::default(), Thickness::World(0.3), Thickness::Precision(1e6)] {
            for method in ["dfb+sfm", "dfb+ofm", "dfb+sfm@released"] {
                let expected = Options { thickness, ..options(method, Some(4)) };
                let expected = reference(&scene, &expected).expect("a reference").kept;
                let mut execs = vec![Exec::Tile, Exec::Threads];
                execs.extend(policies().map(|policy| sim(policy, 3)));
                for exec in execs {
                    let drawn = thick(&scene, method, 4, thickness, exec.clone());
                    assert_eq!(Some(drawn.kept), expected, "{method} {exec:?} {}", scene.name);
                    merged += drawn.report.merged;
                }
            }
            let one = thick(&scene, "skb+ofm", 4, thickness, Exec::Tile);
            let many = Options { thickness, threads: 7, tile: 16, ..options("skb+ofm", Some(4)) };
            assert_eq!(draw(&scene, &many).kept, one.kept, "{}", scene.name);
            let order = thick(&scene, "skb+ofm", 4, thickness, sim(Policy::Order, 0));
            assert_eq!(order.kept, one.kept, "in the order of submission, as tiles are");
        }
    }
    assert!(merged > 100_000, "{merged}");
}

/// Records reach as far as their slabs did: coplanar boxes become one record where they touch.
#[test]
fn coplanar_surfaces_become_one_record() {
    let scene = scene("cubes", [64, 64]);
    let drawn = thick(&scene, "dfb+sfm", 64, Thickness::default(), Exec::Tile);
    let Kept::Records(lists) = &drawn.kept else { panic!("records") };
    assert!(lists.entries.iter().any(|record| record.weight > 1.0));
    for record in lists.entries.iter().filter(|record| record.weight == 1.0) {
        let Record { thickness, .. } = record;
        assert!(*thickness > 0.0 && *thickness < 1e-3, "{record:?}");
    }
}

/// An object's own thickness counts, whatever the run says.
#[test]
fn an_object_has_its_own_thickness() {
    let text = |own: &str| {
        format!(
            "[camera]\neye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\nnear = 1.0\nfar = 9.0\n\
             [[object]]\nprocedural = \"box\"\nscale = 1.0\n{own}\n"
        )
    };
    let load = |own: &str| {
        let description = fragloom::scene::file::parse(text(own).as_bytes(), "s.toml")?;
        description.build(
            &fragloom::scene::Overrides { size: Some([16, 16]), ..Default::default() },
            &mut |source| {
                let fragloom::scene::file::Source::Procedural { keys, size, .. } = source else {
                    panic!("a file")
                };
                fragloom::scene::procedural::generate("box", keys, size)
            },
            &mut |_| Ok(Vec::new()),
        )
    };
    let of = |own: &str| load(own).map(|scene| scene.objects[0].thickness);
    assert_eq!(of("thickness = \"10x\"").unwrap(), Some(Thickness::Precision(10.0)));
    assert_eq!(of("thickness = 0.25").unwrap(), Some(Thickness::World(0.25)));
    assert_eq!(of("").unwrap(), None);
    for wrong in
        ["thickness = -1.0", "thickness = \"ten\"", "thickness = nan", "thickness = \"-3x\""]
    {
        let error = of(wrong).expect_err(wrong).to_string();
        assert!(error.contains("object 0: thickness"), "{error}");
    }
}

/// Distances are those of the camera, whatever the format of depths.
#[test]
fn distances_follow_the_format() {
    let planes = Planes { near: 1.0, far: 9.0, parallel: true };
    for format in Format::ALL {
        let distances = Distances { planes, format };
        let along = distances.along(format.encode(1 << 31));
        assert!((along - 5.0).abs() < 1e-6, "{format:?} {along}");
    }
}
