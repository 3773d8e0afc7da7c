//! The law on the recovered motion of a run that is not periodic: force against force, bin by bin of the record.
//!
//! No waveform is predicted: the law is marched along the recovered slip and normal force, and its answer is compared with
//! the recovered force in the bins the sensors know. The record is tapered, so that the unknown state at its start, a
//! tenth of it, does not matter.

use crate::contact_fit::{LANES, columns, places};
use crate::series::Series;
use frettrace_friction::effects::{Circumstance, Hook, ModifiedLaw};
use frettrace_friction::{Gradient, Scalar};
use nalgebra::{DMatrix, DMatrixViewMut, DVector};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Whether a law depends on the phase of something beside the contact's motion.
pub(crate) fn asks_the_clock(law: &ModifiedLaw<f64>) -> bool {
    law.get(Hook::ModulationCosine).is_some()
}

/// Half periods in a record of the fastest motion that counts as slow: recovered accelerations are integrated twice, and what they leave of
/// a drift reaches so far.
const SLOW: usize = 10;
/// Step of differences by such a motion, over the RMS of the slip.
const SLOW_STEP: f64 = 1e-4;
/// Steps of its fit, and the share of the error that one must leave at most for another.
const SLOW_STEPS: usize = 8;
const SLOW_DONE: f64 = 0.98;
/// Relative error below which no such motion is asked for.
const CLEAR: f64 = 0.01;
/// Relative accuracy of a recovered force: what drift, taper and the structure's errors leave.
pub(crate) const ACCURACY: f64 = 0.01;

/// A run ready for comparison.
#[derive(Clone)]
pub(crate) struct SeriesContact {
    series: Series,
    /// Recovered force with the velocity's share, which a rigid contact takes as long as it holds; empty where the contact
    /// yields.
    trial: Vec<f64>,
    circumstance: Circumstance,
    /// Bins compared: index and standard deviation.
    bins: Vec<(usize, f64)>,
    measured: Vec<Complex64>,
    /// χ² per residual that counts for a model which the run does not judge.
    silent: f64,
}

impl SeriesContact {
    /// Prepares the last `most` samples of a run, of a contact that is `rigid` or yields; `None` where no bin of its force is
    /// known.
    pub fn new(series: &Series, circumstance: Circumstance, (rigid, most): (bool, usize)) -> Option<Self> {
        let series = series.last(most);
        let trial = if rigid { series.trial() } else { Vec::new() };
        let measured = Series::amplitudes(&series.force);
        let deviation = |k: usize| series.deviation_of(k, series.force.len());
        let known: Vec<usize> =
            (2..measured.len()).step_by(2).filter(|&k| measured[k].norm() > 3.0 * deviation(k)).collect();
        let size: f64 = known.iter().map(|&k| measured[k].norm_sqr()).sum();
        let least = ACCURACY * (0.5 * size / known.len().max(1) as f64).sqrt();
        let bins = known.iter().map(|&k| (k, deviation(k).hypot(least))).collect::<Vec<_>>();
        (!bins.is_empty()).then_some(Self { series, trial, circumstance, bins, measured, silent: 1.0 })
    }

    fn answer<T: Scalar>(&self, law: &ModifiedLaw<T>) -> Vec<T> {
        let holds = !self.trial.is_empty() && !law.yields();
        self.series.answer(law, &self.circumstance, holds.then_some(&self.trial[..]))
    }

    /// Number of real residuals.
    pub fn count(&self) -> usize {
        2 * self.bins.len()
    }

    /// From here on it counts as much for a model that it does not judge as the declared `law` leaves, which is the noise or less than that where the
    /// deviations are those of a method that did better, and one per residual at most. Beside models that are judged it is no evidence for
    /// one or the other.
    pub fn silence(&mut self, law: &ModifiedLaw<f64>) {
        self.silent = (self.cost(law) / self.count() as f64).min(1.0);
    }

    /// χ² that counts for a model which the run does not judge.
    pub fn silent_cost(&self) -> f64 {
        self.silent * self.count() as f64
    }

    /// Recovered minus answered force over the standard deviations; the same in every value, whatever the law, where that asks for the phase of a
    /// clock: a run without a period has none to share with the others.
    pub fn residual(&self, law: &ModifiedLaw<f64>, out: &mut [f64]) {
        if asks_the_clock(law) {
            out.fill(self.silent.sqrt());
        } else {
            self.left(&self.answer(law), out);
        }
    }

