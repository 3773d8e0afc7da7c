//! Clamped beam on a roller that moves: modes against the roller's position, the position found from accelerations.
//!
//! The sensitivities are missing, so the set fits no measurement file: `read_table` reads it, and only frequencies and
//! ratios of one channel to itself are used.

use super::measured_contacts::data;
use crate::case::{Case, Outcome, Row, verdict};
use frettrace_beam::{Boundary, Dof, ModeShape, UniformBeam, mode_shapes};
use frettrace_measurement::read_table;
use std::f64::consts::TAU;
use std::ops::Range;

/// The case.
pub const CASE: Case = Case { name: "validate_roller_beam", run };

const FILE: &str = "dropbear_roller_beam/10steps_test1.txt";
const RATE: f64 = 5000.0;
/// Size of the beam (m), and steel (assumed: the source names no material).
const SIZE: [f64; 3] = [0.501, 0.051, 0.00666];
const STEEL: (f64, f64) = (200e9, 7850.0);
/// The roller stands still where the pin's voltage changes less than this over a twentieth of a second (its steps are
/// 0.42 V), for at least 0.4 s.
const STILL: f64 = 0.012;
const SHORTEST: usize = 2000;

/// A dwell: the pin's voltage, the first natural frequency, and the noise of each channel beside the ringing.
struct Dwell {
    pin: f64,
    frequency: f64,
    position: f64,
}

fn run() -> anyhow::Result<Outcome> {
    let path = data().join(FILE);
    if !path.is_file() {
        return Ok(Outcome::Skipped(format!(
            "{} is absent; set FRETTRACE_DATA (see data/README.md)",
            path.display()
        )));
    }
    let table = read_table(&path)?;
    let channel = |k: usize| table.columns.get(k).map(|c| c.values.as_slice()).unwrap_or_default();
    let (low_g, second, pin) = (channel(0), channel(1), channel(2));
    anyhow::ensure!(pin.len() > SHORTEST && low_g.len() == pin.len(), "{FILE}: three channels are expected");
    let beam = UniformBeam::rectangular(SIZE[0], [SIZE[1], SIZE[2]], STEEL.0, STEEL.1);
    let shapes = mode_shapes(&beam, &Boundary::cantilever(), 20)?;
    let mut dwells = Vec::new();
    for still in dwells_of(pin) {
        let frequency = ringing(&low_g[still.clone()]);
        if let (Some(frequency), Some(position)) = (frequency, frequency.and_then(|f| support(&shapes, f))) {
            let mean = pin[still.clone()].iter().sum::<f64>() / still.len() as f64;
            dwells.push(Dwell { pin: mean, frequency, position });
        }
    }
    Ok(Outcome::Ran(rows(&dwells, quiet(low_g), quiet(second))))
}

/// A straight line through the way out predicts the way back.
fn rows(dwells: &[Dwell], low_g: f64, second: f64) -> Vec<Row> {
    let farthest = (0..dwells.len()).max_by(|a, b| dwells[*a].pin.total_cmp(&dwells[*b].pin)).unwrap_or(0);
    let (out, back) = dwells.split_at((farthest + 1).min(dwells.len()));
    let line = straight(out);
    let miss = |part: &[Dwell]| {
        let square = part.iter().map(|d| (d.position - line[0] - line[1] * d.pin).powi(2)).sum::<f64>();
        (square / part.len().max(1) as f64).sqrt()
    };
    let range = out.iter().map(|d| d.position).fold(0.0, f64::max) - out.first().map_or(0.0, |d| d.position);
    let reported = |quantity: &str, unit, found: f64| Row {
        quantity: quantity.to_owned(),
        unit,
        source: "none",
        expected: None,
        found,
        tolerance: 0.2 * found.abs(),
        reason: "a change of a fiftieth would be news",
    };
    let mut rows: Vec<Row> = out
        .iter()
        .map(|d| reported(&format!("first mode with the pin at {:.2} V", d.pin), "Hz", d.frequency))
        .collect();
    rows.push(reported("way of the roller found from accelerations", "m", range));
    rows.push(reported("position against the pin's voltage, fitted way out: rms", "m", miss(out)));
    rows.push(Row {
        expected: Some(0.0),
        source: "line of the way out",
        tolerance: 0.01 * SIZE[0],
        reason: "one hundredth of the beam's length",
        ..reported(
            &format!(
                "position against the pin's voltage, held-out way back: rms ({}: where the support is)",
                verdict(miss(back), 0.01 * SIZE[0])
            ),
            "m",
            miss(back),
        )
    });
    rows.push(Row {
        expected: Some(50.0),
        source: "the set's own remark: fifty times noisier",
        tolerance: 25.0,
        reason: "the remark has one digit",
        ..reported("noise at rest of channel 2 over that of channel 1: the bad channel", "1", second / low_g)
    });
    rows
}

