//! The fast rasterizer against the reference, which is verified by reading.

use fragloom::num::random::Random;
use fragloom::raster::clip::{GUARD_BAND, Polygon, Snapped, UNITS, Viewport, doubled_area};
use fragloom::raster::naive;
use fragloom::raster::plane::DepthPlane;
use fragloom::raster::primitive::{Primitive, Rect, Setup};
use glam::DVec4;
use proptest::prelude::*;

const WIDTH: u32 = 45;
const HEIGHT: u32 = 27;
const IMAGE: Rect = Rect { x0: 0, y0: 0, x1: WIDTH, y1: HEIGHT };
const LIMIT: i32 = GUARD_BAND * UNITS;

/// Fragments compared by the random test; set `FRAGLOOM_FRAGMENTS` for more (see docs/checking.md).
fn fragment_goal() -> u64 {
    std::env::var("FRAGLOOM_FRAGMENTS").map_or(3_000_000, |v| v.parse().expect("a number"))
}

/// The depth codes of every pixel by the fast path.
fn fast(polygon: &Polygon) -> Vec<Option<u32>> {
    let mut image = vec![None; (WIDTH * HEIGHT) as usize];
    if let Setup::Visible(primitive) = Primitive::new(polygon.vertices(), 0, IMAGE) {
        primitive.blocks(IMAGE, |x, y, mask| {
            let origin = primitive.plane.at(x, y);
            let mut codes = [0; 64];
            primitive.plane.codes([x, y], mask, &mut codes);
            for bit in (0..64).filter(|bit| mask >> bit & 1 == 1) {
                let (dx, dy) = (bit % 8, bit / 8);
                let code = primitive.plane.code(primitive.plane.step(origin, dx, dy));
                assert_eq!(codes[bit as usize], code, "a block at once");
                let place = &mut image[((y + dy) * WIDTH + x + dx) as usize];
                assert_eq!(*place, None, "a pixel twice");
                *place = Some(code);
            }
        });
    }
    image
}

fn slow(polygon: &Polygon) -> Vec<Option<u32>> {
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    pixels.map(|(x, y)| naive::fragment(polygon, x, y)).collect()
}

/// Compare one polygon; how many fragments it had.
fn compare(polygon: &Polygon) -> u64 {
    let (fast, slow) = (fast(polygon), slow(polygon));
    assert_eq!(fast, slow, "{polygon:?}");
    fast.iter().flatten().count() as u64
}

/// A coordinate in grid units, of one of several characters.
fn coordinate(kind: u64, extent: u32, random: &mut Random) -> i32 {
    let extent = i64::from(extent) * i64::from(UNITS);
    let any = |random: &mut Random, low: i64, high: i64| {
        (low + random.below((high - low + 1) as u64) as i64) as i32
    };
    match kind {
        0 => any(random, 0, extent),
        1 => any(random, -extent, 2 * extent),
        2 => any(random, -i64::from(LIMIT), i64::from(LIMIT)),
        // On pixel centres and edges, where ties live.
        3 => any(random, -2, 2 * extent / i64::from(UNITS) + 2) * UNITS / 2,
        _ => any(random, -2 * extent, 3 * extent) / 16 * 16,
    }
}

fn depth(random: &mut Random) -> u32 {
    match random.below(4) {
        0 => 0,
        1 => u32::MAX - 1,
        _ => random.below(u64::from(u32::MAX)) as u32,
    }
}

/// A random triangle: general, sliver (the third vertex near the line of the others), or tiny.
fn triangle(random: &mut Random) -> [Snapped; 3] {
    let kinds = [random.below(5), random.below(5)];
    let mut v = [0; 3].map(|_| Snapped {
        x: coordinate(kinds[0], WIDTH, random),
        y: coordinate(kinds[1], HEIGHT, random),
        z: depth(random),
    });
    match random.below(4) {
        0 => {
            let t = random.unit();
            let near = |a: i32, b: i32, r: &mut Random| {
                (f64::from(a) + f64::from(b - a) * t) as i32 + r.below(5) as i32 - 2
            };
            v[2].x = near(v[0].x, v[1].x, random).clamp(-LIMIT, LIMIT);
            v[2].y = near(v[0].y, v[1].y, random).clamp(-LIMIT, LIMIT);
        }
        1 => {
            for i in 1..3 {
                v[i].x = (v[0].x + random.below(600) as i32 - 300).clamp(-LIMIT, LIMIT);
                v[i].y = (v[0].y + random.below(600) as i32 - 300).clamp(-LIMIT, LIMIT);
            }
        }
        _ => {}
    }
    v
}

