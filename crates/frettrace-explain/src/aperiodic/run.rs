//! A law along a recovered motion, beside what the recovery leaves open.
//!
//! Recovered less answered force in the bins of the tapered record, `r(ξ) = (F̂ + Σ ξ_p F_p − L(u, v, N; ξ))/σ`, is judged at the errors
//! `ξ` that make `|r(ξ)|² + |ξ|²` least: what is slower than a record no accelerometer sees, and a friction law answers to it in all bins.
//! The minimum follows a law by `dξ/dp = −(I + DᵀD)⁻¹ Dᵀ ∂r/∂p` with `D = ∂r/∂ξ`.

mod weights;

use super::motion::{Motion, WholeRun};
use crate::contact_fit::LANES;
use crate::records::BAND;
use crate::series::{Series, resistance};
use frettrace_fourier::tapered_spectrum;
use frettrace_friction::effects::{Circumstance, ModifiedLaw, Reached};
use frettrace_friction::{Gradient, Scalar, Step};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Part of a step by which the jump of a rigid contact's force may be misplaced.
const JUMP: f64 = 0.25;
/// Standard deviations that a bin must exceed to be compared.
const KNOWN: f64 = 3.0;
/// Draws of the errors that each bin has of its own, and bins on each side that are taken together for their size: with 8 draws of 9 bins a
/// variance is known to `√(1/72) = 12 %`.
const DRAWS: usize = 8;
const NEAR: usize = 4;
/// Size in standard deviations, over all bins, below which what a shared error does is left where it is.
const IDLE: f64 = 0.05;
/// Standard deviations that a drift as large as the force weighs.
const LEAST_DRIFT: f64 = 10.0;
/// Standard deviations of the phase of a modulation (rad) and of its periods in a record.
const WAVE: [f64; 2] = [0.5, 0.25];
/// Step of differences by an error of unit size.
const STEP: f64 = 1e-2;
/// Steps towards the errors that go with a law, and the share of the cost that one must take for another.
const STEPS: usize = 4;
const WORTH: f64 = 1e-3;

/// Modulation of the preload, `cos(ωt + φ)`: frequency (rad/s), the same in all runs, and phase at the first sample (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wave {
    pub omega: f64,
    pub phase: f64,
}

/// A run ready for comparison.
#[derive(Clone)]
pub(crate) struct OpenRun {
    /// Index of the run in the case.
    pub index: usize,
    pub whole: Arc<WholeRun>,
    circumstance: Circumstance,
    rigid: bool,
    /// Slip lost per unit force in each bin of the record (m/N).
    gain: Arc<Vec<Complex64>>,
    /// Bins compared, and the standard deviations of real and imaginary part.
    bins: Vec<usize>,
    deviation: Vec<f64>,
    pub wave: Wave,
    /// Steps of the law in a sample.
    fine: usize,
    /// Shared errors in use.
    shared: Arc<Vec<Motion>>,
    /// Whether they are counted from those that go with a law.
    turned: bool,
    /// First bin above half the excitation's frequency.
    slow: usize,
}

/// Errors that go with a law, and the directions in which they move what it leaves.
#[derive(Clone, Default)]
pub(crate) struct Open {
    pub xi: DVector<f64>,
    pub directions: Arc<DMatrix<f64>>,
    /// `(I + DᵀD)⁻¹`.
    inverse: Arc<DMatrix<f64>>,
}

impl Open {
    fn new(xi: DVector<f64>, directions: DMatrix<f64>) -> Option<Self> {
        let count = directions.ncols();
        let normal = DMatrix::identity(count, count) + directions.tr_mul(&directions);
        let inverse = normal.cholesky()?.inverse();
        Some(Self { xi, directions: Arc::new(directions), inverse: Arc::new(inverse) })
    }

    /// How the errors follow a change of what a law leaves.
    pub fn follow(&self, change: &DVector<f64>) -> DVector<f64> {
        -(&*self.inverse * self.directions.tr_mul(change))
    }
}

/// A signal less its mean over a window about each sample.
fn faster(x: &[f64], window: usize) -> Vec<f64> {
    let mut sums = vec![0.0; x.len() + 1];
    for (k, x) in x.iter().enumerate() {
        sums[k + 1] = sums[k] + x;
    }
    let mean = |k: usize| {
        let (from, to) = (k.saturating_sub(window / 2), (k + window.div_ceil(2)).min(x.len()));
        (sums[to] - sums[from]) / (to - from).max(1) as f64
    };
    x.iter().enumerate().map(|(k, x)| x - mean(k)).collect()
}

