//! The z-thickness model: what slabs look like when they are cut and put together ("Fragment merging with z-thickness",
//! section 3).
//!
//! A fragment is a slab of a homogeneous medium that reaches from its depth towards the eye. Its visibility is its
//! colour, multiplied by the opacity, with the opacity. All of it is f64 in the order written, with `libm`; nothing is
//! rounded to fewer bits on the way.
//!
//! * Cut: up to the share t of its thickness, a slab of opacity A lets through as equation (4) says, A(t) = β t A + (1 -
//!   β)(1 - (1 - A)^t), with the colour in proportion (3). A part between two shares is what lies up to the second less
//!   what lies up to the first, divided by what the first lets through (5), so that the parts over each other are the
//!   slab again. Both cuts of a slab in three are measured on the whole slab.
//! * Mix: what overlaps wholly contributes by its own sum of opacities, whatever the order (6 to 8). When a slab is cut,
//!   its sum is divided by what each part adds to the opacity of the whole. (Divided by the parts' own opacities, a part
//!   of an opaque slab that is a thousandth as thick would count as much as the rest, and two opaque surfaces one depth
//!   code apart would be mixed two to one: claim C16 would not hold.)
//! * Over: one in front of the other.
//!
//! Slabs that touch do not overlap, so one of thickness 0 overlaps nothing. An opacity of 1 has no inside: where a slab
//! is cut, its opacity counts as at most [`OPAQUE`].

use super::Blending;

/// The largest opacity of what is cut: what lies behind is less than half of what 16 bits of transmittance can show.
pub const OPAQUE: f64 = 1.0 - 1.0 / 131_072.0;

/// Colour, multiplied by the opacity, and opacity: each 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Visibility {
    /// Red, green and blue.
    pub color: [f64; 3],
    /// The share of light that is stopped.
    pub opacity: f64,
}

/// A slab.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slab {
    /// Distance of its near end from the eye, at most `far`.
    pub near: f64,
    /// Distance of its far end: of the surface.
    pub far: f64,
    /// What it looks like.
    pub visibility: Visibility,
    /// The sum of the opacities that were put into it (`Asum`).
    pub sum: f64,
    /// The depth word of its far end.
    pub depth: u32,
    /// Fragments that it stands for.
    pub weight: f64,
}

impl Visibility {
    /// From four components.
    #[must_use]
    pub fn new([r, g, b, opacity]: [f64; 4]) -> Self {
        Self { color: [r, g, b], opacity }
    }

    /// As four components.
    #[must_use]
    pub fn rgba(self) -> [f64; 4] {
        let [r, g, b] = self.color;
        [r, g, b, self.opacity]
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { color: self.color.map(&f), opacity: f(self.opacity) }
    }

    /// The same colour at most [`OPAQUE`].
    fn clamped(self) -> Self {
        if self.opacity > OPAQUE {
            let kept = OPAQUE / self.opacity;
            Self { color: self.color.map(|c| c * kept), opacity: OPAQUE }
        } else {
            self
        }
    }

    /// In front of another.
    #[must_use]
    pub fn over(self, back: Self) -> Self {
        let through = 1.0 - self.opacity;
        Self {
            color: std::array::from_fn(|i| self.color[i] + through * back.color[i]),
            opacity: self.opacity + through * back.opacity,
        }
    }

    /// The opacity up to a share of the thickness, 0 to 1 (equation 4).
    #[must_use]
    pub fn opacity_to(self, share: f64, beta: f64) -> f64 {
        if share <= 0.0 {
            return 0.0;
        }
        if share >= 1.0 {
            return self.opacity;
        }
        let even = share * self.opacity;
        if beta >= 1.0 {
            return even;
        }
        let optical = 1.0 - libm::pow(1.0 - self.opacity, share);
        beta * even + (1.0 - beta) * optical
    }

    /// What lies between two shares of the thickness, 0 to 1 (equations 3 and 5).
    #[must_use]
    pub fn between(self, from: f64, to: f64, beta: f64) -> Self {
        let whole = self.clamped();
        if whole.opacity <= 0.0 {
            return Self::default();
        }
        let [before, behind] = [from, to].map(|share| whole.opacity_to(share, beta));
        let opacity = (behind - before) / (1.0 - before);
        let scale = opacity / whole.opacity;
        whole.map(|c| c * scale).with_opacity(opacity)
    }

