//! A primitive: everything needed for the coverage and depth of one clipped and snapped triangle.

use pulp::{Scalar, Simd, WithSimd};

use super::clip::{Snapped, UNITS, doubled_area, doubled_area_of, fan};
use super::edge::{Edge, block_mask, edges, touched};
use super::plane::DepthPlane;
use crate::fragment::BLOCK;
use crate::num::lanes::explicit;

/// Half-open pixel rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Rect {
    /// Left column.
    pub x0: u32,
    /// Top row.
    pub y0: u32,
    /// One past the right column.
    pub x1: u32,
    /// One past the bottom row.
    pub y1: u32,
}

impl Rect {
    /// The pixels in both; empty (`x0 >= x1` or `y0 >= y1`) if none.
    #[inline]
    #[must_use]
    pub fn intersect(self, other: Self) -> Self {
        Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }

    /// How many pixels it has.
    #[must_use]
    pub fn pixels(self) -> u64 {
        u64::from(self.x1.saturating_sub(self.x0)) * u64::from(self.y1.saturating_sub(self.y0))
    }

    /// Has no pixels.
    #[inline]
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }
}

/// So many blocks are looked at one by one.
const FEW: u32 = 3;

/// A triangle ready to be rasterized. A clipped one stays a single primitive: its coverage is the sum of its fan's
/// signed coverages, so a pixel gets at most one fragment of it.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// The global triangle index.
    pub triangle: u32,
    /// The pixels of the image whose centres lie in its bounding box.
    pub bounds: Rect,
    /// Depth.
    pub plane: DepthPlane,
    coverage: Coverage,
}

#[derive(Clone, Debug)]
enum Coverage {
    Triangle([Edge; 3]),
    /// The fan's triangles with their sign relative to the whole.
    Fan(Box<[([Edge; 3], i8)]>),
}

/// What becomes of a snapped polygon.
#[derive(Clone, Debug)]
pub enum Setup<P = Primitive> {
    /// It may cover pixels.
    Visible(P),
    /// It lies outside the image, or between pixel centres.
    Nothing,
    /// It has no area.
    Degenerate,
}

impl Primitive {
    /// Set up a convex polygon for an image of the given size.
    #[must_use]
    pub fn new(vertices: &[Snapped], triangle: u32, image: Rect) -> Setup {
        match Self::begin(vertices, triangle, image) {
            Setup::Visible((mut primitive, carrier)) => {
                primitive.finish(carrier);
                Setup::Visible(primitive)
            }
            Setup::Nothing => Setup::Nothing,
            Setup::Degenerate => Setup::Degenerate,
        }
    }

    /// The first half: all but its plane and the edges of a triangle; with the carrier of its plane. There are two
    /// halves since the second is one long chain of multiplications, of which a loop that does nothing else works at
    /// several at once.
    #[allow(clippy::inline_always, reason = "three vertices, known to be three, take no loop")]
    #[inline(always)]
    pub(super) fn begin(
        vertices: &[Snapped],
        triangle: u32,
        image: Rect,
    ) -> Setup<(Self, [Snapped; 3])> {
        if vertices.is_empty() {
            return Setup::Nothing;
        }
        let area = doubled_area_of(vertices);
        if area == 0 {
            return Setup::Degenerate;
        }
        let bounds = bounds(vertices, image);
        if bounds.is_empty() {
            return Setup::Nothing;
        }
        let Some((plane, carrier)) = DepthPlane::begin(vertices) else { return Setup::Degenerate };
        let coverage = Coverage::begin(vertices, area);
        Setup::Visible((Self { triangle, bounds, plane, coverage }, carrier))
    }

    /// The second half.
    #[inline]
    pub(super) fn finish(&mut self, carrier: [Snapped; 3]) {
        self.plane.finish(carrier);
        if let Coverage::Triangle(own) = &mut self.coverage {
            *own = edges(carrier);
        }
    }

    /// All of it as text, with its place among the visible ones, for fingerprints that must not change.
    #[must_use]
    pub fn text(&self, place: usize) -> String {
        let Self { triangle, bounds, plane, coverage } = self;
        format!(
            "Primitive {{ triangle: {triangle}, bounds: {bounds:?}, plane: {plane:?}, \
             surface: {place}, coverage: {coverage:?} }}"
        )
    }

    /// Call `emit(x, y, mask)` for every block with covered pixels in `window`, row by row. Blocks are 8x8 and lie on
    /// multiples of 8.
    pub fn blocks(&self, window: Rect, emit: impl FnMut(u32, u32, u64)) {
        explicit(Blocks { primitive: self, window, emit });
    }

