//! One bin of the spectrum: what its accelerations tell of the contact forces, multiplied out.
//!
//! All that a bin is asked for in one round after the other are products, under the sensors' weights `W`, of the measured
//! accelerations `y` and of the vectors `B = [φ_1 … φ_M, H_1 … H_U]`: shapes of the modes and accelerances of the loads. They
//! are formed once. Under a prior of variances `P` the forces are `K(H^H W y)` with `K = (H^H W H + P⁻¹)⁻¹`, and what they leave of two
//! vectors has the product `a^H W b − (a^H W H) K (H^H W b)`.

use crate::contact::Setting;
use crate::dynamics::{LineReceptances, Load};
use num_complex::Complex64;

/// Share of a pivot below which a force is not told from those before it.
const INDEPENDENT: f64 = 1e-13;

/// Amplitudes of the samples in one bin.
#[derive(Clone, Copy)]
pub(super) struct Amplitudes<'a> {
    pub(super) exciter: Complex64,
    pub(super) accelerations: &'a [Complex64],
    /// Variances of the accelerations.
    pub(super) variances: &'a [f64],
}

/// A bin.
pub(super) struct Bin {
    pub(super) line: LineReceptances,
    pub(super) exciter: Complex64,
    /// Accelerations less what the exciter makes.
    pub(super) measured: Vec<Complex64>,
    pub(super) weights: Vec<f64>,
    /// Variance (N²) of each force without prior.
    pub(super) variances: Vec<f64>,
    /// Products `B^H W B`, row-major, and `B^H W y`.
    products: Vec<Complex64>,
    along: Vec<Complex64>,
    modes: usize,
}

/// The forces of a bin under a prior: linear in what is measured.
pub(super) struct Solved {
    /// Covariance `K` (N²), row-major.
    pub(super) covariance: Vec<Complex64>,
    /// Forces of the measured accelerations.
    pub(super) own: Vec<Complex64>,
    /// Forces of the vectors `B` in place of the accelerations, a row each load.
    pub(super) taken: Vec<Complex64>,
}

impl Bin {
    /// The bin of the angular frequency `omega` (rad/s).
    pub(super) fn new(
        setting: &Setting<'_>,
        loads: &[Load],
        (omega, modes): (f64, usize),
        at: &Amplitudes<'_>,
    ) -> Self {
        let mut line = LineReceptances::default();
        setting.dynamics.fill(&setting.structure.model, omega, &mut line);
        let sensors = at.accelerations.len();
        let weights: Vec<f64> = at.variances.iter().map(|v| if *v > 0.0 { v.recip() } else { 0.0 }).collect();
        let vector = |d: usize, s: usize| match loads.get(d.wrapping_sub(modes)) {
            Some(load) => line.acceleration(s, *load),
            None => Complex64::from(setting.dynamics.sensor_shape(d, s)),
        };
        let size = modes + loads.len();
        let vectors: Vec<Complex64> = (0..size * sensors).map(|e| vector(e / sensors, e % sensors)).collect();
        let none = Vec::new;
        let mut bin = Self {
            line,
            exciter: at.exciter,
            measured: none(),
            weights,
            variances: Vec::new(),
            products: vec![Complex64::ZERO; size * size],
            along: none(),
            modes,
        };
        bin.measured = bin.less_exciter(at);
        bin.along = vectors.chunks_exact(sensors).map(|a| bin.product(a, &bin.measured)).collect();
        for (i, a) in vectors.chunks_exact(sensors).enumerate() {
            for (k, b) in vectors.chunks_exact(sensors).enumerate().skip(i) {
                let product = bin.product(a, b);
                bin.products[i * size + k] = product;
                bin.products[k * size + i] = product.conj();
            }
        }
        bin.variances = bin.solve(&vec![f64::INFINITY; loads.len()]).variances().collect();
        bin
    }

    fn less_exciter(&self, at: &Amplitudes<'_>) -> Vec<Complex64> {
        let makes = |s: usize| self.line.acceleration(s, Load::Exciter) * at.exciter;
        at.accelerations.iter().enumerate().map(|(s, a)| a - makes(s)).collect()
    }