/// Intercept and slope of position over voltage.
fn straight(dwells: &[Dwell]) -> [f64; 2] {
    let count = dwells.len().max(1) as f64;
    let mean = |of: fn(&Dwell) -> f64| dwells.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|d| d.pin), mean(|d| d.position));
    let product: f64 = dwells.iter().map(|d| (d.pin - x) * (d.position - y)).sum();
    let square: f64 = dwells.iter().map(|d| (d.pin - x).powi(2)).sum();
    let slope = product / square.max(f64::MIN_POSITIVE);
    [y - slope * x, slope]
}

/// Stretches in which the roller stands still.
fn dwells_of(pin: &[f64]) -> Vec<Range<usize>> {
    let window = 100;
    let smooth: Vec<f64> =
        (0..pin.len() - window).map(|k| pin[k..k + window].iter().sum::<f64>() / window as f64).collect();
    let (mut found, mut start) = (Vec::new(), None);
    for k in 0..smooth.len() - 250 {
        let still = (smooth[k + 250] - smooth[k]).abs() < STILL;
        match (still, start) {
            (true, None) => start = Some(k),
            (false, Some(first)) => {
                if k - first > SHORTEST {
                    found.push(first..k);
                }
                start = None;
            }
            _ => {}
        }
    }
    found.extend(
        start.filter(|first| smooth.len() - 250 - first > SHORTEST).map(|first| first..smooth.len() - 250),
    );
    found
}

/// Strongest frequency between 15 and 80 Hz under a Hann window, `None` where nothing rings above the noise.
fn ringing(signal: &[f64]) -> Option<f64> {
    let count = signal.len() as f64;
    let mean = signal.iter().sum::<f64>() / count;
    let size = (signal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    let line = |frequency: f64| {
        let turn = TAU * frequency / RATE;
        let (mut re, mut im) = (0.0, 0.0);
        for (k, x) in signal.iter().enumerate() {
            let hann = 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / count).cos();
            let (sine, cosine) = (turn * k as f64).sin_cos();
            re += hann * (x - mean) * cosine;
            im -= hann * (x - mean) * sine;
        }
        f64::hypot(re, im)
    };
    let grid = (0..=1300).map(|k| 15.0 + 0.05 * f64::from(k));
    let best = grid.map(|f| (f, line(f))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    // Ten times the noise at rest, 1.7 mV: a dwell without ringing says nothing.
    (size > 0.017).then_some(best.0)
}

/// Where a rigid roller must stand for a first natural frequency: the zero of the cantilever's receptance there.
fn support(shapes: &[ModeShape], frequency: f64) -> Option<f64> {
    let square = (TAU * frequency).powi(2);
    let receptance = |position: f64| {
        shapes
            .iter()
            .map(|s| s.at(Dof::displacement(position)).powi(2) / (s.natural_frequency().powi(2) - square))
            .sum::<f64>()
    };
    // Below the first mode of the cantilever no support does it; the receptance at the clamp is positive and small.
    let grid = (2..=400).map(|k| SIZE[0] * f64::from(k) / 1000.0);
    let mut before: Option<(f64, f64)> = None;
    for position in grid {
        let value = receptance(position);
        if let Some((old, height)) = before.filter(|(_, height)| height * value < 0.0) {
            return Some(old + (position - old) * height / (height - value));
        }
        before = Some((position, value));
    }
    None
}

/// Deviation of a channel over the first half second, at rest.
fn quiet(channel: &[f64]) -> f64 {
    let rest = &channel[..(RATE / 2.0) as usize];
    let mean = rest.iter().sum::<f64>() / rest.len() as f64;
    (rest.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / rest.len() as f64).sqrt()
}
