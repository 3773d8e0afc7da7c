//! How the outputs of each bin move with everything that bins have in common: free decays, jumps, and the structure.

use super::ends::JUMPS;
use super::{Round, Whole};
use crate::contact::Setting;
use crate::dynamics::{LineReceptances, Load};
use faer::{Mat, Side};
use num_complex::Complex64;
use rayon::prelude::*;

/// Outputs before the sensors: friction, slip, slip velocity, normal, second support.
pub(super) const OUTPUTS: usize = 5;
pub(super) type Outputs = [Complex64; OUTPUTS];

/// Spectra of the outputs, from bin 1.
pub(super) type Spectra = [Vec<Complex64>; OUTPUTS];

/// How everything moves with each common unknown, a row each.
pub(super) struct Common {
    pub(super) outputs: Vec<Spectra>,
    /// Spectra of the forces of the loads.
    pub(super) forces: Vec<Vec<Vec<Complex64>>>,
    /// Root of the covariance of the unknowns: a column each independent source.
    pub(super) root: Mat<f64>,
}

/// Changes in one bin, per unit of one common unknown.
struct Change {
    outputs: Outputs,
    forces: Vec<Complex64>,
}

impl Whole<'_> {
    /// Outputs of forces on a line; they are linear in them.
    pub(super) fn outputs(
        &self,
        line: &LineReceptances,
        exciter: Complex64,
        forces: &[Complex64],
    ) -> Outputs {
        let sum = |response: &dyn Fn(Load) -> Complex64| {
            response(Load::Exciter) * exciter
                + self.loads.iter().zip(forces).map(|(l, f)| response(*l) * f).sum::<Complex64>()
        };
        let own = |wanted: Load| {
            self.loads.iter().zip(forces).find(|(l, _)| **l == wanted).map_or(Complex64::ZERO, |(_, f)| *f)
        };
        let (slip, end) = (sum(&|l| line.slip(l)), sum(&|l| line.end(l)));
        let normal = own(Load::NormalDeviation) - end * self.setting.normal_stiffness;
        let velocity = slip * Complex64::new(0.0, line.omega());
        [own(Load::Friction), slip, velocity, normal, own(Load::SecondSupport)]
    }

    /// What the jumps of each load, `J_q r_q`, add to the outputs of a bin: motions that no sensor sees.
    pub(super) fn add_jumps(&self, k: usize, jumps: &dyn Fn(usize, usize) -> f64, outputs: &mut Outputs) {
        let [ramp, parabola] = &self.ramps;
        for (u, slow) in self.slow.iter().enumerate() {
            let (value, slope) = (jumps(u, 0), jumps(u, 1));
            for (o, output) in outputs.iter_mut().enumerate() {
                *output +=
                    (ramp[k] * value + parabola[k] * slope) * slow.gain[o] + ramp[k] * (slope * slow.lag[o]);
            }
            // The velocity of the ramp is in no bin.
            outputs[2] += ramp[k] * (slope * slow.gain[1]);
        }
    }

    /// Adds motion of a mode to the outputs, given as displacement and velocity. A decay ends elsewhere than it began: its velocity is
    /// a spectrum of its own, not iω times its displacement.
    pub(super) fn add_motion(
        &self,
        mode: usize,
        [displacement, velocity]: [Complex64; 2],
        outputs: &mut Outputs,
    ) {
        let [slip, end] = self.setting.dynamics.contact_shape(mode);
        outputs[1] += displacement * slip;
        outputs[2] += velocity * slip;
        outputs[3] -= displacement * (end * self.setting.normal_stiffness);
    }

    /// How outputs and forces move with the common unknowns.
    pub(super) fn common(&self, round: &Round) -> Common {
        let changes: Vec<Vec<Change>> =
            (0..self.bins.len()).into_par_iter().map(|k| self.changes(k, round)).collect();
        let unknowns = round.common.len();
        let spectrum = |value: &dyn Fn(&Vec<Change>) -> Complex64| changes.iter().map(value).collect();
        Common {
            outputs: (0..unknowns).map(|i| std::array::from_fn(|o| spectrum(&|c| c[i].outputs[o]))).collect(),
            forces: (0..unknowns)
                .map(|i| (0..self.loads.len()).map(|u| spectrum(&|c| c[i].forces[u])).collect())
                .collect(),
            root: root(&round.covariance),
        }
    }

    fn changes(&self, k: usize, round: &Round) -> Vec<Change> {
        let (line, solved) = (&self.bins[k].line, &round.solved[k]);
        let columns = self.columns(k, &round.jumps).into_iter().enumerate();
        columns
            .map(|(i, (d, x))| {
                let jumps = |u: usize, q: usize| if i == self.jump(u, q) { 1.0 } else { 0.0 };
                let own = |u: usize| (0..JUMPS).map(|q| jumps(u, q)).sum::<f64>();
                let answered: Vec<Complex64> =
                    (0..self.loads.len()).map(|u| x * own(u) - solved.taken(u, d) * x).collect();
                let mut outputs = self.outputs(line, Complex64::ZERO, &answered);
                self.add_jumps(k, &jumps, &mut outputs);
                if let Some(decay) = self.decays.all.get(i) {
                    self.add_motion(i / 2, [decay.displacement[k], decay.velocity[k]], &mut outputs);
                }
                let ramps = |u: usize| (0..JUMPS).map(|q| self.ramps[q][k] * jumps(u, q)).sum::<Complex64>();
                let forces = answered.iter().enumerate().map(|(u, a)| a + ramps(u)).collect();
                Change { outputs, forces }
            })
            .collect()
    }
}