    /// Recovered minus the given force over the standard deviations.
    fn left(&self, force: &[f64], out: &mut [f64]) {
        let answered = Series::amplitudes(force);
        for (pair, (k, deviation)) in out.chunks_mut(2).zip(&self.bins) {
            let left = (self.measured[*k] - answered[*k]) / *deviation;
            pair.copy_from_slice(&[left.re, left.im]);
        }
    }

    /// The residual, and its derivatives by the hooks of a law, a column each.
    pub fn linearise(
        &self,
        law: &ModifiedLaw<f64>,
        hooks: &[(usize, Hook)],
        (residual, mut jacobian): (&mut [f64], DMatrixViewMut<'_, f64>),
    ) {
        if asks_the_clock(law) {
            residual.fill(1.0);
            jacobian.fill(0.0);
            return;
        }
        let mut plain = Vec::new();
        let whitened = |samples: &[f64]| {
            let bins = Series::amplitudes(samples);
            self.bins.iter().map(|(k, deviation)| bins[*k] / *deviation).collect()
        };
        let answer = |law: &ModifiedLaw<Gradient<LANES>>| {
            let force = self.answer(law);
            // The first march with derivatives is the march as well.
            if plain.is_empty() {
                plain = force.iter().map(|f| f.re).collect();
            }
            force
        };
        columns((law, hooks), (jacobian, LANES), answer, whitened);
        if plain.is_empty() {
            plain = self.answer(law);
        }
        self.left(&plain, residual);
    }

    /// The same motion around a mean slip (m), which no accelerometer sees.
    pub fn around(&self, mean: f64) -> Self {
        let mut moved = self.clone();
        moved.series.slip.iter_mut().for_each(|slip| *slip += mean);
        moved
    }

    /// RMS of the slip about its mean (m).
    pub fn stroke(&self) -> f64 {
        self.series.stroke()
    }

    /// Mean slip (m) around which a law whose friction depends on the place answers best: the best of the places that are tried, and on from
    /// there.
    fn mean_slip(&self, law: &ModifiedLaw<f64>) -> f64 {
        let residual = |mean: f64| {
            let mut left = DVector::zeros(self.count());
            self.around(mean).residual(law, left.as_mut_slice());
            left
        };
        let tried = places(law, self.stroke()).map(|mean| (residual(mean), mean));
        let best = tried.min_by(|a, b| a.0.norm().total_cmp(&b.0.norm()));
        let Some((mut left, mut mean)) = best else { return 0.0 };
        let step = SLOW_STEP * self.stroke();
        for _ in 0..SLOW_STEPS {
            let slope = (residual(mean + step) - &left) / step;
            let moved = mean - slope.dot(&left) / slope.norm_squared().max(f64::MIN_POSITIVE);
            let after = residual(moved);
            if after.norm() >= SLOW_DONE * left.norm() || !after.norm().is_finite() {
                break;
            }
            (mean, left) = (moved, after);
        }
        mean
    }

    /// χ² of a law, where its friction depends on the place around the mean slip with which it answers best.
    pub fn cost(&self, law: &ModifiedLaw<f64>) -> f64 {
        if law.depends_on_place() {
            self.around(self.mean_slip(law)).cost_here(law)
        } else {
            self.cost_here(law)
        }
    }

    /// χ² of a law on the motion as it is.
    fn cost_here(&self, law: &ModifiedLaw<f64>) -> f64 {
        let mut left = vec![0.0; self.count()];
        self.residual(law, &mut left);
        let sum: f64 = left.iter().map(|r| r * r).sum();
        if sum.is_finite() { sum } else { f64::MAX.sqrt() }
    }

    /// Relative RMS of recovered minus answered force in the bins compared, beside a motion of the contact that is as slow as the record
    /// and that accelerometers do not see: `Σ a_j cos(jπt/T)` with amplitudes that make the error least. A friction force answers to
    /// such a motion in all bins, and to where the contact rests (`j = 0`) if it depends on the place.
    pub fn error(&self, law: &ModifiedLaw<f64>) -> f64 {
        if law.depends_on_place() {
            // One place may be a valley of its own.
            [0.0, self.mean_slip(law)]
                .map(|mean| self.error_from(law, mean))
                .into_iter()
                .fold(f64::INFINITY, f64::min)
        } else {
            self.error_from(law, 0.0)
        }
    }

    /// The same with a motion that is sought from a mean slip (m).
    fn error_from(&self, law: &ModifiedLaw<f64>, mean: f64) -> f64 {
        let size: f64 = self.bins.iter().map(|(k, _)| self.measured[*k].norm_sqr()).sum();
        let relative = |left: &DVector<f64>| left.norm() / size.max(f64::MIN_POSITIVE).sqrt();
        let mut motion = [0.0; SLOW + 1];
        motion[0] = mean;
        let mut left = self.left_beside(law, &motion);
        // A rigid contact is driven by its velocity and by its force together.
        let held = !self.trial.is_empty();
        if held || relative(&left) < CLEAR || !left.norm().is_finite() {
            return relative(&left);
        }
        let step = SLOW_STEP * self.series.stroke();
        let first = usize::from(!law.depends_on_place());
        for _ in 0..SLOW_STEPS {
            let beside: Vec<DVector<f64>> = (first..=SLOW)
                .map(|j| {
                    let mut moved = motion;
                    moved[j] += step;
                    (self.left_beside(law, &moved) - &left) / step
                })
                .collect();
            let tangents = DMatrix::from_columns(&beside);
            if !tangents.iter().all(|x| x.is_finite()) {
                break;
            }
            let Ok(change) = tangents.svd(true, true).solve(&left, 0.0) else { break };
            let better = [1.0, 0.3, 0.1].into_iter().find_map(|share| {
                let mut moved = motion;
                moved[first..].iter_mut().zip(&change).for_each(|(a, change)| *a -= share * change);
                let after = self.left_beside(law, &moved);
                (after.norm() < left.norm()).then_some((moved, after))
            });
            let Some((moved, after)) = better else { break };
            let done = after.norm() > SLOW_DONE * left.norm();
            (motion, left) = (moved, after);
            if done {
                break;
            }
        }
        relative(&left)
    }

    /// Recovered minus answered force (N) in the bins compared, with a slow motion beside the recovered one.
    fn left_beside(&self, law: &ModifiedLaw<f64>, motion: &[f64; SLOW + 1]) -> DVector<f64> {
        let moved =
            if motion.iter().all(|a| *a == 0.0) { self.answer(law) } else { self.answer_beside(law, motion) };
        let answered = Series::amplitudes(&moved);
        let left = self.bins.iter().map(|(k, _)| self.measured[*k] - answered[*k]);
        DVector::from_iterator(self.count(), left.flat_map(|left| [left.re, left.im]))
    }

    fn answer_beside(&self, law: &ModifiedLaw<f64>, motion: &[f64; SLOW + 1]) -> Vec<f64> {
        let mut series = self.series.clone();
        let rate = PI / (series.dt * series.slip.len() as f64);
        for (k, (slip, velocity)) in series.slip.iter_mut().zip(&mut series.velocity).enumerate() {
            for (j, amplitude) in motion.iter().enumerate() {
                let number = rate * j as f64;
                let (sine, cosine) = (number * k as f64 * self.series.dt).sin_cos();
                *slip += amplitude * cosine;
                *velocity -= amplitude * number * sine;
            }
        }
        series.answer(law, &self.circumstance, None)
    }
}

#[cfg(test)]
mod tests {
    /// A run under a preload (N).
    fn pressed(preload: f64) -> Circumstance {
        Circumstance { preload, ..Circumstance::default() }
    }

