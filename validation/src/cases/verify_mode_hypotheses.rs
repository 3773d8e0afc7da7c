//! Three hypotheses about the motion, over levels, frequencies, preloads and lubrication.

use crate::case::{Case, Outcome, Row};
use frettrace::hypotheses::{Level, hypotheses};
use frettrace::{Progress, rig::parse_rig, simulate::simulate};
use std::path::Path;

/// The case.
pub const CASE: Case = Case { name: "verify_mode_hypotheses", run };

/// A steel beam on a support that turns and rubs; dry it sticks and slips, lubricated it loses friction with speed.
const RIG: &str = r#"
title = "hypotheses"
seed = 3
[beam]
length_m = 0.52
width_m = 0.030
thickness_m = 0.0070
youngs_modulus_pa = 2.05e11
density_kg_per_m3 = 7840.0
[modes]
damping_ratio = [0.02]
[support]
slip = "rotation"
lever_arm_m = 0.0035
normal_stiffness_n_per_m = 4.0e6
[exciter]
position_m = 0.212
[sensors]
position_m = [0.083, 0.161, 0.254, 0.337, 0.441]
noise_std_m_per_s2 = 0.05
[sampling]
rate_hz = 4096.0
samples = 1024
"#;
const DRY: &str = r#"
law = "dahl"
[support.parameters]
sigma0_per_m = 4.2e5
mu_k = 0.24
exponent = 1.0
"#;
const LUBRICATED: &str = r#"
law = "lugre"
[support.parameters]
sigma0_per_m = 2.5e5
sigma1_s_per_m = 10.0
v_d_m_per_s = 2e-3
sigma2_n_s_per_m = 30.0
mu_s = 0.16
mu_k = 0.08
v_s_m_per_s = 2e-3
delta = 1.5
"#;

/// What is simulated, each with each: preloads, frequencies and amplitudes of the force.
const PRELOADS: [f64; 3] = [30.0, 60.0, 120.0];
const FREQUENCIES: [f64; 2] = [88.0, 94.0];
const AMPLITUDES: [f64; 8] = [0.3, 0.5, 0.8, 1.3, 2.1, 3.4, 5.5, 9.0];
/// The bound of the published finding.
const BOUND: f64 = 0.02;

fn run() -> anyhow::Result<Outcome> {
    let levels = levels()?;
    let largest = |of: &dyn Fn(&Level) -> f64| levels.iter().map(of).fold(0.0, f64::max);
    let plain = |quantity: &str, found: f64| Row {
        quantity: quantity.to_owned(),
        unit: "1",
        source: "nothing known before",
        expected: None,
        found,
        tolerance: 0.05,
        reason: "a twentieth",
    };
    let share = |of: &dyn Fn(&Level) -> f64| {
        levels.iter().filter(|level| of(level) > BOUND).count() as f64 / levels.len() as f64
    };
    let beyond = |of: f64, floor: f64| (of * of - floor * floor).max(0.0).sqrt();
    Ok(Outcome::Ran(vec![
        Row {
            quantity: "harmonic balance: largest error beyond the noise".into(),
            unit: "1",
            source: "the published finding: below 2 % at all levels",
            expected: Some(0.0),
            found: largest(&|level| beyond(level.harmonic, level.noise_floor)),
            tolerance: BOUND,
            reason: "the published bound",
        },
        plain("fixed modes: largest error", largest(&|level| level.fixed)),
        plain("real modes of the level: largest error", largest(&|level| level.real)),
        plain("harmonic balance: share of levels above 2 %", share(&|level| level.harmonic)),
        plain("fixed modes: share of levels above 2 %", share(&|level| level.fixed)),
        plain("real modes of the level: share of levels above 2 %", share(&|level| level.real)),
    ]))
}

/// The table over three preloads, dry and lubricated, eight levels and two frequencies.
///
/// # Errors
/// Where a rig cannot be simulated or reconstructed.
pub fn table() -> anyhow::Result<String> {
    let mut text = "| film | preload [N] | frequency [Hz] | level [m/s²] | noise | fixed modes | real modes | harmonic balance |\n|---|---|---|---|---|---|---|---|\n".to_owned();
    for level in levels()? {
        text += &format!(
            "| {} | {} | {:.1} | {:.2} | {:.2} % | {:.2} % | {:.2} % | {:.2} % |\n",
            if level.lubricated == Some(true) { "lubricated" } else { "dry" },
            level.preload,
            level.frequency_hz,
            level.level,
            100.0 * level.noise_floor,
            100.0 * level.fixed,
            100.0 * level.real,
            100.0 * level.harmonic
        );
    }
    Ok(text)
}

fn levels() -> anyhow::Result<Vec<Level>> {
    let mut all = Vec::new();
    for (lubricated, law) in [(false, DRY), (true, LUBRICATED)] {
        let rig = parse_rig(&text(law, lubricated), Path::new("hypotheses"))?;
        let simulation = simulate(&rig, &Progress::silent())?;
        all.extend(hypotheses(&simulation.measurement, &Progress::silent())?);
    }
    Ok(all)
}

fn text(law: &str, lubricated: bool) -> String {
    let mut text =
        RIG.replace("normal_stiffness_n_per_m = 4.0e6\n", &format!("normal_stiffness_n_per_m = 4.0e6{law}"));
    for preload in PRELOADS {
        for frequency in FREQUENCIES {
            text += &format!(
                "[[run]]\nfrequency_hz = {frequency:?}\npreload_n = {preload:?}\nlubricated = {lubricated}\nforce_amplitude_n = {:?}\n",
                AMPLITUDES
            );
        }
    }
    text
}
