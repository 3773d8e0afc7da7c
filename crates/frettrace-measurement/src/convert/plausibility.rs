//! Doubts about units and signs that the numbers themselves raise.

use crate::measurement::{ContactRecord, ContactRun, Measurement, Run};
use crate::read::Recording;

/// What looks doubtful in a recording, one sentence each.
pub(super) fn remarks(recording: &Recording) -> Vec<String> {
    match recording {
        Recording::Contact(record) => contact(record),
        Recording::Measurement(measurement) => beam(measurement),
    }
}

fn contact(record: &ContactRecord) -> Vec<String> {
    let runs = record.runs.iter();
    runs.flat_map(|run| [kinematics(run), dissipation(run, record.moving_mass)]).flatten().collect()
}

/// A given velocity or acceleration against the derivative of the displacement: their ratio is 1 where the units are
/// right, and tells the wrong unit where they are not.
fn kinematics(run: &ContactRun) -> Option<String> {
    let derived = central_difference(&run.time, &run.slip_displacement);
    let check = |name: &str, given: &Option<Vec<f64>>, derived: &[f64]| {
        let ratio = regression(given.as_ref()?, derived)?;
        let explained = describe(ratio)?;
        Some(format!(
            "run {}: the {name} is {ratio:.4} times the derivative of the displacement: {explained}",
            run.id
        ))
    };
    check("slip velocity", &run.slip_velocity, &derived).or_else(|| {
        check("slip acceleration", &run.slip_acceleration, &central_difference(&run.time, &derived))
    })
}

/// A ratio of about 1 needs no word; one that is known names the unit.
fn describe(ratio: f64) -> Option<String> {
    /// A ratio within this share of a known factor is that factor: differences of noisy signals are biased.
    const CLOSE: f64 = 0.15;
    let near = |factor: f64| (ratio.abs() / factor - 1.0).abs() < CLOSE;
    let known = [
        (9.80665, "g read as m/s^2, or the other way round"),
        (25.4, "inches and millimetres mixed up"),
        (39.3701, "inches read as metres"),
        (1000.0, "millimetres read as metres"),
        (57.29578, "degrees read as radians"),
    ];
    if near(1.0) {
        return (ratio < 0.0).then(|| "the signs differ".to_string());
    }
    let named = known.iter().find(|(factor, _)| near(*factor) || near(1.0 / factor)).map(|(_, words)| *words);
    let far = !(0.5..2.0).contains(&ratio.abs());
    named.or(far.then_some("a unit is wrong")).map(|words| format!("{words}?"))
}

/// Friction takes work from the motion: over whole cycles the force's work is positive.
fn dissipation(run: &ContactRun, mass: Option<f64>) -> Option<String> {
    if mass.is_some() {
        return None;
    }
    let pairs = run.force.windows(2).zip(run.slip_displacement.windows(2));
    let steps: Vec<f64> = pairs.map(|(f, u)| 0.5 * (f[0] + f[1]) * (u[1] - u[0])).collect();
    let (work, moved) =
        steps.iter().fold((0.0, 0.0), |(work, moved), step| (work + step, moved + step.abs()));
    // Under a tenth of the work that goes to and fro the sign may be that of the ends of the record.
    (work < -0.1 * moved)
        .then(|| format!("run {}: the friction force drives the motion: turn its sign (sign = -1)", run.id))
}

fn beam(measurement: &Measurement) -> Vec<String> {
    measurement.runs.iter().filter_map(|run| level(measurement, run)).collect()
}

/// Acceleration of the strongest sensor times the beam's mass over the force: 1 for a free mass.
///
/// Near a resonance it is about `4 φ_e φ_s / (2 ζ_total)`, with shapes of the order of 1 at a sensible exciter: well above
/// 2 for any damping below 0.5. Elsewhere a sensor may stand near a node, and only gross errors show.
fn level(measurement: &Measurement, run: &Run) -> Option<String> {
    let beam = &measurement.beam;
    let mass = beam.density * beam.length * beam.area.unwrap_or(beam.width * beam.thickness);
    let declared = measurement.modes.as_ref().map(|modes| modes.frequency.clone());
    let modes = declared.unwrap_or_else(|| vec![clamped_pinned(measurement)]);
    let resonant = modes.iter().any(|mode| (run.excitation_frequency / mode - 1.0).abs() < 0.05);
    let strongest = run.acceleration.iter().map(|values| fluctuation(values)).fold(0.0, f64::max);
    let ratio = strongest * mass / fluctuation(&run.force);
    let hint = if ratio < if resonant { 2.0 } else { 0.02 } {
        "is it in g, or the force in another unit?"
    } else if ratio > HIGHEST {
        "is it in mm/s^2, or the force in kN?"
    } else {
        return None;
    };
    let run = &run.id;
    Some(format!(
        "run {run}: the acceleration is {ratio:.3} times force over the beam's mass, hard to believe: {hint}"
    ))
}

/// Twice the largest response of a mode of damping 1e-4, `4/(2 ζ)`.
const HIGHEST: f64 = 4.0e4;

/// The first natural frequency of the beam clamped and pinned \[Hz\], β₁L = 3.9266.
fn clamped_pinned(measurement: &Measurement) -> f64 {
    let beam = &measurement.beam;
    let area = beam.area.unwrap_or(beam.width * beam.thickness);
    let moment = beam.second_moment.unwrap_or(beam.width * beam.thickness.powi(3) / 12.0);
    let speed = (beam.youngs_modulus * moment / (beam.density * area)).sqrt();
    (3.926_602 / beam.length).powi(2) * speed / (2.0 * std::f64::consts::PI)
}

fn fluctuation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Derivative over neighbours, one number a sample (0 at the ends, where it is not used).
fn central_difference(time: &[f64], values: &[f64]) -> Vec<f64> {
    let inner = (1..values.len().saturating_sub(1))
        .map(|k| (values[k + 1] - values[k - 1]) / (time[k + 1] - time[k - 1]));
    std::iter::once(0.0).chain(inner).chain(std::iter::once(0.0)).collect()
}

/// The factor of the given in terms of the derived, symmetric in the noise of both: ± their ratio of RMS; `None`
/// where they are not alike enough (correlation under 0.7) to say.
fn regression(given: &[f64], derived: &[f64]) -> Option<f64> {
    // Two differences leave two samples at either end without a derivative.
    let inner = 2..given.len().checked_sub(2)?;
    let (given, derived) = (given.get(inner.clone())?, derived.get(inner)?);
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let (gg, dd, gd) = (product(given, given), product(derived, derived), product(given, derived));
    let correlation = gd / (gg * dd).sqrt();
    (correlation.abs() > 0.7).then(|| correlation.signum() * (gg / dd).sqrt())
}
