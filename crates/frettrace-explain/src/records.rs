//! Runs as the model needs them: base frequency, lines with their deviations, and what lies beside the lines.

use crate::channels::mean_square;
use crate::unsettled::drifting;
use crate::unshared::unshared;
use crate::{Clipped, Series};
use frettrace_forward::accelerations::RunLines;
use frettrace_fourier::{Lines, OpenLines, Projected, ProjectionError, Projector, refine};
use num_complex::Complex64;
use std::sync::Arc;

/// Samples of one run.
#[derive(Clone, Copy, Debug)]
pub struct RunSamples<'a> {
    /// Sampling rate (Hz).
    pub sampling_rate: f64,
    /// Nominal excitation frequency (Hz).
    pub excitation_frequency: f64,
    /// Preload (N).
    pub preload: f64,
    /// Excitation force (N).
    pub force: &'a [f64],
    /// Accelerations (m/s²).
    pub acceleration: &'a [Vec<f64>],
}

/// One run, reduced to lines.
#[derive(Clone, Debug)]
pub struct RunRecord {
    /// Lines for the model.
    pub lines: RunLines,
    /// Order of the subharmonic: the base frequency is the excitation's over this.
    pub subharmonic: usize,
    /// Whether the lines hold all that exceeds the noise.
    pub periodic: bool,
    /// Mean square of each sensor beside the lines ((m/s²)²).
    pub beside: Vec<f64>,
    /// Mean square of each sensor ((m/s²)²).
    pub power: Vec<f64>,
    /// Standard deviation of the noise of each sensor (m/s²).
    pub noise: Vec<f64>,
    /// Power over that of the stated noise which a motion that has not quite settled has beside its lines, in the worst sensor; it is in `noise`.
    pub unsettled: f64,
    /// Share of the power in lines above the trusted band, which nothing is compared with.
    pub untrusted: f64,
    /// Mean square of what a fault of each sensor added ((m/s²)²), mended in everything else here.
    pub excess: Vec<f64>,
    /// Saturation of each sensor; its lines carry no weight.
    pub clipped: Vec<Option<Clipped>>,
    /// Lines that are compared with nothing, first and last; none where the first is the later one.
    untrusted_lines: (usize, usize),
    /// The same lines of the sensors that are cut off.
    above: Vec<Option<Arc<OpenLines>>>,
    /// Lines that hold a foreign tone too.
    drowned: Vec<Drowned>,
    /// What was recovered of a run that is not periodic; `None` for periodic runs, and where nobody recovered it.
    pub series: Option<Series>,
    /// What neither lines nor a constant hold, sample by sample.
    pub residual: Vec<Vec<f64>>,
    /// Samples of the run.
    pub samples: usize,
    /// Sampling rate (Hz).
    pub sampling_rate: f64,
}

/// A tone of known amplitude and unknown phase that lies in a line of one sensor, nearer than the record can tell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Drowned {
    sensor: usize,
    line: usize,
    /// Amplitude (m/s²).
    amplitude: f64,
}

