//! Eigenvectors of a symmetric 3x3 matrix by Jacobi's rotations, in f64, in a fixed order and number.

use glam::DVec3;

/// Each sweep squares what is off the diagonal: six are far beyond f64's precision.
const SWEEPS: usize = 8;

/// The unit eigenvector of the smallest eigenvalue; the first axis's, on a tie. Rows and columns that are 0 off the
/// diagonal stay exactly as they are.
pub(super) fn least(mut m: [[f64; 3]; 3]) -> DVec3 {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut m, &mut vectors, p, q);
        }
    }
    let mut least = 0;
    for i in 1..3 {
        if m[i][i] < m[least][least] {
            least = i;
        }
    }
    DVec3::from(std::array::from_fn(|row| vectors[row][least]))
}

/// Makes the element (p, q) zero (Golub and Van Loan, "Matrix Computations", 8.5.2).
fn rotate(m: &mut [[f64; 3]; 3], vectors: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if m[p][q] == 0.0 {
        return;
    }
    let tau = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
    let root = (1.0 + tau * tau).sqrt();
    let t = if tau >= 0.0 { 1.0 / (tau + root) } else { -1.0 / (root - tau) };
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = t * c;
    for row in &mut *m {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    let (a, b) = (m[p], m[q]);
    m[p] = std::array::from_fn(|i| c * a[i] - s * b[i]);
    m[q] = std::array::from_fn(|i| s * a[i] + c * b[i]);
    (m[p][q], m[q][p]) = (0.0, 0.0);
    for row in vectors {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R diag R^T, for the rotation with rows of 2/3, -1/3, 2/3 and so on.
    #[test]
    fn the_least_axis_is_found() {
        let axes =
            [[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]].map(|r| r.map(|c| c / 3.0));
        for values in [[5.0, 1.0, 3.0], [1.0, 2.0, 2.0], [0.0, 0.0, 4.0], [1e-9, 1.0, 1.0]] {
            let m = std::array::from_fn(|i| {
                std::array::from_fn(|j| (0..3).map(|k| values[k] * axes[k][i] * axes[k][j]).sum())
            });
            let found = least(m);
            let value = |v: DVec3| {
                let mv = DVec3::from(m.map(|row: [f64; 3]| DVec3::from(row).dot(v)));
                (mv.dot(v), (mv - v * mv.dot(v)).length())
            };
            let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
            let (eigenvalue, rest) = value(found);
            // A few roundings of numbers up to 5.
            assert!((eigenvalue - smallest).abs() < 1e-14 && rest < 1e-14, "{values:?}: {found}");
            assert!((found.length() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn what_is_flat_along_an_axis_is_exact() {
        let m = [[2.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.0]];
        assert_eq!(least(m), DVec3::Z);
        assert_eq!(least([[0.0; 3]; 3]), DVec3::X, "a tie");
    }
}
