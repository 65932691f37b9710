//! How often something happens at most that was seen so many times: the upper end of an exact confidence interval for a
//! binomial proportion (Clopper and Pearson, Biometrika 1934), one-sided.

/// The share of such bounds that are too low, at most.
pub const TOO_LOW: f64 = 0.05;

/// Halvings of the interval in which the bound lies: more than an f64 tells apart.
const HALVINGS: u32 = 64;

/// Steps of the continued fraction, at most. It takes about the square root of the number of runs.
const MOST_STEPS: u32 = 100_000;

/// The upper bound of a rate at 95 %, from runs of which so many were hits. Without hits it is about three by the number
/// of runs. It holds for runs that are independent.
#[must_use]
pub fn at_most(hits: u64, runs: u64) -> f64 {
    if hits >= runs {
        return 1.0;
    }
    let (hits, runs) = (hits as f64, runs as f64);
    if hits == 0.0 {
        return -libm::expm1(libm::log(TOO_LOW) / runs);
    }
    // The rate at which so few hits or fewer are as rare as that.
    let (mut low, mut high) = (hits / runs, 1.0);
    for _ in 0..HALVINGS {
        let rate = f64::midpoint(low, high);
        if beta(rate, hits + 1.0, runs - hits) < 1.0 - TOO_LOW {
            low = rate;
        } else {
            high = rate;
        }
    }
    high
}

/// The regularized incomplete beta function: the probability of at least `a` hits in `a + b - 1` runs at the rate `x`.
fn beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    let logarithm = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b)
        + a * libm::log(x)
        + b * libm::log1p(-x);
    let front = libm::exp(logarithm);
    // The fraction converges fast on one side of the mean only.
    if x < (a + 1.0) / (a + b + 2.0) {
        front * fraction(x, a, b) / a
    } else {
        1.0 - front * fraction(1.0 - x, b, a) / b
    }
}

/// Its continued fraction, by Lentz's method.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let away = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / away(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for step in 1..MOST_STEPS {
        let m = f64::from(step);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = value;
        for term in [even, odd] {
            d = 1.0 / away(1.0 + term * d);
            c = away(1.0 + term / c);
            value *= c * d;
        }
        if (value - before).abs() <= value.abs() * f64::EPSILON {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The probability of so many hits or fewer, term by term.
    fn so_few(hits: u64, runs: u64, rate: f64) -> f64 {
        let mut term = libm::exp(runs as f64 * libm::log1p(-rate));
        let mut sum = term;
        for i in 0..hits {
            term *= (runs - i) as f64 / (i + 1) as f64 * rate / (1.0 - rate);
            sum += term;
        }
        sum
    }

    #[test]
    fn so_few_hits_are_as_rare_as_promised_at_the_bound() {
        for (hits, runs) in [(0, 1), (0, 100), (1, 2), (1, 100), (5, 10), (9, 10), (40, 500)] {
            let bound = at_most(hits, runs);
            let rare = so_few(hits, runs, bound);
            assert!((rare - TOO_LOW).abs() < 1e-9, "{hits} of {runs}: {bound}, {rare}");
            // A bound that is a hundredth lower is not one.
            assert!(so_few(hits, runs, bound * 0.99) > TOO_LOW + 1e-4, "{hits} of {runs}");
        }
        assert_eq!([at_most(0, 0), at_most(7, 7)], [1.0; 2]);
    }

    #[test]
    fn without_hits_it_is_three_by_the_runs() {
        for runs in [1_000, 294_912, 100_000_000] {
            let three = at_most(0, runs) * runs as f64;
            assert!((2.99..3.0).contains(&three), "{runs}: {three}");
        }
    }

    /// Published: one-sided 95 % bounds of 1 of 100 and 5 of 10; and with many runs, the normal approximation.
    #[test]
    fn it_is_the_known_bound() {
        assert!((at_most(1, 100) - 0.046_56).abs() < 1e-5, "{}", at_most(1, 100));
        assert!((at_most(5, 10) - 0.777_56).abs() < 1e-5, "{}", at_most(5, 10));
        let (hits, runs) = (100_000.0, 1_000_000.0);
        let normal = 0.1 + 1.644_85 * libm::sqrt(0.1 * 0.9 / runs);
        let found = at_most(hits as u64, runs as u64);
        assert!((found - normal).abs() < 1e-5, "{found}, {normal}");
    }
}
