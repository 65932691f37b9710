//! Approximate transparency, against references written for these tests from the papers' equations in f64, on random
//! pixels in random orders of arrival; closed forms of one and two layers; limits; extremes.

mod support;

use fragloom::exec::one_pixel::OnePixel;
use fragloom::fragment::Fragment;
use fragloom::num::depth::{FARTHEST, Format};
use fragloom::num::orders::orders;
use fragloom::num::planes::{Distances, Planes};
use fragloom::num::random::Random;
use fragloom::raster::Grid;
use fragloom::render::{Exec, Kept, Options};
use fragloom::scheme::approximate::Approximation;
use fragloom::scheme::approximate::wboit::Weight;
use fragloom::scheme::{Config, Held, Light};
use support::{draw, method, options, scene};

const PLANES: Planes = Planes { near: 0.1, far: 100.0, parallel: false };
const DISTANCES: Distances = Distances { planes: PLANES, format: Format::D32 };

/// Colours and transmittances of 16 bits: each of n roundings is half a unit off.
fn sixteen_bits(n: usize) -> f64 {
    (n as f64 + 1.0) / 65_535.0
}

fn config(n: usize, k: u32, approximation: Approximation) -> Config {
    let grid = Grid { width: 1, height: 1, tile: 16 };
    let base = Config { distances: DISTANCES, approximation, grid, ..Config::default() };
    OnePixel::config(n, k, base)
}

/// What a pixel holds after these fragments, in this order.
fn light(name: &str, config: &Config, fragments: &[Fragment]) -> Light {
    let pixel = OnePixel::new(method(name), config).expect("it has memory");
    let stored = pixel.store(fragments);
    assert_eq!(stored.outside, 0);
    match stored.held {
        Held::Light(light) => light,
        other => panic!("{name} gives {other}"),
    }
}

/// Colour and transmittance.
fn seen(light: Light) -> [f64; 4] {
    let [r, g, b] = light.color;
    [r, g, b, light.transmittance]
}

fn apart(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A fragment with its number, as `stochastic` knows it.
fn fragment(depth: u32, data: u32, number: u32) -> Fragment {
    Fragment { pixel: 0, depth, data, extra: number }
}

/// The fragments in every order of arrival.
fn in_all_orders(fragments: &[Fragment]) -> impl Iterator<Item = Vec<Fragment>> + '_ {
    orders(fragments.len()).into_iter().map(|o| o.iter().map(|&i| fragments[i]).collect())
}

fn ranked(fragments: &[Fragment]) -> Vec<Fragment> {
    (0..).zip(fragments).map(|(rank, f)| Fragment { extra: rank, ..*f }).collect()
}

/// Fragments of random depths, nearly all of them different, and colours; opacities as they come.
fn random(random: &mut Random, n: usize) -> Vec<Fragment> {
    let one = |i: usize| {
        // Most of the range of a perspective lies near 1.
        let along = libm::exp(random.range(libm::log(0.11), libm::log(99.0)));
        let depth = (PLANES.depth(along) * f64::from(u32::MAX)) as u32;
        let alpha = match random.below(10) {
            0 => 0,
            1 => 255,
            _ => 1 + random.below(254) as u32,
        };
        fragment(depth, random.bits() as u32 & 0xFF_FFFF | alpha << 24, i as u32)
    };
    (0..n).map(one).collect()
}

/// Straight colour and opacity.
fn rgba(f: &Fragment) -> ([f64; 3], f64) {
    let [r, g, b, a] = f.data.to_le_bytes().map(|c| f64::from(c) / 255.0);
    ([r, g, b], a)
}

fn sorted(fragments: &[Fragment]) -> Vec<Fragment> {
    let mut sorted = fragments.to_vec();
    sorted.sort_unstable_by_key(|f| f.key());
    sorted
}

/// OVER, of sorted fragments.
fn over(fragments: &[Fragment]) -> [f64; 4] {
    let mut all = [0.0, 0.0, 0.0, 1.0];
    for f in fragments {
        let (c, a) = rgba(f);
        (0..3).for_each(|i| all[i] += all[3] * a * c[i]);
        all[3] *= 1.0 - a;
    }
    all
}

