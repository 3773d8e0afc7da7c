//! Records that are not periodic: the same balance at every bin of the whole spectrum.
//!
//! On a finite record the response is the periodic response to the periodically continued forces plus a free decay of
//! every mode, `Σ_n φ_n Re(c_n e^{λ_n t})`: the states at the ends of the record enter as one complex unknown a mode, common
//! to all bins, and no steady state is needed. Without more, a free decay and an impulse at the record's ends could not be
//! told apart; a prior on the contact force does it, whose power at each bin is drawn from the record (tapered at first,
//! then the estimate itself: empirical Bayes).
//!
//! A force that is continued periodically jumps at the ends of the record, in its value and its slope, and the structure answers no
//! such jump: neither a straight line nor a parabola makes an acceleration that changes. Of the force's bins `f_k` the structure answers
//! `f_k − Σ_q J_q r_qk`, with the bins of a ramp and a parabola; that the force holds no more below its own frequencies than the prior
//! says tells the jumps: two more common unknowns a load ([`Jump`]). Without them what the modes beyond the band would make of a jump is
//! taken for a slow force.
//! What the lines of the excitation hold ([`Known`]) is taken off first, with its response at its own frequencies, where
//! nothing jumps; only what is left is balanced bin by bin, and its prior is the smaller the nearer a run is to a period.
//!
//! A drift of contact force and slip that is slower than the record leaves accelerations below the noise. What the balance says of it
//! is weighed against what a random walk would do ([`drift`]); it is named unobservable, and the bands hold what is left.

mod bins;
mod calibration;
mod drift;
mod ends;
mod known;
mod outcome;
mod power;
#[cfg(test)]
mod rigs;
mod sources;
mod structure;

use crate::contact::{RunBalance, Setting};
use crate::dynamics::Load;
use bins::{Amplitudes, Bin, Solved};
pub(crate) use calibration::slopes;
use ends::{Decays, JUMPS, Jump, Record};
use faer::prelude::Solve;
use faer::{Col, Mat, Side};
use frettrace_fourier::tapered_spectrum;
pub(crate) use known::{Known, Left};
use num_complex::Complex64;
use power::{FROM_FEW, smoothed};
use rayon::prelude::*;
use sources::Slow;
use std::f64::consts::TAU;

/// Rounds of empirical Bayes; the estimate settles in two or three.
const ROUNDS: usize = 4;
/// Bins whose normal equations are added up together.
const PART: usize = 64;
/// How powers rise towards zero frequency: as `1/k` for the estimate, between a level and a random walk, neither of which is known; as the
/// walk for the bands.
const ESTIMATED: i32 = 1;
const ALLOWED: i32 = 2;

/// The balance of a run over its whole spectrum.
pub(crate) struct Whole<'a> {
    setting: &'a Setting<'a>,
    loads: &'a [Load],
    known: &'a Known,
    bins: Vec<Bin>,
    record: Record,
    decays: Decays,
    /// Polynomials that jump where the record ends.
    ramps: [Vec<Complex64>; JUMPS],
    /// What forces of each load make that are slower than every mode.
    slow: Vec<Slow>,
    base: f64,
}

/// What one round knows: prior powers of the forces (one vector a load), the balance of each bin under them, the common unknowns
/// (two decays a mode, a jump a load) and their covariance.
struct Round {
    priors: Vec<Vec<f64>>,
    jumps: Vec<Jump>,
    solved: Vec<Solved>,
    common: Vec<f64>,
    covariance: Mat<f64>,
}

/// A run without an assumed period, its forces and free decays estimated; the bands cost more and are worked out when asked for.
pub(crate) struct Estimated<'a> {
    whole: Whole<'a>,
    round: Round,
}