/// A fan around a point with its rim in order of angle, if it goes round exactly once: its triangles share their inner
/// edges and do not overlap.
fn fan(random: &mut Random) -> Vec<[Snapped; 3]> {
    let kind = random.below(5);
    let point = |random: &mut Random| Snapped {
        x: coordinate(kind, WIDTH, random),
        y: coordinate(kind, HEIGHT, random),
        z: depth(random),
    };
    let center = point(random);
    let mut rim: Vec<Snapped> = (0..3 + random.below(12)).map(|_| point(random)).collect();
    let angle = |p: &Snapped| {
        libm::atan2(f64::from(p.y) - f64::from(center.y), f64::from(p.x) - f64::from(center.x))
    };
    rim.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let triangles: Vec<[Snapped; 3]> =
        (0..rim.len()).map(|i| [center, rim[i], rim[(i + 1) % rim.len()]]).collect();
    if triangles.iter().all(|&t| doubled_area(t) > 0) { triangles } else { Vec::new() }
}

/// The random soup: general, slivers, tiny, huge and off-screen triangles, and fans whose pixels are hit at most once.
#[test]
fn fast_equals_naive_on_random_triangles() {
    let mut random = Random::new(1, 0);
    let (mut fragments, mut triangles, mut fans) = (0, 0u64, 0u64);
    while fragments < fragment_goal() {
        fragments += compare(&Polygon::new(&triangle(&mut random)));
        triangles += 1;
        let fan = fan(&mut random);
        let mut hits = vec![0; (WIDTH * HEIGHT) as usize];
        for &part in &fan {
            fragments += compare(&Polygon::new(&part));
            for (hit, code) in hits.iter_mut().zip(fast(&Polygon::new(&part))) {
                *hit += u32::from(code.is_some());
            }
        }
        assert!(hits.iter().all(|&h| h <= 1), "a shared edge was hit twice: {fan:?}");
        triangles += fan.len() as u64;
        fans += u64::from(!fan.is_empty());
    }
    assert!(fans > 0);
    println!(
        "{fragments} fragments of {triangles} triangles, {fans} fans among them: 0 differences"
    );
}

/// Blocks of an image that is more than eight blocks wide, and those of its tiles, against the reference; row by row.
#[test]
fn blocks_are_those_of_the_reference_in_every_window() {
    const WIDE: Rect = Rect { x0: 0, y0: 0, x1: 203, y1: 141 };
    let window = |x: u32, y: u32, edge: u32| {
        Rect { x0: x, y0: y, x1: x + edge, y1: y + edge }.intersect(WIDE)
    };
    let mut random = Random::new(5, 0);
    let (mut covered, mut whole, mut polygons) = (0, 0, 0);
    while polygons < 150 {
        // From slivers to triangles that cross the guard band.
        let mut vertices = triangle(&mut random).map(|v| Snapped { x: v.x * 4, y: v.y * 4, ..v });
        for v in &mut vertices {
            (v.x, v.y) = (v.x.clamp(-LIMIT, LIMIT), v.y.clamp(-LIMIT, LIMIT));
        }
        let polygon = Polygon::new(&vertices);
        let Setup::Visible(primitive) = Primitive::new(polygon.vertices(), 0, WIDE) else {
            continue;
        };
        polygons += 1;
        let all = |window: Rect| {
            let mut blocks = Vec::new();
            primitive.blocks(window, |x, y, mask| blocks.push((y, x, mask)));
            assert!(blocks.is_sorted_by(|a, b| (a.0, a.1) < (b.0, b.1)), "{polygon:?}");
            blocks
        };
        let own = |x: u32, y: u32| naive::fragment(&polygon, x, y).is_some();
        let mut expected = Vec::new();
        for (y, x) in
            (0..WIDE.y1).step_by(8).flat_map(|y| (0..WIDE.x1).step_by(8).map(move |x| (y, x)))
        {
            let inside = |bit: &u32| x + bit % 8 < WIDE.x1 && y + bit / 8 < WIDE.y1;
            let bits = (0..64).filter(inside).filter(|bit| own(x + bit % 8, y + bit / 8));
            let mask: u64 = bits.map(|bit| 1 << bit).sum();
            if mask != 0 {
                expected.push((y, x, mask));
            }
        }
        let found = all(WIDE);
        assert_eq!(found, expected, "{polygon:?}");
        covered += found.len();
        whole += found.iter().filter(|(.., mask)| *mask == u64::MAX).count();
        for edge in [16, 64] {
            let tiles = (0..WIDE.y1)
                .step_by(edge as usize)
                .flat_map(|y| (0..WIDE.x1).step_by(edge as usize).map(move |x| window(x, y, edge)));
            let mut found: Vec<_> = tiles.flat_map(all).collect();
            found.sort_unstable();
            assert_eq!(found, expected, "{polygon:?}, tiles of {edge}");
        }
    }
    println!("{polygons} polygons, {covered} blocks, {whole} of them whole");
    assert!(covered > 5_000 && whole > 1_000);
}

