//! Transmittance from power moments (Münstermann, Krumpen, Klein, Peters, "Moment-based order-independent
//! transparency", PACMCGIT 1(1), 2018): the Hamburger moment problem with an overestimation weight.
//!
//! Of a pixel's absorbance A(u), u from -1 to 1, are known `b_0` = Σ A and `b_j` = Σ A u^j. Wanted is how much lies in front
//! of u. With b' = (1 - ε) b / `b_0` + ε β (the biased moments):
//!
//! 1. H c = (1, u, .., u^h), H the Hankel matrix of b', h = m / 2; by L D Lᵀ.
//! 2. The h roots of `c_0` + `c_1` x + .. + `c_h` x^h and u itself are the nodes of a quadrature.
//! 3. f is 1 at nodes before u, 0 at nodes behind it, and the overestimation at u.
//! 4. p is the polynomial through (node, f), by divided differences; T = exp(-b_0 Σ `p_j` b'_j), at most 1.
//!
//! The roots are real where H is positive definite. In f64 the bias makes it so; in f32 it does not always, and then
//! the published form gives what is no number. With [`Guard::Clamped`], what rounding makes complex counts as a double
//! root, and a leading coefficient of 0 as a root very far away.
//!
//! The paper solves cubics and quartics in closed form. Here a root is looked for between the roots of the derivative,
//! by Newton's steps that must stay in between: the same roots, without trigonometry.

/// The most moments.
pub const MOST: usize = 8;

/// The weight of the node at u itself (the paper's 4.2).
pub const OVERESTIMATION: f64 = 0.25;

/// The bias of single precision, and its vector: what moments are drawn towards.
#[must_use]
pub fn bias(moments: u32) -> (f64, [f64; MOST]) {
    match moments {
        6 => (5e-6, [0.0, 0.48, 0.0, 0.451, 0.0, 0.45, 0.0, 0.0]),
        8 => (5e-5, [0.0, 0.75, 0.0, 0.676_67, 0.0, 0.63, 0.0, 0.603_30]),
        _ => (5e-7, [0.0, 0.375, 0.0, 0.375, 0.0, 0.0, 0.0, 0.0]),
    }
}

/// What is done where rounding leaves the solution without real roots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// The nearest real ones are taken.
    Clamped,
    /// Nothing, as published: the result is no number.
    Published,
}

/// f32 or f64.
pub trait Real:
    Copy
    + PartialOrd
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
    + std::ops::Neg<Output = Self>
{
    /// The nearest number of this precision.
    fn of(x: f64) -> Self;
    /// The square root.
    #[must_use]
    fn root(self) -> Self;
    /// Without its sign.
    #[must_use]
    fn size(self) -> Self;
}

macro_rules! real {
    ($($type:ty)*) => {$(
        impl Real for $type {
            #[inline]
            fn of(x: f64) -> Self {
                x as $type
            }

            #[inline]
            fn root(self) -> Self {
                self.sqrt()
            }

            #[inline]
            fn size(self) -> Self {
                self.abs()
            }
        }
    )*};
}

real! { f32 f64 }

/// Coefficients of a polynomial, lowest first; or one number for each node.
type Row<R> = [R; 5];

/// The logarithm of the transmittance at `u`, at most 0, from `b_0` and the `b_j` / `b_0` (without bias): 4, 6 or 8 of them
/// count, as `moments` says.
#[must_use]
pub fn log_transmittance<R: Real>(
    whole: R,
    normalised: &[R; MOST],
    moments: u32,
    u: R,
    guard: Guard,
) -> R {
    let (epsilon, vector) = bias(moments);
    let keep = R::of(1.0 - epsilon);
    let mut biased = [R::of(1.0); MOST + 1];
    for (i, b) in biased[1..].iter_mut().enumerate() {
        *b = keep * normalised[i] + R::of(epsilon * vector[i]);
    }
    let share = match moments {
        6 => share::<R, 3>(&biased, u, guard),
        8 => share::<R, 4>(&biased, u, guard),
        _ => share::<R, 2>(&biased, u, guard),
    };
    let log = -(whole * share);
    // Also where it is no number: `if log > 0` leaves that as it is.
    if log > R::of(0.0) { R::of(0.0) } else { log }
}

/// The share of all absorbance that counts in front of `u`.
fn share<R: Real, const H: usize>(b: &[R; MOST + 1], u: R, guard: Guard) -> R {
    let zero = R::of(0.0);
    let mut nodes = [u; 5];
    let found = match (guard, H) {
        (Guard::Published, 2) => published(b, u),
        _ => roots::<R>(&solve::<R, H>(b, u), H, guard),
    };
    nodes[1..=H].copy_from_slice(&found[..H]);
    let mut values = [R::of(OVERESTIMATION); 5];
    for i in 1..=H {
        values[i] = if nodes[i] < u { R::of(1.0) } else { zero };
    }
    // Divided differences, in place.
    for order in 1..=H {
        for i in (order..=H).rev() {
            let apart = nodes[i] - nodes[i - order];
            let rise = values[i] - values[i - 1];
            let same = guard == Guard::Clamped && apart.size() <= zero;
            values[i] = if same { zero } else { rise / apart };
        }
    }
    // From Newton's form to powers.
    let mut p = [zero; 5];
    p[0] = values[H];
    for i in (0..H).rev() {
        for j in (1..=H).rev() {
            p[j] = p[j - 1] - nodes[i] * p[j];
        }
        p[0] = values[i] - nodes[i] * p[0];
    }
    (0..=H).fold(zero, |sum, j| sum + p[j] * b[j])
}