    /// The same, with the machine's vectors.
    #[allow(clippy::inline_always, reason = "see `lanes`")]
    #[inline(always)]
    pub(super) fn each_block<S: Simd>(
        &self,
        simd: S,
        window: Rect,
        mut emit: impl FnMut(u32, u32, u64),
    ) {
        let area = self.bounds.intersect(window);
        if area.is_empty() {
            return;
        }
        let (left, right) = (area.x0 / BLOCK, area.x1.div_ceil(BLOCK));
        let (top, bottom) = (area.y0 / BLOCK, area.y1.div_ceil(BLOCK));
        // Row by row: more than 8 blocks across, the blocks of one row at a time.
        let tall = if right - left <= 8 { 8 } else { 1 };
        let mut row = top;
        while row < bottom {
            let rows = (bottom - row).min(tall);
            let mut column = left;
            while column < right {
                let columns = (right - column).min(8);
                let mut touched = (0xFF >> (8 - columns)) * 0x0101_0101_0101_0101;
                touched &= u64::MAX >> (64 - 8 * rows);
                if rows * columns > FEW {
                    touched &= self.touched(simd, BLOCK * column, BLOCK * row);
                }
                while touched != 0 {
                    let bit = touched.trailing_zeros();
                    touched &= touched - 1;
                    let (x, y) = (BLOCK * (column + bit % 8), BLOCK * (row + bit / 8));
                    let mask = self.mask(simd, x, y) & rows_mask(y, area) & columns_mask(x, area);
                    if mask != 0 {
                        emit(x, y, mask);
                    }
                }
                column += columns;
            }
            row += rows;
        }
    }

    /// Which of the 8x8 blocks from (x, y) on may have covered pixels: bit `8 * row + column`.
    #[allow(clippy::inline_always, reason = "as above")]
    #[inline(always)]
    fn touched<S: Simd>(&self, simd: S, x: u32, y: u32) -> u64 {
        match &self.coverage {
            Coverage::Triangle(edges) => touched(simd, edges, x, y),
            Coverage::Fan(_) => u64::MAX,
        }
    }

    /// Covered pixels of the block whose first pixel is (x, y), both multiples of 8, within `bounds`.
    #[allow(clippy::inline_always, reason = "as above")]
    #[inline(always)]
    fn mask<S: Simd>(&self, simd: S, x: u32, y: u32) -> u64 {
        match &self.coverage {
            Coverage::Triangle(edges) => block_mask(simd, edges, x, y),
            Coverage::Fan(fan) => fan_mask(fan, x, y),
        }
    }
}

/// The blocks of one primitive.
struct Blocks<'a, F> {
    primitive: &'a Primitive,
    window: Rect,
    emit: F,
}

impl<F: FnMut(u32, u32, u64)> WithSimd for Blocks<'_, F> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "as above")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.primitive.each_block(simd, self.window, self.emit);
    }
}

impl Coverage {
    #[allow(clippy::inline_always, reason = "as above")]
    #[inline(always)]
    fn begin(vertices: &[Snapped], area: i64) -> Self {
        if vertices.len() == 3 {
            return Self::Triangle(Default::default());
        }
        let signed = |t| match doubled_area(t) {
            0 => None,
            part => Some((edges(t), (part.signum() * area.signum()) as i8)),
        };
        Self::Fan(fan(vertices).filter_map(signed).collect())
    }
}

/// Pixels whose signed coverages sum to more than 0.
#[inline(never)]
fn fan_mask(fan: &[([Edge; 3], i8)], x: u32, y: u32) -> u64 {
    let mut sums = [0i8; 64];
    for (edges, sign) in fan {
        let mask = block_mask(Scalar::new(), edges, x, y);
        for (bit, sum) in sums.iter_mut().enumerate() {
            *sum += sign * ((mask >> bit) & 1) as i8;
        }
    }
    sums.iter().enumerate().fold(0, |mask, (bit, &sum)| mask | (u64::from(sum > 0) << bit))
}

/// The rows of the block at `y` that lie in the rectangle.
#[inline]
fn rows_mask(y: u32, area: Rect) -> u64 {
    let first = area.y0.saturating_sub(y);
    let last = (area.y1 - y).min(BLOCK);
    (u64::MAX << (8 * first)) & (u64::MAX >> (64 - 8 * last))
}

/// The columns of the block at `x` that lie in the rectangle.
#[inline]
fn columns_mask(x: u32, area: Rect) -> u64 {
    let first = area.x0.saturating_sub(x);
    let last = (area.x1 - x).min(BLOCK);
    let row = (0xFFu64 << first) & (0xFF >> (8 - last));
    row * 0x0101_0101_0101_0101
}

/// The pixels whose centres lie in the polygon's bounding box.
#[allow(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn bounds(vertices: &[Snapped], image: Rect) -> Rect {
    let x = vertices.iter().map(|v| v.x);
    let y = vertices.iter().map(|v| v.y);
    // The first centre at or right of a coordinate, and one past the last at or left of it.
    let first = |v: Option<i32>| (v.unwrap_or(0) + UNITS / 2 - 1).div_euclid(UNITS).max(0) as u32;
    let past = |v: Option<i32>| ((v.unwrap_or(0) + UNITS / 2).div_euclid(UNITS)).max(0) as u32;
    Rect {
        x0: first(x.clone().min()),
        y0: first(y.clone().min()),
        x1: past(x.max()),
        y1: past(y.max()),
    }
    .intersect(image)
}