    /// `a^H W b`.
    fn product(&self, a: &[Complex64], b: &[Complex64]) -> Complex64 {
        a.iter().zip(b).zip(&self.weights).map(|((a, b), w)| a.conj() * b * *w).sum()
    }

    /// Number of vectors `B`.
    pub(super) fn size(&self) -> usize {
        self.along.len()
    }

    fn loads(&self) -> usize {
        self.size() - self.modes
    }

    /// The forces under prior variances (N²); infinite: none.
    pub(super) fn solve(&self, prior: &[f64]) -> Solved {
        let (size, loads) = (self.size(), self.loads());
        let entry = |e: usize| {
            let (i, k) = (e / loads, e % loads);
            let pinned = if i == k { prior[i].recip() } else { 0.0 };
            self.products[(self.modes + i) * size + self.modes + k] + pinned
        };
        let covariance = inverse((0..loads * loads).map(entry).collect(), loads);
        let row = |u: usize, right: &dyn Fn(usize) -> Complex64| -> Complex64 {
            (0..loads).map(|i| covariance[u * loads + i] * right(i)).sum()
        };
        let own = (0..loads).map(|u| row(u, &|i| self.along[self.modes + i])).collect();
        let taken = (0..loads * size)
            .map(|e| row(e / size, &|i| self.products[(self.modes + i) * size + e % size]))
            .collect();
        Solved { covariance, own, taken }
    }

    /// The forces of other accelerations and another excitation, without prior.
    pub(super) fn free_forces(&self, at: &Amplitudes<'_>, loads: &[Load], free: &Solved) -> Vec<Complex64> {
        let measured = self.less_exciter(at);
        let along: Vec<Complex64> = loads
            .iter()
            .map(|load| {
                let column: Vec<Complex64> =
                    (0..measured.len()).map(|s| self.line.acceleration(s, *load)).collect();
                self.product(&column, &measured)
            })
            .collect();
        let n = loads.len();
        (0..n).map(|u| (0..n).map(|i| free.covariance[u * n + i] * along[i]).sum()).collect()
    }

    /// Products of what the forces leave of the vectors `B` (`D × D`), and with what they leave of the measured ones (`D`).
    pub(super) fn left(&self, solved: &Solved) -> (Vec<Complex64>, Vec<Complex64>) {
        let (size, loads) = (self.size(), self.loads());
        let (mut products, mut along) = (self.products.clone(), self.along.clone());
        for d in 0..size {
            for u in 0..loads {
                let common = self.products[d * size + self.modes + u];
                along[d] -= common * solved.own[u];
                for (entry, taken) in
                    products[d * size..(d + 1) * size].iter_mut().zip(&solved.taken[u * size..(u + 1) * size])
                {
                    *entry -= common * taken;
                }
            }
        }
        (products, along)
    }
}

#[cfg(test)]
impl Bin {
    /// What the forces leave of the measured accelerations, squared under the weights, with what their prior adds.
    pub(super) fn measured_left(&self, solved: &Solved) -> f64 {
        let taken = self.along[self.modes..].iter().zip(&solved.own).map(|(a, own)| (a.conj() * own).re);
        self.product(&self.measured, &self.measured).re - taken.sum::<f64>()
    }
}

impl Solved {
    /// Force of a load for the vector `d` in place of the accelerations.
    pub(super) fn taken(&self, load: usize, d: usize) -> Complex64 {
        let size = self.taken.len() / self.own.len();
        self.taken[load * size + d]
    }

    /// Variance (N²) of each force.
    pub(super) fn variances(&self) -> impl Iterator<Item = f64> {
        let loads = self.own.len();
        (0..loads).map(move |u| self.covariance[u * loads + u].re)
    }
}

