//! Finite elements of the rig with static and with dynamic friction, after the 2019 study of the frictional beam.

use crate::case::{Case, Outcome, Row};
use frettrace::report::chart::{Chart, Curve, Ink, Role};
use frettrace_beam::{Dof, FiniteElements, UniformBeam};
use frettrace_forward::march::{
    Assembly, FrictionContact, March, Moment, Normal, SettleOptions, Settling, Structure, settle,
};
use frettrace_friction::FrictionLaw;
use frettrace_friction::laws::{Coulomb, Dahl, Hybrid, Lugre, Stribeck};
use std::f64::consts::TAU;

/// The case.
pub const CASE: Case = Case { name: "validate_finite_element_rig", run };

const LENGTH: f64 = 0.5;
const ARM: f64 = 0.0037;
const SUPPORT: f64 = 5e6;
const PRELOAD: f64 = 70.0;
const OMEGA: f64 = TAU * 109.0;
const SIGMA0: f64 = 5e5;
const MU_K: f64 = 0.25;
const SAMPLES: usize = 512;
const REFINEMENT: usize = 4;
/// Elements of the "experiment" and of the models: no model has the experiment's mesh.
const MESHES: [usize; 2] = [60, 24];
/// Amplitudes of the force (N): mostly presliding, both, mostly sliding.
const FORCES: [f64; 3] = [1.1, 3.0, 8.0];

/// Excitation, contact and sensor over the settled period.
type Record = Vec<(Moment, f64)>;

/// Errors of one model: beam (relative root mean square of the displacement) and size of the friction force (ratio).
#[derive(Clone, Copy, Debug)]
struct Errors {
    beam: f64,
    size: f64,
}

/// What came of one experiment at one force: Coulomb, Stribeck, Dahl, hybrid.
struct Level {
    force: f64,
    slip: f64,
    models: [Errors; 4],
}

fn run() -> anyhow::Result<Outcome> {
    let levels = FORCES.map(level).into_iter().collect::<anyhow::Result<Vec<_>>>()?;
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/validate_finite_element_rig");
    std::fs::write(std::path::Path::new(folder).join("beam_error.svg"), figure(&levels))?;
    Ok(Outcome::Ran(levels.iter().flat_map(judged).collect()))
}

fn judged(level: &Level) -> Vec<Row> {
    let [coulomb, stribeck, dahl, hybrid] = level.models;
    let at = format!("{} N (slip {:.0} elastic deflections)", level.force, level.slip);
    let reported = |name: &str, found: f64| Row {
        quantity: format!("beam error of {name}; {at}"),
        unit: "1",
        source: "the hybrid experiment",
        expected: None,
        found,
        tolerance: 0.02,
        reason: "reported",
    };
    let held = |quantity: String, expected: f64, found: f64, tolerance: f64, reason: &'static str| Row {
        quantity,
        unit: "1",
        source: "the hybrid experiment",
        expected: Some(expected),
        found,
        tolerance,
        reason,
    };
    vec![
        reported("Coulomb", coulomb.beam),
        reported("Stribeck", stribeck.beam),
        reported("Dahl", dahl.beam),
        held(format!("beam error of the hybrid law; {at}"), 0.0, hybrid.beam, 2e-3, "two meshes, two steps"),
        held(
            format!("size of the static friction force; {at}"),
            1.0,
            0.5 * (coulomb.size + stribeck.size),
            0.5,
            "the right order, as the study says",
        ),
    ]
}

fn figure(levels: &[Level]) -> String {
    let force: Vec<f64> = levels.iter().map(|level| level.force).collect();
    let errors: Vec<Vec<f64>> =
        (0..4).map(|model| levels.iter().map(|level| level.models[model].beam).collect()).collect();
    let names = ["Coulomb", "Stribeck", "Dahl", "hybrid"];
    let curves = names.iter().zip(&errors).enumerate();
    let chart = Chart {
        title: "Error of the beam's motion",
        x_label: "force amplitude [N]",
        y_label: "relative error [1]",
        logarithmic: true,
        curves: curves
            .map(|(number, (&name, y))| Curve::line(name, Role::Number(number), &force, y))
            .collect(),
    };
    chart.picture(Ink::File).svg
}