/// Factor on the deviation of a sensor that says nothing.
const SILENT: f64 = 1e6;
/// Deviations of the noise from its limit within which a channel is cut off.
const FLAT: f64 = 6.0;
/// Highest line kept for a model, however high the sampling rate. What a stiff contact does above it is periodic all the same,
/// and is compared with nothing.
const MOST_LINES: usize = 160;
/// Highest line of the excitation up to which a run may be periodic.
const MOST_TRIED: usize = 400;
/// What lies beside the lines over the noise from which lines above those of a model are looked for, and the least factor by which
/// they must lessen it: four standard deviations of a level of 20 000 samples. What they are is compared with nothing, so that
/// lines of mere noise do no harm.
const ABOVE: f64 = 1.02;
/// Largest divisor of the excitation's frequency that a motion is looked for at.
pub(crate) const MOST_DIVIDED: usize = 5;
/// Lines of the excitation on which a subharmonic must show.
const FEW_LINES: usize = 30;
/// Factor on what lies beside the lines by which more lines must lessen it.
const CLEARER: f64 = 0.7;
/// Share of its power that the lowest lines of a subharmonic may leave: between the whole of it and the least of
/// [`CLEARER`].
const NOTICED: f64 = 0.8;
/// Standard deviations of chance beyond which a sensor hears the lines of a subharmonic, and the bins beside a line that tell the noise there.
const CHANCE: f64 = 4.0;
const NEAR: f64 = 6.0;
/// Share of the band below half the sampling rate that is trusted: above it anti-alias filters bend every channel.
pub(crate) const BAND: f64 = 0.8;
/// Relative accuracy to which lines can be compared with any model of a beam: bounds the weight of a single line.
const RELATIVE_ACCURACY: f64 = 3e-5;
/// A run is periodic where what lies beside its lines stays within this factor of the noise …
const BESIDE_LIMIT: f64 = 1.25;
/// … or below this share of its power: what has not quite settled is then part of the noise of the lines, not a reason to
/// leave them out.
const BESIDE_SHARE: f64 = 1e-4;
/// Factor between a local level of the noise and the stated one from which the local one counts: five standard deviations
/// of a level averaged over 128 bins.
const COLOURED: f64 = 1.5;

impl RunRecord {
    /// Lines of a run; `noise` holds the stated deviations where there are any.
    ///
    /// # Errors
    /// Those of the projection.
    pub fn new(run: &RunSamples<'_>, noise: Option<&[f64]>, progress: f64) -> Result<Self, ProjectionError> {
        Self::on(run, (noise, progress), None)
    }

    /// The same on the lines of a fraction of the excitation, one over `subharmonic`, or of the first that holds the run.
    pub(crate) fn on(
        run: &RunSamples<'_>,
        (noise, progress): (Option<&[f64]>, f64),
        subharmonic: Option<usize>,
    ) -> Result<Self, ProjectionError> {
        let nominal = std::f64::consts::TAU * run.excitation_frequency;
        let samples = run.force.len();
        let of_base = |base: f64, order: usize| Lines {
            base,
            order,
            samples,
            sampling_rate: run.sampling_rate,
            drift: 0,
        };
        let refined = refine(of_base(nominal, 3), &[run.force])?.base;
        let on = |base: f64, order: usize| projected(run, &of_base(base, order));
        let all = (0.995 * std::f64::consts::PI * run.sampling_rate / refined).floor() as usize;
        let highest = |subharmonic: usize, most: usize| {
            (all * subharmonic).min(most * subharmonic).min(samples / 3).max(1)
        };
        let mut best: Option<Trial> = None;
        let tried = |best: &mut Option<Trial>, subharmonic: usize, most: usize| {
            let base = refined / subharmonic as f64;
            let Ok((channels, force)) = on(base, highest(subharmonic, most)) else { return };
            let ratio = worst_beside(&channels, noise);
            // A motion that has not settled is no subharmonic one because lines that lie closer hold more of it.
            let settled = subharmonic == 1 || ratio < BESIDE_LIMIT;
            let more = |old: &Trial| subharmonic == old.subharmonic && ratio * ABOVE < old.ratio;
            let clearer = |old: &Trial| ratio < CLEARER * old.ratio || ratio < BESIDE_LIMIT && more(old);
            if best.as_ref().is_none_or(|old| settled && clearer(old)) {
                *best = Some(Trial { subharmonic, channels, force, ratio });
            }
        };
        let (first, last) = subharmonic.map_or((1, MOST_DIVIDED), |only| (only, only));
        tried(&mut best, first, MOST_LINES);
        if first == 1 && best.as_ref().is_none_or(|found| found.ratio > ABOVE) && all > MOST_LINES {
            tried(&mut best, 1, MOST_TRIED);
        }
        for subharmonic in first + 1..=last {
            if !open(best.as_ref()) {
                break;
            }
            let base = refined / subharmonic as f64;
            let few = highest(subharmonic, FEW_LINES);
            if best.as_ref().is_none_or(|old| lessens(run, old, subharmonic, &of_base(base, few))) {
                tried(&mut best, subharmonic, MOST_LINES);
            }
        }
        // What is louder than the noise may be lines above these, as with the excitation's own.
        if let Some(found) = best.as_ref().filter(|found| found.subharmonic > 1 && found.ratio > ABOVE)
            && all > MOST_LINES
        {
            let subharmonic = found.subharmonic;
            tried(&mut best, subharmonic, MOST_TRIED);
        }
        let unresolved = ProjectionError::TooShort { samples, unknowns: 3 };
        let Trial { subharmonic, channels, force, ratio } = best.ok_or(unresolved)?;
        let mut noise: Vec<f64> = match noise {
            Some(stated) => stated.to_vec(),
            None => own_noise(&channels),
        };
        let known = noise.clone();
        let periodic = ratio < BESIDE_LIMIT || beside_share(run, &channels) < BESIDE_SHARE;
        if periodic && ratio >= BESIDE_LIMIT {
            noise.iter_mut().zip(&channels).for_each(|(n, c)| *n = n.max(c.residual_std));
        } else if periodic {
            // What has not quite settled is noise to a model of what repeats, however little of it there is.
            noise.iter_mut().zip(drifting(&channels)).for_each(|(n, more)| *n = n.hypot(more.sqrt()));
        }
        let more = noise.iter().zip(&known).map(|(all, noise)| (all / noise).powi(2) - 1.0);
        let unsettled = more.fold(0.0, f64::max);
        let record = Self::assemble(run, (channels, force), noise, (subharmonic, periodic, progress));
        Ok(Self { unsettled, ..record })
    }

