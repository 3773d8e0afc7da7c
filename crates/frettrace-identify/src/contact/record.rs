//! From raw samples of a test rig to histories: smooth motion, cycles, noise, a part held out.

use super::smooth::Smoother;
use super::{Closure, ContactHistory, NoiseDraw};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::ops::Range;

/// Raw samples of one run of a contact record.
#[derive(Clone, Copy, Debug)]
pub struct RawRun<'a> {
    /// Name.
    pub label: &'a str,
    /// Times (s).
    pub time: &'a [f64],
    /// Slip (m or rad).
    pub slip: &'a [f64],
    /// Slip velocity, where measured.
    pub velocity: Option<&'a [f64]>,
    /// Slip acceleration, where measured.
    pub acceleration: Option<&'a [f64]>,
    /// Normal force (N), where known.
    pub normal: Option<&'a [f64]>,
    /// Preload (N), where known.
    pub preload: Option<f64>,
    /// Force (N).
    pub force: &'a [f64],
    /// Standard deviation of the force's noise (N), where given.
    pub force_std: Option<f64>,
}

/// Where a noise floor comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloorSource {
    /// The file states it.
    Given,
    /// From repeated cycles.
    Repeats,
    /// From the scatter between neighbouring samples.
    Estimated,
}

/// A run with smooth motion and known cycles.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedRun {
    /// The whole run.
    pub history: ContactHistory,
    /// Cycles of the slip, as ranges of samples.
    pub cycles: Vec<Range<usize>>,
    /// Standard deviation of the force about what repeats (N): what a perfect model leaves.
    pub floor: f64,
    /// Where the floor comes from.
    pub floor_source: FloorSource,
}

/// Draws of the slip's noise kept with a history.
const DRAWS: usize = 12;
/// Samples of one run that a fit can use: more only repeat what neighbours say.
const MOST_SAMPLES: usize = 6000;
/// Cycles whose amplitude is within this share of the median one are repeats.
const ALIKE: f64 = 0.05;

impl PreparedRun {
    /// Smooths the motion, finds cycles and noise.
    #[must_use]
    pub fn new(raw: &RawRun<'_>, seed: u64) -> Self {
        let smoother = Smoother::of(raw.time, raw.slip);
        let stride = raw.time.len().div_ceil(MOST_SAMPLES).max(1);
        let kept: Vec<usize> = (0..raw.time.len()).step_by(stride).collect();
        let pick = |x: &[f64]| kept.iter().map(|k| x[*k]).collect::<Vec<_>>();
        let motion = smoother.motion(raw.time, raw.slip);
        let known = |k: usize| raw.normal.map_or(raw.preload.unwrap_or(1.0), |n| n[k]);
        let acceleration = raw.acceleration.map_or_else(|| pick(&motion.acceleration), pick);
        let velocity = match raw.velocity {
            Some(measured) if trustworthy(measured, &motion.velocity) => pick(measured),
            _ => pick(&motion.velocity),
        };
        let mut history = ContactHistory {
            label: raw.label.to_owned(),
            time: pick(raw.time),
            slip: pick(&motion.slip),
            velocity,
            acceleration: Some(acceleration),
            normal: kept.iter().map(|k| known(*k)).collect(),
            force: pick(raw.force),
            closure: Closure::Open,
            mean_is_seen: true,
            force_std: 0.0,
            draws: Vec::new(),
            first: 1,
        };
        let cycles = cycles(&history);
        let repeats = repeatability(&history, &cycles);
        let (floor, floor_source) = match (raw.force_std, repeats) {
            (Some(std), _) if std > 0.0 => (std, FloorSource::Given),
            (_, Some(std)) => (std, FloorSource::Repeats),
            _ => (scatter(raw.force), FloorSource::Estimated),
        };
        history.force_std = floor.max(1e-9 * rms(&history.force)).max(f64::MIN_POSITIVE);
        history.draws = draws(raw, (&smoother, &kept), seed);
        Self { history, cycles, floor, floor_source }
    }

    /// A part of the run as a history of its own.
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> ContactHistory {
        let h = &self.history;
        let cut = |x: &[f64]| x[range.clone()].to_vec();
        ContactHistory {
            label: h.label.clone(),
            time: cut(&h.time),
            slip: cut(&h.slip),
            velocity: cut(&h.velocity),
            acceleration: h.acceleration.as_deref().map(cut),
            normal: cut(&h.normal),
            force: cut(&h.force),
            closure: h.closure,
            mean_is_seen: h.mean_is_seen,
            force_std: h.force_std,
            draws: h
                .draws
                .iter()
                .map(|d| NoiseDraw { slip: cut(&d.slip), velocity: cut(&d.velocity), force: cut(&d.force) })
                .collect(),
            first: 1,
        }
    }

