//! Simulated rigs whose effect another one nearly stands in for: the name is the effect's, and so are its values.

use crate::case::{Case, Outcome, Row};
use anyhow::Context;
use frettrace::{
    Progress,
    explain::{ExplainOptions, explain},
    results::Effect,
    rig::parse_rig,
    simulate::simulate,
};
use frettrace_measurement::Recording;
use std::path::Path;

/// The case.
pub const CASE: Case = Case { name: "verify_explained_rigs", run };

/// A rig, its effect, and the parameters of the claim with their true values.
struct Hidden {
    rig: &'static str,
    effect: &'static str,
    parameters: &'static [(&'static str, &'static str, f64)],
}

const RIGS: [Hidden; 5] = [
    Hidden {
        rig: include_str!("../../cases/verify_explained_rigs/ageing.toml"),
        effect: "friction.ageing",
        parameters: &[
            ("ageing_gain", "1", 0.08),
            ("ageing_distance", "m", 6.0117e-7),
            ("ageing_time", "s", 3.632e-4),
        ],
    },
    Hidden {
        rig: include_str!("../../cases/verify_explained_rigs/quadratic_damping.toml"),
        effect: "structure.quadratic-damping",
        parameters: &[("position", "m", 0.314), ("quadratic_damping", "N·s²/m²", 5.2116)],
    },
    Hidden {
        rig: include_str!("../../cases/verify_explained_rigs/exponent.toml"),
        effect: "friction.exponent",
        parameters: &[("exponent", "1", 0.5)],
    },
    // Of a rig whose modes nobody measured: below the first resonance the contact's force takes up what the drift changes.
    Hidden {
        rig: include_str!("../../cases/verify_explained_rigs/drift.toml"),
        effect: "structure.frequency-drift",
        parameters: &[("drift", "1", -0.002)],
    },
    // The lag that explains it is one of the law's other forms: the name is the claim.
    Hidden {
        rig: include_str!("../../cases/verify_explained_rigs/lag.toml"),
        effect: "friction.lag",
        parameters: &[],
    },
];

fn run() -> anyhow::Result<Outcome> {
    let mut rows = Vec::new();
    for hidden in &RIGS {
        rows.extend(told(hidden)?);
    }
    Ok(Outcome::Ran(rows))
}

fn told(hidden: &Hidden) -> anyhow::Result<Vec<Row>> {
    let quiet = Progress::silent();
    let made = simulate(&parse_rig(hidden.rig, Path::new(hidden.effect))?, &quiet)?;
    let found = explain(&Recording::Measurement(made.measurement), &ExplainOptions::default(), &quiet)?;
    let named = |effect: &&Effect| effect.id == hidden.effect;
    let others = found.effects.iter().filter(|effect| !named(effect)).count();
    let row = |quantity: String, found: f64| Row {
        quantity: format!("{}: {quantity}", hidden.effect),
        unit: "1",
        source: "rig",
        expected: Some(1.0),
        found,
        tolerance: 0.0,
        reason: "one effect is in the rig",
    };
    let held_out = found.held_out.context("nothing held out")?;
    let mut rows = vec![
        row("named".into(), found.effects.iter().filter(named).count() as f64),
        Row { expected: Some(0.0), ..row("other names".into(), others as f64) },
        Row {
            tolerance: 0.02,
            source: "noise",
            reason: "scatter of the noise and of the fitted values",
            ..row("error of held-out runs over the noise".into(), held_out.after / held_out.noise_floor)
        },
    ];
    if let Some(effect) = found.effects.iter().find(named) {
        for &(name, unit, truth) in hidden.parameters {
            let estimate =
                effect.parameters.get(name).with_context(|| format!("{name} is not in the claim"))?;
            rows.push(Row {
                unit,
                expected: Some(truth),
                tolerance: 3.0 * estimate.std,
                reason: "three of its standard deviations",
                ..row(name.into(), estimate.value)
            });
        }
    }
    Ok(rows)
}
