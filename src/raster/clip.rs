//! From clip space to snapped polygons.
//!
//! Clipping happens only at the near and far planes and at a guard band of ±32,768 pixels, never at the viewport:
//! cutting at the viewport before snapping moves edges (DESIGN: 20,647 sliver pixels changed owner). Each new
//! vertex is computed from (inside, outside) in that order, so that two triangles that share an edge get the same
//! one. Everything is f64 in the order written here; snapping is the only rounding to a grid.

use glam::DVec4;

use crate::num::depth::{self, round_ties_even};

/// Half the guard band in pixels; coordinates after snapping lie within ± this.
pub const GUARD_BAND: i32 = 32_768;

/// Grid units per pixel. With 4 sub-pixel bits, coordinates are multiples of 16 units.
pub const UNITS: i32 = 256;

/// The most vertices of a clipped polygon: eight corners of a disc, and one more for each of six planes.
pub const MAX_VERTICES: usize = 14;

/// The image area and how vertices are snapped to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Viewport {
    /// Pixels across, 1 to 16,384.
    pub width: u32,
    /// Pixels down, 1 to 16,384.
    pub height: u32,
    /// 8 or 4.
    pub sub_pixel_bits: u32,
}

/// A vertex on the grid: x right and y down in units of 1/256 pixel, and a depth code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Snapped {
    /// Within ±`GUARD_BAND` * `UNITS`.
    pub x: i32,
    /// Within ±`GUARD_BAND` * `UNITS`.
    pub y: i32,
    /// 0 to 2^32 - 2.
    pub z: u32,
}

impl Viewport {
    /// Snap a point in pixels to the grid, halves to even, and its depth in 0..1 to a code.
    #[inline]
    #[must_use]
    pub fn snap(&self, x: f64, y: f64, z: f64) -> Snapped {
        Snapped { x: self.snap_axis(x), y: self.snap_axis(y), z: depth::code(z) }
    }

    #[inline]
    fn snap_axis(&self, v: f64) -> i32 {
        let steps = f64::from(1u32 << self.sub_pixel_bits);
        let limit = f64::from(GUARD_BAND) * steps;
        let units = UNITS >> self.sub_pixel_bits;
        round_ties_even((v * steps).clamp(-limit, limit)) as i32 * units
    }

    /// Divide by w and map to pixels: x = (x/w * 0.5 + 0.5) * width, y = (0.5 - y/w * 0.5) * height.
    #[inline]
    fn project(&self, v: DVec4) -> Snapped {
        let x = (v.x / v.w * 0.5 + 0.5) * f64::from(self.width);
        let y = (0.5 - v.y / v.w * 0.5) * f64::from(self.height);
        self.snap(x, y, v.z / v.w)
    }

    /// Signed distances to the clip planes, inside where >= 0: near, far, left, right, top, bottom guard band.
    #[inline]
    fn distances(&self, v: DVec4) -> [f64; 6] {
        let guard = f64::from(GUARD_BAND);
        let (half_w, half_h) = (f64::from(self.width) * 0.5, f64::from(self.height) * 0.5);
        [
            v.z,
            v.w - v.z,
            v.x * half_w + v.w * (guard + half_w),
            v.w * (guard - half_w) - v.x * half_w,
            v.w * (guard + half_h) - v.y * half_h,
            v.y * half_h + v.w * (guard - half_h),
        ]
    }

    /// Where a vertex lies on the screen, if it is inside of all clip planes.
    #[inline]
    #[must_use]
    pub fn place(&self, v: DVec4) -> Option<Snapped> {
        self.distances(v).iter().all(|&d| d >= 0.0).then(|| self.project(v))
    }

