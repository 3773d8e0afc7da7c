//! Calibration of the structure on runs that are not periodic.
//!
//! Of a lightly damped mode a shift of its frequency by a tenth of its half-width moves the response at resonance by a tenth: far more than the noise
//! of a good accelerometer, and more than a derivative by it tells. So the structure is calibrated on the balance, as on the lines of periodic runs:
//! with `r` what forces and common unknowns `c` leave of the weighted accelerations, and `Z`, `X` what is left of their derivatives by the parameters
//! `θ = ln ω_n, ln ζ_n` and by `c`, Gauss-Newton on `‖r + Z δ‖² + ‖(θ + δ)/s‖²` over all runs, the `c` of each eliminated:
//!
//! `δ = −(Σ S + s⁻²)⁻¹ (Σ Zᵀr + s⁻²θ)`, `S = ZᵀZ − ZᵀX (XᵀX)⁻¹ XᵀZ`.
//!
//! The exciter's lines move the structure at their own frequencies; what the contact does is left to the bins as a whole.

use super::ends::Decay;
use super::known::Known;
use super::{Estimated, PART, Round, Whole};
use crate::RunData;
use crate::calibration::{Equations, Step};
use crate::contact::Setting;
use crate::dynamics::{LineReceptances, Load};
use frettrace_fourier::Harmonics;
use num_complex::Complex64;
use rayon::prelude::*;

/// Rounds of empirical Bayes: powers that are about right.
const FEW: usize = 2;
/// Share of the exciter's loudest line below which one is not followed.
const SILENT: f64 = 1e-3;

impl Known {
    /// What the lines of the exciter make by themselves.
    pub(crate) fn of_exciter(setting: &Setting<'_>, equations: &Equations<'_>) -> Self {
        let lines = equations.lines;
        let receptances = equations.receptances(setting.dynamics, &setting.structure.model);
        let made = |s: usize| {
            let of_line = |(line, h): (&LineReceptances, usize)| {
                line.acceleration(s, Load::Exciter) * lines.force.coefficients[h]
            };
            let bins = std::iter::once(Complex64::ZERO).chain(receptances.iter().zip(1..).map(of_line));
            Harmonics::exact(lines.force.base, bins.collect()).sample(lines.sampling_rate, lines.samples)
        };
        Self::of_force(lines, (0..setting.dynamics.sensors()).map(made).collect())
    }
}

/// Normal equations of the parameters of the structure, `S` and `Zᵀr`, of a run.
pub(crate) fn slopes(setting: &Setting<'_>, run: &RunData<'_>, equations: &Equations<'_>) -> Step {
    let known = Known::of_exciter(setting, equations);
    let left = known.taken_off(run, &equations.lines.noise_std);
    let from = (&known, equations.share());
    Estimated::in_rounds(FEW, setting, &left, from, &equations.loads).slopes(&equations.lines.force)
}

impl Estimated<'_> {
    /// The same beside the lines of the exciter.
    fn slopes(&self, exciter: &Harmonics) -> Step {
        let (whole, round) = (&self.whole, &self.round);
        let decays = whole.moved_decays(round);
        let mut step = Step::zero(2 * whole.setting.structure.modes);
        if decays.is_empty() {
            // No mode that may move lies within the band.
            return step;
        }
        let of_lines = whole.moved_lines(exciter, decays.len());
        let (parameters, unknowns) = (decays.len(), round.common.len());
        let sums = whole.slopes((&decays, &of_lines), round);
        let size = step.gradient.len();
        for p in 0..parameters {
            step.gradient[p] = sums.gradient[p];
            step.matrix[p * size..][..parameters]
                .copy_from_slice(&sums.matrix[p * parameters..][..parameters]);
        }
        let across = &sums.across;
        // What the common unknowns take up.
        for p in 0..parameters {
            let answer: Vec<f64> = (0..unknowns)
                .map(|i| (0..unknowns).map(|j| round.covariance[(i, j)] * across[j * parameters + p]).sum())
                .collect();
            for q in 0..parameters {
                let taken: f64 = answer.iter().enumerate().map(|(i, a)| across[i * parameters + q] * a).sum();
                step.matrix[q * size + p] -= taken;
            }
        }
        step
    }
}

/// `ZᵀZ`, `Zᵀr` and `XᵀZ`, row-major.
struct Slopes {
    matrix: Vec<f64>,
    gradient: Vec<f64>,
    across: Vec<f64>,
}

impl Slopes {
    fn zero(parameters: usize, unknowns: usize) -> Self {
        Self {
            matrix: vec![0.0; parameters * parameters],
            gradient: vec![0.0; parameters],
            across: vec![0.0; unknowns * parameters],
        }
    }