    fn with_opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

/// What fills the same interval: two visibilities, each with its sum of opacities (equations 6 to 8).
#[must_use]
pub fn mix((a, a_sum): (Visibility, f64), (b, b_sum): (Visibility, f64)) -> Visibility {
    let opacity = 1.0 - (1.0 - a.opacity) * (1.0 - b.opacity);
    let sum = a_sum + b_sum;
    if sum <= 0.0 {
        return Visibility { color: [0.0; 3], opacity };
    }
    let part = |v: Visibility, sum: f64, i: usize| {
        if v.opacity > 0.0 { v.color[i] / v.opacity * sum } else { 0.0 }
    };
    let color = |i: usize| (part(a, a_sum, i) + part(b, b_sum, i)) / sum * opacity;
    Visibility { color: std::array::from_fn(color), opacity }
}

impl Slab {
    /// Whether both fill a part of the ray together. Slabs that touch do not, unless `closed`.
    #[must_use]
    pub fn overlaps(&self, other: &Self, closed: bool) -> bool {
        let (from, to) = (self.near.max(other.near), self.far.min(other.far));
        from < to || (closed && from <= to)
    }

    /// Where a distance lies in the slab, 0 to 1 from its near end.
    fn share(&self, distance: f64) -> f64 {
        let length = self.far - self.near;
        if length > 0.0 { ((distance - self.near) / length).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Its parts in front of `from`, from there to `to`, and behind, each with its part of the sum of opacities.
    fn cut(&self, from: f64, to: f64, blending: &Blending) -> [(Visibility, f64); 3] {
        let [from, to] = [self.share(from), self.share(to)].map(|share| blending.faulty(share));
        let beta = blending.beta;
        // The released shaders use beta on the front part alone, and equation (2) on what is left.
        let rest = if blending.front_only { 0.0 } else { beta };
        let parts = [
            self.visibility.between(0.0, from, beta),
            self.visibility.between(from, to, if from > 0.0 { rest } else { beta }),
            self.visibility.between(to, 1.0, rest),
        ];
        // What each part adds to the opacity of the whole: the thinner it is, the less it counts.
        let whole = self.visibility.clamped();
        let [before, behind] = [from, to].map(|share| whole.opacity_to(share, beta));
        let adds = [before, behind - before, whole.opacity - behind];
        let part =
            |adds: f64| if whole.opacity > 0.0 { self.sum * (adds / whole.opacity) } else { 0.0 };
        std::array::from_fn(|i| (blending.stored(parts[i]), part(adds[i])))
    }

    /// What lies between two distances, with its part of the sum of opacities; the cuts are measured on the whole slab.
    #[must_use]
    pub fn part(&self, from: f64, to: f64, blending: &Blending) -> (Visibility, f64) {
        self.cut(from, to, blending)[1]
    }

    /// Smooth merging (section 3.2.1): this one and another that overlaps it and is not nearer, as one.
    #[must_use]
    pub fn smooth(&self, next: &Self, blending: &Blending) -> Self {
        let (from, to) = (self.near.max(next.near), self.far.min(next.far));
        let [front, middle, _] = self.cut(from, to, blending);
        let [next_front, next_middle, back] = next.cut(from, to, blending);
        let front = if self.near < next.near { front } else { next_front };
        let middle = blending.stored(mix(middle, next_middle));
        let visibility = blending.stored(front.0.over(middle).over(back.0));
        self.joined(next, visibility)
    }

    /// One in front of the other as one, where there is no room for both (Algorithm 1, lines 15 to 18).
    #[must_use]
    pub fn tail(&self, next: &Self, blending: &Blending) -> Self {
        let visibility = if blending.mixed_tail {
            mix((self.visibility, self.sum), (next.visibility, next.sum))
        } else {
            self.visibility.over(next.visibility)
        };
        self.joined(next, blending.stored(visibility))
    }

    /// Both, wherever they lie, as one of this visibility.
    fn joined(&self, next: &Self, visibility: Visibility) -> Self {
        Self {
            near: self.near.min(next.near),
            far: self.far.max(next.far),
            visibility,
            sum: self.sum + next.sum,
            depth: self.depth.max(next.depth),
            weight: self.weight + next.weight,
        }
    }
}

/// Algorithm 1: slabs, sorted by their far ends, become at most `most` (at least 1), in one pass. What overlaps the slab
/// in hand is merged into it; what does not takes its place, while there is room; then it is put behind it.
///
/// As printed, line 20 assigns the merged slab to an array that is not there: it is the slab in hand, `f_i`, which the
/// next iteration goes on with.
pub fn merge_sorted(
    slabs: impl IntoIterator<Item = Slab>,
    most: usize,
    blending: &Blending,
    out: &mut Vec<Slab>,
) {
    let mut slabs = slabs.into_iter();
    let Some(mut hand) = slabs.next() else { return };
    let begin = out.len();
    for next in slabs {
        if hand.overlaps(&next, blending.closed) {
            hand = hand.smooth(&next, blending);
        } else if out.len() - begin + 1 < most {
            out.push(hand);
            hand = next;
        } else {
            hand = hand.tail(&next, blending);
        }
    }
    out.push(hand);
}
