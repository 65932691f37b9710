//! The papers' artificial scene: every covered pixel gets exactly `n` fragments. Layers are rectangles on whole
//! pixels, parallel to the screen, so that none misses or repeats a pixel; layer i of n is at depth
//! (i + 1/2) / n. Triangles inside a tessellated layer share edges, which the top-left rule gives to one side.
//! (Vasilakis and Fudos, "k+-buffer", I3D 2014, section 4.1.)

use super::super::super::{Model, ScreenTriangle};
use super::super::shape::{ORDER, in_order, layer_depth, random_color, rectangle};
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

/// The most rectangles over all layers.
const MAX_QUADS: u64 = 1 << 22;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "synthetic",
    about: "n fragments on each pixel of a centred rectangle, in random order, as in the papers",
    in_pixels: true,
    keys: &[
        Key {
            name: "n",
            default: "32",
            range: Range::Count(1, 4096),
            about: "fragments per pixel",
        },
        Key {
            name: "density",
            default: "50",
            range: Range::Real(0.0001, 100.0),
            about: "covered pixels, % of the image, as near as whole rows and columns allow",
        },
        Key {
            name: "tessellation",
            default: "1",
            range: Range::Count(1, 64),
            about: "rectangles of a layer along each side",
        },
        Key {
            name: "area",
            default: "0",
            range: Range::Real(0.0, 1e9),
            about: "of a triangle in pixels, about, instead of tessellation; 0: as tessellation says",
        },
        ORDER,
        Key::alpha("0.5"),
        Key::SEED,
    ],
    generate,
};

fn generate(keys: &Keys<'_>, size: [u32; 2]) -> Result<Model> {
    let n = keys.count("n")?;
    let edges = covered(size, keys.real("density")?);
    let (cells, key) = cells(keys, edges)?;
    if u64::from(n) * u64::from(cells[0]) * u64::from(cells[1]) > MAX_QUADS {
        let [columns, rows] = cells;
        let problem = format!("n x {columns} x {rows} rectangles exceed {MAX_QUADS}");
        return Err(keys.wrong(key, &problem));
    }
    let alpha = keys.alpha()?;
    let seed = keys.seed()?;
    let mut colors = Random::new(seed, 1);
    let layers: Vec<_> = (0..n).map(|i| (layer_depth(i, n), random_color(&mut colors))).collect();
    let screen = in_order(keys.choice("order")?, Random::new(seed, 2), layers)
        .into_iter()
        .flat_map(|(z, [r, g, b])| layer(edges, cells, z, [r, g, b, alpha]))
        .collect();
    Ok(Model { screen, ..Model::default() })
}

/// Rectangles of a layer across and down, and the key that says so.
fn cells(keys: &Keys<'_>, edges: [u32; 4]) -> Result<([u32; 2], &'static str)> {
    let (along, area) = (keys.count("tessellation")?, keys.real("area")?);
    if area == 0.0 {
        return Ok(([along, along], "tessellation"));
    }
    if along > 1 {
        return Err(keys.wrong("area", "is given, and tessellation: both cut layers, give one"));
    }
    Ok((cut([edges[2] - edges[0], edges[3] - edges[1]], area), "area"))
}

/// Into how many rectangles of two triangles of `area` pixels each a rectangle is cut, across and down: squares, as
/// near as whole numbers of them allow, and none narrower than half a pixel.
fn cut(size: [u32; 2], area: f64) -> [u32; 2] {
    let edge = libm::sqrt(2.0 * area);
    size.map(|length| {
        let length = f64::from(length);
        libm::round(length / edge).clamp(1.0, 2.0 * length) as u32
    })
}

/// The centred rectangle of `density` percent of the pixels: left, top, right, bottom.
fn covered(size: [u32; 2], density: f64) -> [u32; 4] {
    let share = density / 100.0;
    let [width, height] = size.map(f64::from);
    let columns = libm::round(width * libm::sqrt(share)).clamp(1.0, width);
    let rows = libm::round(width * height * share / columns).clamp(1.0, height);
    let (columns, rows) = (columns as u32, rows as u32);
    let (left, top) = ((size[0] - columns) / 2, (size[1] - rows) / 2);
    [left, top, left + columns, top + rows]
}

/// One layer, row by row.
fn layer(
    [left, top, right, bottom]: [u32; 4],
    [columns, rows]: [u32; 2],
    z: f64,
    color: [f32; 4],
) -> impl Iterator<Item = ScreenTriangle> {
    let line = |from: u32, to: u32, i: u32, cells: u32| {
        f64::from(from) + f64::from(to - from) * f64::from(i) / f64::from(cells)
    };
    (0..columns * rows).flat_map(move |cell| {
        let (x, y) = (cell % columns, cell / columns);
        let edges = [
            line(left, right, x, columns),
            line(top, bottom, y, rows),
            line(left, right, x + 1, columns),
            line(top, bottom, y + 1, rows),
        ];
        rectangle(edges, z, color)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rectangle_covers_its_share_of_the_pixels() {
        for (size, density) in [([1024, 1024], 50.0), ([854, 480], 25.0), ([854, 480], 75.0)] {
            let [left, top, right, bottom] = covered(size, density);
            let pixels = f64::from((right - left) * (bottom - top));
            let share = 100.0 * pixels / f64::from(size[0] * size[1]);
            assert!((share - density).abs() < 0.1, "{size:?} {density}: {share}");
            assert!(size[0] - right - left <= 1 && size[1] - bottom - top <= 1, "centred");
        }
        assert_eq!(covered([640, 480], 100.0), [0, 0, 640, 480]);
        assert_eq!(covered([3, 5], 0.0001), [1, 2, 2, 3], "never less than a pixel");
    }

    #[test]
    fn cells_share_their_corners_and_end_on_whole_pixels() {
        let triangles: Vec<_> = layer([3, 5, 10, 9], [4, 4], 0.5, [1.0; 4]).collect();
        assert_eq!(triangles.len(), 32);
        let xs = triangles.iter().flat_map(|t| t.points.map(|p| p[0]));
        let mut xs: Vec<_> = xs.collect();
        xs.sort_by(f64::total_cmp);
        xs.dedup();
        assert_eq!(xs, [3.0, 4.75, 6.5, 8.25, 10.0]);
    }

    #[test]
    fn triangles_have_the_area_that_is_asked_for() {
        assert_eq!(cut([1024, 1024], 8.0), [256, 256]);
        assert_eq!(cut([1024, 512], 128.0), [64, 32]);
        assert_eq!(cut([10, 7], 1e9), [1, 1], "never less than one");
        assert_eq!(cut([10, 7], 1e-9), [20, 14], "never narrower than half a pixel");
        let model = |keys: &str| {
            let keys = super::super::super::parse_keys("synthetic", keys)?;
            super::super::super::generate("synthetic", &keys, [64, 32])
        };
        let screen = model("n=3,density=100,area=8").unwrap().screen;
        assert_eq!(screen.len(), 3 * 2 * 16 * 8);
        for triangle in &screen {
            let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = triangle.points;
            let doubled = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
            assert!((doubled.abs() - 16.0).abs() < 1e-9, "{triangle:?}");
        }
        let error = |keys: &str| model(keys).unwrap_err().to_string();
        let both = error("area=8,tessellation=2");
        assert_eq!(both, "synthetic: area: is given, and tessellation: both cut layers, give one");
        let many = error("n=4096,density=100,area=0.5");
        assert_eq!(many, "synthetic: area: n x 64 x 32 rectangles exceed 4194304");
    }
}