    use super::*;

    /// A slip of two incommensurable tones, and the force of a law along it.
    fn series(law: &ModifiedLaw<f64>) -> Series {
        let dt = 1.0 / 2048.0;
        let n = 4096;
        let at = |k: usize| {
            let t = k as f64 * dt;
            let (a, b) = (2.0 * std::f64::consts::PI * 20.0, 2.0 * std::f64::consts::PI * 13.7);
            let slip = 1e-4 * ((a * t).sin() + 0.6 * (b * t).cos());
            (slip, 1e-4 * (a * (a * t).cos() - 0.6 * b * (b * t).sin()))
        };
        let (slip, velocity) = (0..n).map(at).unzip();
        let mut found = Series {
            dt,
            slip,
            velocity,
            normal: vec![20.0; n],
            force: vec![0.0; n],
            deviation: vec![1e-4; n / 2],
            open_share: 0.0,
        };
        let blank = SeriesContact {
            series: found.clone(),
            trial: Vec::new(),
            circumstance: Circumstance::default(),
            bins: Vec::new(),
            measured: Vec::new(),
            silent: 1.0,
        };
        found.force = blank.answer(law);
        found
    }

    /// A law, and the same with a Stribeck rise of a half.
    fn laws() -> [ModifiedLaw<f64>; 2] {
        let plain: ModifiedLaw<f64> = ModifiedLaw::dahl(4e4, 0.3);
        let mut falling = plain;
        falling.set(Hook::StribeckRise, 0.15);
        falling.set(Hook::StribeckVelocity, 4e-3);
        falling.set(Hook::StribeckExponent, 2.0);
        [plain, falling]
    }

