//! From the samples of a run to its lines: base frequency, form and projection.

pub(crate) mod bands;
mod form;

use crate::aperiodic::Left;
use crate::{FormChoice, InverseError, RunData, Sensor};
use form::Subharmonics;
use frettrace_fourier::{
    Frequency, Harmonics, Lines, Projected, Projector, Sampler, refine, spectrum, variance,
};
use std::f64::consts::TAU;

/// Form of a run's answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Periodic with the excitation.
    #[default]
    Harmonic,
    /// Periodic with a multiple of the excitation's period.
    Subharmonic,
    /// Not periodic: quasi-periodic, chaotic or still settling.
    Aperiodic,
}

/// The lines of one run.
#[derive(Clone, Debug)]
pub struct RunLines {
    /// Name of the run.
    pub id: String,
    /// Sampling rate (Hz).
    pub sampling_rate: f64,
    /// Samples.
    pub samples: usize,
    /// Preload (N).
    pub preload: f64,
    /// Form.
    pub form: Form,
    /// Subharmonic order `ν` (1 unless the form is subharmonic).
    pub subharmonic_order: usize,
    /// Base angular frequency `Ω/ν` (rad/s).
    pub frequency: Frequency,
    /// Excitation force (N).
    pub force: Harmonics,
    /// Accelerations (m/s²).
    pub accelerations: Vec<Harmonics>,
    /// Standard deviation of what the lines leave of each acceleration (m/s²).
    pub residual_std: Vec<f64>,
    /// Noise of each sensor (m/s²): declared, or the floor of its spectrum.
    pub noise_std: Vec<f64>,
    /// Share of the accelerations' power beyond the noise that no line holds.
    pub aperiodic_share: f64,
    /// What the lines of a periodic run leave, where it is more than noise.
    pub(crate) rest: Option<Left>,
    /// Samples what lies on the lines, until that is done.
    pub(crate) sampler: Option<Sampler>,
}

/// Lines of the first refinement over all channels: enough for the frequency, few enough to be quick.
const REFINEMENT_ORDER: usize = 8;

/// Share of the power outside all lines above which a run is not periodic in any case: three per cent in amplitude.
const APERIODIC_SHARE: f64 = 1e-3;
/// The same where what lies outside the lines stands out of the noise by [`STANDS_OUT`]: three per mille in amplitude, the
/// least that could spoil a force by a per cent near a resonance.
const CONSPICUOUS_SHARE: f64 = 1e-5;
/// Power outside the lines over the power of the noise.
const STANDS_OUT: f64 = 30.0;

/// Share of what the harmonic form leaves that a subharmonic one may leave: a motion that has its period leaves none, and one that only
/// has much of its power near such lines is not periodic.
const SUBHARMONIC_LEFT: f64 = 0.05;

/// The highest line is kept this share below half the sampling rate.
const BAND: f64 = 0.98;

/// Lines of a run in the form asked for.
///
/// # Errors
/// [`InverseError::Projection`] where the record is too short for its lines.
pub fn analyse(run: &RunData<'_>, sensors: &[Sensor], choice: FormChoice) -> Result<RunLines, InverseError> {
    let failed = |source| InverseError::Projection { run: run.id.to_owned(), source };
    let base = base_frequency(run).map_err(failed)?;
    let mut found = Projection::new(run, base, 1).map_err(failed)?;
    let noise_std = noise(sensors, &found);
    let mut order = 1;
    if matches!(choice, FormChoice::Auto | FormChoice::Subharmonic) {
        let residuals: Vec<&[f64]> = found.accelerations.iter().map(|p| p.residual.as_slice()).collect();
        let search = Subharmonics { base, sampling_rate: run.sampling_rate, noise_std: &noise_std };
        let forced = choice == FormChoice::Subharmonic;
        if let Some(candidate) = search.best(&residuals, forced) {
            let tried = Projection::new(run, base, candidate);
            if let Ok(tried) = tried
                && (forced || excess(&tried, &noise_std) < SUBHARMONIC_LEFT * excess(&found, &noise_std))
            {
                (found, order) = (tried, candidate);
            }
        }
    }
    let noise_std = noise(sensors, &found);
    let share = excess(&found, &noise_std) / signal_power(run).max(f64::MIN_POSITIVE);
    let noise_power: f64 = noise_std.iter().map(|s| s * s).sum();
    let stands_out = excess(&found, &noise_std) > STANDS_OUT * noise_power;
    let least = if stands_out { CONSPICUOUS_SHARE } else { APERIODIC_SHARE };
    let form = match (choice, order) {
        (FormChoice::Auto, _) if share > least => Form::Aperiodic,
        (FormChoice::Aperiodic, _) => Form::Aperiodic,
        (_, 1) => Form::Harmonic,
        _ => Form::Subharmonic,
    };
    let is_asked = choice == FormChoice::Auto;
    Ok(found.finish(run, Found { form, order, noise_std, share, base, is_asked }))
}

struct Found {
    form: Form,
    order: usize,
    noise_std: Vec<f64>,
    share: f64,
    base: Frequency,
    /// Whether the form was found rather than told: what the wrong one leaves must stay visible.
    is_asked: bool,
}

/// All channels of a run on the lines of one base frequency.
struct Projection {
    sampler: Sampler,
    force: Projected,
    accelerations: Vec<Projected>,
}