    /// Takes the weight from sensors that clip, as long as three others are left.
    pub(crate) fn silence(&mut self, clipped: &[Option<Clipped>]) {
        if clipped.iter().filter(|c| c.is_none()).count() < crate::channels::LEAST_LEFT {
            return;
        }
        for (sensor, new) in clipped.iter().enumerate().filter(|(_, c)| c.is_some()) {
            if self.clipped[sensor].is_none() {
                self.lines.deviation[sensor].iter_mut().for_each(|d| *d *= SILENT);
            }
            self.clipped[sensor].clone_from(new);
            self.above[sensor] = self.above(sensor);
        }
    }

    /// Leaves a tone (Hz) of an amplitude (m/s²) and of any phase open in the line of a sensor that it cannot be told from, if there is one.
    pub(crate) fn drown(&mut self, sensor: usize, frequency: f64, amplitude: f64) {
        let line = (std::f64::consts::TAU * frequency / self.lines.omega).round() as usize;
        if line == 0 || line > self.lines.order() {
            return;
        }
        let deviation = &mut self.lines.deviation[sensor][line];
        *deviation = deviation.hypot(amplitude / std::f64::consts::SQRT_2);
        self.excess[sensor] += 0.5 * amplitude * amplitude;
        self.drowned.push(Drowned { sensor, line, amplitude });
    }

    /// The lines that are compared with nothing, of a sensor that is cut off: near half the sampling rate, and above a model's. A channel that is
    /// read as it is projects them out with its own.
    fn above(&self, sensor: usize) -> Option<Arc<OpenLines>> {
        let Some(Clipped::Hard { limits: [low, high], raw, .. }) = &self.clipped[sensor] else { return None };
        let edge = FLAT * self.noise[sensor];
        let open: Vec<bool> = raw.iter().map(|x| *x > low + edge && *x < high - edge).collect();
        OpenLines::new(self.untrusted_lines, self.lines.omega / self.sampling_rate, &open).map(Arc::new)
    }

    /// Gives sensors that clip their weight back: of lines that were not read from them.
    pub(crate) fn unsilence(&mut self) {
        for (sensor, clipped) in self.clipped.iter_mut().enumerate() {
            if clipped.take().is_some() {
                self.lines.deviation[sensor].iter_mut().for_each(|d| *d /= SILENT);
            }
        }
    }