/// The experiment and its four models, each fitted to the experiment's own contact force.
fn level(force: f64) -> anyhow::Result<Level> {
    let lugre = Lugre {
        sigma0: SIGMA0,
        sigma1: 0.0,
        v_d: 1e-3,
        sigma2: 0.0,
        mu_s: MU_K,
        mu_k: MU_K,
        v_s: 1e-3,
        delta: 1.0,
    };
    let hybrid = Hybrid { lugre, breakaway: 0.3 };
    let truth = respond(hybrid, MESHES[0], force)?;
    let ratio = |m: &Moment| m.velocity.signum() * m.friction / m.normal;
    let mu_k = truth.iter().map(|(m, _)| ratio(m)).sum::<f64>() / truth.len() as f64;
    let models = [
        respond(Coulomb { mu_k }, MESHES[1], force)?,
        respond(fitted_stribeck(&truth), MESHES[1], force)?,
        respond(Dahl { sigma0: SIGMA0, mu_k: dahl_level(&truth), exponent: 1.0 }, MESHES[1], force)?,
        respond(hybrid, MESHES[1], force)?,
    ];
    let friction = |record: &Record| root_mean_square(record.iter().map(|(m, _)| m.friction));
    let models = models
        .each_ref()
        .map(|model| Errors { beam: difference(model, &truth), size: friction(model) / friction(&truth) });
    let slip = truth.iter().map(|(m, _)| m.slip.abs()).fold(0.0, f64::max) * SIGMA0 / MU_K;
    Ok(Level { force, slip, models })
}

/// The largest friction over normal force: what a presliding law's level is seen as.
fn dahl_level(truth: &Record) -> f64 {
    truth.iter().map(|(m, _)| (m.friction / m.normal).abs()).fold(0.0, f64::max)
}

/// Exciter, slip, end, sensor.
fn structure(elements: usize) -> anyhow::Result<Structure> {
    let beam = UniformBeam::rectangular(LENGTH, [0.03, 0.0075], 2.0e11, 7850.0);
    let mut mesh = FiniteElements::clamped(&beam, elements)?;
    mesh.add_spring(Dof::displacement(LENGTH), SUPPORT);
    let modes = mesh.eigenmodes()?;
    let row = |dof: Dof, factor: f64| -> Vec<f64> {
        let row = mesh.row(dof);
        let sum = |n: usize| row.iter().enumerate().map(|(i, r)| factor * r * modes.modes[(i, n)]).sum();
        (0..row.len()).map(sum).collect()
    };
    let rows = vec![
        row(Dof::displacement(0.21), 1.0),
        row(Dof::rotation(LENGTH), ARM),
        row(Dof::displacement(LENGTH), 1.0),
        row(Dof::displacement(0.31), 1.0),
    ];
    let damping = vec![0.005; modes.natural_frequency.len()];
    Ok(Structure::new(modes.natural_frequency, damping, rows)?)
}

/// Contact and sensor displacement over the settled period.
fn respond<L: FrictionLaw<f64>>(law: L, elements: usize, amplitude: f64) -> anyhow::Result<Record> {
    let normal = Normal { port: Some(2), stiffness: SUPPORT, ..Normal::constant(PRELOAD) };
    let assembly = Assembly {
        structure: structure(elements)?,
        inputs: vec![0],
        friction: Some(FrictionContact { law, slip_port: 1, normal }),
        loads: Vec::new(),
    };
    let steps = SAMPLES * REFINEMENT;
    let options =
        SettleOptions { steps_per_period: steps, tolerance: 1e-6, ..SettleOptions::new(TAU / OMEGA) };
    let mut march = March::new(&assembly, 1.0);
    let force = |time: f64| amplitude * (OMEGA * time).cos();
    let settled = settle(&mut march, &options, |time, loads| loads[0] = force(time));
    anyhow::ensure!(matches!(settled, Settling::Periodic { multiple: 1, .. }), "not settled: {settled:?}");
    let dt = options.period / steps as f64;
    let mut record = Vec::new();
    for step in 1..=steps {
        march.step(&[force(march.time() + dt)]);
        if step % REFINEMENT == 0 {
            record.push((march.moment(), march.displacement(3)));
        }
    }
    Ok(record)
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (count, square) = values.fold((0_usize, 0.0), |(n, sum), x| (n + 1, sum + x * x));
    (square / count as f64).sqrt()
}