impl<'a> Estimated<'a> {
    /// Estimates from what is left of the samples when what is `known` is taken off, which is put back at the end. `doubt` is the share
    /// of the accelerations that the structure itself may be wrong by.
    pub(crate) fn new(
        setting: &'a Setting<'a>,
        left: &Left,
        (known, doubt): (&'a Known, f64),
        loads: &'a [Load],
    ) -> Self {
        Self::in_rounds(ROUNDS, setting, left, (known, doubt), loads)
    }

    /// The same where what the forces leave without a prior, as samples of the fitted accelerations, is told to be worth it.
    pub(crate) fn if_worth(
        setting: &'a Setting<'a>,
        left: &Left,
        from: (&'a Known, f64),
        loads: &'a [Load],
        is_worth: impl Fn(&[Vec<f64>]) -> bool,
    ) -> Option<Self> {
        let whole = Whole::new(setting, left, from, loads);
        is_worth(&whole.fitted(&whole.free())).then(|| Self::of(whole, left, ROUNDS))
    }

    /// The same in so many rounds.
    fn in_rounds(
        rounds: usize,
        setting: &'a Setting<'a>,
        left: &Left,
        (known, doubt): (&'a Known, f64),
        loads: &'a [Load],
    ) -> Self {
        Self::of(Whole::new(setting, left, (known, doubt), loads), left, rounds)
    }

    fn of(whole: Whole<'a>, left: &Left, rounds: usize) -> Self {
        let mut round = whole.round(whole.tapered_priors(left));
        for _ in 1..rounds {
            round = whole.round(whole.updated_priors(&round, ESTIMATED));
        }
        Self { whole, round }
    }

    /// Samples of the fitted accelerations, sensor by sensor, what was known not put back.
    pub(crate) fn fitted(&self) -> Vec<Vec<f64>> {
        self.whole.fitted(&self.round)
    }

    /// The balance with its bands.
    pub(crate) fn balance(&self) -> RunBalance {
        let mut allowed = self.whole.updated_priors(&self.round, ALLOWED);
        allowed.iter_mut().flatten().for_each(|power| *power *= FROM_FEW);
        self.whole.outcome(&self.round, &self.whole.round(allowed))
    }
}

impl<'a> Whole<'a> {
    fn new(
        setting: &'a Setting<'a>,
        left: &Left,
        (known, doubt): (&'a Known, f64),
        loads: &'a [Load],
    ) -> Self {
        let model = &setting.structure.model;
        let record = Record::new(model, left.rate, left.force.len());
        let base = TAU * left.rate / record.samples as f64;
        let force = record.amplitudes(&left.force);
        let accelerations: Vec<_> = left.accelerations.iter().map(|a| record.amplitudes(a)).collect();
        let noise: Vec<f64> = left.noise_std.iter().map(|s| 4.0 / record.samples as f64 * s * s).collect();
        let bins = (0..record.order)
            .into_par_iter()
            .map(|k| {
                let here: Vec<Complex64> = accelerations.iter().map(|a| a[k]).collect();
                let variances: Vec<f64> =
                    noise.iter().zip(&here).map(|(v, a)| v + doubt * a.norm_sqr()).collect();
                let at = Amplitudes { exciter: force[k], accelerations: &here, variances: &variances };
                Bin::new(setting, loads, (base * (k as f64 + 1.0), record.modes), &at)
            })
            .collect();
        let decays = Decays::new(model, &record);
        let (ramps, slow) = (ends::ramps(&record), Slow::all(setting, loads, base));
        Self { setting, loads, known, bins, record, decays, ramps, slow, base }
    }

    /// Powers of the contact forces of the tapered record: a taper forgets the states at the ends.
    fn tapered_priors(&self, left: &Left) -> Vec<Vec<f64>> {
        let force = tapered_spectrum(&left.force);
        let accelerations: Vec<_> = left.accelerations.iter().map(|a| tapered_spectrum(a)).collect();
        let free = vec![f64::INFINITY; self.loads.len()];
        let powers = |(k, bin): (usize, &Bin)| -> Vec<f64> {
            let here: Vec<Complex64> = accelerations.iter().map(|a| a[k + 1]).collect();
            let at = Amplitudes { exciter: force[k + 1], accelerations: &here, variances: &[] };
            let solved = bin.solve(&free);
            let forces = bin.free_forces(&at, self.loads, &solved);
            forces.iter().zip(solved.variances()).map(|(f, v)| (f.norm_sqr() - v).max(0.0)).collect()
        };
        let found: Vec<Vec<f64>> = self.bins.par_iter().enumerate().map(powers).collect();
        self.priors(&found, ESTIMATED)
    }

    /// Powers of the estimate: its square and its variance.
    fn updated_priors(&self, round: &Round, tilt: i32) -> Vec<Vec<f64>> {
        let powers = |(k, solved): (usize, &Solved)| -> Vec<f64> {
            let forces = self.forces(k, round).0;
            forces.iter().zip(solved.variances()).map(|(f, v)| f.norm_sqr() + v).collect()
        };
        let found: Vec<Vec<f64>> = round.solved.par_iter().enumerate().map(powers).collect();
        self.priors(&found, tilt)
    }

    /// Prior powers from powers, one vector a bin.
    fn priors(&self, powers: &[Vec<f64>], tilt: i32) -> Vec<Vec<f64>> {
        let smooth = |load: usize| {
            let powers: Vec<f64> = powers.iter().map(|bin| bin[load]).collect();
            let variances: Vec<f64> = self.bins.iter().map(|bin| bin.variances[load]).collect();
            smoothed(&powers, &variances, (tilt, 0))
        };
        (0..self.loads.len()).into_par_iter().map(smooth).collect()
    }

    /// Every bin by itself: forces without a prior, and none of the common unknowns.
    fn free(&self) -> Round {
        let free = vec![f64::INFINITY; self.loads.len()];
        let priors = vec![vec![f64::INFINITY; self.bins.len()]; self.loads.len()];
        let unknowns = self.unknowns();
        Round {
            jumps: priors.iter().map(|_| Jump::none()).collect(),
            priors,
            solved: self.bins.par_iter().map(|bin| bin.solve(&free)).collect(),
            common: vec![0.0; unknowns],
            covariance: Mat::zeros(unknowns, unknowns),
        }
    }

    /// Number of the common unknowns.
    fn unknowns(&self) -> usize {
        self.decays.all.len() + JUMPS * self.loads.len()
    }

    /// The common unknowns by least squares over all bins, the contact forces eliminated.
    fn round(&self, priors: Vec<Vec<f64>>) -> Round {
        let jumps: Vec<Jump> = priors.iter().map(|powers| Jump::new(powers, self.base)).collect();
        let prior = |k: usize| -> Vec<f64> { priors.iter().map(|p| p[k]).collect() };
        let solved: Vec<Solved> =
            self.bins.par_iter().enumerate().map(|(k, bin)| bin.solve(&prior(k))).collect();
        let (mut matrix, right) = self.normal_equations(&jumps, &solved);
        let variances = jumps.iter().flat_map(|jump| jump.variances);
        for (i, variance) in variances.enumerate() {
            matrix[(self.decays.all.len() + i) * (right.len() + 1)] += variance.recip();
        }
        let (common, covariance) = least_squares(&matrix, &right);
        Round { priors, jumps, solved, common, covariance }
    }

    /// Normal matrix (upper triangle, row-major) and right side of the common unknowns.
    fn normal_equations(&self, jumps: &[Jump], solved: &[Solved]) -> (Vec<f64>, Vec<f64>) {
        let unknowns = self.unknowns();
        let zero = || (vec![0.0; unknowns * unknowns], vec![0.0; unknowns]);
        let add = |mut a: (Vec<f64>, Vec<f64>), b: (Vec<f64>, Vec<f64>)| {
            a.0.iter_mut().zip(&b.0).for_each(|(x, y)| *x += y);
            a.1.iter_mut().zip(&b.1).for_each(|(x, y)| *x += y);
            a
        };
        // Parts of one size, added in order: the sum is the same to the last digit however the work is shared out.
        let parts: Vec<_> = solved
            .par_chunks(PART)
            .enumerate()
            .map(|(part, solved)| {
                let mut sums = zero();
                for (i, solved) in solved.iter().enumerate() {
                    let k = part * PART + i;
                    self.accumulate((k, solved), &self.columns(k, jumps), &mut sums);
                }
                sums
            })
            .collect();
        parts.into_iter().fold(zero(), add)
    }

    /// The common unknowns in bin `k` (from 0): which of the bin's vectors each moves, and by how much.
    fn columns(&self, k: usize, jumps: &[Jump]) -> Vec<(usize, Complex64)> {
        let mut columns = Vec::with_capacity(self.decays.all.len() + JUMPS * jumps.len());
        columns.extend(self.decays.all.iter().enumerate().map(|(i, decay)| (i / 2, decay.acceleration[k])));
        for (u, jump) in jumps.iter().enumerate() {
            columns.extend(self.ramps.iter().map(|ramp| (self.record.modes + u, -ramp[k] * jump.below(k))));
        }
        columns
    }

    /// Adds one bin to the normal equations (upper triangle) of the common unknowns.
    fn accumulate(
        &self,
        (k, solved): (usize, &Solved),
        columns: &[(usize, Complex64)],
        (matrix, right): &mut (Vec<f64>, Vec<f64>),
    ) {
        let (products, along) = self.bins[k].left(solved);
        let size = along.len();
        for (i, (a, x)) in columns.iter().enumerate() {
            // Twice: a bin's real and imaginary parts have half the variance each.
            let twice = x.conj() * 2.0;
            right[i] += (twice * along[*a]).re;
            for (j, (b, y)) in columns.iter().enumerate().skip(i) {
                matrix[i * columns.len() + j] += (twice * products[a * size + b] * y).re;
            }
        }
    }

    /// Forces of bin `k`: what the prior is for, `h`, and what the structure answers, `h − J r̃`.
    fn forces(&self, k: usize, round: &Round) -> (Vec<Complex64>, Vec<Complex64>) {
        let (solved, columns) = (&round.solved[k], self.columns(k, &round.jumps));
        let taken = |u: usize| -> Complex64 {
            columns.iter().zip(&round.common).map(|((d, x), c)| solved.taken(u, *d) * x * *c).sum()
        };
        let held: Vec<Complex64> = (0..self.loads.len()).map(|u| solved.own[u] - taken(u)).collect();
        let below = |u: usize| -> Complex64 {
            let own = self.jump(u, 0)..self.jump(u, JUMPS);
            own.map(|i| columns[i].1 * round.common[i]).sum()
        };
        let answered = held.iter().enumerate().map(|(u, h)| h + below(u)).collect();
        (held, answered)
    }

    /// Index of a load's jump among the common unknowns.
    fn jump(&self, load: usize, order: usize) -> usize {
        self.decays.all.len() + JUMPS * load + order
    }
}

/// Least squares with the covariance, from the upper triangle of the normal matrix.
fn least_squares(matrix: &[f64], right: &[f64]) -> (Vec<f64>, Mat<f64>) {
    let n = right.len();
    // The unknowns have units of their own.
    let scale: Vec<f64> = (0..n).map(|i| matrix[i * (n + 1)].max(f64::MIN_POSITIVE).sqrt().recip()).collect();
    let normal = Mat::from_fn(n, n, |i, k| {
        let entry = matrix[i.min(k) * n + i.max(k)] * scale[i] * scale[k];
        // Rounding may leave a decay that no sensor sees without curvature.
        if i == k { entry * (1.0 + 1e-12) } else { entry }
    });
    let Ok(factor) = normal.llt(Side::Lower) else { return (vec![0.0; n], Mat::zeros(n, n)) };
    let solved = factor.solve(Col::from_fn(n, |i| right[i] * scale[i]));
    let inverse = factor.solve(Mat::<f64>::identity(n, n));
    let covariance = Mat::from_fn(n, n, |i, k| inverse[(i, k)] * scale[i] * scale[k]);
    ((0..n).map(|i| solved[i] * scale[i]).collect(), covariance)
}
