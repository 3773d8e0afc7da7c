//! What the report draws of a contact record: loops and signals of two strokes, and what the residual depends on.

use super::{Parts, maps};
use crate::exhibits::SPECTRA;
use crate::report::spectra::{self, Channel, Residual};
use crate::results::{ChannelSpectrum, ContactCurve, ContactLoop, Exhibits, ResidualShape, Waveform};
use frettrace_explain::records_explain::{RecordOutcome, RecordRun, strokes};
use frettrace_measurement::{ContactRecord, SlipUnit};
use std::ops::Range;

/// Points of a curve: as many as a drawing shows.
const POINTS: usize = 400;
/// Bins of a residual's shape.
const BINS: usize = 24;
/// Samples are equidistant when their steps differ by less than this share.
const UNEVEN: f64 = 0.1;
/// Most runs that are drawn.
const MOST_RUNS: usize = 12;

/// One run with both residuals, from its first sample that counts.
pub(super) struct Shown<'a> {
    pub run: &'a RecordRun,
    pub part: &'a super::Part,
    pub held_out: bool,
    pub residual: [&'a [f64]; 2],
    pub first: usize,
}

/// Loops and signals of every run, residuals against what may drive them.
pub(super) fn exhibits(record: &ContactRecord, parts: &Parts, outcome: &RecordOutcome) -> Exhibits {
    let unit = if record.slip_unit == SlipUnit::Radian { "rad" } else { "m" };
    let sides =
        [(&parts.case.training, &parts.training, false), (&parts.case.held_out, &parts.held_out, true)];
    let mut shown = Vec::new();
    for (runs, names, held_out) in sides {
        let [before, after] = [&outcome.baseline, &outcome.model]
            .map(|fit| if held_out { &fit.held_out } else { &fit.training });
        for (k, (run, part)) in runs.iter().zip(names).enumerate() {
            let residual = [before[k].as_slice(), after[k].as_slice()];
            let first = run.history.len() - residual[0].len();
            shown.push(Shown { run, part, held_out, residual, first });
        }
    }
    let drawn = || shown.iter().filter(|s| s.held_out).chain(shown.iter().filter(|s| !s.held_out));
    Exhibits {
        contact_is_measured: true,
        loops: drawn().take(MOST_RUNS).map(|s| contact_loop(s, unit)).collect(),
        waveforms: drawn().filter(|s| s.held_out).take(MOST_RUNS).map(waveform).collect(),
        spectra: drawn().filter(|s| s.held_out).filter_map(spectrum).take(SPECTRA).collect(),
        residual: shapes(&shown, outcome, unit),
        maps: maps::maps(&shown, outcome.floor[0], unit),
    }
}

/// Samples of two strokes that count, thinned, and whether they are a whole cycle: a closed loop.
fn window(shown: &Shown<'_>) -> (Vec<usize>, bool) {
    let slip = &shown.run.history.slip;
    let samples = slip.len();
    let all = strokes(slip);
    // The first and the last one are cut off by the ends of the record.
    let inner = all.get(1..all.len().saturating_sub(1)).unwrap_or_default();
    let counted: Vec<&Range<usize>> = inner.iter().filter(|s| s.start >= shown.first).collect();
    let cycle = inner.last().map_or(samples, |stroke| 2 * stroke.len());
    let (range, closed) = match counted[..] {
        [first, second, ..] => (first.start..second.end + 1, true),
        _ if shown.first + cycle <= samples => (samples - cycle..samples, true),
        _ => (shown.first..samples, false),
    };
    let stride = range.len().div_ceil(POINTS).max(1);
    (range.step_by(stride).collect(), closed)
}

/// `∮ F du` of a loop whose last point joins its first.
fn energy(slip: &[f64], force: &[f64]) -> f64 {
    let next = |x: &[f64], k: usize| x[(k + 1) % x.len()];
    (0..slip.len()).map(|k| 0.5 * (force[k] + next(force, k)) * (next(slip, k) - slip[k])).sum()
}

fn modelled(shown: &Shown<'_>, side: usize, samples: &[usize]) -> Vec<f64> {
    let force = &shown.run.history.force;
    samples.iter().map(|k| rounded(force[*k] - shown.residual[side][k - shown.first])).collect()
}

fn contact_loop(shown: &Shown<'_>, unit: &str) -> ContactLoop {
    let (samples, closed) = window(shown);
    let history = &shown.run.history;
    let pick = |x: &[f64]| samples.iter().map(|k| rounded(x[*k])).collect::<Vec<_>>();
    let curve = |force: Vec<f64>| {
        let slip = pick(&history.slip);
        ContactCurve {
            energy_per_cycle_j: if closed { rounded(energy(&slip, &force)) } else { f64::NAN },
            slip_velocity: pick(&history.velocity),
            slip,
            force,
        }
    };
    ContactLoop {
        run: shown.part.id.clone(),
        label: shown.part.label.clone(),
        held_out: shown.held_out,
        slip_unit: unit.to_owned(),
        measured: curve(pick(&history.force)),
        before: curve(modelled(shown, 0, &samples)),
        after: curve(modelled(shown, 1, &samples)),
    }
}

