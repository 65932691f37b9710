//! Polygons of any outline become triangles.
//!
//! A polygon is looked at along the axis that its Newell normal lies nearest to, by leaving out one coordinate, which
//! keeps the others exact. One that is convex there is cut into a fan from its first corner. Any other one goes to an
//! ear cutter, whose triangles are turned to the polygon's own side. The ear cutter leaves out corners on straight lines;
//! the triangles beside them are split there, so that all of them share whole edges and no pixel is drawn twice or not
//! at all. Where the outline, looked at like that, crosses itself, or a corner would be lost that is off the line of its
//! neighbours in space, it is a fan: it keeps every edge, so that what is closed stays closed.

use std::ops::Range;

use earcut::Earcut;
use glam::DVec3;

/// A corner in the plane that is looked at.
type Flat = [f64; 2];

/// How far a corner may be from a line to lie on it, as a share of the line's length.
const NEAR: f64 = 1e-12;

/// How much the triangles' area may differ from the polygon's, as a share.
const SAME: f64 = 1e-9;

/// The most corners that are looked at as more than a fan.
const MOST: usize = 1 << 17;

/// Cuts polygons into triangles, with memory that is used again.
pub(in crate::scene) struct Cutter {
    ears: Earcut<f64>,
    flat: Vec<Flat>,
    found: Vec<u32>,
}

impl Default for Cutter {
    fn default() -> Self {
        Self { ears: Earcut::new(), flat: Vec::new(), found: Vec::new() }
    }
}

impl Cutter {
    /// The triangles of a polygon as places in its list of corners, each turning as the polygon does; and whether they
    /// cover it once. They need not where the outline crosses itself, or has more corners than [`MOST`].
    pub(in crate::scene) fn cut(&mut self, corners: &[[f64; 3]]) -> (Vec<[u32; 3]>, bool) {
        let count = corners.len() as u32;
        let fan = || (2..count).map(|i| [0, i - 1, i]).collect();
        if corners.len() <= 3 || corners.len() > MOST {
            return (fan(), corners.len() <= 3);
        }
        // Without a side that it faces it is a line, or crosses itself.
        let Some([u, v]) = plane(corners) else {
            let flat = fan().iter().all(|t: &[u32; 3]| !has_area(t.map(|i| corners[i as usize])));
            return (fan(), flat);
        };
        let first = corners[0];
        self.flat.clear();
        self.flat.extend(corners.iter().map(|c| [c[u] - first[u], c[v] - first[v]]));
        if is_convex(&self.flat) {
            return (fan(), true);
        }
        self.ears.earcut(self.flat.iter().copied(), &[], &mut self.found);
        let whole = doubled_area(&self.flat);
        let mut triangles = Vec::with_capacity(corners.len() - 2);
        for &[a, b, c] in self.found.as_chunks().0 {
            let turn = turn(self.flat[a as usize], self.flat[b as usize], self.flat[c as usize]);
            triangles.push(if (turn < 0.0) == (whole < 0.0) { [a, b, c] } else { [a, c, b] });
        }
        self.split(&mut triangles);
        let covered: f64 = triangles.iter().map(|&t| self.turn(t).abs()).sum();
        let same = (covered - whole.abs()).abs() <= SAME * whole.abs();
        let whole = same && !triangles.is_empty() && !loses(corners, &triangles);
        if whole { (triangles, true) } else { (fan(), false) }
    }

    fn turn(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|i| self.flat[i as usize]);
        turn(a, b, c)
    }

    /// Splits triangles on whose edges corners lie that no triangle has.
    fn split(&self, triangles: &mut Vec<[u32; 3]>) {
        if triangles.len() + 2 >= self.flat.len() {
            return;
        }
        let mut used = vec![false; self.flat.len()];
        triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
        for (q, _) in (0..).zip(&used).filter(|(_, used)| !**used) {
            let mut i = 0;
            while i < triangles.len() {
                let at = |[a, b, _]: &[u32; 3]| self.is_between(*a, q, *b);
                let [a, b, c] = triangles[i];
                if let Some([a, b, c]) = [[a, b, c], [b, c, a], [c, a, b]].into_iter().find(at) {
                    triangles[i] = [a, q, c];
                    triangles.push([q, b, c]);
                }
                i += 1;
            }
        }
    }

    /// Whether a corner lies between two others on their line.
    fn is_between(&self, a: u32, q: u32, b: u32) -> bool {
        let [a, q, b] = [a, q, b].map(|i| self.flat[i as usize]);
        let (along, to) = ([b[0] - a[0], b[1] - a[1]], [q[0] - a[0], q[1] - a[1]]);
        let square = along[0] * along[0] + along[1] * along[1];
        let far = (along[0] * to[1] - along[1] * to[0]).abs();
        let share = (along[0] * to[0] + along[1] * to[1]) / square;
        let inside: Range<f64> = f64::MIN_POSITIVE..1.0;
        far <= NEAR * square && inside.contains(&share)
    }
}

/// Whether triangles leave out a corner that is off the line of its neighbours in space.
fn loses(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> bool {
    if triangles.len() + 2 >= corners.len() {
        return false;
    }
    let mut used = vec![false; corners.len()];
    triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    let count = corners.len();
    let lost = |i: usize| {
        let three = [count - 1, 0, 1].map(|step| corners[(i + step) % count]);
        !used[i] && has_area(three)
    };
    (0..count).any(lost)
}

/// Whether three places are no line.
fn has_area([a, b, c]: [[f64; 3]; 3]) -> bool {
    let [p, q] = [b, c].map(|end| DVec3::from(end) - DVec3::from(a));
    let longest = p.length().max(q.length());
    p.cross(q).length() > NEAR * (longest * longest)
}

/// The direction that a polygon faces, as long as twice its area.
fn newell(corners: &[[f64; 3]]) -> [f64; 3] {
    let first = corners.first().copied().unwrap_or_default();
    let at = |i: usize| {
        let c = corners[i % corners.len()];
        [c[0] - first[0], c[1] - first[1], c[2] - first[2]]
    };
    let mut sum = [0.0; 3];
    for i in 0..corners.len() {
        let (a, b) = (at(i), at(i + 1));
        for (axis, sum) in sum.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += a[u] * b[v] - a[v] * b[u];
        }
    }
    sum
}

/// The two axes to look at, so that what turns anticlockwise stays so or not, but alike for all corners.
fn plane(corners: &[[f64; 3]]) -> Option<[usize; 2]> {
    let size = newell(corners).map(f64::abs);
    let axis = (0..3).fold(2, |best, axis| if size[axis] > size[best] { axis } else { best });
    (size[axis] > 0.0 && size[axis].is_finite()).then_some([(axis + 1) % 3, (axis + 2) % 3])
}

/// Whether a fan from the first corner covers a polygon: it turns to one side only, and so do the fan's triangles.
fn is_convex(flat: &[Flat]) -> bool {
    let (mut left, mut right) = (false, false);
    let mut note = |turn: f64| {
        left |= turn > 0.0;
        right |= turn < 0.0;
    };
    for i in 0..flat.len() {
        let [b, c] = [1, 2].map(|next| flat[(i + next) % flat.len()]);
        note(turn(flat[i], b, c));
        note(turn(flat[0], flat[i], b));
    }
    !(left && right)
}

/// Twice the area of a triangle, above 0 where it turns anticlockwise.
fn turn(a: Flat, b: Flat, c: Flat) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn doubled_area(flat: &[Flat]) -> f64 {
    flat.windows(2).map(|pair| turn(flat[0], pair[0], pair[1])).sum()
}