impl OpenRun {
    /// A run under its circumstances, of a contact that is `rigid` or yields; `None` where no bin of its force is known.
    pub fn new(
        index: usize,
        (whole, gain): (Arc<WholeRun>, Arc<Vec<Complex64>>),
        (circumstance, rigid, excitation): (Circumstance, bool, f64),
    ) -> Option<Self> {
        let samples = whole.found.force.len();
        let kept = samples - Series::settling(samples);
        let slow = (0.5 * excitation * kept as f64 * whole.dt / TAU) as usize;
        let mut run = Self {
            index,
            whole,
            circumstance,
            rigid,
            gain,
            bins: Vec::new(),
            deviation: Vec::new(),
            wave: Wave::default(),
            fine: 1,
            shared: Arc::new(Vec::new()),
            turned: false,
            slow,
        };
        run.shared = Arc::new(run.whole.shared.clone());
        let xi = run.least_drift();
        let measured = Series::amplitudes(&run.moved(&xi).force);
        let trusted = (BAND * measured.len() as f64) as usize;
        run.bins = (2..trusted).step_by(2).collect();
        run.deviation = vec![1.0; run.bins.len()];
        let noise = run.deviations(&|motion: &Motion| vec![0.0; motion.force.len()], &xi);
        let told = |(k, noise): (&usize, &f64)| (measured[*k].norm() > KNOWN * noise).then_some((*k, *noise));
        let (bins, noise): (Vec<usize>, Vec<f64>) = run.bins.iter().zip(&noise).filter_map(told).unzip();
        (run.bins, run.deviation) = (bins, noise);
        run.blur(&measured);
        (!run.bins.is_empty()).then_some(run)
    }

    /// Number of real residuals.
    pub fn count(&self) -> usize {
        2 * self.bins.len()
    }

    /// Number of shared errors.
    pub fn errors(&self) -> usize {
        self.shared.len() + if self.is_modulated() { WAVE.len() } else { 0 }
    }

    fn is_modulated(&self) -> bool {
        self.wave.omega > 0.0
    }

    /// The modulation with the errors that a run has of it, beside the shared ones: phase, and frequency about the middle of the record.
    fn waved(&self, xi: &DVector<f64>) -> Wave {
        if !self.is_modulated() {
            return self.wave;
        }
        let whole = self.whole.dt * self.whole.found.force.len() as f64;
        let [phase, turns] = std::array::from_fn(|k| xi[self.shared.len() + k] * WAVE[k]);
        let faster = TAU * turns / whole;
        Wave { omega: self.wave.omega + faster, phase: self.wave.phase + phase - 0.5 * faster * whole }
    }

    /// Errors of which some are new, from a run without them.
    pub fn extended(&self, law: &ModifiedLaw<f64>, open: &Open) -> Option<Open> {
        if open.xi.len() == self.errors() {
            return Some(open.clone());
        }
        self.open(law, open.xi.clone().resize_vertically(self.errors(), 0.0))
    }

    /// The same run with so many steps of the law in a sample.
    pub fn refined(&self, fine: usize) -> Self {
        Self { fine, ..self.clone() }
    }

    /// Turns the shared errors to the directions in which they move what a law leaves, `D = U S Vᵀ`, and leaves those that move it by
    /// less than [`IDLE`] where they are: errors of unit size and independent of each other stay so when they are turned.
    pub fn turn(&mut self, open: &Open) {
        let parts = (*open.directions).clone().svd(false, true);
        let Some(turned) = parts.v_t else { return };
        let found = self.moved(&open.xi);
        let along = |row: usize| {
            let mut sum = Motion::nothing(found.force.len());
            self.shared.iter().enumerate().for_each(|(p, error)| sum.add(error, turned[(row, p)]));
            sum
        };
        let used = parts.singular_values.iter().filter(|size| **size > IDLE).count();
        let kept: Vec<Motion> = (0..used).map(along).collect();
        let xi = &turned * &open.xi;
        // What stays free is counted from where it was found without a law.
        let mut whole = WholeRun { found, shared: Vec::new(), ..(*self.whole).clone() };
        kept.iter().zip(xi.iter()).for_each(|(error, xi)| whole.found.add(error, -xi));
        (self.whole, self.shared, self.turned) = (Arc::new(whole), Arc::new(kept), true);
    }

    /// The recovered motion with errors.
    pub fn moved(&self, xi: &DVector<f64>) -> Motion {
        let mut motion = self.whole.found.clone();
        self.shared.iter().zip(xi.iter()).for_each(|(error, xi)| motion.add(error, *xi));
        motion
    }

