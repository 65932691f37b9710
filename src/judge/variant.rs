//! Other coverage of the same scene: what a rasterizer gives that samples elsewhere, or has another rule.

use rayon::prelude::*;

use super::answer::{Entry, gather, join};
use crate::raster::clip::{Snapped, UNITS};
use crate::raster::primitive::{Primitive, Setup};
use crate::raster::{CullFace, FrontEnd};
use crate::render::Options;
use crate::resolve::Lists;
use crate::scene::Scene;

/// How coverage is decided, if not as it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Variant {
    /// Moved by parts of a pixel, 1/256 each: right and down.
    Moved([i32; 2]),
    /// Pixel centres on an edge belong to bottom and right edges, instead of top and left ones.
    BottomRight,
    /// Vertices are snapped with this many bits after the point.
    Bits(u32),
    /// Faces that should be left out are drawn.
    BothFaces,
}

/// Half a pixel.
const HALF: i32 = UNITS / 2;

impl Variant {
    /// Those that are tried.
    pub(super) fn all(options: &Options) -> Vec<Self> {
        let mut all = vec![Self::BottomRight, Self::Bits(12 - options.sub_pixel_bits)];
        let signs = [[1, 1], [-1, -1], [1, -1], [-1, 1], [1, 0], [-1, 0], [0, 1], [0, -1]];
        all.extend(signs.map(|signs| Self::Moved(signs.map(|sign| sign * HALF))));
        if options.cull_face != CullFace::None {
            all.push(Self::BothFaces);
        }
        all
    }

    /// In words, after "as if".
    pub(super) fn name(self) -> String {
        match self {
            Self::Moved([x, y]) => {
                let part = |v: i32, plus: &str, minus: &str| match v {
                    0 => None,
                    v => Some(if v > 0 { plus.to_owned() } else { minus.to_owned() }),
                };
                let ways = [part(x, "right", "left"), part(y, "down", "up")];
                let ways: Vec<String> = ways.into_iter().flatten().collect();
                format!("everything were half a pixel {}", ways.join(" and "))
            }
            Self::BottomRight => "bottom and right edges owned the centres on them".to_owned(),
            Self::Bits(bits) => format!("vertices were snapped to {bits} sub-pixel bits"),
            Self::BothFaces => "no faces were left out".to_owned(),
        }
    }

    /// All fragments, so covered.
    pub(super) fn lists(self, scene: &Scene, options: &Options, front: &FrontEnd) -> Lists<Entry> {
        let format = options.record().depth;
        let drawn = |bits, cull| gather(&FrontEnd::new(scene, front.grid, bits, cull), format);
        match self {
            Self::Bits(bits) => drawn(bits, options.cull_face),
            Self::BothFaces => drawn(options.sub_pixel_bits, CullFace::None),
            Self::BottomRight => {
                let [width, height] = [front.grid.width, front.grid.height];
                // Seen from the other side, top and left edges are bottom and right ones.
                let turn = |v: Snapped| Snapped {
                    x: width as i32 * UNITS - v.x,
                    y: height as i32 * UNITS - v.y,
                    z: v.z,
                };
                redrawn(front, turn, |of, _, [x, y]| {
                    let pixel = [width - 1 - x, height - 1 - y];
                    (pixel, format.encode(of.plane.code(of.plane.at(pixel[0], pixel[1]))))
                })
            }
            Self::Moved([dx, dy]) => {
                let turn = |v: Snapped| Snapped { x: v.x + dx, y: v.y + dy, z: v.z };
                redrawn(front, turn, |_, moved, [x, y]| {
                    ([x, y], format.encode(moved.plane.code(moved.plane.at(x, y))))
                })
            }
        }
    }
}

/// Rasterize the primitives of a front end with other corners. `place` gets the primitive, the one with other corners,
/// and a pixel that this covers, and says which pixel that is, and at which depth.
fn redrawn(
    front: &FrontEnd,
    turn: impl Fn(Snapped) -> Snapped + Sync,
    place: impl Fn(&Primitive, &Primitive, [u32; 2]) -> ([u32; 2], u32) + Sync,
) -> Lists<Entry> {
    let image = front.grid.image();
    let width = front.grid.width;
    let part = |part: &[u32]| {
        let mut found = Vec::new();
        for &index in part {
            let Some(outline) = front.outline(index) else { continue };
            let (primitive, surface) = (front.primitive(index), front.surface(index));
            let corners: Vec<Snapped> = outline.vertices().iter().map(|&v| turn(v)).collect();
            let Setup::Visible(moved) = Primitive::new(&corners, primitive.triangle, image) else {
                continue;
            };
            moved.blocks(image, |x, y, mask| {
                for bit in crate::raster::batch::bits(mask) {
                    let ([x, y], depth) = place(primitive, &moved, [x + bit % 8, y + bit / 8]);
                    if !surface.is_cut(x, y) {
                        let (color, triangle) = (surface.at(x, y), primitive.triangle);
                        found.push((y * width + x, Entry { depth, color, triangle }));
                    }
                }
            });
        }
        found
    };
    let parts: Vec<Vec<(u32, Entry)>> = front.indices().par_chunks(1_024).map(part).collect();
    let mut all = parts.concat();
    all.par_sort_unstable();
    join(&front.grid, &[all])
}