/// Equation 2 of weighted blended transparency, with the weights as the paper prints them.
fn weighted_blended(fragments: &[Fragment], weight: Weight) -> [f64; 4] {
    let (mut colors, mut alphas, mut through) = ([0.0; 3], 0.0, 1.0);
    for f in fragments {
        let (c, a) = rgba(f);
        let d = Format::D32.decode(f.depth);
        let z = PLANES.along(d);
        let pow = |x: f64, n: i32| (0..n).fold(1.0, |p, _| p * x);
        let between = |w: f64| a * w.clamp(1e-2, 3e3);
        let w = match weight {
            Weight::Eq7 => between(10.0 / (1e-5 + pow(z / 5.0, 2) + pow(z / 200.0, 6))),
            Weight::Eq8 => between(10.0 / (1e-5 + pow(z / 10.0, 3) + pow(z / 200.0, 6))),
            Weight::Eq9 => between(0.03 / (1e-5 + pow(z / 200.0, 4))),
            Weight::Eq10 => a * (3e3 * pow(1.0 - d, 3)).max(1e-2),
        };
        (0..3).for_each(|i| colors[i] += a * c[i] * w);
        alphas += a * w;
        through *= 1.0 - a;
    }
    if alphas == 0.0 {
        return [0.0, 0.0, 0.0, through];
    }
    let [r, g, b] = colors.map(|c| c / alphas * (1.0 - through));
    [r, g, b, through]
}

/// What `wboit` may be off: the smallest term is right to 7.5e-7 of itself.
const WEIGHTED: f64 = 2e-6;