    /// For a model that a run does not judge it counts as for the declared law: one a residual before there is one and where that misses the force,
    /// next to nothing where it made it.
    #[test]
    fn a_run_without_a_period_is_no_evidence_of_what_it_does_not_judge() {
        let [plain, falling] = laws();
        let contact = SeriesContact::new(&series(&falling), pressed(20.0), (false, 4096)).unwrap();
        let count = contact.count() as f64;
        let mut clocked = falling;
        clocked.set(Hook::ModulationCosine, 0.1);
        let right = contact.cost(&falling);
        assert!(right < 1e-9 * count, "{right}");
        let [missed, met] = [&plain, &falling].map(|law| {
            let mut contact = contact.clone();
            contact.silence(law);
            contact
        });
        for (one, counts) in [(contact, count), (missed, count), (met, right)] {
            for found in [one.silent_cost(), one.cost(&clocked)] {
                assert!((found - counts).abs() < 1e-9 * count, "{found} {counts}");
            }
        }
    }

    /// The law that made the force leaves nothing; one without its Stribeck rise of a half leaves more than a twentieth
    /// of it, five times the accuracy assumed (25 in χ² a residual).
    #[test]
    fn the_law_is_judged_without_a_period() {
        let [plain, falling] = laws();
        // A part begins with another state than at rest; its first tenth, a period of the motion, wears that off.
        for (most, rest) in [(4096, 1e-9), (1024, 1e-3)] {
            let contact = SeriesContact::new(&series(&falling), pressed(20.0), (false, most)).unwrap();
            assert!(contact.error(&falling) < rest, "{}", contact.error(&falling));
            assert!(contact.error(&plain) > 0.05, "{}", contact.error(&plain));
            assert!(contact.cost(&plain) > 20.0 * contact.count() as f64);
        }
    }

    /// A contact that drifts by its stroke while the record is made: the recovered motion lacks that, and the law along it misses a tenth of
    /// the force. With the drift free the law that made the force leaves a hundredth, and another one what it lacks.
    #[test]
    fn a_drift_that_no_sensor_sees_is_not_the_laws() {
        let [plain, falling] = laws();
        let mut recovered = series(&falling);
        let whole = SeriesContact::new(&recovered, pressed(20.0), (false, usize::MAX)).unwrap();
        let mut drift = [0.0; SLOW + 1];
        (drift[1], drift[3], drift[7]) = (4e-4, -1e-4, 5e-5);
        recovered.force = whole.answer_beside(&falling, &drift);
        let contact = SeriesContact::new(&recovered, pressed(20.0), (false, usize::MAX)).unwrap();
        let size: f64 = contact.bins.iter().map(|(k, _)| contact.measured[*k].norm_sqr()).sum();
        let blind = contact.left_beside(&falling, &[0.0; SLOW + 1]).norm() / size.sqrt();
        assert!(blind > 0.1, "{blind}");
        assert!(contact.error(&falling) < 0.01, "{}", contact.error(&falling));
        assert!(contact.error(&plain) > 0.05, "{}", contact.error(&plain));
    }

