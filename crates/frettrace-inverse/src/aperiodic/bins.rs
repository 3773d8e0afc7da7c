//! One bin of the spectrum: what its accelerations tell of the contact forces, multiplied out.
//!
//! What a bin is asked for in one round after the other are the measured accelerations `y` and the vectors `B = [φ_1 … φ_M, H_1 … H_U]`, shapes of
//! the modes and accelerances of the loads, under the sensors' weights `W`, and their products with the loads' own, `H^H W y` and `H^H W B`. They are
//! formed once. Under a prior of variances `P` the forces are `f = K(H^H W y)` with `K = (H^H W H + P⁻¹)⁻¹`, and what they leave of a vector, with what
//! the prior adds for them, are the rows `√W (y − H f)` and `P^{−½} f` ([`Bin::leave`]): what they leave of two vectors has the product
//! `a^H W b − (a^H W H) K (H^H W b)`, without the difference.

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
    /// Vectors `√W B`, one after the other, and `√W y`.
    vectors: Vec<Complex64>,
    weighted: Vec<Complex64>,
    /// Products `H^H W B`, a row each load, and `H^H W y`.
    across: Vec<Complex64>,
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
    taken: Vec<Complex64>,
    /// Roots `P^{−½}` (1/N) of the prior; zero where there is none.
    held: Vec<f64>,
    size: usize,
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
        let roots: Vec<f64> = weights.iter().map(|w| w.sqrt()).collect();
        let mut vectors = Vec::with_capacity((modes + loads.len()) * sensors);
        for mode in 0..modes {
            let shape =
                roots.iter().enumerate().map(|(s, root)| setting.dynamics.sensor_shape(mode, s) * root);
            vectors.extend(shape.map(Complex64::from));
        }
        for load in loads {
            vectors.extend(roots.iter().enumerate().map(|(s, root)| line.acceleration(s, *load) * *root));
        }
        let measured = less_exciter(&line, at);
        let weighted: Vec<Complex64> = measured.iter().zip(&roots).map(|(y, root)| y * *root).collect();
        let own = || vectors[modes * sensors..].chunks_exact(sensors);
        let along = own().map(|h| inner(h, &weighted)).collect();
        let across = own().flat_map(|h| vectors.chunks_exact(sensors).map(move |b| inner(h, b))).collect();
        let exciter = at.exciter;
        let mut bin = Self {
            line,
            exciter,
            measured,
            weights,
            variances: Vec::new(),
            vectors,
            weighted,
            across,
            along,
            modes,
        };
        bin.variances = bin.solve(&vec![f64::INFINITY; loads.len()]).variances().collect();
        bin
    }

    fn loads(&self) -> usize {
        self.along.len()
    }

    /// Number of vectors `B`.
    pub(super) fn size(&self) -> usize {
        self.modes + self.loads()
    }

    /// Number of rows that the forces leave of a vector: one a sensor, one a load.
    pub(super) fn rows(&self) -> usize {
        self.measured.len() + self.loads()
    }

    /// The forces under prior variances (N²); infinite: none.
    pub(super) fn solve(&self, prior: &[f64]) -> Solved {
        let (size, loads) = (self.size(), self.loads());
        let entry = |e: usize| {
            let (i, k) = (e / loads, e % loads);
            let pinned = if i == k { prior[i].recip() } else { 0.0 };
            self.across[i * size + self.modes + k] + pinned
        };
        let covariance = inverse((0..loads * loads).map(entry).collect(), loads);
        let mut own = vec![Complex64::ZERO; loads];
        let mut taken = vec![Complex64::ZERO; loads * size];
        for ((row, own), taken) in
            covariance.chunks_exact(loads).zip(&mut own).zip(taken.chunks_exact_mut(size))
        {
            for ((share, along), across) in row.iter().zip(&self.along).zip(self.across.chunks_exact(size)) {
                *own += share * along;
                taken.iter_mut().zip(across).for_each(|(taken, across)| *taken += share * across);
            }
        }
        let held = prior.iter().map(|v| if *v > 0.0 { v.recip().sqrt() } else { 0.0 }).collect();
        Solved { covariance, own, taken, held, size }
    }

    /// The forces of other accelerations and another excitation, without prior.
    pub(super) fn free_forces(&self, at: &Amplitudes<'_>, free: &Solved) -> Vec<Complex64> {
        let weighted: Vec<Complex64> =
            less_exciter(&self.line, at).iter().zip(&self.weights).map(|(y, w)| y * w.sqrt()).collect();
        let own = self.vectors[self.modes * weighted.len()..].chunks_exact(weighted.len());
        let along: Vec<Complex64> = own.map(|h| inner(h, &weighted)).collect();
        let n = along.len();
        (0..n).map(|u| (0..n).map(|i| free.covariance[u * n + i] * along[i]).sum()).collect()
    }

    /// What the forces leave of the vectors `B`, [`Self::rows`] of each after the other, and of the measured accelerations.
    pub(super) fn leave(&self, solved: &Solved, vectors: &mut Vec<Complex64>, measured: &mut Vec<Complex64>) {
        let sensors = self.measured.len();
        let made = |u: usize| &self.vectors[(self.modes + u) * sensors..][..sensors];
        let rows = |of: &[Complex64], force: &dyn Fn(usize) -> Complex64, out: &mut Vec<Complex64>| {
            let first = out.len();
            out.extend_from_slice(of);
            for u in 0..solved.held.len() {
                let force = force(u);
                out[first..][..sensors].iter_mut().zip(made(u)).for_each(|(left, h)| *left -= h * force);
                out.push(force * solved.held[u]);
            }
        };
        vectors.clear();
        for (d, of) in self.vectors.chunks_exact(sensors).enumerate() {
            rows(of, &|u| solved.taken(u, d), vectors);
        }
        measured.clear();
        rows(&self.weighted, &|u| solved.own[u], measured);
    }
}