impl Projection {
    fn new(
        run: &RunData<'_>,
        base: Frequency,
        order: usize,
    ) -> Result<Self, frettrace_fourier::ProjectionError> {
        let samples = run.force.len();
        let base = base.base / order as f64;
        let within_band = (BAND * 0.5 * run.sampling_rate * TAU / base) as usize;
        let within_record = samples / 6;
        let order = within_band.min(within_record).max(1);
        let lines = Lines { base, order, samples, sampling_rate: run.sampling_rate, drift: 1 };
        let projector = Projector::new(lines)?;
        let channels: Vec<&[f64]> =
            std::iter::once(run.force).chain(run.accelerations.iter().copied()).collect();
        let mut accelerations = projector.project_all(&channels)?;
        let force = accelerations.remove(0);
        Ok(Self { sampler: projector.sampler(), force, accelerations })
    }

    /// What the lines leave, where it is more than noise.
    fn rest(&self, run: &RunData<'_>, found: &Found) -> Option<Left> {
        let powers: Vec<&[f64]> = self.accelerations.iter().map(|p| p.periodogram.as_slice()).collect();
        let asked = found.is_asked && found.form != Form::Aperiodic;
        let is_noise = bands::excesses(&powers, &found.noise_std).iter().all(|band| !band.is_conspicuous());
        (asked && !is_noise).then(|| Left {
            force: self.force.residual.clone(),
            accelerations: self.accelerations.iter().map(|p| p.residual.clone()).collect(),
            noise_std: found.noise_std.clone(),
            rate: run.sampling_rate,
        })
    }

    fn finish(self, run: &RunData<'_>, found: Found) -> RunLines {
        let rest = self.rest(run, &found);
        let residual_std = self.accelerations.iter().map(|p| p.residual_std).collect();
        let accelerations = self
            .accelerations
            .into_iter()
            .zip(&found.noise_std)
            .map(|(p, noise)| trusted(p.harmonics, *noise, run.force.len()))
            .collect();
        let scale = found.order as f64;
        RunLines {
            id: run.id.to_owned(),
            sampling_rate: run.sampling_rate,
            samples: run.force.len(),
            preload: run.preload,
            form: found.form,
            subharmonic_order: if found.form == Form::Aperiodic { 1 } else { found.order },
            frequency: Frequency { base: found.base.base / scale, std: found.base.std / scale },
            force: self.force.harmonics,
            accelerations,
            residual_std,
            noise_std: found.noise_std,
            aperiodic_share: found.share,
            rest,
            sampler: Some(self.sampler),
        }
    }
}

/// Where the noise around a line agrees with the sensor's noise, that one is used: it is known better.
fn trusted(mut harmonics: Harmonics, noise: f64, samples: usize) -> Harmonics {
    for variance in &mut harmonics.variance {
        let local = *variance * samples as f64 / 4.0;
        let ratio = local / (noise * noise);
        // A local level is known to 10 %: three of that, in either direction, is agreement.
        if (0.7..1.3).contains(&ratio) {
            *variance /= ratio;
        }
    }
    harmonics
}

/// Base frequency from the force, then from all channels together.
fn base_frequency(run: &RunData<'_>) -> Result<Frequency, frettrace_fourier::ProjectionError> {
    let lines = |base: f64, order: usize| Lines {
        base,
        order,
        samples: run.force.len(),
        sampling_rate: run.sampling_rate,
        drift: 0,
    };
    let start = nominal_or_peak(run);
    let from_force = refine(lines(start, 1), &[run.force])?;
    let in_band = (BAND * 0.5 * run.sampling_rate * TAU / from_force.base) as usize;
    let mut channels = run.accelerations.clone();
    channels.push(run.force);
    let all = refine(lines(from_force.base, REFINEMENT_ORDER.min(in_band).max(1)), &channels)?;
    // A response that does not follow the force would draw the frequency away from it.
    let agree = (all.base - from_force.base).abs() < 5.0 * from_force.std.hypot(all.std);
    Ok(if agree { all } else { from_force })
}

/// The nominal frequency, or the peak of the force near it where they differ by more than the resolution of the record.
fn nominal_or_peak(run: &RunData<'_>) -> f64 {
    let resolution = run.sampling_rate / run.force.len() as f64;
    let nominal = run.excitation_frequency;
    let bins = spectrum(run.force);
    let near = |k: &usize| (0.7 * nominal..1.3 * nominal).contains(&(*k as f64 * resolution));
    let peak = (1..bins.len()).filter(near).max_by(|a, b| bins[*a].norm().total_cmp(&bins[*b].norm()));
    match peak {
        Some(k) if (k as f64 * resolution - nominal).abs() > resolution => TAU * k as f64 * resolution,
        _ => TAU * nominal,
    }
}

/// Declared noise, or the floor of the residual's spectrum: its median, which single peaks do not move.
fn noise(sensors: &[Sensor], projection: &Projection) -> Vec<f64> {
    sensors
        .iter()
        .zip(&projection.accelerations)
        .map(|(sensor, projected)| sensor.noise_std.unwrap_or_else(|| form::floor(&projected.periodogram)))
        .collect()
}

/// Mean square of the accelerations, means removed, summed over the sensors.
fn signal_power(run: &RunData<'_>) -> f64 {
    run.accelerations.iter().map(|a| variance(a)).sum()
}

/// Mean square beyond the noise that the lines leave, summed over the sensors.
fn excess(projection: &Projection, noise_std: &[f64]) -> f64 {
    projection
        .accelerations
        .iter()
        .zip(noise_std)
        .map(|(p, noise)| (p.residual_std.powi(2) - noise * noise).max(0.0))
        .sum()
}