    /// Mean square of measured minus predicted lines of a sensor, with what lies beside the lines; of a line that holds a foreign tone of
    /// amplitude `A` as well, `|d| − A` is left of a difference `d`, for the tone has the phase that explains most.
    pub(crate) fn line_error(&self, sensor: usize, predicted: &[Complex64]) -> f64 {
        let measured = &self.lines.acceleration[sensor];
        let of_tone = |tone: &Drowned| {
            let left = predicted.get(tone.line).map_or(0.0, |line| (measured[tone.line] - line).norm());
            0.5 * (left * left - (left - tone.amplitude).powi(2))
        };
        let tones: f64 = self.drowned.iter().filter(|tone| tone.sensor == sensor).map(of_tone).sum();
        power(measured.iter().zip(predicted).map(|(a, b)| a - b)) + self.beside[sensor] - tones
    }

    /// Mean square of measured minus predicted in a sensor that clips, with the prediction clipped alike.
    pub(crate) fn clipped_error(&self, sensor: usize, predicted: &[Complex64]) -> Option<f64> {
        Some(match self.clipped[sensor].as_ref()? {
            Clipped::Hard { limits: [low, high], raw, bend } => {
                let bent = |x: f64| bend.map_or(x, |bend| bend.reads(x));
                let wave = self.wave(predicted);
                let mut reads: Vec<f64> = wave.iter().map(|x| bent(*x)).collect();
                if let Some(above) = &self.above[sensor] {
                    let rest: Vec<f64> = raw.iter().zip(&reads).map(|(raw, reads)| raw - reads).collect();
                    reads.iter_mut().zip(above.of(&rest)).for_each(|(reads, more)| *reads += more);
                }
                mean_square(raw.iter().zip(reads).map(|(raw, reads)| raw - reads.clamp(*low, *high)))
            }
            Clipped::Soft(saturation) => self.line_error(sensor, &saturation.lines(predicted)),
        })
    }

    /// The same with the prediction as it is.
    pub(crate) fn unclipped_error(&self, sensor: usize, predicted: &[Complex64]) -> Option<f64> {
        Some(match self.clipped[sensor].as_ref()? {
            Clipped::Hard { raw, .. } => {
                mean_square(raw.iter().zip(self.wave(predicted)).map(|(raw, wave)| raw - wave))
            }
            Clipped::Soft(_) => self.line_error(sensor, predicted),
        })
    }

    /// Predicted lines at the samples of the run.
    fn wave(&self, predicted: &[Complex64]) -> Vec<f64> {
        let step = Complex64::from_polar(1.0, self.lines.omega / self.sampling_rate);
        let mut turn = Complex64::ONE;
        let mut sample = || {
            let value = predicted.iter().rev().fold(Complex64::ZERO, |sum, line| sum * turn + line).re;
            turn *= step;
            value
        };
        (0..self.samples).map(|_| sample()).collect()
    }

    fn assemble(
        run: &RunSamples<'_>,
        (channels, force): (Vec<Projected>, Projected),
        noise: Vec<f64>,
        (subharmonic, periodic, progress): (usize, bool, f64),
    ) -> Self {
        let samples = run.force.len();
        // Beyond the trusted band, and beyond the lines of a model, nothing is compared.
        let edge = (BAND * std::f64::consts::PI * run.sampling_rate / force.harmonics.base) as usize;
        let highest = channels[0].harmonics.order().min(edge.max(1)).min(MOST_LINES * subharmonic);
        let order = significant_order(&channels).max(8 * subharmonic).min(highest);
        let acceleration: Vec<Vec<Complex64>> =
            channels.iter().map(|c| c.harmonics.coefficients[..=order].to_vec()).collect();
        let deviation = acceleration
            .iter()
            .enumerate()
            .map(|(s, lines)| {
                let noise = line_noise(&channels[s], noise[s]);
                lines.iter().zip(noise).map(|(a, n)| n.hypot(RELATIVE_ACCURACY * a.norm())).collect()
            })
            .collect();
        // Lines beyond the last significant one count as beside.
        let beside = channels
            .iter()
            .map(|c| {
                let above = &c.harmonics.coefficients[order + 1..=highest];
                mean_square(c.residual.iter().copied())
                    + above.iter().map(|a| 0.5 * a.norm_sqr()).sum::<f64>()
            })
            .collect();
        let beyond: f64 = channels
            .iter()
            .flat_map(|c| &c.harmonics.coefficients[highest + 1..])
            .map(|a| 0.5 * a.norm_sqr())
            .sum();
        let power: Vec<f64> = run.acceleration.iter().map(|x| mean_square(x.iter().copied())).collect();
        let contact_order = order + order / 4 + 4;
        let lines = RunLines {
            omega: force.harmonics.base,
            preload: run.preload,
            progress,
            worked: [progress; 2],
            force: force_lines(&force, order),
            acceleration,
            deviation,
            base_phase: 0.0,
            known_force: Vec::new(),
            contact_order,
            samples: (8 * contact_order).next_power_of_two().clamp(128, 4096),
        };
        Self {
            lines,
            subharmonic,
            periodic,
            drowned: Vec::new(),
            unsettled: 0.0,
            series: None,
            beside,
            untrusted: beyond / power.iter().sum::<f64>().max(f64::MIN_POSITIVE),
            power,
            excess: vec![0.0; run.acceleration.len()],
            clipped: vec![None; run.acceleration.len()],
            untrusted_lines: (highest + 1, channels[0].harmonics.order()),
            above: vec![None; run.acceleration.len()],
            noise,
            residual: channels.into_iter().map(|c| c.residual).collect(),
            samples,
            sampling_rate: run.sampling_rate,
        }
    }
}