fn less_exciter(line: &LineReceptances, at: &Amplitudes<'_>) -> Vec<Complex64> {
    let makes = |s: usize| line.acceleration(s, Load::Exciter) * at.exciter;
    at.accelerations.iter().enumerate().map(|(s, a)| a - makes(s)).collect()
}

/// `a^H b`.
fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

#[cfg(test)]
impl Bin {
    /// Products of what the forces leave of the vectors `B` (`D × D`), and with what they leave of the measured ones (`D`), by the difference.
    pub(super) fn left(&self, solved: &Solved) -> (Vec<Complex64>, Vec<Complex64>) {
        let (size, sensors) = (self.size(), self.measured.len());
        let of = |d: usize| &self.vectors[d * sensors..][..sensors];
        let common = |d: usize, force: &dyn Fn(usize) -> Complex64| -> Complex64 {
            (0..self.loads()).map(|u| self.across[u * size + d].conj() * force(u)).sum()
        };
        let product = |e: usize| {
            let (a, b) = (e / size, e % size);
            inner(of(a), of(b)) - common(a, &|u| solved.taken(u, b))
        };
        let along = |d: usize| inner(of(d), &self.weighted) - common(d, &|u| solved.own[u]);
        ((0..size * size).map(product).collect(), (0..size).map(along).collect())
    }

    /// What the forces leave of the measured accelerations, squared under the weights, with what their prior adds.
    pub(super) fn measured_left(&self, solved: &Solved) -> f64 {
        let taken = self.along.iter().zip(&solved.own).map(|(a, own)| (a.conj() * own).re);
        inner(&self.weighted, &self.weighted).re - taken.sum::<f64>()
    }
}

impl Solved {
    /// Force of a load for the vector `d` in place of the accelerations.
    pub(super) fn taken(&self, load: usize, d: usize) -> Complex64 {
        self.taken[load * self.size + d]
    }

    /// Force of a load for so much of each vector in place of the accelerations.
    pub(super) fn made(&self, load: usize, moved: &[Complex64]) -> Complex64 {
        self.taken[load * self.size..].iter().zip(moved).map(|(taken, x)| taken * x).sum()
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
            for n in 0..3 {
                assert!(close(along[n], inner(&shape(n), &target)));
                assert!(close(products[n * bin.size() + 1], inner(&shape(n), &shape(1))));
            }
            let (mut vectors, mut measured) = (Vec::new(), Vec::new());
            bin.leave(&found, &mut vectors, &mut measured);
            let row = |d: usize| &vectors[d * bin.rows()..][..bin.rows()];
            assert!((inner(&measured, &measured).re - bin.measured_left(&found)).abs() < 1e-8);
            // By the difference, what is left is known to the rounding of what was there.
            let there =
                |d: usize| bin.vectors[d * 5..][..5].iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
            for a in 0..bin.size() {
                let left = inner(row(a), &measured) - along[a];
                assert!(left.norm() < 1e-12 * there(a) * inner(&bin.weighted, &bin.weighted).re.sqrt());
                for b in 0..bin.size() {
                    let left = inner(row(a), row(b)) - products[a * bin.size() + b];
                    assert!(left.norm() < 1e-12 * there(a) * there(b), "{a} {b} {left}");
                }
            }
        }
    }
}