/// Triangles in clip space that cross every plane.
fn clip_vertex() -> impl Strategy<Value = DVec4> {
    let reach = prop_oneof![Just(1.5), Just(40.0), Just(1e5)];
    let w = prop_oneof![0.01..4.0, -2.0..2.0f64, Just(1.0)];
    (reach, w, -1.0..1.0f64, -1.0..1.0f64, -0.5..1.5f64)
        .prop_map(|(reach, w, x, y, z)| DVec4::new(x * reach, y * reach, z * w, w))
}

fn viewport(sub_pixel_bits: u32) -> Viewport {
    Viewport { width: WIDTH, height: HEIGHT, sub_pixel_bits }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn fast_equals_naive_on_clipped_triangles(
        v in [clip_vertex(), clip_vertex(), clip_vertex()],
        bits in prop_oneof![Just(8), Just(4)],
    ) {
        let polygon = viewport(bits).clip(v);
        compare(&polygon);
    }

    /// A fan around a point, its rim anywhere: interior edges are shared, so every pixel is hit exactly as often as the
    /// winding says, which for a star-shaped rim inside out of nothing is 0 or 1.
    #[test]
    fn shared_edges_are_hit_exactly_once(
        center in (0.0..45.0f64, 0.0..27.0f64),
        radii in proptest::collection::vec(0.05..3_000.0f64, 3..24),
        w in proptest::collection::vec(0.05..20.0f64, 25),
    ) {
        let hits = fan_hits(center, &radii, &w);
        let twice = hits.iter().filter(|&&h| h > 1).count();
        prop_assert_eq!(twice, 0);
        // Pixels well inside the smallest radius around the centre cannot be missed.
        let least = radii.iter().copied().fold(f64::MAX, f64::min) * inner_share(radii.len());
        for (i, &h) in hits.iter().enumerate() {
            let (x, y) = (f64::from(i as u32 % WIDTH) + 0.5, f64::from(i as u32 / WIDTH) + 0.5);
            let d = ((x - center.0) * (x - center.0) + (y - center.1) * (y - center.1)).sqrt();
            if d < least - 0.1 {
                prop_assert_eq!(h, 1, "pixel {} {}", x, y);
            }
        }
    }

    /// Depth is within one unit of the rational plane, and inside the triangle's range.
    #[test]
    fn depth_is_within_one_unit_of_the_rational_plane(seed in any::<u64>()) {
        let mut random = Random::new(seed, 1);
        let polygon = Polygon::new(&triangle(&mut random));
        for (i, code) in fast(&polygon).iter().enumerate() {
            if let Some(code) = code {
                let error = depth_error(polygon.vertices(), i as u32 % WIDTH, i as u32 / WIDTH, *code);
                prop_assert!(error <= MAX_DEPTH_ERROR, "{} units", error);
            }
        }
    }
}