/// What a force of a load makes that is slower than every mode: `u = G f + L ḟ`.
pub(super) struct Slow {
    /// `G` of each output; no velocity, which is that of the slip.
    pub(super) gain: [f64; OUTPUTS],
    /// `L` (s) of each output.
    lag: [f64; OUTPUTS],
}

impl Slow {
    /// That of all loads, read off the receptances at a frequency far below that of the record (rad/s): `H = G + iωL`.
    pub(super) fn all(setting: &Setting<'_>, loads: &[Load], base: f64) -> Vec<Self> {
        let mut line = LineReceptances::default();
        setting.dynamics.fill(&setting.structure.model, STILL * base, &mut line);
        let of = |load: &Load| {
            let own = |wanted: Load| Complex64::from(if *load == wanted { 1.0 } else { 0.0 });
            let normal = own(Load::NormalDeviation) - line.end(*load) * setting.normal_stiffness;
            let outputs =
                [own(Load::Friction), line.slip(*load), Complex64::ZERO, normal, own(Load::SecondSupport)];
            Self { gain: outputs.map(|h| h.re), lag: outputs.map(|h| h.im / line.omega()) }
        };
        loads.iter().map(of).collect()
    }
}

/// Share of the record's own frequency at which a force is slow.
const STILL: f64 = 1e-3;

/// Sums of spectra with shares, a column of them each sum: for each output the product of a matrix of its bins, two rows each, with the shares.
pub(super) fn combined(of: &[&Spectra], shares: &Mat<f64>) -> Vec<Spectra> {
    let bins = of.first().map_or(0, |spectra| spectra[0].len());
    let product = |o: usize| {
        let part = |row: usize, i: usize| {
            let value = of[i][o][row / 2];
            if row.is_multiple_of(2) { value.re } else { value.im }
        };
        Mat::from_fn(2 * bins, of.len(), part) * shares
    };
    let products: Vec<Mat<f64>> = (0..OUTPUTS).into_par_iter().map(product).collect();
    let spectrum = |o: usize, s: usize| {
        let sum = &products[o];
        (0..bins).map(|k| Complex64::new(sum[(2 * k, s)], sum[(2 * k + 1, s)])).collect()
    };
    (0..shares.ncols()).into_par_iter().map(|s| std::array::from_fn(|o| spectrum(o, s))).collect()
}

/// Root `L` of a covariance, `LLᵀ`; zero where it has none.
fn root(covariance: &Mat<f64>) -> Mat<f64> {
    let n = covariance.nrows();
    let scale: Vec<f64> = (0..n).map(|i| covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let unit = Mat::from_fn(n, n, |i, k| covariance[(i, k)] / (scale[i] * scale[k]));
    let eigen = unit.self_adjoint_eigen(Side::Lower);
    eigen.map_or_else(
        |_| Mat::zeros(n, n),
        |eigen| Mat::from_fn(n, n, |i, k| scale[i] * eigen.U()[(i, k)] * eigen.S()[k].max(0.0).sqrt()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums are the sums, bin by bin and output by output.
    #[test]
    fn combined_spectra_are_their_weighted_sums() {
        let value = |i: usize, o: usize, k: usize| {
            Complex64::new((i + 2 * o) as f64 - k as f64, (3 * i * k) as f64 + o as f64)
        };
        let spectra: Vec<Spectra> =
            (0..3).map(|i| std::array::from_fn(|o| (0..4).map(|k| value(i, o, k)).collect())).collect();
        let shares = Mat::from_fn(3, 2, |i, s| (i + 1) as f64 / (s + 2) as f64);
        let found = combined(&spectra.iter().collect::<Vec<_>>(), &shares);
        assert_eq!(found.len(), 2);
        for (s, sums) in found.iter().enumerate() {
            for (o, sum) in sums.iter().enumerate() {
                for (k, sum) in sum.iter().enumerate() {
                    let expected: Complex64 = (0..3).map(|i| value(i, o, k) * shares[(i, s)]).sum();
                    assert!((sum - expected).norm() < 1e-12, "{s} {o} {k}: {sum} {expected}");
                }
            }
        }
        assert!(combined(&[], &Mat::zeros(0, 0)).is_empty());
    }
}