fn waveform(shown: &Shown<'_>) -> Waveform {
    let (samples, _) = window(shown);
    let history = &shown.run.history;
    Waveform {
        run: shown.part.id.clone(),
        label: shown.part.label.clone(),
        held_out: shown.held_out,
        channel: "force [N]".to_owned(),
        is_recovered: false,
        time: samples.iter().map(|k| rounded(history.time[*k])).collect(),
        measured: samples.iter().map(|k| rounded(history.force[*k])).collect(),
        before: modelled(shown, 0, &samples),
        after: modelled(shown, 1, &samples),
    }
}

/// Spectrum of the force from the first sample that counts, and of what the models leave; none where samples are not equidistant.
fn spectrum(shown: &Shown<'_>) -> Option<ChannelSpectrum> {
    let time = &shown.run.history.time[shown.first..];
    let step = (time.last()? - time.first()?) / time.len().saturating_sub(1).max(1) as f64;
    let even = time.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() < UNEVEN * step);
    let channel = Channel {
        signal: &shown.run.history.force[shown.first..],
        sampling_rate: 1.0 / step,
        noise_std: shown.run.stated,
        residual: shown.residual.map(Residual::Samples),
    };
    even.then(|| ChannelSpectrum {
        run: shown.part.id.clone(),
        label: shown.part.label.clone(),
        held_out: shown.held_out,
        channel: "force [N]".to_owned(),
        ..spectra::channel(&channel)
    })
}

/// Residuals in units of the floor against slip, velocity, acceleration, normal force, level, and time.
fn shapes(shown: &[Shown<'_>], outcome: &RecordOutcome, unit: &str) -> Vec<ResidualShape> {
    type Of = fn(&RecordRun, usize) -> f64;
    let against: [(&str, String, Of); 5] = [
        ("slip", unit.to_owned(), |run, k| run.history.slip[k]),
        ("slip velocity", format!("{unit}/s"), |run, k| run.history.velocity[k]),
        ("slip acceleration", format!("{unit}/s^2"), |run, k| {
            run.history.acceleration.as_ref().map_or(0.0, |a| a[k])
        }),
        ("normal force", "N".to_owned(), |run, k| run.history.normal[k]),
        ("time", "share of the record".to_owned(), |run, k| {
            run.progress[0] + (run.progress[1] - run.progress[0]) * k as f64 / run.history.len() as f64
        }),
    ];
    let floor = outcome.floor[0].max(f64::MIN_POSITIVE);
    let of_samples =
        against.into_iter().filter_map(|(name, unit, of)| shape(shown, (name, unit), (of, floor)));
    of_samples.chain(by_level(shown, floor, unit)).collect()
}

/// Residuals run by run, against the amplitude of the slip; none of one run.
fn by_level(shown: &[Shown<'_>], floor: f64, unit: &str) -> Option<ResidualShape> {
    let size = |residual: &[f64]| {
        let square = residual.iter().map(|r| r * r).sum::<f64>() / residual.len().max(1) as f64;
        rounded(square.sqrt() / floor)
    };
    let mut runs: Vec<(f64, [f64; 2])> =
        shown.iter().map(|s| (rounded(s.run.history.amplitude()), s.residual.map(size))).collect();
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    (runs.len() > 1).then(|| ResidualShape {
        against: "level".to_owned(),
        unit: format!("{unit}, amplitude of the slip"),
        centre: runs.iter().map(|run| run.0).collect(),
        before: runs.iter().map(|run| run.1[0]).collect(),
        after: runs.iter().map(|run| run.1[1]).collect(),
    })
}

fn shape(
    shown: &[Shown<'_>],
    (against, unit): (&str, String),
    (of, floor): (fn(&RecordRun, usize) -> f64, f64),
) -> Option<ResidualShape> {
    let points = || {
        shown.iter().flat_map(|s| {
            (s.first..s.run.history.len())
                .map(move |k| (of(s.run, k), s.residual.map(|residual| residual[k - s.first])))
        })
    };
    let (low, high) =
        points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (x, _)| (a.min(x), b.max(x)));
    if (high - low).partial_cmp(&(1e-9 * high.abs())) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let mut bins = vec![([0.0; 2], 0.0); BINS];
    for (x, residual) in points() {
        let place = (((x - low) / (high - low) * BINS as f64) as usize).min(BINS - 1);
        bins[place].1 += 1.0;
        for (sum, r) in bins[place].0.iter_mut().zip(residual) {
            *sum += r * r;
        }
    }
    let filled = || bins.iter().enumerate().filter(|(_, bin)| bin.1 > 0.0);
    let of_side =
        |side: usize| filled().map(|(_, bin)| rounded((bin.0[side] / bin.1).sqrt() / floor)).collect();
    Some(ResidualShape {
        against: against.to_owned(),
        unit,
        centre: filled().map(|(k, _)| rounded(low + (high - low) * (k as f64 + 0.5) / BINS as f64)).collect(),
        before: of_side(0),
        after: of_side(1),
    })
}

/// Six significant digits.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