    /// Clip a triangle, or another convex polygon, and snap what is left: no vertices (nothing visible), as many as
    /// there were, or up to six more.
    #[must_use]
    pub fn clip<const N: usize>(&self, corners: [DVec4; N]) -> Polygon {
        let placed = corners.map(|v| self.place(v));
        if let Some(polygon) = Polygon::of_placed(placed) {
            return polygon;
        }
        let distances = corners.map(|v| self.distances(v));
        if (0..6).any(|plane| distances.iter().all(|d| d[plane] < 0.0)) {
            return Polygon::default();
        }
        let mut polygon = corners.to_vec();
        for plane in 0..6 {
            polygon = self.cut(&polygon, plane);
        }
        // w = 0 is left only by a perspective with near = 0, which the scene rules out.
        polygon.retain(|v| v.w > 0.0);
        Polygon::new(&polygon.iter().map(|&v| self.project(v)).collect::<Vec<_>>())
    }

    /// Sutherland-Hodgman against one plane.
    fn cut(&self, polygon: &[DVec4], plane: usize) -> Vec<DVec4> {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (da, db) = (self.distances(a)[plane], self.distances(b)[plane]);
            if da >= 0.0 {
                kept.push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                kept.push(if da >= 0.0 { between(a, b, da, db) } else { between(b, a, db, da) });
            }
        }
        kept
    }
}

/// Where the edge from an inside to an outside vertex crosses the plane.
fn between(inside: DVec4, outside: DVec4, d_in: f64, d_out: f64) -> DVec4 {
    let t = d_in / (d_in - d_out);
    inside + (outside - inside) * t
}

/// A clipped, snapped convex polygon of 0 or 3 to 14 vertices (a triangle or an octagon gains at most one per plane).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Polygon {
    vertices: [Snapped; MAX_VERTICES],
    len: usize,
}

impl Polygon {
    /// From vertices in order; fewer than three make it empty, and any beyond [`MAX_VERTICES`] are dropped.
    #[must_use]
    pub fn new(vertices: &[Snapped]) -> Self {
        let mut polygon = Self::default();
        if vertices.len() >= 3 {
            polygon.len = vertices.len().min(MAX_VERTICES);
            polygon.vertices[..polygon.len].copy_from_slice(&vertices[..polygon.len]);
        }
        polygon
    }

    /// From vertices as [`Viewport::place`] gives them, if all are inside.
    #[must_use]
    pub fn of_placed<const N: usize>(placed: [Option<Snapped>; N]) -> Option<Self> {
        let inside = placed.iter().all(Option::is_some);
        inside.then(|| Self::new(&placed.map(Option::unwrap_or_default)))
    }

    /// The vertices in order.
    #[must_use]
    pub fn vertices(&self) -> &[Snapped] {
        &self.vertices[..self.len]
    }

    /// Its fan: (v0, v1, v2), (v0, v2, v3), ...
    pub fn fan(&self) -> impl Iterator<Item = [Snapped; 3]> + '_ {
        fan(self.vertices())
    }

    /// Twice the signed area in square units; above 0 is clockwise on the screen.
    #[must_use]
    pub fn doubled_area(&self) -> i64 {
        doubled_area_of(self.vertices())
    }
}

/// The fan of a convex polygon: (v0, v1, v2), (v0, v2, v3), ...
#[inline]
pub(super) fn fan(v: &[Snapped]) -> impl Iterator<Item = [Snapped; 3]> + '_ {
    (2..v.len()).map(move |i| [v[0], v[i - 1], v[i]])
}

/// Twice the signed area of a convex polygon in square units; above 0 is clockwise on the screen.
#[allow(clippy::inline_always, reason = "three vertices, known to be three, take no loop")]
#[inline(always)]
#[must_use]
pub fn doubled_area_of(vertices: &[Snapped]) -> i64 {
    fan(vertices).map(doubled_area).sum()
}

/// Twice the signed area of a triangle in square units; above 0 is clockwise on the screen (y points down).
#[inline]
#[must_use]
pub fn doubled_area([a, b, c]: [Snapped; 3]) -> i64 {
    let (bx, by) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
    let (cx, cy) = (i64::from(c.x) - i64::from(a.x), i64::from(c.y) - i64::from(a.y));
    bx * cy - by * cx
}
