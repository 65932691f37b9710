//! Scenes whose answer is known without a renderer.
//!
//! * Layers: their blended colour, by integers of unbounded size (the formulas of `resolve::composite`, written here
//!   a second time), and by real numbers within a bound.
//! * The papers' artificial scene: how many fragments, where, how deep.
//! * Opacity 1 and 0: the nearest fragment, the background.
//! * Rectangles: their pixels counted by hand.
//! * Closed surfaces: as many front as back faces at every pixel.

mod support;

use fragloom::render::{CullFace, Lists, Options};
use fragloom::scene::{Scene, ScreenTriangle};
use support::{draw, lists, options, scene};

/// One surface of colour `c` and opacity `alpha`, in 128 bits, where nothing overflows.
fn over(color: u128, transmittance: u128, alpha: u128, c: u128) -> u128 {
    (color + (transmittance * alpha * c + 32_512) / 65_025).min(65_535)
}

/// The linear 16-bit colour of data words before a background, front to back, by the stated formulas.
fn composite(words: impl IntoIterator<Item = u32>, background: [u128; 3]) -> [u128; 3] {
    let (mut sum, mut transmittance) = ([0; 3], 65_535);
    for word in words {
        let [r, g, b, alpha] = word.to_le_bytes().map(u128::from);
        let channels = [r, g, b];
        sum = std::array::from_fn(|i| over(sum[i], transmittance, alpha, channels[i]));
        transmittance = (transmittance * (255 - alpha) + 127) / 255;
    }
    let behind = background.map(|b| (transmittance * b + 32_767) / 65_535);
    std::array::from_fn(|i| (sum[i] + behind[i]).min(65_535))
}