/// A run on the lines of one base frequency.
struct Trial {
    subharmonic: usize,
    channels: Vec<Projected>,
    force: Projected,
    /// What lies beside the lines over the noise, in the worst sensor.
    ratio: f64,
}

/// Whether something lies beside the lines.
fn open(best: Option<&Trial>) -> bool {
    best.is_none_or(|trial| trial.ratio >= BESIDE_LIMIT)
}

/// All channels and the force on lines.
fn projected(run: &RunSamples<'_>, lines: &Lines) -> Result<(Vec<Projected>, Projected), ProjectionError> {
    let projector = Projector::new(*lines)?;
    let channels = run.acceleration.iter().map(|x| projector.project(x)).collect::<Result<Vec<_>, _>>()?;
    Ok((channels, projector.project(run.force)?))
}

/// Whether the few lowest lines of a subharmonic take something out of what lies beside the lines of a trial. A motion
/// shows in more than one sensor; what a single one hears, a hum beside a fraction of the excitation, is no motion.
fn lessens(run: &RunSamples<'_>, trial: &Trial, subharmonic: usize, lines: &Lines) -> bool {
    let rest: Vec<Vec<f64>> = trial.channels.iter().map(|c| c.residual.clone()).collect();
    let beside = RunSamples { acceleration: &rest, ..*run };
    let total = |channels: &[Projected]| {
        channels.iter().map(|c| mean_square(c.residual.iter().copied())).sum::<f64>()
    };
    projected(&beside, lines).is_ok_and(|(left, _)| {
        total(&left) < NOTICED * total(&trial.channels)
            && left.iter().filter(|channel| hears(channel, subharmonic, lines)).count() >= left.len().min(2)
    })
}

/// Whether the lines of a subharmonic, those of the excitation left aside, are louder in a channel than what is left beside them,
/// line by line: noise may be coloured. Of noise alone the mean ratio is about one, with a deviation of `√(2 / lines)`.
fn hears(channel: &Projected, subharmonic: usize, lines: &Lines) -> bool {
    let bins = channel.periodogram.len() as f64;
    let spacing = lines.base * lines.samples as f64 / (std::f64::consts::TAU * lines.sampling_rate);
    let ratio = |h: usize| {
        let at = h as f64 * spacing;
        let near = ((at - NEAR).max(1.0).ceil() as usize)..=(at + NEAR).min(bins - 1.0) as usize;
        // Where a line is taken out its bin is empty.
        let lies = |bin: usize| bin as f64 / spacing;
        let apart = |bin: &usize| (lies(*bin) - lies(*bin).round()).abs() * spacing > 1.0;
        let beside: Vec<f64> = near.filter(apart).map(|bin| channel.periodogram[bin]).collect();
        let level = match beside.len() {
            0 => channel.residual_std.powi(2),
            count => beside.iter().sum::<f64>() / count as f64,
        };
        let wave = 0.25 * lines.samples as f64 * channel.harmonics.coefficients[h].norm_sqr();
        (level > 0.0).then(|| wave / level)
    };
    let ratios: Vec<f64> = (1..=lines.order).filter(|h| h % subharmonic != 0).filter_map(ratio).collect();
    let count = ratios.len().max(1) as f64;
    ratios.iter().sum::<f64>() / count > 1.0 + CHANCE * (2.0 / count).sqrt()
}

