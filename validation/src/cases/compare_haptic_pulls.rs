//! Coulomb, Dahl and LuGre from pulls at three speeds.

use crate::case::{Case, Outcome, Row};
use frettrace_friction::{FrictionLaw, Step, laws::Lugre};
use frettrace_identify::contact::{
    Closure, ContactHistory, ContactModel, ContactSettings, Extras, Family, identify_contact,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// The case.
pub const CASE: Case = Case { name: "compare_haptic_pulls", run };

/// Speeds (m/s) and distance (m) of the pulls.
const SPEEDS: [f64; 3] = [1e-3, 5e-4, 1e-4];
const DISTANCE: f64 = 5e-3;
const SAMPLES: usize = 400;
/// Gram-force (N): the forces of the source are in it.
const GRAM: f64 = 9.806_65e-3;
/// Static and sliding friction of the source (N).
const STATIC: f64 = 889.2 * GRAM;
const SLIDING: f64 = 680.243 * GRAM;
/// Scatter of the force (N).
const NOISE: f64 = 20.0 * GRAM;

fn run() -> anyhow::Result<Outcome> {
    let pulls = SPEEDS.map(pull);
    let used: Vec<&ContactHistory> = pulls.iter().collect();
    let settings = ContactSettings { profiles: false, ..ContactSettings::default() };
    let mut errors = Vec::new();
    for family in [Family::Coulomb, Family::Dahl, Family::LuGre] {
        let fit = identify_contact(family, &used, &settings)?;
        let values = fit.law_values();
        errors.push(used.iter().map(|h| error(family, &values, h)).collect::<Vec<_>>());
    }
    let mut rows = Vec::new();
    for (k, speed) in SPEEDS.iter().enumerate() {
        for (family, error) in ["Coulomb", "Dahl", "LuGre"].iter().zip(&errors) {
            rows.push(Row {
                quantity: format!("RMS force error of {family} at {} mm/s", speed * 1e3),
                unit: "gf",
                source: "reported",
                expected: None,
                found: error[k] / GRAM,
                tolerance: 2.0,
                reason: "a tenth of the scatter",
            });
        }
    }
    let best = (0..3).filter(|k| errors[2][*k] < errors[0][*k].min(errors[1][*k])).count();
    rows.push(Row {
        quantity: "speeds at which LuGre is nearest, of three".to_owned(),
        unit: "1",
        source: "haptic vision, table 2 (means of three pulls)",
        expected: Some(3.0),
        found: best as f64,
        tolerance: 0.0,
        reason: "a ranking",
    });
    Ok(Outcome::Ran(rows))
}

/// A pull at constant speed of a contact with the source's static and sliding friction.
fn pull(speed: f64) -> ContactHistory {
    let law = Lugre {
        sigma0: STATIC / 2e-4,
        sigma1: 0.0,
        v_d: f64::INFINITY,
        sigma2: 0.0,
        mu_s: STATIC,
        mu_k: SLIDING,
        v_s: 3e-4,
        delta: 2.0,
    };
    let dt = DISTANCE / speed / SAMPLES as f64;
    let (mut state, mut force) = (law.rest(), vec![0.0]);
    for k in 1..SAMPLES {
        let at = |k: usize| k as f64 * dt * speed;
        let step = Step { slip: [at(k - 1), at(k)], velocity: [speed; 2], normal: [1.0; 2], dt };
        let (next, f) = law.step(state, &step);
        state = next;
        force.push(f);
    }
    let mut random = Pcg64::seed_from_u64((speed * 1e6) as u64);
    for f in &mut force {
        let unit: f64 = StandardNormal.sample(&mut random);
        *f += NOISE * unit;
    }
    ContactHistory {
        label: format!("{} mm/s", speed * 1e3),
        time: (0..SAMPLES).map(|k| k as f64 * dt).collect(),
        slip: (0..SAMPLES).map(|k| k as f64 * dt * speed).collect(),
        velocity: vec![speed; SAMPLES],
        acceleration: None,
        normal: vec![1.0; SAMPLES],
        force,
        closure: Closure::Open,
        mean_is_seen: true,
        force_std: NOISE,
        draws: Vec::new(),
        first: 1,
    }
}

/// RMS of predicted minus measured force (N).
fn error(family: Family, values: &[f64], history: &ContactHistory) -> f64 {
    let model = ContactModel::new(family, vec![history], values, Extras::default());
    let residual = model.force_residual(0, values);
    (residual.iter().map(|r| r * r).sum::<f64>() / residual.len() as f64).sqrt()
}