/// The nodes of four moments, operation by operation as published (algorithm 2). On one layer the leading coefficient
/// is 0 up to rounding, and where it is 0 the roots are no numbers.
fn published<R: Real>(b: &[R; MOST + 1], u: R) -> Row<R> {
    let [_, b1, b2, b3, b4, ..] = *b;
    let l = b3 - b1 * b2;
    let d1 = b2 - b1 * b1;
    let ratio = l / d1;
    let d2 = (b4 - b2 * b2) - l * ratio;
    let (mut c0, mut c1, mut c2) = (R::of(1.0), u, u * u);
    c1 = c1 - b1;
    c2 = c2 - (b2 + ratio * c1);
    c1 = c1 / d1;
    c2 = c2 / d2;
    c1 = c1 - ratio * c2;
    c0 = c0 - (b1 * c1 + b2 * c2);
    let (p, q) = (c1 / c2, c0 / c2);
    let half = p * R::of(0.5);
    let root = (half * half - q).root();
    let zero = R::of(0.0);
    [-half - root, root - half, zero, zero, zero]
}

/// H c = (1, u, .., u^h), by L D Lᵀ.
fn solve<R: Real, const H: usize>(b: &[R; MOST + 1], u: R) -> Row<R> {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    let mut l = [[zero; 5]; 5];
    let mut d = [one; 5];
    for j in 0..=H {
        let mut pivot = b[2 * j];
        for k in 0..j {
            pivot = pivot - l[j][k] * l[j][k] * d[k];
        }
        d[j] = pivot;
        for i in j + 1..=H {
            let mut entry = b[i + j];
            for k in 0..j {
                entry = entry - l[i][k] * l[j][k] * d[k];
            }
            l[i][j] = entry / pivot;
        }
    }
    let mut c = [one; 5];
    for i in 1..=H {
        c[i] = c[i - 1] * u;
    }
    for i in 0..=H {
        for k in 0..i {
            c[i] = c[i] - l[i][k] * c[k];
        }
    }
    for i in 0..=H {
        c[i] = c[i] / d[i];
    }
    for i in (0..=H).rev() {
        for k in i + 1..=H {
            c[i] = c[i] - l[k][i] * c[k];
        }
    }
    c
}

/// The roots of a polynomial of degree 2, 3 or 4, all of which are taken to be real; in ascending order.
fn roots<R: Real>(c: &Row<R>, degree: usize, guard: Guard) -> Row<R> {
    let zero = R::of(0.0);
    let mut c = *c;
    if guard == Guard::Clamped {
        let largest =
            c[..degree].iter().fold(zero, |most, c| if c.size() > most { c.size() } else { most });
        let least = largest * R::of(1e-18);
        if c[degree].size() < least {
            c[degree] = if c[degree] < zero { -least } else { least };
        }
    }
    if degree == 2 {
        return quadratic(&c, guard);
    }
    let mut derivative = [zero; 5];
    for i in 1..=degree {
        derivative[i - 1] = c[i] * R::of(i as f64);
    }
    let turns = roots(&derivative, degree - 1, guard);
    // Cauchy's bound.
    let most = c[..degree].iter().fold(zero, |most, x| {
        let x = (*x / c[degree]).size();
        if x > most { x } else { most }
    });
    let bound = most + R::of(1.0);
    let mut found = [zero; 5];
    for i in 0..degree {
        let from = if i == 0 { -bound } else { turns[i - 1] };
        let to = if i + 1 == degree { bound } else { turns[i] };
        found[i] = between(&c, degree, from, to);
    }
    found
}

/// Both roots of a quadratic, without cancellation.
fn quadratic<R: Real>(c: &Row<R>, guard: Guard) -> Row<R> {
    let zero = R::of(0.0);
    let half = c[1] / c[2] * R::of(0.5);
    let constant = c[0] / c[2];
    let mut square = half * half - constant;
    if guard == Guard::Clamped && square < zero {
        square = zero;
    }
    let root = square.root();
    let far = if half > zero { -(half + root) } else { root - half };
    let near = if far.size() > zero { constant / far } else { zero };
    let (low, high) = if far < near { (far, near) } else { (near, far) };
    [low, high, zero, zero, zero]
}

/// The most steps to a root.
const STEPS: usize = 128;

/// The value and the slope of a polynomial.
fn at<R: Real>(c: &Row<R>, degree: usize, x: R) -> (R, R) {
    let (mut value, mut slope) = (c[degree], R::of(0.0));
    for i in (0..degree).rev() {
        slope = slope * x + value;
        value = value * x + c[i];
    }
    (value, slope)
}

/// The root between two places where the polynomial has different signs; where it has not, the place where it is nearer
/// to 0.
fn between<R: Real>(c: &Row<R>, degree: usize, from: R, to: R) -> R {
    let zero = R::of(0.0);
    let (mut low, mut high) = (from, to);
    let (first, last) = (at(c, degree, low).0, at(c, degree, high).0);
    if (first > zero) == (last > zero) {
        return if first.size() < last.size() { low } else { high };
    }
    let rises = last > first;
    let mut x = (low + high) * R::of(0.5);
    for _ in 0..STEPS {
        let (value, slope) = at(c, degree, x);
        if (value > zero) == rises {
            high = x;
        } else {
            low = x;
        }
        let mut next = x - value / slope;
        // Also where the slope is 0.
        if !(next > low && next < high) {
            next = (low + high) * R::of(0.5);
        }
        if next == x || next == low || next == high {
            return next;
        }
        // A step that no longer changes the lower half of the digits is the last: Newton's steps double them.
        let small = (next - x).size() <= x.size() * R::of(1e-9);
        x = next;
        if small {
            return x;
        }
    }
    x
}