    /// Samples of the first two thirds of the cycles, and of the rest; by time where there are fewer than three.
    #[must_use]
    pub fn split(&self) -> (Range<usize>, Range<usize>) {
        let n = self.history.len();
        let middle = match self.cycles.len() {
            0..=2 => 2 * n / 3,
            count => self.cycles[2 * count / 3].start,
        };
        (0..middle, middle..n)
    }
}

/// Measured velocity that agrees with the derivative of the slip to a tenth is the better one.
fn trustworthy(measured: &[f64], derived: &[f64]) -> bool {
    let miss: f64 = measured.iter().zip(derived).map(|(a, b)| (a - b).powi(2)).sum();
    let size: f64 = derived.iter().map(|v| v * v).sum();
    miss < 0.01 * size && scatter(measured) <= scatter(derived)
}

/// Cycles between rising crossings of the middle of the slip, with a hysteresis of a fifth of the amplitude.
fn cycles(history: &ContactHistory) -> Vec<Range<usize>> {
    let (low, high) = super::history::range(&history.slip);
    let (middle, band) = (0.5 * (low + high), 0.1 * (high - low));
    let (mut below, mut crossings) = (false, Vec::new());
    for (k, slip) in history.slip.iter().enumerate() {
        if *slip < middle - band {
            below = true;
        } else if below && *slip >= middle {
            crossings.push(k);
            below = false;
        }
    }
    crossings.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

/// Phases at which cycles are compared.
const PHASES: usize = 200;

/// Scatter of the force about the mean cycle, over the cycles that are alike; `None` for fewer than three.
fn repeatability(history: &ContactHistory, cycles: &[Range<usize>]) -> Option<f64> {
    let size = |c: &Range<usize>| {
        let (low, high) = super::history::range(&history.slip[c.clone()]);
        (high - low, history.time[c.end] - history.time[c.start])
    };
    let median = |mut x: Vec<f64>| {
        x.sort_by(f64::total_cmp);
        x.get(x.len() / 2).copied()
    };
    let width = median(cycles.iter().map(|c| size(c).0).collect())?;
    let length = median(cycles.iter().map(|c| size(c).1).collect())?;
    let alike: Vec<Vec<f64>> = cycles
        .iter()
        .filter(|c| (size(c).0 / width - 1.0).abs() < ALIKE && (size(c).1 / length - 1.0).abs() < ALIKE)
        .map(|c| by_phase(history, c))
        .collect();
    if alike.len() < 3 {
        return None;
    }
    let count = alike.len() as f64;
    let sum: f64 = (0..PHASES)
        .map(|p| {
            let mean = alike.iter().map(|c| c[p]).sum::<f64>() / count;
            alike.iter().map(|c| (c[p] - mean).powi(2)).sum::<f64>()
        })
        .sum();
    Some((sum / (PHASES as f64 * (count - 1.0))).sqrt())
}

/// The force of a cycle at equidistant phases.
fn by_phase(history: &ContactHistory, cycle: &Range<usize>) -> Vec<f64> {
    let (start, end) = (history.time[cycle.start], history.time[cycle.end]);
    let mut k = cycle.start;
    (0..PHASES)
        .map(|p| {
            let t = start + (end - start) * p as f64 / PHASES as f64;
            while history.time[k + 1] < t && k + 1 < cycle.end {
                k += 1;
            }
            let share = (t - history.time[k]) / (history.time[k + 1] - history.time[k]);
            history.force[k] + share * (history.force[k + 1] - history.force[k])
        })
        .collect()
}

/// Noise from second differences: `√(Σ(x₋ − 2x + x₊)²/6n)`.
fn scatter(x: &[f64]) -> f64 {
    let sum: f64 = x.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2)).sum();
    (sum / (6.0 * x.len().saturating_sub(2).max(1) as f64)).sqrt()
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|v| v * v).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

/// Draws of white slip noise through the same smoothing, with independent force noise.
fn draws(raw: &RawRun<'_>, (smoother, kept): (&Smoother, &[usize]), seed: u64) -> Vec<NoiseDraw> {
    let mut generator = rand_pcg::Pcg64::seed_from_u64(seed);
    let force_std = raw.force_std.unwrap_or_else(|| scatter(raw.force));
    (0..DRAWS)
        .map(|_| {
            let mut white = |std: f64, n: usize| -> Vec<f64> {
                (0..n)
                    .map(|_| {
                        let unit: f64 = StandardNormal.sample(&mut generator);
                        std * unit
                    })
                    .collect()
            };
            let error = smoother.motion(raw.time, &white(smoother.noise(), raw.time.len()));
            NoiseDraw {
                slip: kept.iter().map(|k| error.slip[*k]).collect(),
                velocity: kept.iter().map(|k| error.velocity[*k]).collect(),
                force: white(force_std, kept.len()),
            }
        })
        .collect()
}