/// Half a unit for rounding the result, plus 2^25 coefficient roundings of 2^-25 at the far corner of the largest
/// image (`raster::plane`); here the image is small, so the rest is far below this.
const MAX_DEPTH_ERROR: f64 = 0.501;

/// |code - exact plane| in depth units, the plane in rationals of i128.
fn depth_error(v: &[Snapped], x: u32, y: u32, code: u32) -> f64 {
    let wide = i128::from;
    let [a, b, c] = [v[0], v[1], v[2]];
    let (px, py) = (i128::from(x) * 256 + 128, i128::from(y) * 256 + 128);
    let weight = |p: Snapped, q: Snapped| {
        (wide(q.x) - wide(p.x)) * (py - wide(p.y)) - (wide(q.y) - wide(p.y)) * (px - wide(p.x))
    };
    let (wa, wb, wc) = (weight(b, c), weight(c, a), weight(a, b));
    let area = wa + wb + wc;
    let z = wa * i128::from(a.z) + wb * i128::from(b.z) + wc * i128::from(c.z);
    (z - i128::from(code) * area) as f64 / area as f64
}

/// The rim of a regular polygon comes this near to its centre, in radii, and a rim of unequal radii no nearer than
/// that share of the smallest.
fn inner_share(corners: usize) -> f64 {
    libm::cos(std::f64::consts::PI / corners as f64)
}

/// How often each pixel is hit by the triangles of a star-shaped fan, clipped at the guard band where it is huge.
fn fan_hits(center: (f64, f64), radii: &[f64], w: &[f64]) -> Vec<u32> {
    let n = radii.len();
    let clip = |x: f64, y: f64, w: f64| {
        let (nx, ny) = (x / f64::from(WIDTH) * 2.0 - 1.0, 1.0 - y / f64::from(HEIGHT) * 2.0);
        DVec4::new(nx * w, ny * w, 0.5 * w, w)
    };
    let rim: Vec<DVec4> = (0..n)
        .map(|i| {
            let (sin, cos) = libm::sincos(i as f64 / n as f64 * std::f64::consts::TAU);
            // Every third radius reaches beyond the guard band.
            let r = if i % 3 == 2 { radii[i] * 40.0 } else { radii[i] };
            clip(center.0 + r * cos, center.1 + r * sin, w[i])
        })
        .collect();
    let middle = clip(center.0, center.1, w[n]);
    let mut hits = vec![0; (WIDTH * HEIGHT) as usize];
    for i in 0..n {
        let polygon = viewport(8).clip([middle, rim[i], rim[(i + 1) % n]]);
        for (hit, code) in hits.iter_mut().zip(fast(&polygon)) {
            *hit += u32::from(code.is_some());
        }
    }
    hits
}

#[test]
fn degenerate_triangles_cover_nothing() {
    let p = |x, y| Snapped { x, y, z: 7 };
    for v in [[p(0, 0), p(512, 512), p(1024, 1024)], [p(5, 5), p(5, 5), p(900, 3)], [p(9, 9); 3]] {
        assert!(matches!(Primitive::new(&v, 0, IMAGE), Setup::Degenerate));
        assert_eq!(compare(&Polygon::new(&v)), 0);
    }
}

#[test]
fn the_largest_triangle_covers_every_pixel() {
    let v = [(-LIMIT, -LIMIT), (LIMIT, -LIMIT), (0, LIMIT)].map(|(x, y)| Snapped { x, y, z: 9 });
    assert_eq!(compare(&Polygon::new(&v)), u64::from(WIDTH * HEIGHT));
}

/// Negative control: the comparison sees one changed sub-pixel unit.
#[test]
fn a_vertex_moved_by_one_unit_is_seen() {
    let p = |x, y| Snapped { x, y, z: 7 };
    let right = Polygon::new(&[p(128, 128), p(2_688, 128), p(128, 2_688)]);
    let wrong = Polygon::new(&[p(129, 128), p(2_688, 128), p(128, 2_688)]);
    assert_ne!(fast(&right), fast(&wrong));
    assert!(DepthPlane::new(right.vertices()).is_some());
}
