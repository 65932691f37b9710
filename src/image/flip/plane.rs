//! Separable convolution with kernels that have as many weights on either side of their middle.

/// `weight` at -reach..=reach.
pub(super) fn kernel(reach: f64, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    let reach = reach as i32;
    (-reach..=reach).map(|x| weight(f64::from(x))).collect()
}

/// Its positive weights scaled to a sum of 1, its negative ones to -1.
pub(super) fn unit(kernel: &[f64]) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|&&w| w > 0.0).sum();
    let negative: f64 = kernel.iter().filter(|&&w| w < 0.0).sum();
    kernel.iter().map(|&w| if w < 0.0 { w / -negative } else { w / positive }).collect()
}

/// A channel of some rows of a picture.
pub(super) struct Plane {
    pub(super) width: usize,
    /// The row that `values` begins with.
    pub(super) first: usize,
    pub(super) values: Vec<f64>,
    /// The rows to compute; `values` reaches beyond them as far as kernels do, where the picture does.
    pub(super) rows: [usize; 2],
}

impl Plane {
    /// By one kernel along rows and another along columns.
    pub(super) fn convolved(&self, across: &[f64], down: &[f64]) -> Vec<f64> {
        let (width, reach) = (self.width, across.len() / 2);
        let mut wide = vec![0.0; width + 2 * reach];
        let mut lines = vec![0.0; self.values.len()];
        for (row, line) in self.values.chunks_exact(width).zip(lines.chunks_exact_mut(width)) {
            wide[..reach].fill(row[0]);
            wide[reach..reach + width].copy_from_slice(row);
            wide[reach + width..].fill(row[width - 1]);
            for (shift, &weight) in across.iter().enumerate() {
                add(line, weight, &wide[shift..shift + width]);
            }
        }
        let (reach, last) = (down.len() / 2, lines.len() / width - 1);
        let mut out = vec![0.0; width * (self.rows[1] - self.rows[0])];
        for (y, line) in (self.rows[0]..).zip(out.chunks_exact_mut(width)) {
            for (shift, &weight) in down.iter().enumerate() {
                let from = (y + shift).saturating_sub(reach).saturating_sub(self.first).min(last);
                add(line, weight, &lines[from * width..(from + 1) * width]);
            }
        }
        out
    }
}

fn add(line: &mut [f64], weight: f64, other: &[f64]) {
    line.iter_mut().zip(other).for_each(|(sum, value)| *sum += weight * value);
}