/// Inverse of a Hermitian positive matrix by its factor `LLᴴ`; rows that depend on those before them are left out (zero).
fn inverse(mut matrix: Vec<Complex64>, n: usize) -> Vec<Complex64> {
    let mut pivots = vec![0.0; n];
    for j in 0..n {
        let whole = matrix[j * n + j].re;
        let pivot = whole - (0..j).map(|k| matrix[j * n + k].norm_sqr()).sum::<f64>();
        pivots[j] = if pivot > INDEPENDENT * whole { pivot.sqrt() } else { 0.0 };
        matrix[j * n + j] = Complex64::from(pivots[j]);
        for i in j + 1..n {
            let along: Complex64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k].conj()).sum();
            let free = matrix[i * n + j] - along;
            matrix[i * n + j] = if pivots[j] > 0.0 { free / pivots[j] } else { Complex64::ZERO };
        }
    }
    let mut found = vec![Complex64::ZERO; n * n];
    for column in 0..n {
        let mut x = vec![Complex64::ZERO; n];
        for i in column..n {
            let right = Complex64::from(if i == column { 1.0 } else { 0.0 });
            let along: Complex64 = (column..i).map(|k| matrix[i * n + k] * x[k]).sum();
            x[i] = if pivots[i] > 0.0 { (right - along) / pivots[i] } else { Complex64::ZERO };
        }
        for i in (0..n).rev() {
            let along: Complex64 = (i + 1..n).map(|k| matrix[k * n + i].conj() * x[k]).sum();
            x[i] = if pivots[i] > 0.0 { (x[i] - along) / pivots[i] } else { Complex64::ZERO };
        }
        (0..n).for_each(|i| found[i * n + column] = x[i]);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::rigs::rig;
    use super::*;
    use crate::Dynamics;
    use crate::balance::{LineBalance, LineData};
    use crate::calibration::CalibratedStructure;
    use std::sync::OnceLock;

    /// Products once multiplied out say what the orthogonal factorisation of [`LineBalance`] says: forces, covariance and what is
    /// left of the accelerations, with a prior and without.
    #[test]
    fn products_agree_with_the_factorisation() {
        let rig = rig(12, 0.01, 0);
        let dynamics = Dynamics::new(&rig);
        let structure = CalibratedStructure::declared(rig.structure.clone(), &[]);
        let setting = Setting {
            structure: &structure,
            dynamics: &dynamics,
            normal_stiffness: 1e5,
            splines: false,
            roots: OnceLock::new(),
        };
        let loads = [Load::Friction, Load::NormalDeviation];
        let accelerations: Vec<Complex64> =
            (0..5).map(|s| Complex64::new(1.0 + s as f64, (3.0 * s as f64).sin())).collect();
        let variances = [0.01, 0.02, 0.01, 0.04, 0.01];
        let at = Amplitudes {
            exciter: Complex64::new(0.3, -0.2),
            accelerations: &accelerations,
            variances: &variances,
        };
        let bin = Bin::new(&setting, &loads, (700.0, 3), &at);
        let data = LineData {
            force: at.exciter,
            force_variance: 0.0,
            accelerations: accelerations.clone(),
            variances: variances.into(),
        };
        for prior in [[f64::INFINITY; 2], [2.0, 0.5]] {
            let (found, expected) = (bin.solve(&prior), LineBalance::solve(&bin.line, &data, &loads, &prior));
            let close = |a: Complex64, b: Complex64| (a - b).norm() < 1e-8 * (1e-6 + b.norm());
            assert!(found.own.iter().zip(&expected.forces).all(|(a, b)| close(*a, *b)));
            assert!(found.covariance.iter().zip(expected.covariance()).all(|(a, b)| close(*a, b)));
            let (products, along) = bin.left(&found);
            let shape = |n: usize| -> Vec<Complex64> {
                expected.remainder(
                    &(0..5).map(|s| Complex64::from(dynamics.sensor_shape(n, s))).collect::<Vec<_>>(),
                )
            };
            let target = expected.remainder(&bin.measured);
            let inner = |a: &[Complex64], b: &[Complex64]| -> Complex64 {
                a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
            };
            for n in 0..3 {
                assert!(close(along[n], inner(&shape(n), &target)));
                assert!(close(products[n * bin.size() + 1], inner(&shape(n), &shape(1))));
            }
        }
    }
}
