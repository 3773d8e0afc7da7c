//! Three hypotheses about the motion of the beam, compared at every level.
//!
//! | hypothesis | accelerations at the sensors |
//! |---|---|
//! | fixed modes | `Σ_{n ≤ K} φ_n(x_s) q_n(t)`, shapes of the linear beam |
//! | real modes of the level | `Σ_{n ≤ K} ψ_n(x_s) q_n(t)`, real shapes of each run: the principal components of its lines |
//! | harmonic balance | `Re Σ_h a_h(x_s) e^{ihΩt}`, complex shapes of each line, made of receptances and recovered forces |

use crate::{Form, Rig, RunReconstruction};
use faer::linalg::solvers::SolveLstsq;
use faer::{Mat, Side};
use frettrace_beam::Dof;

/// Errors of the three hypotheses for one run: relative root mean square of measured less described lines.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeComparison {
    /// Number `K` of modes of the first two hypotheses: those up to twice the excitation frequency, fewer than sensors.
    pub modes: usize,
    /// Fixed linear modes.
    pub fixed: f64,
    /// Real modes of the level.
    pub real: f64,
    /// Harmonic balance.
    pub harmonic: f64,
    /// The same of noise alone.
    pub noise_floor: f64,
    /// First real mode of the level at the sensors, largest entry one.
    pub shape: Vec<f64>,
    /// Modal assurance criterion of that shape with the linear mode it resembles most.
    pub assurance: f64,
    /// That linear mode, from 0.
    pub resembles: usize,
    /// Root mean square of the first generalised acceleration (m/s² at the largest entry of the shape).
    pub coordinate: f64,
}

/// Compares the hypotheses on one run; `None` with a single sensor, and for a run that is not periodic: its motion is no sum of the lines that
/// the hypotheses describe.
#[must_use]
pub fn compare_modes(rig: &Rig, run: &RunReconstruction) -> Option<ModeComparison> {
    if run.lines.form == Form::Aperiodic {
        return None;
    }
    let contact = run.contact.as_ref()?;
    let measured = line_rows(&run.lines.accelerations);
    let fitted = line_rows(&contact.acceleration_fit);
    let sensors = measured.ncols();
    if sensors < 2 || measured.nrows() == 0 {
        return None;
    }
    let power = measured.squared_norm_l2().max(f64::MIN_POSITIVE);
    let excitation = run.lines.force.base * run.lines.subharmonic_order as f64;
    let within = rig.structure.natural_frequency().iter().take_while(|w| **w < 2.0 * excitation).count();
    let modes = within.clamp(1, sensors - 1);
    let linear = linear_shapes(rig, sensors);
    let (values, vectors) = principal(&measured)?;
    let left: f64 = values.iter().skip(modes).sum();
    let (resembles, assurance) = most_alike(&vectors[0], &linear);
    let noise: f64 = run.lines.accelerations.iter().flat_map(|a| a.variance.iter().skip(1)).sum();
    let largest = vectors[0].iter().copied().fold(0.0, |m: f64, v| if v.abs() > m.abs() { v } else { m });
    Some(ModeComparison {
        modes,
        fixed: (outside(&measured, &linear[..modes]) / power).sqrt(),
        real: (left.max(0.0) / power).sqrt(),
        harmonic: ((&measured - &fitted).squared_norm_l2() / power).sqrt(),
        noise_floor: (noise / power).sqrt(),
        shape: vectors[0].iter().map(|v| v / largest).collect(),
        assurance,
        resembles,
        coordinate: (0.5 * values[0]).sqrt() * largest.abs(),
    })
}

/// Real and imaginary parts of the lines `h ≥ 1`, one row each; one column a sensor.
fn line_rows(accelerations: &[frettrace_fourier::Harmonics]) -> Mat<f64> {
    let order = accelerations.iter().map(frettrace_fourier::Harmonics::order).min().unwrap_or(0);
    Mat::from_fn(2 * order, accelerations.len(), |row, s| {
        let value = accelerations[s].coefficients[1 + row / 2];
        if row % 2 == 0 { value.re } else { value.im }
    })
}

/// Linear modes at the sensors, as many as there are sensors.
fn linear_shapes(rig: &Rig, sensors: usize) -> Vec<Vec<f64>> {
    let at = |position| Dof { position, freedom: frettrace_beam::Freedom::Displacement };
    rig.structure
        .shapes()
        .iter()
        .take(sensors)
        .map(|shape| rig.sensors.iter().map(|sensor| shape.at(at(sensor.position))).collect())
        .collect()
}

/// Squared part of the rows outside the span of the shapes.
fn outside(rows: &Mat<f64>, shapes: &[Vec<f64>]) -> f64 {
    let basis = Mat::from_fn(rows.ncols(), shapes.len(), |s, n| shapes[n][s]);
    let target = rows.transpose().to_owned();
    let coordinates = basis.qr().solve_lstsq(&target);
    (target - basis * coordinates).squared_norm_l2()
}

/// Principal components of the rows: squared singular values, falling, and their real shapes.
fn principal(rows: &Mat<f64>) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let gram = rows.transpose() * rows;
    let eigen = gram.self_adjoint_eigen(Side::Lower).ok()?;
    let n = rows.ncols();
    let values = (0..n).rev().map(|i| eigen.S()[i].max(0.0)).collect();
    let vectors = (0..n).rev().map(|i| (0..n).map(|s| eigen.U()[(s, i)]).collect()).collect();
    Some((values, vectors))
}

/// The shape that is most alike, and its modal assurance criterion `(aᵀb)²/(aᵀa · bᵀb)`.
fn most_alike(shape: &[f64], others: &[Vec<f64>]) -> (usize, f64) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let assurance = |other: &[f64]| dot(shape, other).powi(2) / (dot(shape, shape) * dot(other, other));
    others
        .iter()
        .enumerate()
        .map(|(n, other)| (n, assurance(other)))
        .fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best })
}