/// Mean square of what lines from the mean on make over a period.
pub(crate) fn power(lines: impl Iterator<Item = Complex64>) -> f64 {
    lines.enumerate().map(|(h, line)| line.norm_sqr() * if h == 0 { 1.0 } else { 0.5 }).sum()
}

/// Share of the power beside the lines.
fn beside_share(run: &RunSamples<'_>, channels: &[Projected]) -> f64 {
    let beside: f64 = channels.iter().map(|c| mean_square(c.residual.iter().copied())).sum();
    let power: f64 = run.acceleration.iter().map(|x| mean_square(x.iter().copied())).sum();
    beside / power.max(f64::MIN_POSITIVE)
}

/// Standard deviation of real and imaginary part of every line: white noise of deviation `noise`, or, where the spectrum
/// between the lines is not flat, its local level.
fn line_noise(channel: &Projected, noise: f64) -> Vec<f64> {
    let white = noise * noise * 4.0 / channel.residual.len() as f64;
    let local = &channel.harmonics.variance;
    let coloured = local.iter().skip(1).any(|v| *v > COLOURED * white);
    local.iter().map(|v| if coloured { *v } else { white }).map(|v| (0.5 * v).sqrt()).collect()
}

/// Largest ratio over the sensors of what lies beside the lines to the noise, stated or told from the channels themselves.
fn worst_beside(channels: &[Projected], noise: Option<&[f64]>) -> f64 {
    let noise = noise.map_or_else(|| own_noise(channels), <[f64]>::to_vec);
    channels.iter().zip(noise).map(|(c, n)| c.residual_std / n).fold(0.0, f64::max)
}

/// Noise of sensors that state none: what each does not share with the others beside the lines, or, of few, the level between the lines.
fn own_noise(channels: &[Projected]) -> Vec<f64> {
    let rest: Vec<&[f64]> = channels.iter().map(|c| c.residual.as_slice()).collect();
    unshared(&rest).unwrap_or_else(|| channels.iter().map(between_lines).collect())
}

/// Noise from the variances of the lines, which come from the spectrum around each line: their median.
fn between_lines(channel: &Projected) -> f64 {
    let mut variance: Vec<f64> = channel.harmonics.variance.iter().skip(1).copied().collect();
    variance.sort_by(f64::total_cmp);
    let median = variance.get(variance.len() / 2).copied().unwrap_or_default();
    // A line of n samples has the variance 4σ²/n of real and imaginary part together.
    (median * channel.residual.len() as f64 / 4.0).sqrt()
}

/// Highest line that any sensor shows with five standard deviations.
fn significant_order(channels: &[Projected]) -> usize {
    channels
        .iter()
        .map(|c| {
            let h = &c.harmonics;
            (1..h.coefficients.len())
                .rev()
                .find(|&k| h.coefficients[k].norm_sqr() > 25.0 * h.variance[k])
                .unwrap_or(1)
        })
        .max()
        .unwrap_or(1)
}

/// Lines of the force; those within five standard deviations of nothing are nothing.
fn force_lines(force: &Projected, order: usize) -> Vec<Complex64> {
    let h = &force.harmonics;
    let largest = h.coefficients.iter().map(|c| c.norm()).fold(0.0, f64::max);
    (0..=order)
        .map(|k| {
            let line = h.coefficients[k];
            let kept = k > 0 && line.norm_sqr() > 25.0 * h.variance[k] && line.norm() > 1e-7 * largest;
            if kept { line } else { Complex64::ZERO }
        })
        .collect()
}