#[test]
fn wboit_is_the_papers_equation() {
    let mut numbers = Random::new(1, 1);
    for round in 0..2_000 {
        let n = 1 + round % 40;
        let fragments = random(&mut numbers, n);
        for weight in Weight::ALL {
            let config = config(n, 1, Approximation { weight, ..Approximation::default() });
            let found = seen(light("wboit", &config, &fragments));
            let right = weighted_blended(&fragments, weight);
            assert!(apart(found, right) < WEIGHTED, "{weight:?} {fragments:?} {found:?} {right:?}");
            let float = seen(light("wboit@published-f32", &config, &fragments));
            assert!(apart(float, right) < 1e-4, "{weight:?} {float:?} {right:?}");
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Moments.

const BIASES: [(usize, f64, &[f64]); 3] = [
    (4, 5e-7, &[0.0, 0.375, 0.0, 0.375]),
    (6, 5e-6, &[0.0, 0.48, 0.0, 0.451, 0.0, 0.45]),
    (8, 5e-5, &[0.0, 0.75, 0.0, 0.676_67, 0.0, 0.63, 0.0, 0.603_30]),
];

fn place(f: &Fragment) -> f64 {
    let z = DISTANCES.along(f.depth);
    let (near, far) = (libm::log(PLANES.near), libm::log(PLANES.far));
    2.0 * (libm::log(z) - near) / (far - near) - 1.0
}

fn absorbance(f: &Fragment) -> f64 {
    let (_, a) = rgba(f);
    if a == 1.0 { 10.0 } else { -libm::log(1.0 - a) }
}

/// A linear system by elimination with pivots.
fn solve(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for j in 0..n {
        let pivot = (j..n).max_by(|&a, &b| rows[a][j].abs().total_cmp(&rows[b][j].abs()));
        rows.swap(j, pivot.expect("rows"));
        for i in 0..n {
            if i != j {
                let factor = rows[i][j] / rows[j][j];
                (j..=n).for_each(|k| rows[i][k] -= factor * rows[j][k]);
            }
        }
    }
    (0..n).map(|i| rows[i][n] / rows[i][i]).collect()
}

/// All roots at once, as complex numbers (Durand, Kerner); the real parts.
fn roots(c: &[f64]) -> Vec<f64> {
    type Complex = (f64, f64);
    let times = |(a, b): Complex, (c, d): Complex| (a * c - b * d, a * d + b * c);
    let by = |(a, b): Complex, (c, d): Complex| {
        let n = c * c + d * d;
        ((a * c + b * d) / n, (b * c - a * d) / n)
    };
    let h = c.len() - 1;
    let size = 1.0 + c[..h].iter().map(|x| (x / c[h]).abs()).fold(0.0, f64::max);
    let start = |i: usize| {
        let angle = 0.4 + i as f64 * 2.0 * std::f64::consts::PI / h as f64;
        (size.min(4.0) * libm::cos(angle), size.min(4.0) * libm::sin(angle))
    };
    let mut all: Vec<Complex> = (0..h).map(start).collect();
    for _ in 0..2_000 {
        for i in 0..h {
            let value = (0..h).rev().fold((1.0, 0.0), |v, j| {
                let (a, b) = times(v, all[i]);
                (a + c[j] / c[h], b)
            });
            let others = (0..h)
                .filter(|&j| j != i)
                .fold((1.0, 0.0), |p, j| times(p, (all[i].0 - all[j].0, all[i].1 - all[j].1)));
            let step = by(value, others);
            all[i] = (all[i].0 - step.0, all[i].1 - step.1);
        }
    }
    all.into_iter().map(|(real, _)| real).collect()
}

/// The transmittance in front of u: the quadrature's nodes, and its weights from a Vandermonde system.
fn transmittance(b: &[f64], u: f64) -> f64 {
    let m = b.len() - 1;
    let (_, epsilon, vector) = *BIASES.iter().find(|bias| bias.0 == m).expect("a bias");
    let biased: Vec<f64> = (0..=m)
        .map(|j| match j {
            0 => 1.0,
            j => (1.0 - epsilon) * b[j] / b[0] + epsilon * vector[j - 1],
        })
        .collect();
    let h = m / 2;
    let power = |x: f64, n: usize| (0..n).fold(1.0, |p, _| p * x);
    let row = |i: usize| (0..=h).map(|j| biased[i + j]).chain([power(u, i)]).collect();
    let kernel = solve((0..=h).map(row).collect());
    let nodes: Vec<f64> = [u].into_iter().chain(roots(&kernel)).collect();
    let row = |i: usize| nodes.iter().map(|&x| power(x, i)).chain([biased[i]]).collect();
    let weights = solve((0..=h).map(row).collect());
    let before = (1..=h).filter(|&i| nodes[i] < u).map(|i| weights[i]).sum::<f64>();
    libm::exp(-b[0] * (before + 0.25 * weights[0])).clamp(0.0, 1.0)
}

fn moments_of(fragments: &[Fragment], m: usize) -> Vec<f64> {
    let power = |x: f64, n: usize| (0..n).fold(1.0, |p, _| p * x);
    (0..=m).map(|j| fragments.iter().map(|f| absorbance(f) * power(place(f), j)).sum()).collect()
}

fn moment_based(fragments: &[Fragment], m: usize) -> [f64; 4] {
    let b = moments_of(fragments, m);
    if b[0] == 0.0 {
        return [0.0, 0.0, 0.0, 1.0];
    }
    let (mut colors, mut alphas) = ([0.0; 3], 0.0);
    for f in fragments {
        let (c, a) = rgba(f);
        let t = transmittance(&b, place(f));
        (0..3).for_each(|i| colors[i] += a * c[i] * t);
        alphas += a * t;
    }
    let through = libm::exp(-b[0]);
    let [r, g, b] = colors.map(|c| c / alphas * (1.0 - through));
    [r, g, b, through]
}

fn with_moments(moments: usize) -> Approximation {
    Approximation { moments: moments as u32, ..Approximation::default() }
}

/// Both solve ill-conditioned systems, by different means: a share of the digits is lost.
const SOLVED: [f64; 3] = [1e-6, 1e-5, 1e-3];

#[test]
fn mbt_is_the_papers_algorithm() {
    let mut numbers = Random::new(2, 1);
    for (i, m) in [4, 6, 8].into_iter().enumerate() {
        let mut most = 0.0;
        for round in 0..300 {
            let n = 1 + round % 12;
            let fragments = random(&mut numbers, n);
            let config = config(n, 1, with_moments(m));
            let found = seen(light("mbt", &config, &fragments));
            let right = moment_based(&fragments, m);
            most = f64::max(most, apart(found, right));
            assert!(apart(found, right) < SOLVED[i], "{m} {fragments:?} {found:?} {right:?}");
        }
        println!("{m} moments: at most {most:.1e} off");
    }
}

/// One layer, and two that lie apart: T1 = e^(-A1 / 4), T2 = e^(-A1 - A2 / 4).
#[test]
fn mbt_of_one_and_two_layers() {
    const BOUNDS: [f64; 3] = [2e-5, 5e-5, 2e-4];
    let mut numbers = Random::new(3, 1);
    for (bound, m) in BOUNDS.into_iter().zip([4, 6, 8]) {
        for _ in 0..1_000 {
            let mut two = sorted(&random(&mut numbers, 2));
            two.iter_mut().for_each(|f| f.data |= 1 << 24);
            let config = config(2, 1, with_moments(m));
            let one = seen(light("mbt", &config, &two[..1]));
            let exact = over(&two[..1]);
            let opaque = if two[0].data >> 24 == 255 { 5e-5 } else { 1e-9 };
            assert!(apart(one, exact) < opaque, "{m} {one:?} {exact:?}");
            if (place(&two[0]) - place(&two[1])).abs() < 0.1 {
                continue;
            }
            let [a, b] = [absorbance(&two[0]), absorbance(&two[1])];
            let t = [libm::exp(-a / 4.0), libm::exp(-a - b / 4.0)];
            let [(c1, a1), (c2, a2)] = [rgba(&two[0]), rgba(&two[1])];
            let [w1, w2] = [a1 * t[0], a2 * t[1]];
            // The share of the absorbance is off by the bias: more of it makes more difference.
            let bound = bound * f64::max(1.0, a + b);
            let through = libm::exp(-a - b);
            let [r, g, b] =
                [0, 1, 2].map(|i| (c1[i] * w1 + c2[i] * w2) / (w1 + w2) * (1.0 - through));
            let found = seen(light("mbt", &config, &two));
            assert!(apart(found, [r, g, b, through]) < bound, "{m} {two:?}");
        }
    }
}

/// The published bias does not save single precision, and double precision needs no more.
#[test]
fn single_precision_gives_what_is_no_number() {
    let mut numbers = Random::new(4, 1);
    let pixels: Vec<Fragment> = (0..4_000)
        .map(|_| {
            let mut one = random(&mut numbers, 1)[0];
            one.data = one.data & 0xFF_FFFF | (1 + numbers.below(254) as u32) << 24;
            one
        })
        .collect();
    let nan = |name: &str| {
        let config = config(1, 1, Approximation::default());
        let is_nan = |f: &&Fragment| light(name, &config, &[**f]).color[0].is_nan();
        pixels.iter().filter(is_nan).count()
    };
    let [single, double] = [nan("mbt@published-f32"), nan("mbt")];
    println!("of {} pixels, {single} are no number in f32, {double} in f64", pixels.len());
    assert!(double == 0 && (400..900).contains(&single), "{single} {double}");
}

#[test]
fn pixels_that_are_no_number_are_counted() {
    let scene = scene("synthetic:n=3,density=40", [64, 48]);
    let drawn = |name| draw(&scene, &options(name, None));
    let published = drawn("mbt@published-f32");
    let Kept::Color(lights) = &published.kept else { panic!("colours") };
    let found = lights.iter().filter(|light| light.color.iter().any(|c| c.is_nan())).count();
    println!("{found} pixels are no number");
    assert_eq!(published.report.nan_pixels, Some(found as u64));
    // Two pixels more, one of them in its last channel alone.
    let Kept::Color(mut lights) = drawn("mbt").kept else { panic!("colours") };
    lights[0].color = [f64::NAN; 3];
    lights[5].color[2] = f64::NAN;
    assert_eq!(Kept::Color(lights).nan_pixels(), Some(2));
    assert_eq!(drawn("mbt").report.nan_pixels, Some(0));
    assert_eq!(drawn("kplus-array").report.nan_pixels, None);
}

// ---------------------------------------------------------------------------------------------------------------------
// Nodes.

/// Nodes (key, colour, transmittance), the last two merged where one too many comes.
fn multi_layer(fragments: &[Fragment], k: usize) -> [f64; 4] {
    let mut nodes: Vec<(u64, [f64; 3], f64)> = Vec::new();
    for f in fragments {
        let (c, a) = rgba(f);
        nodes.push((f.key(), c.map(|c| a * c), 1.0 - a));
        nodes.sort_by_key(|node| node.0);
        if nodes.len() > k {
            let (_, color, through) = nodes.pop().expect("nodes");
            let last = nodes.last_mut().expect("k is at least 1");
            (0..3).for_each(|i| last.1[i] += last.2 * color[i]);
            last.2 *= through;
        }
    }
    let mut all = [0.0, 0.0, 0.0, 1.0];
    for (_, color, through) in nodes {
        (0..3).for_each(|i| all[i] += all[3] * color[i]);
        all[3] *= through;
    }
    all
}

#[test]
fn mlab_is_the_papers_algorithm() {
    let mut numbers = Random::new(5, 1);
    for round in 0..3_000 {
        let (n, k) = (1 + round % 14, 1 + (round / 14) % 5);
        let fragments = random(&mut numbers, n);
        let found = seen(light("mlab", &config(n, k as u32, Approximation::default()), &fragments));
        let right = multi_layer(&fragments, k);
        assert!(
            apart(found, right) < 2.0 * sixteen_bits(n),
            "{k} {fragments:?} {found:?} {right:?}"
        );
    }
}

/// Visibility as (distance, transmittance behind it); `None` where two nodes are equally good to remove, up to rounding.
fn visibility(fragments: &[Fragment], k: usize) -> Option<[f64; 4]> {
    let mut nodes: Vec<(u64, f64)> = Vec::new();
    let along = |key: u64| DISTANCES.along((key >> 32) as u32);
    for f in fragments {
        let (_, a) = rgba(f);
        let place = nodes.partition_point(|node| node.0 <= f.key());
        let before = place.checked_sub(1).map_or(1.0, |i| nodes[i].1);
        nodes.insert(place, (f.key(), before));
        nodes[place..].iter_mut().for_each(|node| node.1 *= 1.0 - a);
        if nodes.len() > k {
            let error = |i: usize| {
                let width = along(nodes[i].0) - along(nodes[i - 1].0);
                width * (nodes[i - 1].1 - nodes[i].1)
            };
            let mut errors: Vec<(f64, usize)> = (1..nodes.len()).map(|i| (error(i), i)).collect();
            errors.sort_by(|a, b| a.0.total_cmp(&b.0));
            if errors.len() > 1 && errors[1].0 - errors[0].0 < 5e-3 * (1.0 + errors[1].0) {
                return None;
            }
            let gone = errors[0].1;
            nodes[gone - 1].1 = nodes[gone].1;
            nodes.remove(gone);
        }
    }
    let mut all = [0.0, 0.0, 0.0, nodes.last().map_or(1.0, |node| node.1)];
    for f in fragments {
        let (c, a) = rgba(f);
        let seen = nodes.iter().take_while(|node| node.0 < f.key()).last().map_or(1.0, |n| n.1);
        (0..3).for_each(|i| all[i] += a * c[i] * seen);
    }
    Some(all)
}

#[test]
fn adaptive_is_the_papers_algorithm() {
    let mut numbers = Random::new(6, 1);
    let mut compared = 0;
    for round in 0..4_000 {
        let (n, k) = (1 + round % 12, 1 + (round / 12) % 5);
        let fragments = random(&mut numbers, n);
        let Some(mut right) = visibility(&fragments, k) else { continue };
        // Sums may exceed all light, which a pixel cannot.
        right.iter_mut().for_each(|c| *c = c.min(1.0));
        let config = config(n, k as u32, Approximation::default());
        let found = seen(light("adaptive", &config, &fragments));
        assert!(
            apart(found, right) < 3.0 * sixteen_bits(n),
            "{k} {fragments:?} {found:?} {right:?}"
        );
        compared += 1;
    }
    println!("{compared} of 4000 pixels compared");
    assert!(compared > 1_000);
}

/// `adaptive@over` never sees less than `adaptive`, and both see what is in front of every removed node alike.
#[test]
fn variants_of_adaptive_differ_as_they_say() {
    let mut numbers = Random::new(7, 1);
    let (mut more, mut last) = (0, 0);
    for _ in 0..2_000 {
        let fragments = random(&mut numbers, 5);
        let config = config(5, 4, Approximation::default());
        let [under, over, keeps] = ["adaptive", "adaptive@over", "adaptive@keeps-last"]
            .map(|name| seen(light(name, &config, &fragments)));
        // What passes all fragments is the same; without its last node, rounding takes another way.
        assert!((0..3).all(|i| over[i] >= under[i] - sixteen_bits(5)), "{under:?} {over:?}");
        more += u32::from(apart(under, over) > sixteen_bits(5));
        last += u32::from(apart(under, keeps) > sixteen_bits(5));
    }
    println!("{more} pixels are brighter overestimated, {last} differ where the last node stays");
    assert!(more > 100 && last > 100);
}

#[test]
fn hybrid_is_the_papers_equation() {
    let mut numbers = Random::new(8, 1);
    for round in 0..3_000 {
        let (n, k) = (1 + round % 20, 1 + (round / 20) % 6);
        let fragments = random(&mut numbers, n);
        let all = sorted(&fragments);
        let (near, far) = all.split_at(n.min(k));
        let core = over(near);
        let alphas: f64 = far.iter().map(|f| rgba(f).1).sum();
        let mean = alphas / far.len() as f64;
        let powers = far.iter().fold(1.0, |p, _| p * (1.0 - mean));
        let product: f64 = far.iter().map(|f| 1.0 - rgba(f).1).product();
        for (name, through) in [("hybrid", powers), ("hybrid@product", product)] {
            let mut right = core;
            if alphas > 0.0 {
                let of = |i: usize| far.iter().map(|f| rgba(f).0[i] * rgba(f).1).sum::<f64>();
                (0..3).for_each(|i| right[i] += core[3] * of(i) / alphas * (1.0 - through));
                right[3] *= through;
            }
            let config = config(n, k as u32, Approximation::default());
            let found = seen(light(name, &config, &fragments));
            assert!(apart(found, right) < sixteen_bits(n), "{name} {found:?} {right:?}");
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Samples.

fn sampled(samples: u32, seed: u64) -> Approximation {
    Approximation { samples, seed, ..Approximation::default() }
}

/// The mean over seeds is OVER, for plain samples.
#[test]
fn stochastic_is_right_in_the_mean() {
    const SEEDS: u64 = 4_000;
    let mut numbers = Random::new(9, 1);
    for (samples, n) in [(1, 2), (4, 3), (8, 5), (64, 4)] {
        let mut fragments = random(&mut numbers, n);
        fragments.iter_mut().for_each(|f| f.data = f.data & 0xFF_FFFF | 0x7000_0000);
        let right = over(&sorted(&fragments));
        let runs: Vec<[f64; 4]> = (0..SEEDS)
            .map(|seed| {
                seen(light("stochastic@plain", &config(n, 1, sampled(samples, seed)), &fragments))
            })
            .collect();
        for i in 0..4 {
            let mean = runs.iter().map(|run| run[i]).sum::<f64>() / SEEDS as f64;
            let variance = runs.iter().map(|run| (run[i] - mean) * (run[i] - mean)).sum::<f64>();
            let error = (variance / (SEEDS * (SEEDS - 1)) as f64).sqrt();
            assert!(
                (mean - right[i]).abs() <= 4.0 * error + 1e-12,
                "{samples} {mean} {}",
                right[i]
            );
        }
    }
}

/// The share of samples is α S, rounded up or down; it is exact where that is whole.
#[test]
fn stochastic_of_one_layer() {
    let mut numbers = Random::new(10, 1);
    for round in 0..2_000_u64 {
        let samples = 1 + (round % 64) as u32;
        let one = random(&mut numbers, 1);
        let exact = over(&one);
        let config = config(1, 1, sampled(samples, round));
        let plain = seen(light("stochastic@plain", &config, &one));
        let covered = (1.0 - plain[3]) * f64::from(samples);
        let expected = (1.0 - exact[3]) * f64::from(samples);
        assert!((covered - covered.round()).abs() < 1e-9 && (covered - expected).abs() < 1.0);
        if (expected - expected.round()).abs() < 1e-9 {
            assert!(apart(plain, exact) < 1e-12, "{samples} {plain:?} {exact:?}");
        }
        let corrected = seen(light("stochastic", &config, &one));
        let right = if covered > 0.5 { exact } else { [0.0, 0.0, 0.0, exact[3]] };
        assert!(apart(corrected, right) < 1e-9, "{corrected:?} {right:?}");
        let depth = seen(light("stochastic@depth", &config, &one));
        assert!(apart(depth, exact) < 1e-9, "{depth:?} {exact:?}");
    }
}

/// The second pass of depth-based samples, from the samples of the plain form: a fragment of a colour of its own shows
/// where it is nearest.
#[test]
fn many_samples_come_near_the_exact_picture() {
    let scene = scene("synthetic:n=9", [40, 30]);
    let exact = draw(&scene, &options("exact", None)).image;
    let error = |name: &str, samples: u32| {
        let approximation = sampled(samples, 3);
        let drawn = draw(&scene, &Options { approximation, ..options(name, None) }).image;
        let bytes = exact.pixels.iter().flatten().zip(drawn.pixels.iter().flatten());
        bytes.map(|(a, b)| f64::from(u32::from(a.abs_diff(*b)).pow(2))).sum::<f64>()
    };
    for name in ["stochastic", "stochastic@plain", "stochastic@depth"] {
        let errors = [1, 8, 64].map(|samples| error(name, samples));
        println!("{name}: squared errors {errors:?}");
        assert!(errors[0] > 2.0 * errors[1] && errors[1] > 2.0 * errors[2], "{name} {errors:?}");
    }
    // Section 3.2: colours from visibility are less noisy than those of samples.
    assert!(error("stochastic@depth", 8) < error("stochastic@plain", 8));
}

// ---------------------------------------------------------------------------------------------------------------------
// Order.

const ORDER_FREE: [&str; 7] = [
    "wboit",
    "mbt",
    "hybrid",
    "hybrid@product",
    "stochastic",
    "stochastic@plain",
    "stochastic@depth",
];

#[test]
fn sums_do_not_depend_on_arrival() {
    let mut numbers = Random::new(11, 1);
    for _ in 0..12 {
        let mut fragments = random(&mut numbers, 6);
        // Two of equal depth, two wholly alike.
        fragments[1].depth = fragments[0].depth;
        fragments[3] = Fragment { extra: 3, ..fragments[2] };
        for name in ORDER_FREE {
            let config = config(6, 2, Approximation::default());
            let all: Vec<Light> =
                in_all_orders(&fragments).map(|f| light(name, &config, &f)).collect();
            assert_eq!(all.len(), 720);
            assert!(all.iter().all(|light| *light == all[0]), "{name} {fragments:?}");
        }
    }
}

/// Nodes give the same in every order up to k + 1 fragments, and not beyond.
#[test]
fn nodes_depend_on_arrival_beyond_k_and_one_more() {
    let mut numbers = Random::new(12, 1);
    for name in ["mlab", "adaptive", "adaptive@over", "adaptive@keeps-last"] {
        let mut differ = 0;
        for _ in 0..40 {
            let fragments = random(&mut numbers, 5);
            let all = |k: u32| -> Vec<Light> {
                let config = config(5, k, Approximation::default());
                in_all_orders(&fragments).map(|f| light(name, &config, &f)).collect()
            };
            let same = |lights: &[Light]| lights.iter().all(|light| *light == lights[0]);
            assert!(same(&all(5)) && same(&all(4)), "{name} {fragments:?}");
            differ += u32::from(!same(&all(2)));
        }
        println!("{name}: {differ} of 40 depend on arrival with k = 2");
        assert!(differ > 0, "{name}");
    }
}

/// k = 1, arrival by depth 1, 3, 2: C1 + T1 C3 + T1 T3 C2.
#[test]
fn mlab_puts_what_comes_late_behind() {
    let three = [(1, 0x8000_00FF), (3, 0x80FF_0000), (2, 0x8000_FF00)];
    let arrival = three.map(|(depth, data)| fragment(depth, data, 0));
    let found = seen(light("mlab", &config(3, 1, Approximation::default()), &arrival));
    assert!(apart(found, over(&arrival)) < sixteen_bits(3), "{found:?}");
    assert!(apart(found, over(&sorted(&arrival))) > 0.05);
}

/// Later in front, whatever the depth.
#[test]
fn unsorted_is_the_order_of_submission() {
    let mut numbers = Random::new(13, 1);
    for n in 1..20 {
        let fragments = ranked(&random(&mut numbers, n));
        let found =
            seen(light("blend-unsorted", &config(n, 1, Approximation::default()), &fragments));
        let back: Vec<Fragment> = fragments.iter().rev().copied().collect();
        assert!(apart(found, over(&back)) < sixteen_bits(n), "{found:?}");
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Pictures.

/// With one layer, every method gives the exact picture (opacity 0.5, which eight samples do not divide evenly).
#[test]
fn one_layer_is_the_exact_picture() {
    let scene = scene("layers:count=1", [33, 17]);
    let exact = draw(&scene, &options("exact", None)).image;
    let unlike = ["stochastic@plain"];
    for name in
        ORDER_FREE.into_iter().chain(["wboit@published-f32", "mlab", "adaptive", "blend-unsorted"])
    {
        for exec in [Exec::Tile, Exec::Threads] {
            let image = draw(&scene, &Options { exec, ..options(name, None) }).image;
            assert!(image == exact || unlike.contains(&name), "{name}");
        }
    }
    for weight in Weight::ALL {
        let approximation = Approximation { weight, ..Approximation::default() };
        assert_eq!(draw(&scene, &Options { approximation, ..options("wboit", None) }).image, exact);
    }
}

/// Node for node, visibility is exact; the battery has the same of `mlab` and `hybrid`.
#[test]
fn adaptive_with_enough_nodes_is_the_exact_picture() {
    for name in ["adaptive", "adaptive@over", "adaptive@keeps-last"] {
        for source in ["synthetic:n=14,tessellation=3", "layers:count=6", "hairball:strands=40"] {
            let scene = scene(source, [40, 28]);
            let exact = draw(&scene, &options("exact", None)).image;
            assert_eq!(draw(&scene, &options(name, Some(64))).image, exact, "{name} {source}");
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Extremes.

const ALL: [&str; 14] = [
    "wboit",
    "wboit@published-f32",
    "mbt",
    "mbt@published-f32",
    "mlab",
    "adaptive",
    "adaptive@over",
    "adaptive@keeps-last",
    "hybrid",
    "hybrid@product",
    "stochastic",
    "stochastic@plain",
    "stochastic@depth",
    "blend-unsorted",
];

/// What has no opacity changes nothing, alone or among others.
#[test]
fn opacity_0_shows_nothing() {
    for name in ALL {
        let config = config(3, 1, Approximation::default());
        let clear = [0, 77, FARTHEST].map(|depth| fragment(depth, 0x00FF_FFFF, 0));
        for n in 0..=3 {
            let found = seen(light(name, &config, &ranked(&clear[..n])));
            assert_eq!(found, [0.0, 0.0, 0.0, 1.0], "{name} {n}");
        }
    }
}

/// One opaque fragment, wherever it lies, is what is seen: exactly, or (`mbt`) but for 4.5e-5.
#[test]
fn opacity_1_hides_what_is_behind() {
    for name in ALL.into_iter().filter(|name| *name != "mbt@published-f32") {
        for depth in [0, 1 << 31, FARTHEST] {
            for samples in [1, 8, 64] {
                let config = config(1, 1, sampled(samples, 5));
                let found = seen(light(name, &config, &[fragment(depth, 0xFF40_80FF, 0)]));
                let [r, g, b] = [255.0, 128.0, 64.0].map(|c| c / 255.0);
                let bound = if name.starts_with("mbt") { 4.6e-5 } else { 1e-6 };
                assert!(apart(found, [r, g, b, 0.0]) < bound, "{name} {depth} {found:?}");
            }
        }
    }
}

/// 65,536 layers: nothing overflows. All opaque, at different depths or all at one.
#[test]
fn very_many_layers() {
    const N: usize = 1 << 16;
    let spread: Vec<Fragment> =
        (0..N as u32).map(|i| fragment(i * 65_535, 0xFFFF_FFFF, i)).collect();
    let same: Vec<Fragment> = (0..N as u32).map(|i| fragment(1 << 31, 0xFFFF_FFFF, i)).collect();
    let faint: Vec<Fragment> =
        (0..N as u32).map(|i| fragment(i * 65_535, 0x01FF_FFFF, i)).collect();
    for name in ALL.into_iter().filter(|name| !name.ends_with("f32")) {
        for (what, fragments) in [("spread", &spread), ("same", &same), ("faint", &faint)] {
            let config = config(N, 4, sampled(4, 1));
            let found = seen(light(name, &config, &ranked(fragments)));
            // Visibility is underestimated between nodes: what lies between the first two is hidden.
            let dark = name.starts_with("adaptive") && what == "faint";
            let least = if dark { 0.1 } else { 0.998 };
            // Products of 16 bits stop where a layer's share of them is less than half a unit.
            let dim = if what == "faint" { 128.0 / 65_535.0 } else { 1e-4 };
            let white = (0..3).all(|i| (least..=1.0).contains(&found[i]));
            assert!(white && found[3] < dim, "{name} {what} {found:?}");
        }
    }
}

/// k = 1 and S = 1 are methods, too.
#[test]
fn the_least_room_is_enough() {
    let scene = scene("synthetic:n=9", [24, 18]);
    for name in ALL {
        let k = method(name).contract().default_k.map(|_| 1);
        let drawn = draw(&scene, &Options { approximation: sampled(1, 0), ..options(name, k) });
        let Kept::Color(lights) = &drawn.kept else { panic!("colours") };
        let fine = |light: &Light| light.color.iter().all(|c| (0.0..=1.0 + 1e-6).contains(c));
        let nan = drawn.report.nan_pixels.expect("counted");
        assert!(lights.iter().filter(|light| !fine(light)).count() as u64 <= nan, "{name}");
        assert_eq!(drawn.report.violations, Vec::<String>::new(), "{name}");
    }
}

/// Every built-in fault shows on a random pixel.
#[test]
fn faults_show() {
    let mut numbers = Random::new(14, 1);
    for fault in [
        "wboit@constant-weight",
        "wboit@premultiplied-twice",
        "wboit@eight-bits",
        "mlab@opacity-sum",
        "mlab@farther-depth",
        "hybrid@tail-alpha",
        "stochastic@same-samples",
    ] {
        let base = fault.split('@').next().expect("a name");
        let differs = (0..50).any(|_| {
            let fragments = random(&mut numbers, 6);
            let config = config(6, 2, Approximation::default());
            light(fault, &config, &fragments) != light(base, &config, &fragments)
        });
        assert!(differs, "{fault}");
    }
}
