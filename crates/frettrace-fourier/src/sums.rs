//! Sums of products in lanes, so that they fill the processor's vectors.

/// Lanes that are summed side by side.
const LANES: usize = 16;

/// `Σ a_j b_j`.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut lanes = [0.0; LANES];
    let (pairs, others) = (a.chunks_exact(LANES).zip(b.chunks_exact(LANES)), n / LANES * LANES..n);
    for (a, b) in pairs {
        for ((lane, a), b) in lanes.iter_mut().zip(a).zip(b) {
            *lane += a * b;
        }
    }
    lanes.iter().sum::<f64>() + others.map(|j| a[j] * b[j]).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the plain sum, for lengths that are no multiple of the lanes.
    #[test]
    fn lanes_add_up() {
        for n in [0, 5, 16, 77] {
            let a: Vec<f64> = (0..n).map(|j| (j as f64 * 0.7).sin()).collect();
            let b: Vec<f64> = (0..n).map(|j| (j as f64).sqrt()).collect();
            let plain: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert!((dot(&a, &b) - plain).abs() < 1e-12);
        }
    }
}
