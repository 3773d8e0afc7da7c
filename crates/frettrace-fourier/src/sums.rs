//! Sums in lanes, so that they fill the processor's vectors: a sum in order waits for each of its terms.

/// Lanes that are summed side by side.
const LANES: usize = 16;

/// `Σ a_j`, in the unit of `a`.
#[must_use]
pub fn sum(a: &[f64]) -> f64 {
    sum_of(a, |a| a)
}

/// Mean square about the mean, `1/n Σ (a_j − ā)²`, in the unit of `a` squared; 0 of nothing.
#[must_use]
pub fn variance(a: &[f64]) -> f64 {
    let n = a.len().max(1) as f64;
    let mean = sum(a) / n;
    sum_of(a, |a| (a - mean) * (a - mean)) / n
}

/// `Σ f(a_j)`.
fn sum_of(a: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let (blocks, others) = a.as_chunks::<LANES>();
    let mut lanes = [0.0; LANES];
    for block in blocks {
        lanes.iter_mut().zip(block).for_each(|(lane, a)| *lane += f(*a));
    }
    lanes.iter().sum::<f64>() + others.iter().map(|a| f(*a)).sum::<f64>()
}

/// Multiplies samples by their distance `j − (n − 1)/2` from the middle.
pub(crate) fn times_distance(a: &mut [f64]) {
    let middle = 0.5 * (a.len().max(1) - 1) as f64;
    // Counted on instead of converted: there are no vectors of integers to numbers.
    let mut distance: [f64; LANES] = std::array::from_fn(|lane| lane as f64 - middle);
    let (blocks, others) = a.as_chunks_mut::<LANES>();
    for block in blocks {
        for (value, distance) in block.iter_mut().zip(&mut distance) {
            *value *= *distance;
            *distance += LANES as f64;
        }
    }
    others.iter_mut().zip(&distance).for_each(|(value, distance)| *value *= distance);
}

/// `Σ a_j b_j`, in the product of the units of `a` and `b`; what the longer one has beyond the other is left out.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
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
            let total: f64 = b.iter().sum();
            assert!((sum(&b) - total).abs() < 1e-12 * total.max(1.0));
            let (count, mean) = (n.max(1) as f64, total / n.max(1) as f64);
            let scatter = b.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / count;
            assert!((variance(&b) - scatter).abs() < 1e-12 * scatter.max(1.0));
            let moved: Vec<f64> =
                a.iter().enumerate().map(|(j, a)| (j as f64 - 0.5 * (count - 1.0)) * a).collect();
            let mut found = a.clone();
            times_distance(&mut found);
            assert!(found.iter().zip(&moved).all(|(found, moved)| (found - moved).abs() < 1e-12));
        }
    }
}
