//! The force of a contact that sticks from one instant on: memory equation, closed form, truncated modes.

use crate::case::{Case, Outcome, Row};
use frettrace::report::chart::{Chart, Curve, Ink, Role};
use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::march::Port;
use frettrace_forward::memory::Memory;
use std::{fs, path::Path};

/// The case.
pub const CASE: Case = Case { name: "verify_memory_equation", run };

const STEP: f64 = 2e-6;
const STEPS: usize = 400;
/// So many modes reach half a million rad/s, a turn in a step.
const ALL_MODES: usize = 400;

fn run() -> anyhow::Result<Outcome> {
    let time: Vec<f64> = (0..STEPS).map(|k| k as f64 * STEP).collect();
    // Unit beam, unit velocity.
    let scale = 4.0 * 0.25_f64.powf(0.25) / std::f64::consts::PI.sqrt();
    let exact: Vec<f64> = time.iter().map(|t| scale * t.sqrt()).collect();
    let whole = held(ALL_MODES, true, &time)?;
    let last = STEPS - 1;
    let mut rows = vec![Row {
        quantity: "contact force at the end of the window over the closed form".into(),
        unit: "1",
        source: "Abel's equation of the half-infinite beam",
        expected: Some(1.0),
        found: whole[last] / exact[last],
        tolerance: 0.01,
        reason: "the square root at the start is no straight line",
    }];
    let mut curves = vec![("closed form".to_owned(), exact.clone()), ("memory equation".to_owned(), whole)];
    for modes in [6, 12, 24] {
        for residual in [false, true] {
            let force = held(modes, residual, &time)?;
            let name = format!("{modes} modes{}", if residual { " and residual" } else { "" });
            rows.push(if residual { near(&name, &force, &exact) } else { impulse(&name, &force, &exact) });
            if modes == 12 {
                curves.push((name, force));
            }
        }
    }
    draw(&time, &curves)?;
    Ok(Outcome::Ran(rows))
}

fn near(name: &str, force: &[f64], exact: &[f64]) -> Row {
    Row {
        quantity: format!("{name}: deviation of the contact force"),
        unit: "1",
        source: "nothing known before",
        expected: None,
        found: deviation(force, exact),
        tolerance: 0.1,
        reason: "a tenth of the force itself",
    }
}

/// A mass at the contact needs an impulse: the first force grows with the inverse square of the step, and those that follow swing
/// without bound.
fn impulse(name: &str, force: &[f64], exact: &[f64]) -> Row {
    let found = force[1] / exact[1];
    Row {
        quantity: format!("{name} alone: force of the first step over the closed form"),
        unit: "1",
        source: "the mass that truncated modes put at the contact",
        expected: None,
        found,
        tolerance: 0.1 * found.abs(),
        reason: "a tenth of itself",
    }
}

/// Force that holds a contact which would move at unit velocity.
fn held(modes: usize, residual: bool, time: &[f64]) -> anyhow::Result<Vec<f64>> {
    let beam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };
    let options = ModalOptions { modes, ..ModalOptions::default() };
    let model = ModalModel::new(&beam, &Boundary::pinned(), &options)?;
    let port = Port { dof: Dof::rotation(1.0), factor: 1.0 };
    let make = if residual { Memory::new } else { Memory::truncated };
    Ok(make(&model, port, STEP, time.len())?.force(time, &vec![0.0; time.len()]))
}

fn deviation(force: &[f64], exact: &[f64]) -> f64 {
    let square: f64 = force.iter().zip(exact).map(|(a, b)| (a - b).powi(2)).sum();
    (square / exact.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

/// A force within the frame, up to the sample where it leaves all numbers.
fn cut_to(force: &[f64], low: f64, high: f64) -> Vec<f64> {
    force.iter().take_while(|f| f.is_finite()).map(|f| f.clamp(low, high)).collect()
}

/// The figure: forces larger than the frame are cut to it, or an impulse would hide all else.
fn draw(time: &[f64], forces: &[(String, Vec<f64>)]) -> anyhow::Result<()> {
    let top = 2.0 * forces[0].1.iter().copied().fold(0.0, f64::max);
    let milli: Vec<f64> = time.iter().map(|t| 1e3 * t).collect();
    let cut: Vec<Vec<f64>> = forces.iter().map(|(_, force)| cut_to(force, -0.5 * top, top)).collect();
    let curves = forces
        .iter()
        .zip(&cut)
        .enumerate()
        .map(|(index, ((name, _), y))| Curve::line(name, Role::Number(index), &milli[..y.len()], y))
        .collect();
    let chart = Chart {
        title: "Contact force after the onset of sticking",
        x_label: "time [10⁻³ L²√(ρA/EI)]",
        y_label: "force, cut to the frame",
        logarithmic: false,
        curves,
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/verify_memory_equation");
    fs::write(folder.join("stick_onset.svg"), chart.picture(Ink::File).svg)?;
    Ok(())
}