/// The linear value, 0..1, of an sRGB value, 0..1 (IEC 61966-2-1).
fn linear(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// The sRGB byte nearest to a linear value: by decoding the limits between bytes, not by encoding the value.
fn srgb(value: f64) -> u8 {
    (0..255).find(|&byte| value < linear((f64::from(byte) + 0.5) / 255.0)).unwrap_or(255)
}

fn pixel_of(color: [u128; 3]) -> [u8; 4] {
    let [r, g, b] = color.map(|c| srgb(c as f64 / 65_535.0));
    [r, g, b, 255]
}

fn word16(c: f32) -> u128 {
    (f64::from(c) * 65_535.0 + 0.5) as u128
}

/// The picture by the formulas, from a frame's own lists.
fn expected_pixel(scene: &Scene, keys: &[u64]) -> [u8; 4] {
    pixel_of(composite(keys.iter().map(|&key| key as u32), scene.background.map(word16)))
}

fn count(lists: &Lists, x: u32, y: u32) -> usize {
    lists.pixel(x, y).len()
}

fn counts(lists: &Lists) -> Vec<u64> {
    lists.offsets.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// Layers of one colour before a background.
struct Layers {
    n: u32,
    alpha: u8,
    color: [u8; 3],
    background: [f32; 3],
}

impl Layers {
    fn all() -> Vec<Self> {
        let colors = [[51, 153, 230], [255, 0, 1], [128, 64, 3]];
        let backgrounds = [[1.0; 3], [0.0, 0.25, 1.0]];
        let mut all = Vec::new();
        for (i, n) in [1, 2, 3, 7, 16, 64, 300].into_iter().enumerate() {
            for (j, alpha) in [1, 2, 64, 128, 200, 254, 255].into_iter().enumerate() {
                let (color, background) = (colors[(i + j) % 3], backgrounds[(i * 3 + j) % 2]);
                all.push(Self { n, alpha, color, background });
            }
        }
        all
    }

    /// The picture, by the renderer.
    fn drawn(&self) -> [u8; 4] {
        let part = |byte: u8| f64::from(byte) / 255.0;
        let [r, g, b] = self.color.map(part);
        let (n, alpha) = (self.n, part(self.alpha));
        let source = format!("layers:count={n},alpha={alpha:?},color={r:?}/{g:?}/{b:?}");
        let mut scene = scene(&source, [3, 2]);
        scene.background = self.background;
        let drawn = draw(&scene, &options("ab-ll", None));
        assert_eq!(drawn.report.generated, 6 * u64::from(n));
        assert!(drawn.image.pixels.iter().all(|pixel| *pixel == drawn.image.pixels[0]));
        drawn.image.pixels[0]
    }

    fn word(&self) -> u32 {
        let [r, g, b] = self.color;
        u32::from_le_bytes([r, g, b, self.alpha])
    }

    /// c (1 - (1 - a)^n) + b (1 - a)^n of a channel, in units of 1/65535.
    fn closed_form(&self, channel: usize) -> f64 {
        let (c, a) = (f64::from(self.color[channel]) / 255.0, f64::from(self.alpha) / 255.0);
        let through = libm::pow(1.0 - a, f64::from(self.n));
        65_535.0 * (c * (1.0 - through) + f64::from(self.background[channel]) * through)
    }

    /// How far rounding may lead from the closed form, in units of 1/65535. Each product is rounded to the nearest
    /// integer, by at most 1/2. Transmittance shrinks by (1 - a) from step to step, and its errors with it, so their
    /// sum stays below 1/(2a); it enters a colour with a factor of at most a, that is 1/2, and 1/2 more for the
    /// colour's own rounding: 1 per layer. The background takes 1/(2a), its own rounding and that of its 16 bits.
    fn rounding_bound(&self) -> f64 {
        f64::from(self.n) + 0.5 * 255.0 / f64::from(self.alpha) + 1.0
    }
}

#[test]
fn equal_layers_by_integers() {
    for layers in Layers::all() {
        let words = (0..layers.n).map(|_| layers.word());
        let expected = pixel_of(composite(words, layers.background.map(word16)));
        assert_eq!(layers.drawn(), expected, "{} x {}", layers.n, layers.alpha);
    }
}

#[test]
fn equal_layers_by_real_numbers() {
    for layers in Layers::all() {
        let drawn = layers.drawn();
        for (channel, &byte) in drawn[..3].iter().enumerate() {
            let (exact, bound) = (layers.closed_form(channel), layers.rounding_bound());
            let [low, high] = [exact - bound, exact + bound].map(|c| srgb(c / 65_535.0));
            assert!((low..=high).contains(&byte), "{} x {}: {byte}", layers.n, layers.alpha);
        }
    }
}

/// Negative control: a formula that rounds otherwise, or one layer less, is another picture somewhere.
#[test]
fn a_wrong_formula_is_seen() {
    let truncated = |words: &[u32], background: u128| {
        let step = |(sum, t): (u128, u128), word: &u32| {
            let [c, _, _, alpha] = word.to_le_bytes().map(u128::from);
            (sum + t * alpha * c / 65_025, t * (255 - alpha) / 255)
        };
        let (sum, t) = words.iter().fold((0, 65_535), step);
        sum + t * background / 65_535
    };
    let wrong = |layers: &Layers, words: &[u32]| {
        srgb(truncated(words, word16(layers.background[0])) as f64 / 65_535.0) != layers.drawn()[0]
    };
    let all = Layers::all();
    assert!(all.iter().any(|layers| wrong(layers, &vec![layers.word(); layers.n as usize])));
    let fewer = |l: &Layers| composite((1..l.n).map(|_| l.word()), l.background.map(word16));
    assert!(all.iter().any(|layers| pixel_of(fewer(layers)) != layers.drawn()));
}

/// Different colours, many layers: every pixel of every scene is its list by the formulas.
#[test]
fn every_pixel_is_its_list_by_the_formulas() {
    for scene in support::small_scenes() {
        for method in ["exact", "kplus-array"] {
            let drawn = draw(&scene, &options(method, None));
            let (image, lists) = (&drawn.image, drawn.lists().expect("lists"));
            for y in 0..lists.height {
                for x in 0..lists.width {
                    let expected = expected_pixel(&scene, lists.pixel(x, y));
                    assert_eq!(image.pixel(x, y), expected, "{} {method} {x} {y}", scene.name);
                }
            }
        }
    }
}

/// Columns and rows with any fragment: first, and one past the last.
fn extent(lists: &Lists) -> [u32; 4] {
    let covered = |x: u32, y: u32| count(lists, x, y) > 0;
    let columns = (0..lists.width).filter(|&x| (0..lists.height).any(|y| covered(x, y)));
    let rows = (0..lists.height).filter(|&y| (0..lists.width).any(|x| covered(x, y)));
    let (columns, rows): (Vec<_>, Vec<_>) = (columns.collect(), rows.collect());
    [columns[0], rows[0], columns[columns.len() - 1] + 1, rows[rows.len() - 1] + 1]
}

#[test]
fn the_artificial_scene_has_n_fragments_on_its_share_of_the_pixels() {
    for (size, density, tessellation) in
        [([64, 64], 25.0, 1), ([101, 67], 50.0, 3), ([40, 90], 75.0, 7), ([33, 21], 100.0, 64)]
    {
        let source = format!("synthetic:n=7,density={density},tessellation={tessellation}");
        let lists = lists(&scene(&source, size), &options("ab-ll", None));
        let [left, top, right, bottom] = extent(&lists);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let inside = (left..right).contains(&x) && (top..bottom).contains(&y);
                assert_eq!(count(&lists, x, y), if inside { 7 } else { 0 }, "{source} {x} {y}");
            }
        }
        let covered = f64::from((right - left) * (bottom - top));
        let wanted = density / 100.0 * f64::from(size[0] * size[1]);
        // The number of rows is rounded: by half a row at most.
        assert!((covered - wanted).abs() <= 0.5 * f64::from(right - left), "{source}: {covered}");
        let margins = [left.abs_diff(size[0] - right), top.abs_diff(size[1] - bottom)];
        assert!(margins.iter().all(|&apart| apart <= 1), "{source} is centred");
    }
}