    fn add(mut self, other: &Self) -> Self {
        let pairs = [
            (&mut self.matrix, &other.matrix),
            (&mut self.gradient, &other.gradient),
            (&mut self.across, &other.across),
        ];
        for (sum, part) in pairs {
            sum.iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
        }
        self
    }
}

impl Whole<'_> {
    /// Derivatives of what lines of the exciter make of each mode: `ω² ∂g_n φ_n F`, a row of bins each parameter.
    fn moved_lines(&self, exciter: &Harmonics, parameters: usize) -> Vec<Vec<Complex64>> {
        let (dynamics, model) = (self.setting.dynamics, &self.setting.structure.model);
        // What is in the noise of the force moves no mode.
        let loudest = exciter.coefficients.iter().map(|force| force.norm()).fold(0.0, f64::max);
        let last =
            exciter.coefficients.iter().rposition(|force| force.norm() > SILENT * loudest).unwrap_or(0);
        let moved = |p: usize| {
            let (mode, kind) = (p / 2, p % 2);
            let scale = [model.natural_frequency()[mode], model.damping_ratio()[mode]][kind];
            let load = scale * dynamics.load_shape(mode, Load::Exciter);
            let line = |(h, force): (usize, &Complex64)| {
                let omega = exciter.base * h as f64;
                let gain =
                    if h == 0 { Complex64::ZERO } else { model.modal_receptance_gradient(mode, omega)[kind] };
                gain * force * (omega * omega * load)
            };
            let lines = exciter.coefficients[..=last].iter().enumerate().map(line).collect();
            let samples = Harmonics::exact(exciter.base, lines).sample(self.record.rate, self.record.samples);
            self.record.amplitudes(&samples)
        };
        (0..parameters).into_par_iter().map(moved).collect()
    }

    /// Sums over all bins, in parts of one size that are added in order.
    fn slopes(&self, moved: (&[Decay], &[Vec<Complex64>]), round: &Round) -> Slopes {
        let zero = || Slopes::zero(moved.0.len(), round.common.len());
        let part = |first: usize| {
            let mut sums = zero();
            for k in first..(first + PART).min(self.bins.len()) {
                self.add_slopes(k, moved, round, &mut sums);
            }
            sums
        };
        let parts: Vec<Slopes> =
            (0..self.bins.len().div_ceil(PART)).into_par_iter().map(|p| part(p * PART)).collect();
        parts.iter().fold(zero(), Slopes::add)
    }

    fn add_slopes(
        &self,
        k: usize,
        (decays, lines): (&[Decay], &[Vec<Complex64>]),
        round: &Round,
        sums: &mut Slopes,
    ) {
        let (bin, answered) = (&self.bins[k], self.forces(k, round).1);
        let omega = bin.line.omega();
        let along_mode = |(p, (decay, line)): (usize, (&Decay, &Vec<Complex64>))| {
            self.motion((k, p), &answered) * (omega * omega) + line[k] - decay.acceleration[k]
        };
        let z: Vec<Complex64> = decays.iter().zip(lines).enumerate().map(along_mode).collect();
        let (products, mut along) = bin.left(&round.solved[k]);
        let (size, parameters) = (along.len(), z.len());
        // Twice: a bin's real and imaginary parts have half the variance each.
        let rows = sums.across.chunks_exact_mut(parameters);
        for (((d, x), c), row) in self.columns(k, &round.jumps).iter().zip(&round.common).zip(rows) {
            along.iter_mut().enumerate().for_each(|(m, left)| *left -= products[m * size + d] * x * *c);
            let twice = x.conj() * 2.0;
            for (p, (entry, z)) in row.iter_mut().zip(&z).enumerate() {
                *entry += (twice * products[d * size + p / 2] * z).re;
            }
        }
        for (p, row) in sums.matrix.chunks_exact_mut(parameters).enumerate() {
            let twice = z[p].conj() * 2.0;
            sums.gradient[p] += (twice * along[p / 2]).re;
            for (q, (entry, z)) in row.iter_mut().zip(&z).enumerate() {
                *entry += (twice * products[p / 2 * size + q / 2] * z).re;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rigs::rig;
    use super::super::{Left, Whole};
    use super::Known;
    use crate::Dynamics;
    use crate::calibration::CalibratedStructure;
    use crate::contact::Setting;
    use crate::dynamics::Load;
    use frettrace_fourier::Harmonics;
    use num_complex::Complex64;
    use std::sync::OnceLock;

    const RATE: f64 = 1024.0;
    const SAMPLES: usize = 400;

    /// What is left of noise under given powers of the force, and of the exciter's line: `‖r‖²` with the forces and the common unknowns under
    /// their priors. Its derivatives by the parameters are twice `Zᵀr`, by central differences of 1e-6.
    #[test]
    fn slopes_are_differences_of_what_is_left() {
        let rig = rig(8, 0.02, 3);
        let dynamics = Dynamics::new(&rig);
        let declared = CalibratedStructure::declared(rig.structure.clone(), &rig.trust);
        let wave =
            |k: usize, turn: f64| (0..SAMPLES).map(move |j| (turn * (j * j + 7 * k) as f64).sin()).collect();
        let accelerations: Vec<Vec<f64>> = (0..5).map(|s| wave(s, 0.3 + 0.1 * s as f64)).collect();
        let line = Harmonics::exact(290.0, vec![Complex64::ZERO, Complex64::new(1.5, -0.7)]);
        let loads = [Load::Friction];
        let priors = || vec![(1..=(SAMPLES - 1) / 2).map(|k| 4.0 / (1.0 + 0.01 * (k * k) as f64)).collect()];
        let on = |structure: &CalibratedStructure, of: &mut dyn FnMut(&Whole<'_>)| {
            let setting = Setting {
                structure,
                dynamics: &dynamics,
                normal_stiffness: 1e5,
                splines: false,
                roots: OnceLock::new(),
            };
            let mut at = crate::LineReceptances::default();
            dynamics.fill(&structure.model, line.base, &mut at);
            let made = |(s, a): (usize, &Vec<f64>)| -> Vec<f64> {
                let made = at.acceleration(s, Load::Exciter) * line.coefficients[1];
                let made = Harmonics::exact(line.base, vec![Complex64::ZERO, made]).sample(RATE, SAMPLES);
                a.iter().zip(made).map(|(a, made)| a - made).collect()
            };
            let left = Left {
                force: wave(9, 0.17),
                accelerations: accelerations.iter().enumerate().map(made).collect(),
                noise_std: vec![0.05; 5],
                rate: RATE,
            };
            let known = Known::default();
            of(&Whole::new(&setting, &left, (&known, 0.0), &loads));
        };
        let cost = |structure: &CalibratedStructure| {
            let mut cost = 0.0;
            on(structure, &mut |whole| cost = whole.cost(&whole.round(priors())));
            cost
        };
        let mut gradient = Vec::new();
        on(&declared, &mut |whole| {
            let round = whole.round(priors());
            let moved = (&whole.moved_decays(&round)[..], &whole.moved_lines(&line, 6)[..]);
            gradient = whole.slopes(moved, &round).gradient;
        });
        let largest = gradient.iter().map(|g| g.abs()).fold(0.0, f64::max);
        assert!(largest > 1.0);
        for (p, slope) in gradient.iter().enumerate() {
            let moved = |sign: f64| {
                let mut other = declared.clone();
                let (mode, model) = (p / 2, &declared.model);
                let mut values = [model.natural_frequency()[mode], model.damping_ratio()[mode]];
                values[p % 2] *= (sign * 1e-6_f64).exp();
                other.model.set_mode(mode, values[0], values[1]);
                cost(&other)
            };
            let difference = (moved(1.0) - moved(-1.0)) / 2e-6;
            assert!((2.0 * slope - difference).abs() < 1e-4 * largest, "{p}: {slope} {difference}");
        }
    }

    impl Whole<'_> {
        /// `‖r‖²` with what the priors of forces and jumps add.
        fn cost(&self, round: &super::Round) -> f64 {
            let bins = (0..self.bins.len()).map(|k| self.left(k, round)).sum::<f64>();
            let variances = round.jumps.iter().flat_map(|jump| jump.variances);
            let jumps = round.common[self.decays.all.len()..].iter().zip(variances).map(|(j, v)| j * j / v);
            bins + jumps.sum::<f64>()
        }

        fn left(&self, k: usize, round: &super::Round) -> f64 {
            let bin = &self.bins[k];
            let (products, along) = bin.left(&round.solved[k]);
            let columns = self.columns(k, &round.jumps);
            let vector = |m: usize| columns.iter().zip(&round.common).filter(move |((d, _), _)| *d == m);
            let taken: Vec<Complex64> =
                (0..along.len()).map(|m| vector(m).map(|((_, x), c)| x * *c).sum()).collect();
            let own = bin.measured_left(&round.solved[k]);
            let cross: f64 = taken.iter().zip(&along).map(|(t, a)| (t.conj() * a).re).sum();
            let square: f64 = (0..along.len())
                .flat_map(|m| (0..along.len()).map(move |n| (m, n)))
                .map(|(m, n)| (taken[m].conj() * products[m * along.len() + n] * taken[n]).re)
                .sum();
            2.0 * (own - 2.0 * cross + square)
        }
    }
}