/// Relative root mean square of the difference of the sensor's displacement.
fn difference(found: &Record, truth: &Record) -> f64 {
    let apart = found.iter().zip(truth).map(|(a, b)| a.1 - b.1);
    root_mean_square(apart) / root_mean_square(truth.iter().map(|sample| sample.1))
}

/// Stribeck's law through friction over normal force: linear least squares in both coefficients for each of a ladder of
/// Stribeck velocities.
fn fitted_stribeck(truth: &Record) -> Stribeck<f64> {
    let ladder = (0..24).map(|k| 1e-5 * 1.4_f64.powi(k));
    let fits = ladder.map(|v_s| (static_fit(truth, v_s), v_s));
    let best = fits.min_by(|a, b| a.0.1.total_cmp(&b.0.1));
    let (([level, rise], _), v_s) = best.unwrap_or((([0.0; 2], 0.0), 1.0));
    Stribeck { mu_s: (level + rise).max(0.0), mu_k: level, v_s, delta: 1.0, sigma2: 0.0 }
}

/// Friction over normal force against `sgn v` and `sgn v · e^{−|v|/v_s}`: coefficients and remaining square.
fn static_fit(record: &Record, v_s: f64) -> ([f64; 2], f64) {
    let columns = |m: &Moment| (m.velocity.signum(), m.velocity.signum() * (-m.velocity.abs() / v_s).exp());
    let (mut a, mut b) = ([0.0_f64; 3], [0.0_f64; 2]);
    for (m, _) in record {
        let ((c, d), y) = (columns(m), m.friction / m.normal);
        a = [a[0] + c * c, a[1] + c * d, a[2] + d * d];
        b = [b[0] + c * y, b[1] + d * y];
    }
    let determinant = a[0] * a[2] - a[1] * a[1];
    let x = [(b[0] * a[2] - b[1] * a[1]) / determinant, (a[0] * b[1] - a[1] * b[0]) / determinant];
    let rest = |m: &Moment| {
        let (c, d) = columns(m);
        (m.friction / m.normal - x[0] * c - x[1] * d).powi(2)
    };
    (x, record.iter().map(|(m, _)| rest(m)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fitted to force over velocity, Stribeck's curve rises, since a presliding contact gives way first; it is nearer to the beam
    /// than Coulomb's, as the study found, only where sliding prevails: where presliding matters no function of the velocity helps.
    #[test]
    fn static_friction_gets_the_force_right_and_the_beam_wrong() {
        for (force, sliding) in [(FORCES[0], false), (FORCES[2], true)] {
            let [coulomb, stribeck, dahl, hybrid] = level(force).unwrap().models;
            // The right order of the friction force, whatever the law.
            assert!([coulomb, stribeck, dahl, hybrid].iter().all(|model| (0.5..2.0).contains(&model.size)));
            let nearer = coulomb.beam.min(stribeck.beam);
            assert_eq!(stribeck.beam < coulomb.beam, sliding, "{coulomb:?} {stribeck:?}");
            // Found: 25 and 28 % where presliding matters, 2.6 and 2.1 % where sliding prevails, Dahl a tenth of them.
            assert!(nearer > if sliding { 0.01 } else { 0.1 }, "{nearer}");
            assert!(dahl.beam < 0.5 * nearer, "{dahl:?}");
            // Two meshes and two steps: frequencies differ by 1e-5, amplified by 1/(2ζ).
            assert!(hybrid.beam < 1e-3, "{hybrid:?}");
        }
    }
}