/// The code of (2 i + 1) / 32: (2 i + 1)(2^32 - 1) / 32, rounded half to even (it is never half: 2^32 - 1 is odd).
fn code_of_layer(i: u64) -> u64 {
    let numerator = (2 * i + 1) * u64::from(u32::MAX);
    (numerator + 16) / 32
}

#[test]
fn the_artificial_scene_has_its_layers_in_depth_order() {
    let lists_of = |order: &str| {
        let source = format!("synthetic:n=16,order={order}");
        lists(&scene(&source, [24, 24]), &options("ab-ll", None))
    };
    let lists = lists_of("random");
    let depths: Vec<u64> = lists.pixel(12, 12).iter().map(|key| key >> 32).collect();
    assert_eq!(depths, (0..16).map(code_of_layer).collect::<Vec<_>>());
    assert_eq!(lists, lists_of("front-to-back"));
    assert_eq!(lists, lists_of("back-to-front"));
}

#[test]
fn opaque_surfaces_show_the_nearest_and_clear_ones_the_background() {
    for source in ["synthetic:n=9,alpha=1", "cubes:alpha=1", "hairball:strands=40,alpha=1"] {
        let scene = scene(source, [48, 40]);
        let all = draw(&scene, &options("ab-ll", None));
        let nearest = draw(&scene, &options("z-buffer", None));
        assert_eq!(all.image, nearest.image, "{source}");
        for y in 0..40 {
            for x in 0..48 {
                let first = all.lists().expect("lists").pixel(x, y).first().map(|&key| key as u32);
                let seen = first.map(|word| pixel_of(composite([word], [0; 3])));
                let expected = seen.unwrap_or_else(|| expected_pixel(&scene, &[]));
                assert_eq!(all.image.pixel(x, y), expected, "{source} {x} {y}");
            }
        }
    }
    for source in ["synthetic:n=9,alpha=0", "cubes:alpha=0"] {
        let mut scene = scene(source, [48, 40]);
        scene.background = [0.25, 0.5, 0.75];
        let drawn = draw(&scene, &options("kplus-array", None));
        assert!(drawn.report.generated > 1_000);
        let background = expected_pixel(&scene, &[]);
        assert!(drawn.image.pixels.iter().all(|pixel| *pixel == background), "{source}");
    }
}

/// The two triangles of a rectangle: left, top, right, bottom.
fn rectangle([left, top, right, bottom]: [f64; 4], z: f64, color: [f32; 4]) -> [ScreenTriangle; 2] {
    let (a, b, c, d) = ([left, top, z], [right, top, z], [right, bottom, z], [left, bottom, z]);
    [[a, b, c], [a, c, d]].map(|points| ScreenTriangle { points, color })
}

/// An image of 16 x 12 pixels with these rectangles.
fn rectangles(parts: &[[ScreenTriangle; 2]]) -> Scene {
    let mut scene = scene("layers:count=1", [16, 12]);
    scene.screen = parts.concat();
    scene
}

const RED: [f32; 4] = [1.0, 0.0, 0.0, 0.5];
const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 0.5];
/// Their words: alpha 128 on top, then B, G, R.
const RED_WORD: u64 = 0x8000_00FF;
const BLUE_WORD: u64 = 0x80FF_0000;