    /// Friction that falls along the path, of a contact that rests most of a stroke away from where the recovered motion has its mean, marched
    /// in steps a quarter as long: the law around that mean misses a tenth of the force and more, and a hundredth around the place that is found.
    #[test]
    fn where_a_contact_rests_is_found_if_its_friction_depends_on_the_place() {
        let [mut law, _] = laws();
        law.set(Hook::Position, -2e3);
        let recovered = series(&law);
        let (fine, offset) = (4, 7e-5);
        let mut moved = recovered.clone();
        moved.dt /= f64::from(fine);
        let tones = |t: f64| {
            let (a, b) = (2.0 * PI * 20.0, 2.0 * PI * 13.7);
            let slip = 1e-4 * ((a * t).sin() + 0.6 * (b * t).cos());
            (offset + slip, 1e-4 * (a * (a * t).cos() - 0.6 * b * (b * t).sin()))
        };
        let samples = recovered.slip.len() * fine as usize;
        (moved.slip, moved.velocity) = (0..samples).map(|k| tones(k as f64 * moved.dt)).unzip();
        moved.normal = vec![20.0; samples];
        let force = moved.answer(&law, &pressed(20.0), None);
        let seen = Series { force: force.into_iter().step_by(fine as usize).collect(), ..recovered };
        let contact = SeriesContact::new(&seen, pressed(20.0), (false, usize::MAX)).unwrap();
        let size: f64 = contact.bins.iter().map(|(k, _)| contact.measured[*k].norm_sqr()).sum();
        let blind = contact.left_beside(&law, &[0.0; SLOW + 1]).norm() / size.sqrt();
        assert!(blind > 0.1, "{blind}");
        assert!((contact.mean_slip(&law) - offset).abs() < 0.02 * offset, "{:e}", contact.mean_slip(&law));
        assert!(contact.error(&law) < 0.01, "{}", contact.error(&law));
        let count = contact.count() as f64;
        assert!(contact.cost_here(&law) > 100.0 * count && contact.cost(&law) < count);
    }

    /// A rigid contact under two incommensurable tones that holds whatever is slower than a fifth of the largest speed, and takes a
    /// ramp of force from one slide to the next meanwhile. Its velocity is known to a hundredth: sliding tells the law to that
    /// share of its rise, holding nothing. A bristle stiff enough to hold turns the same hundredth of the slip into half the force.
    #[test]
    fn a_rigid_contact_takes_the_recovered_force_where_it_holds() {
        let (dt, n, load) = (1.0 / 4096.0, 8192, 20.0);
        let mut law: ModifiedLaw<f64> = ModifiedLaw::dahl(1e7, 0.25);
        let plain = law;
        law.set(Hook::StribeckRise, 0.15);
        law.set(Hook::StribeckVelocity, 2e-2);
        law.set(Hook::StribeckExponent, 2.0);
        let tone = |hertz: f64, k: usize| (std::f64::consts::TAU * hertz * k as f64 * dt).sin();
        let driven = |k: usize| 0.05 * (tone(20.0, k) + 0.6 * tone(13.7, k));
        let holds = |v: f64| v.signum() * (v.abs() - 0.016).max(0.0);
        let velocity: Vec<f64> = (0..n).map(|k| holds(driven(k))).collect();
        let slides = |v: f64| load * (0.25 + 0.15 * (-(v / 2e-2).powi(2)).exp()) * v.signum();
        // Samples that slide, with their forces; the record begins and ends without any.
        let inner = (1..n - 1).filter(|&k| velocity[k] != 0.0).map(|k| (k, slides(velocity[k])));
        let known: Vec<(usize, f64)> = [(0, 0.0)].into_iter().chain(inner).chain([(n, 0.0)]).collect();
        let ramp = |pair: &[(usize, f64)]| {
            let [(from, start), (to, end)] = [pair[0], pair[1]];
            (from..to).map(move |k| start + (end - start) * (k - from) as f64 / (to - from) as f64)
        };
        let force: Vec<f64> = known.windows(2).flat_map(ramp).collect();
        let off = |k: usize| 0.01 * 0.08 * tone(31.3, k);
        let mut slip = vec![0.0; n];
        for k in 1..n {
            slip[k] = slip[k - 1] + dt * 0.5 * (velocity[k] + velocity[k - 1] + off(k) + off(k - 1));
        }
        let series = Series {
            dt,
            slip,
            velocity: velocity.iter().enumerate().map(|(k, v)| v + off(k)).collect(),
            normal: vec![load; n],
            force,
            deviation: vec![1e-4; n / 2],
            open_share: 0.0,
        };
        let error = |rigid: bool, law: &ModifiedLaw<f64>| {
            SeriesContact::new(&series, pressed(load), (rigid, usize::MAX)).unwrap().error(law)
        };
        assert!(error(true, &law) < 0.02, "{}", error(true, &law));
        assert!(error(true, &plain) > 0.1, "{}", error(true, &plain));
        assert!(error(false, &law) > 0.3, "{}", error(false, &law));
    }
}