    /// The errors of a drift, whose power lies below half the excitation's frequency, that leave the least force: a drift of unknown size is taken
    /// for none to begin with.
    fn least_drift(&self) -> DVector<f64> {
        let mut xi = DVector::zeros(self.errors());
        if self.turned {
            return xi;
        }
        let power = |z: &Complex64| z.norm_sqr();
        let spectra: Vec<Vec<Complex64>> =
            self.shared.iter().map(|error| Series::amplitudes(&error.force)).collect();
        let drifts = |spectrum: &Vec<Complex64>| {
            let slow: f64 = spectrum[..self.slow.min(spectrum.len())].iter().map(power).sum();
            2.0 * slow > spectrum.iter().map(power).sum()
        };
        let drifting: Vec<usize> = (0..spectra.len()).filter(|&p| drifts(&spectra[p])).collect();
        if drifting.is_empty() {
            return xi;
        }
        let found = Series::amplitudes(&self.whole.found.force);
        let faster: f64 = found[self.slow.min(found.len())..].iter().map(power).sum();
        let unit = (0.5 * faster).max(1e-6 * self.whole.found.force_power()).sqrt().max(f64::MIN_POSITIVE);
        let reals = |spectrum: &Vec<Complex64>| {
            let reals = spectrum.iter().flat_map(|z| [z.re, z.im]).map(|x| x * LEAST_DRIFT / unit);
            DVector::from_iterator(2 * spectrum.len(), reals)
        };
        let columns: Vec<DVector<f64>> = drifting.iter().map(|&p| reals(&spectra[p])).collect();
        let open = Open::new(DVector::zeros(columns.len()), DMatrix::from_columns(&columns));
        let found = open.map(|open| open.follow(&reals(&found)));
        for (&p, value) in drifting.iter().zip(found.iter().flat_map(|found| found.iter())) {
            xi[p] = *value;
        }
        xi
    }

    /// The recovered motion with the least drift that the accelerations allow, and without what is slower than two periods of the excitation: what
    /// the first values of a law are read from.
    pub fn quiet(&self) -> Motion {
        let motion = self.moved(&self.least_drift());
        Motion {
            force: self.faster(&motion.force),
            slip: self.faster(&motion.slip),
            velocity: self.faster(&motion.velocity),
            normal: motion.normal,
        }
    }

    /// A signal of the run without what is slower than two periods of the excitation.
    pub fn faster(&self, signal: &[f64]) -> Vec<f64> {
        let samples = signal.len();
        let kept = samples - Series::settling(samples);
        let periods = 2.0 * self.slow.max(1) as f64 * samples as f64 / kept as f64;
        faster(signal, (2.0 * samples as f64 / periods).round() as usize)
    }

    /// Force (N) of a law along a motion, from rest. A rigid contact takes the recovered force where it holds.
    fn answer<T: Scalar>(&self, law: &ModifiedLaw<T>, motion: &Motion, wave: Wave) -> Vec<T> {
        let motion = &motion.refined(self.fine);
        let dt = self.whole.dt / self.fine as f64;
        let held = self.rigid && !law.yields();
        let resistance = if held { resistance(&motion.force, &motion.velocity) } else { 0.0 };
        let mut state = law.rest_at(T::from(motion.slip[0]));
        let mut reached = Reached::default();
        let mut force = vec![T::from(0.0); motion.slip.len()];
        let turn = Complex64::from_polar(1.0, wave.omega * dt);
        let mut phase = Complex64::from_polar(1.0, wave.phase);
        for (k, force) in force.iter_mut().enumerate().skip(1) {
            let ends = |series: &[f64]| [T::from(series[k - 1]), T::from(series[k])];
            let step = Step {
                slip: ends(&motion.slip),
                velocity: ends(&motion.velocity),
                normal: ends(&motion.normal),
                dt,
            };
            let next = phase * turn;
            let circumstance =
                Circumstance { phase: [[phase.re, phase.im], [next.re, next.im]], ..self.circumstance };
            phase = next;
            (state, *force) = if held {
                let trial = motion.force[k] + resistance * motion.velocity[k];
                law.advance_rigid(state, &step, (T::from(trial), &circumstance))
            } else {
                law.advance_on(state, &step, (&circumstance, &mut reached))
            };
        }
        force
    }

    /// Force of a law at the errors that go with it, sample by sample, and the motion there.
    pub fn answered(&self, law: &ModifiedLaw<f64>, xi: &DVector<f64>) -> (Motion, Vec<f64>) {
        let motion = self.moved(xi);
        let force = self.answer(law, &motion, self.waved(xi));
        (motion, force.into_iter().step_by(self.fine).collect())
    }

