//! The rasterizer against the reference.

use fragloom::raster::clip::{GUARD_BAND, Polygon, Snapped, UNITS, Viewport};
use fragloom::raster::naive;
use fragloom::raster::primitive::{Primitive, Rect, Setup};
use glam::DVec4;

const WIDTH: u32 = 21;
const HEIGHT: u32 = 19;
const IMAGE: Rect = Rect { x0: 0, y0: 0, x1: WIDTH, y1: HEIGHT };

/// The first byte chooses: snapped triangles (three little-endian words a vertex), or triangles in clip space (four
/// floats a vertex), snapped to 8 or 4 sub-pixel bits.
pub fn raster(bytes: &[u8]) {
    let Some((&mode, rest)) = bytes.split_first() else { return };
    let words: Vec<[u8; 4]> = rest.as_chunks().0.to_vec();
    match mode % 3 {
        0 => words.as_chunks::<9>().0.iter().for_each(|t| compare(&snapped(t))),
        bits => {
            let sub_pixel_bits = if bits == 1 { 8 } else { 4 };
            let viewport = Viewport { width: WIDTH, height: HEIGHT, sub_pixel_bits };
            for triangle in words.as_chunks::<12>().0 {
                let v = triangle.map(|w| f64::from(f32::from_le_bytes(w)));
                if v.iter().all(|c| c.is_finite()) {
                    let corner = |i: usize| DVec4::new(v[i], v[i + 1], v[i + 2], v[i + 3]);
                    compare(&viewport.clip([corner(0), corner(4), corner(8)]));
                }
            }
        }
    }
}

/// Coordinates within the guard band; depth codes below `EMPTY`.
fn snapped(words: &[[u8; 4]; 9]) -> Polygon {
    let limit = GUARD_BAND * UNITS;
    let vertex = |i: usize| Snapped {
        x: i32::from_le_bytes(words[i]).clamp(-limit, limit),
        y: i32::from_le_bytes(words[i + 1]).clamp(-limit, limit),
        z: u32::from_le_bytes(words[i + 2]).min(u32::MAX - 1),
    };
    Polygon::new(&[vertex(0), vertex(3), vertex(6)])
}

fn compare(polygon: &Polygon) {
    let mut fast = vec![None; (WIDTH * HEIGHT) as usize];
    if let Setup::Visible(primitive) = Primitive::new(polygon.vertices(), 0, IMAGE) {
        primitive.blocks(IMAGE, |x, y, mask| {
            let origin = primitive.plane.at(x, y);
            for bit in (0..64).filter(|bit| mask >> bit & 1 == 1) {
                let (dx, dy) = (bit % 8, bit / 8);
                let code = primitive.plane.code(primitive.plane.step(origin, dx, dy));
                fast[((y + dy) * WIDTH + x + dx) as usize] = Some(code);
            }
        });
    }
    for (place, fast) in (0..).zip(fast) {
        let (x, y) = (place % WIDTH, place / WIDTH);
        assert_eq!(fast, naive::fragment(polygon, x, y), "pixel {x} {y} of {polygon:?}");
    }
}
