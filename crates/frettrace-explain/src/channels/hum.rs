//! Mains hum: a tone of a fixed frequency that is no line of the motion.

use super::bare::{Bare, bare};
use super::{ChannelFault, Channels, HEARD, HEARD_IN_A_RUN};
use crate::RunSamples;
use frettrace_fourier::dot;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Mains frequencies (Hz) and the harmonics that are looked for.
const MAINS: [f64; 2] = [50.0, 60.0];
const HARMONICS: usize = 6;
/// Share of a tone that the lines of the motion must leave for it to be told from them without another run.
const LEAST_OWN: f64 = 0.02;
/// Relative accuracy of its amplitude to which what they leave must tell it beside others.
const TOLD: f64 = 0.05;
/// Largest ratio between the upper and the lower quartile of a hum's amplitude over the runs: it does not follow the level.
const STEADY: f64 = 2.0;
/// Distances, in what the record can tell apart, at which the noise beside a tone is heard.
const BESIDE: [f64; 4] = [2.0, 3.0, 4.0, 5.0];
/// Frequencies that are taken out.
const MOST: usize = 4;

/// A tone in one channel over the runs.
struct Tone {
    frequency: f64,
    sensor: usize,
    /// χ² that it explains in the runs that are asked, beside noise of the density that it has there.
    gain: f64,
    /// Those of them that hear it by themselves.
    heard: usize,
    /// Cosine and sine amplitude in each run; zero where it cannot be told from the lines of the motion.
    amplitude: Vec<[f64; 2]>,
    /// What little the lines leave of it tells of the same, with the standard deviation.
    hidden: Vec<([f64; 2], f64)>,
}

impl Tone {
    /// Whether it is in the runs whatever their excitation: most hear it, with the same amplitude. One run alone may hear its own
    /// motion, where that has no period.
    fn lasts(&self, asked: &[bool]) -> bool {
        let mut sizes = self.sizes(asked);
        sizes.sort_by(f64::total_cmp);
        let n = sizes.len();
        2 * self.heard > n && sizes[(3 * n / 4).min(n - 1)] < STEADY * sizes[n / 4]
    }

    /// Mean of its amplitudes in the runs that are asked and tell it from the motion.
    fn amplitude(&self, asked: &[bool]) -> f64 {
        let sizes = self.sizes(asked);
        sizes.iter().sum::<f64>() / sizes.len().max(1) as f64
    }

    /// With the amplitudes of the runs that tell it only beside others: to a twentieth, and as large as there.
    fn completed(mut self, amplitude: f64) -> Self {
        let other = |[a, b]: [f64; 2]| (a.hypot(b) - amplitude).abs() > TOLD * amplitude;
        for (own, (hidden, deviation)) in self.amplitude.iter_mut().zip(&self.hidden) {
            if *own == [0.0; 2] && *deviation < TOLD / 3.0 * amplitude && !other(*hidden) {
                *own = *hidden;
            }
        }
        self
    }

    /// Its amplitudes in the runs that are asked and tell it from the motion.
    fn sizes(&self, asked: &[bool]) -> Vec<f64> {
        let asked = self.amplitude.iter().zip(asked).filter(|(_, asked)| **asked);
        asked.map(|(a, _)| a[0].hypot(a[1])).filter(|a| *a > 0.0).collect()
    }
}