#[test]
fn two_rectangles_counted_by_hand() {
    // Pixels 2..10 x 2..8 and 6..14 x 5..11: 48 each, 4 x 3 = 12 in both.
    let scene = rectangles(&[
        rectangle([2.0, 2.0, 10.0, 8.0], 0.5, BLUE),
        rectangle([6.0, 5.0, 14.0, 11.0], 0.5, RED),
    ]);
    let drawn = draw(&scene, &options("ab-ll", None));
    let pixels_with = |n: u64| {
        counts(drawn.lists().expect("lists")).into_iter().filter(|&found| found == n).count()
    };
    assert_eq!((drawn.report.generated, drawn.report.kept), (96, 96));
    assert_eq!([pixels_with(0), pixels_with(1), pixels_with(2)], [192 - 84, 72, 12]);
    // 1/2 of 2^32 - 1 is a tie, and 2^31 is even.
    let depth = 0x8000_0000_u64 << 32;
    assert_eq!(drawn.lists().expect("lists").pixel(2, 2), [depth | BLUE_WORD]);
    assert_eq!(drawn.lists().expect("lists").pixel(13, 10), [depth | RED_WORD]);
    for [x, y] in [[6, 5], [9, 5], [6, 7], [9, 7]] {
        let both = [depth | RED_WORD, depth | BLUE_WORD];
        assert_eq!(
            drawn.lists().expect("lists").pixel(x, y),
            both,
            "equal depths stand in the order of their words"
        );
    }
    for [x, y] in [[5, 5], [10, 7], [6, 4], [9, 8]] {
        assert_eq!(count(drawn.lists().expect("lists"), x, y), 1, "{x} {y}");
    }
}

#[test]
fn edges_through_pixel_centres_belong_to_one_side() {
    // Left and top edges own their centres, right and bottom edges do not.
    let alone = rectangles(&[rectangle([2.5, 2.5, 10.5, 8.5], 0.5, RED)]);
    let found = lists(&alone, &options("ab-ll", None));
    assert_eq!(extent(&found), [2, 2, 10, 8]);
    assert_eq!(counts(&found).into_iter().filter(|&n| n == 1).count(), 48);
    // Four rectangles around (6.5, 5.5): every pixel of 2..12 x 1..9 once.
    let around = rectangles(&[
        rectangle([2.5, 1.5, 6.5, 5.5], 0.5, RED),
        rectangle([6.5, 1.5, 12.5, 5.5], 0.25, BLUE),
        rectangle([2.5, 5.5, 6.5, 9.5], 0.75, BLUE),
        rectangle([6.5, 5.5, 12.5, 9.5], 0.5, RED),
    ]);
    let found = lists(&around, &options("ab-ll", None));
    assert_eq!(extent(&found), [2, 1, 12, 9]);
    assert_eq!(counts(&found).into_iter().filter(|&n| n == 1).count(), 80);
    assert_eq!(found.entries.len(), 80);
    assert_eq!(found.pixel(6, 5)[0] as u32, RED_WORD as u32, "the lower right one has the corner");
}

/// Fragments of front and of back faces at every pixel.
fn faces(scene: &Scene, sub_pixel_bits: u32) -> [Vec<u64>; 2] {
    [CullFace::Back, CullFace::Front].map(|cull_face| {
        let options = Options { cull_face, sub_pixel_bits, ..options("ab-ll", None) };
        counts(&lists(scene, &options))
    })
}

/// Exactly as many front as back faces, so an even number: the top-left rule decides coverage as if every sample were
/// moved by the same infinitesimal step off all edges. A closed surface winds around such a point's line of sight 0
/// times in sum, also after snapping, which moves vertices but keeps them shared; a triangle that snapping makes
/// degenerate covers nothing, and counts for nothing in the winding. It holds where nothing is cut by the near or
/// far plane, and for open surfaces it does not.
#[test]
fn closed_surfaces_have_as_many_fronts_as_backs() {
    for source in ["cubes", "bottles:columns=4,rows=3,levels=2,sides=14", "gears:count=4"] {
        for bits in [8, 4] {
            let [front, back] = faces(&scene(source, [96, 80]), bits);
            assert!(front.iter().sum::<u64>() > 2_000, "{source}");
            assert_eq!(front, back, "{source} at {bits} bits");
        }
    }
}

/// Negative control: one triangle missing is a hole.
#[test]
fn an_open_surface_is_seen() {
    let mut open = scene("cubes", [96, 80]);
    let mesh = std::sync::Arc::make_mut(&mut open.objects[0].mesh);
    mesh.triangles.pop();
    let [front, back] = faces(&open, 8);
    assert_ne!(front, back);
    let odd = front.iter().zip(&back).filter(|(front, back)| (*front + *back) % 2 == 1).count();
    assert!(odd > 20, "{odd} pixels see the hole");
}