    /// Amplitudes of an answer in the bins of the record: its harmonics beyond the recorded band do not fold into it.
    fn amplitudes(&self, answer: &[f64]) -> Vec<Complex64> {
        let samples = answer.len() / self.fine;
        tapered_spectrum(&answer[self.fine * Series::settling(samples)..])
    }

    fn whitened(&self, spectrum: impl Fn(usize) -> Complex64) -> DVector<f64> {
        let left = self.bins.iter().zip(&self.deviation).map(|(&k, deviation)| spectrum(k) / *deviation);
        DVector::from_iterator(self.count(), left.flat_map(|left| [left.re, left.im]))
    }

    /// What a law leaves at some errors, whitened.
    pub fn left(&self, law: &ModifiedLaw<f64>, xi: &DVector<f64>) -> DVector<f64> {
        let motion = self.moved(xi);
        let answered = self.amplitudes(&self.answer(law, &motion, self.waved(xi)));
        let force = Series::amplitudes(&motion.force);
        self.whitened(|k| force[k] - answered[k])
    }

    /// Errors where nothing is known of a law, with the directions around it.
    pub fn begin(&self, law: &ModifiedLaw<f64>) -> Option<Open> {
        let xi = self.least_drift();
        self.open(law, xi)
    }

    /// Directions around a law and errors.
    pub fn open(&self, law: &ModifiedLaw<f64>, xi: DVector<f64>) -> Option<Open> {
        let base = self.left(law, &xi);
        let mut directions = DMatrix::zeros(self.count(), self.errors());
        for (p, mut column) in directions.column_iter_mut().enumerate() {
            let mut moved = xi.clone();
            moved[p] += STEP;
            column.copy_from(&((self.left(law, &moved) - &base) / STEP));
        }
        directions.iter().all(|d| d.is_finite()).then(|| Open::new(xi, directions))?
    }

    /// Moves the errors to where they go with a law; what is left there, and the cost `|r|² + |ξ|²`.
    pub fn settle(&self, law: &ModifiedLaw<f64>, open: &mut Open) -> (DVector<f64>, f64) {
        let cost = |left: &DVector<f64>, xi: &DVector<f64>| left.norm_squared() + xi.norm_squared();
        let mut left = self.left(law, &open.xi);
        let mut now = cost(&left, &open.xi);
        for _ in 0..STEPS {
            // Where the linear problem has its minimum: `ξ = −(I + DᵀD)⁻¹ Dᵀ (r − Dξ)`.
            let change = open.follow(&(&left - &*open.directions * &open.xi)) - &open.xi;
            let better = [1.0, 0.3, 0.1].into_iter().find_map(|share| {
                let xi = &open.xi + share * &change;
                let after = self.left(law, &xi);
                let value = cost(&after, &xi);
                (value < now).then_some((xi, after, value))
            });
            let Some((xi, after, value)) = better else { break };
            let done = value > (1.0 - WORTH) * now;
            (open.xi, left, now) = (xi, after, value);
            if done {
                break;
            }
        }
        (left, now)
    }

    /// Derivatives of the whitened residual by what varies in a law, one column a lane.
    pub fn slopes(
        &self,
        law: &ModifiedLaw<Gradient<LANES>>,
        lanes: usize,
        xi: &DVector<f64>,
    ) -> Vec<DVector<f64>> {
        let force = self.answer(law, &self.moved(xi), self.waved(xi));
        let lane = |lane: usize| {
            let slopes: Vec<f64> = force.iter().map(|f| -f.slopes[lane]).collect();
            let slopes = self.amplitudes(&slopes);
            self.whitened(|k| slopes[k])
        };
        (0..lanes).map(lane).collect()
    }

    /// Sums over the bins compared of what a law leaves, of its standard deviation and of the force, squared (N²).
    pub fn squares(&self, law: &ModifiedLaw<f64>, xi: &DVector<f64>) -> [f64; 3] {
        let motion = self.moved(xi);
        let answered = self.amplitudes(&self.answer(law, &motion, self.waved(xi)));
        let force = Series::amplitudes(&motion.force);
        let bins = || self.bins.iter().zip(&self.deviation);
        [
            bins().map(|(&k, _)| (force[k] - answered[k]).norm_sqr()).sum(),
            bins().map(|(_, deviation)| 2.0 * deviation * deviation).sum(),
            bins().map(|(&k, _)| force[k].norm_sqr()).sum(),
        ]
    }
}