/// Finds hum and takes it out. Runs without a period are not asked where others are: their motion has a part at any frequency.
pub(super) fn find(
    runs: &[RunSamples<'_>],
    noise: Option<&[f64]>,
    channels: &mut Channels,
) -> Vec<ChannelFault> {
    let mut faults: Vec<ChannelFault> = Vec::new();
    for _ in 0..MOST {
        let Some(bare) = bare(runs, noise, channels) else { break };
        let mut asked: Vec<bool> = bare.iter().map(Bare::is_steady).collect();
        if !asked.contains(&true) {
            asked.fill(true);
        }
        let claim = HEARD_IN_A_RUN * asked.iter().filter(|asked| **asked).count() as f64;
        let loudest = |tones: &[Tone]| tones.iter().map(|tone| tone.gain).fold(0.0, f64::max);
        let mut best: Vec<Tone> = Vec::new();
        let frequencies = (1..=HARMONICS).flat_map(|multiple| MAINS.map(|f| f * multiple as f64));
        let frequencies: Vec<f64> = frequencies.collect();
        let heard: Vec<Vec<Tone>> =
            frequencies.par_iter().map(|frequency| tones((&bare, &asked), *frequency)).collect();
        for (frequency, tones) in frequencies.into_iter().zip(heard) {
            let hearing = tones.iter().filter(|tone| tone.gain > claim).count();
            if 2 * hearing > tones.len() && runs.iter().any(|run| subharmonic(run, frequency)) {
                continue;
            }
            if loudest(&tones) > loudest(&best) {
                best = tones;
            }
        }
        // A loop of the ground is heard by every sensor.
        best.retain(|tone| {
            tone.gain > claim && tone.lasts(&asked) && tone.amplitude(&asked) > HEARD * level(&bare, tone)
        });
        if best.is_empty() {
            break;
        }
        let phases = phases(&best);
        for (tone, phase) in best.into_iter().zip(phases) {
            let amplitude = tone.amplitude(&asked);
            let tone = tone.completed(amplitude);
            take_out(runs, &tone, channels);
            for (drowning, own) in channels.drowning.iter_mut().zip(&tone.amplitude) {
                if *own == [0.0; 2] {
                    drowning.push((tone.sensor, tone.frequency, amplitude));
                }
            }
            if let Some(fault) = faults.iter_mut().find(|f| f.sensor == tone.sensor) {
                fault.evidence += tone.gain;
                continue;
            }
            faults.push(ChannelFault {
                id: "measurement.hum",
                sensor: tone.sensor,
                parameters: vec![
                    ("frequency".into(), "Hz".into(), tone.frequency, 0.0),
                    ("amplitude".into(), "m/s^2".into(), amplitude, amplitude * (2.0 / tone.gain).sqrt()),
                    ("phase".into(), "rad".into(), phase, (2.0 / tone.gain).sqrt()),
                ],
                evidence: tone.gain,
            });
        }
    }
    faults
}

/// The tone of a frequency in every channel, beside the lines of the motion.
fn tones((bare, asked): (&[Bare<'_>], &[bool]), frequency: f64) -> Vec<Tone> {
    let sensors = bare.first().map_or(0, |b| b.residual.len());
    let mut out: Vec<Tone> = (0..sensors)
        .map(|sensor| Tone {
            frequency,
            sensor,
            gain: 0.0,
            heard: 0,
            amplitude: Vec::new(),
            hidden: Vec::new(),
        })
        .collect();
    for (one, asked) in bare.iter().zip(asked) {
        if frequency > 0.45 * one.run.sampling_rate {
            return Vec::new();
        }
        let count = one.run.force.len();
        let waves = waves(one.run, frequency);
        let resolution = one.run.sampling_rate / count as f64;
        let beside: Vec<[Vec<f64>; 2]> = BESIDE
            .into_iter()
            .flat_map(|bins| [frequency - bins * resolution, frequency + bins * resolution])
            .filter(|hertz| *hertz > resolution)
            .map(|hertz| self::waves(one.run, hertz))
            .collect();
        let own: Vec<Vec<f64>> =
            waves.iter().filter_map(|w| one.projector.project(w).ok().map(|p| p.residual)).collect();
        let [cosine, sine] = own.as_slice() else { return Vec::new() };
        let (cc, ss, cs) = (dot(cosine, cosine), dot(sine, sine), dot(cosine, sine));
        let determinant = cc * ss - cs * cs;
        let whole = 0.5 * count as f64;
        let separable = cc.min(ss) > LEAST_OWN * whole && determinant > (LEAST_OWN * whole).powi(2);
        for tone in &mut out {
            let left = &one.residual[tone.sensor];
            let (c, s) = (dot(cosine, left), dot(sine, left));
            let solution = [(c * ss - s * cs) / determinant, (s * cc - c * cs) / determinant];
            // Beside what the tone explains: in a record of a few of its periods it is heard beside itself.
            let rest: Vec<f64> = left
                .iter()
                .zip(cosine.iter().zip(sine))
                .map(|(x, (c, s))| x - solution[0] * c - solution[1] * s)
                .collect();
            let density = density(&rest, one.variance[tone.sensor], &beside);
            if separable {
                let gain = (solution[0] * c + solution[1] * s) / density;
                if *asked {
                    tone.gain += gain;
                    tone.heard += usize::from(gain > HEARD_IN_A_RUN);
                }
                tone.amplitude.push(solution);
                tone.hidden.push((solution, 0.0));
            } else {
                // Of the least certain combination of the two.
                let least = 0.5 * (cc + ss - (cc - ss).hypot(2.0 * cs));
                tone.hidden.push((solution, (density / least).sqrt()));
                tone.amplitude.push([0.0; 2]);
            }
        }
    }
    out
}

/// Phases (rad) of tones of one frequency beside the one that explains most: runs begin anywhere, but alike for all channels.
fn phases(tones: &[Tone]) -> Vec<f64> {
    let Some(reference) = tones.iter().max_by(|a, b| a.gain.total_cmp(&b.gain)) else { return Vec::new() };
    let phase = |tone: &Tone| {
        let pairs = tone.amplitude.iter().zip(&reference.amplitude);
        // A wave `a cos ωt + b sin ωt` has the amplitude `a − ib`.
        let [re, im] =
            pairs.fold([0.0; 2], |[re, im], ([a, b], [c, d])| [re + a * c + b * d, im + a * d - b * c]);
        im.atan2(re)
    };
    tones.iter().map(phase).collect()
}

/// Standard deviation of what a tone's channel holds beside the motion, its mean over the runs.
fn level(bare: &[Bare<'_>], tone: &Tone) -> f64 {
    bare.iter().map(|one| one.variance[tone.sensor].sqrt()).sum::<f64>() / bare.len().max(1) as f64
}

/// Cosine and sine of a frequency over a run.
fn waves(run: &RunSamples<'_>, frequency: f64) -> [Vec<f64>; 2] {
    let angle = |k: usize| TAU * frequency * k as f64 / run.sampling_rate;
    let count = run.force.len();
    [(0..count).map(|k| angle(k).cos()).collect(), (0..count).map(|k| angle(k).sin()).collect()]
}

/// Variance of white noise as loud as a channel is at the frequencies `beside` a tone, and no less than that of its own: coloured noise may
/// be forty times as loud at one frequency as on the whole. A wave takes two degrees of freedom of the `n/2` times its power.
fn density(left: &[f64], variance: f64, beside: &[[Vec<f64>; 2]]) -> f64 {
    let power = |[c, s]: &[Vec<f64>; 2]| (dot(c, left).powi(2) + dot(s, left).powi(2)) / left.len() as f64;
    let mean = beside.iter().map(power).sum::<f64>() / beside.len().max(1) as f64;
    mean.max(variance)
}

/// Whether a tone is nearer to a half or a third of a line of the motion than the record can tell: what most sensors hear there
/// is the motion's own.
fn subharmonic(run: &RunSamples<'_>, frequency: f64) -> bool {
    let resolution = run.sampling_rate / run.force.len().max(1) as f64;
    [2.0, 3.0].into_iter().any(|part: f64| {
        let base = run.excitation_frequency / part;
        let line = (frequency / base).round();
        line % part != 0.0 && (frequency - line * base).abs() < resolution
    })
}

fn take_out(runs: &[RunSamples<'_>], tone: &Tone, channels: &mut Channels) {
    for ((run, amplitude), signals) in runs.iter().zip(&tone.amplitude).zip(&mut channels.signal) {
        for (k, value) in signals[tone.sensor].iter_mut().enumerate() {
            let angle = TAU * tone.frequency * k as f64 / run.sampling_rate;
            *value -= amplitude[0] * angle.cos() + amplitude[1] * angle.sin();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a second tells tones 4 Hz apart: at 118.6 Hz mains of 60 Hz lies beside the half (59.3 Hz) and of 50 Hz beside
    /// neither half nor third (39.5 and 79.0 Hz); at 60 Hz both mains are lines or between them.
    #[test]
    fn mains_beside_a_subharmonic_of_the_motion_are_known() {
        let run = |excitation_frequency: f64| RunSamples {
            force: &[0.0; 4096],
            acceleration: &[],
            sampling_rate: 16_384.0,
            excitation_frequency,
            preload: 1.0,
        };
        assert!(subharmonic(&run(118.6), 60.0));
        assert!(!subharmonic(&run(118.6), 50.0));
        assert!(!subharmonic(&run(60.0), 60.0));
        assert!(!subharmonic(&run(60.0), 50.0));
    }

    /// Runs at 99.4 Hz, 0.41 s each, in which four channels hear the motion and `noise` (a deviation for each run, and how much of it stays
    /// from sample to sample), the first also 50 Hz of an amplitude: nearer to the half of the excitation than the record can tell.
    struct Laboratory {
        rate: f64,
        frequency: f64,
        force: Vec<f64>,
        signals: Vec<Vec<Vec<f64>>>,
    }

    impl Laboratory {
        fn new(noise: &[f64], stays: f64, tone: f64) -> Self {
            let mut state = 1_u64;
            let mut uniform = move || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            let (rate, frequency) = (1e4, 99.4);
            let wave = |hertz: f64, k: usize| (TAU * hertz * k as f64 / rate).sin();
            let mut channel = |tone: f64, noise: f64| -> Vec<f64> {
                let mut kept = 0.0;
                let fresh = 12.0_f64.sqrt() * noise * (1.0 - stays * stays).sqrt();
                (0..4096)
                    .map(|k| {
                        kept = stays * kept + fresh * uniform();
                        wave(frequency, k) + tone * wave(50.0, k) + kept
                    })
                    .collect()
            };
            let mut run = |noise: f64| [tone, 0.0, 0.0, 0.0].map(|tone| channel(tone, noise)).to_vec();
            let signals = noise.iter().map(|&noise| run(noise)).collect();
            Self { rate, frequency, force: (0..4096).map(|k| wave(frequency, k)).collect(), signals }
        }

        fn runs(&self) -> Vec<RunSamples<'_>> {
            let run = |acceleration| RunSamples {
                force: &self.force,
                acceleration,
                sampling_rate: self.rate,
                excitation_frequency: self.frequency,
                preload: 1.0,
            };
            self.signals.iter().map(|signals| run(signals)).collect()
        }
    }

    /// Records of 31 ms at 692 Hz, with noise of 0.1: four channels hear the motion, the first also 50 Hz of an amplitude of 2.2 for one and a half
    /// of its periods, which 60 Hz and a drift follow as well. With a drift it is the same beside it.
    #[test]
    fn hum_in_a_short_record_is_no_drift() {
        let (rate, hertz) = (32_768.0, 692.0);
        let wave = |hertz: f64, k: usize| (TAU * hertz * k as f64 / rate + 0.7).sin();
        for (record, drift) in [(1024, 0.0), (16_384, 3.0)] {
            let Laboratory { signals, .. } = Laboratory::new(&[0.1, 0.1, 0.1, 0.1], 0.0, 0.0);
            let force: Vec<f64> = (0..record).map(|k| wave(hertz, k)).collect();
            let added = |s: usize, k: usize| {
                if s == 0 { 2.2 * wave(50.0, k) + drift * (k as f64 / record as f64 - 0.5) } else { 0.0 }
            };
            let noise = |run: usize, s: usize, k: usize| {
                signals[run][s][k % 4096] - (TAU * 99.4 * (k % 4096) as f64 / 1e4).sin()
            };
            let heard = |run: usize, s: usize| -> Vec<f64> {
                (0..record).map(|k| force[k] + added(s, k) + noise(run, s, k)).collect()
            };
            let signals = (0..4).map(|run| (0..4).map(|s| heard(run, s)).collect()).collect();
            let laboratory = Laboratory { rate, frequency: hertz, force: force.clone(), signals };
            let (_, faults) = crate::records(&laboratory.runs(), Some(&[0.1; 4])).unwrap();
            let hum = faults.iter().find(|f| f.id == "measurement.hum").unwrap();
            let [frequency, amplitude] = [0, 1].map(|k| hum.parameters[k].2);
            assert_eq!(frequency, 50.0, "{record}");
            assert!((amplitude - 2.2).abs() < 0.05, "{record}: {amplitude}");
            let mut values = faults.iter().flat_map(|fault| &fault.parameters);
            let ramp = values.find(|(name, ..)| name == "drift_over_record").map(|found| found.2);
            match ramp {
                Some(ramp) => assert!((ramp - drift).abs() < 0.1, "{record}: {ramp}"),
                None => assert!(drift == 0.0, "{record}"),
            }
            assert!(faults.iter().all(|fault| fault.sensor == 0), "{faults:?}");
        }
    }

    /// Of three runs the second and third have no period: broad noise of thirty deviations in every channel. In the first run alone only
    /// the first channel hears a tone.
    #[test]
    fn runs_without_a_period_are_not_asked_for_hum() {
        let laboratory = Laboratory::new(&[0.03, 0.9, 0.9], 0.0, 0.9);
        let runs = laboratory.runs();
        let found = find(&runs, Some(&[0.03; 4]), &mut Channels::new(&runs));
        assert_eq!(found.iter().map(|f| (f.id, f.sensor)).collect::<Vec<_>>(), [("measurement.hum", 0)]);
        let [frequency, amplitude] = [0, 1].map(|k| found[0].parameters[k].2);
        assert_eq!(frequency, 50.0);
        assert!((amplitude - 0.9).abs() < 3e-3, "{amplitude}");
    }

    /// Every channel hears the same mains.
    #[test]
    fn all_sensors_may_hear_the_mains() {
        let mut laboratory = Laboratory::new(&[0.03, 0.03, 0.03], 0.0, 0.0);
        for (k, share) in [0.4, 0.6, 0.8, 1.0].into_iter().enumerate() {
            for signals in &mut laboratory.signals {
                for (j, value) in signals[k].iter_mut().enumerate() {
                    *value += share * (TAU * 60.0 * j as f64 / laboratory.rate).sin();
                }
            }
        }
        let runs = laboratory.runs();
        let found = find(&runs, Some(&[0.03; 4]), &mut Channels::new(&runs));
        let mut sensors: Vec<usize> = found.iter().map(|fault| fault.sensor).collect();
        sensors.sort_unstable();
        assert_eq!(sensors, [0, 1, 2, 3]);
        for fault in found {
            let [frequency, amplitude, phase] = [0, 1, 2].map(|k| fault.parameters[k].2);
            assert_eq!(frequency, 60.0);
            let share = [0.4, 0.6, 0.8, 1.0][fault.sensor];
            assert!((amplitude - share).abs() < 3e-3 && phase.abs() < 5e-3, "{amplitude} {phase}");
        }
    }

    /// Records of half a second at 29.4 Hz and at a frequency whose second line lies near the mains, with noise of 0.01: four channels hear the
    /// motion, the first also 60 Hz.
    fn beside(hertz: f64) -> (Vec<crate::RunRecord>, Vec<ChannelFault>) {
        let rate = 8192.0;
        let tone = |hertz: f64, k: usize| (TAU * hertz * k as f64 / rate).sin();
        let made = [hertz, 29.4].map(|hertz| {
            let Laboratory { force, signals, .. } = Laboratory::new(&[0.01], 0.0, 0.0);
            let heard = |s: usize, k: usize| if s == 0 { 0.9 * tone(60.0, k) } else { 0.0 };
            let motion = |k: usize| tone(hertz, k) + 0.3 * tone(2.0 * hertz, k);
            let channel = |s: usize| -> Vec<f64> {
                (0..4096).map(|k| signals[0][s][k] - force[k] + motion(k) + heard(s, k)).collect()
            };
            let driven: Vec<f64> = (0..4096).map(|k| tone(hertz, k)).collect();
            (hertz, driven, [0, 1, 2, 3].map(channel).to_vec())
        });
        let runs = made.each_ref().map(|(hertz, force, acceleration)| RunSamples {
            force,
            acceleration,
            sampling_rate: rate,
            excitation_frequency: *hertz,
            preload: 1.0,
        });
        crate::records(&runs, Some(&[0.01; 4])).unwrap()
    }

    /// A tenth of a hertz from it the line leaves `(2π · 0.1 · 0.5)²/12` = 0.8 % of the tone, which tells it to `0.01 √(2/4096)/√0.008` =
    /// 0.0025 beside the other run, and is nothing without that. Two thousandths of a hertz from it the tone is left open in the line. In
    /// both the first channel holds the motion that the others read, and the noise of 0.01 of both.
    #[test]
    fn a_tone_beside_a_line_is_known_from_other_runs() {
        for (hertz, open) in [(30.05, false), (30.001, true)] {
            let (records, faults) = beside(hertz);
            let told: Vec<_> = faults.iter().map(|f| (f.id, f.sensor)).collect();
            assert_eq!(told, [("measurement.hum", 0)], "{hertz}");
            let run = &records[0];
            let [one, two] = [1, 2].map(|part| part * run.subharmonic);
            let deviation = &run.lines.deviation;
            // Of an amplitude of 0.9 and any phase, 0.9/√2 in each part.
            assert_eq!(deviation[0][two] > 0.6, open, "{hertz}: {}", deviation[0][two]);
            assert!(deviation[0][one].max(deviation[1][two]) < 0.01);
            let error = run.line_error(0, &run.lines.acceleration[1]).sqrt();
            assert!(error < 0.012, "{hertz}: {error}");
        }
    }

    /// Noise of which 0.95 stays is 39 times as loud at low frequencies as on the whole: tones in it explain a χ² of 78 where white noise
    /// has 2. The runs that are louder have no period, and their parts at mains frequencies are no hum's.
    #[test]
    fn coloured_noise_is_no_hum() {
        let laboratory = Laboratory::new(&[0.03, 0.9, 0.9], 0.95, 0.0);
        let runs = laboratory.runs();
        assert!(find(&runs, Some(&[0.03; 4]), &mut Channels::new(&runs)).is_empty());
    }
}
