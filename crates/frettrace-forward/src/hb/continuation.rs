//! Frequency response as a curve: pseudo-arclength continuation that follows turning points.
//!
//! The curve `(f̂, Ω)` is followed by its arclength `s`, forces measured in units of their size and frequency in units of
//! the range. The predictor is the polynomial through the last points; the step is chosen so that it errs by what is
//! asked; the corrector stays in the plane across the predictor.

use super::bordered::{Conditions, Corrector, Effort, State};
use super::contact::Contact;
use super::lines::Lines;
use super::network::Network;
use super::newton::Status;
use super::solver::Solver;
use super::system::{Problem, pack};
use crate::ForwardError;
use num_complex::Complex64;

/// How a curve is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Base frequency at the start and at the end (rad/s), in either order.
    pub range: [f64; 2],
    /// Factor on the alternating loads.
    pub level: f64,
    /// Error of the predictor that is aimed at, relative to forces and range.
    pub resolution: f64,
    /// Longest step, as a share of the range.
    pub longest: f64,
    /// Most points.
    pub points: usize,
}

impl Default for Sweep {
    fn default() -> Self {
        Self { range: [1.0, 2.0], level: 1.0, resolution: 3e-3, longest: 0.05, points: 2000 }
    }
}

/// A point of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Base frequency (rad/s).
    pub omega: f64,
    /// Lines of the contact forces (N), `D × (H + 1)`.
    pub forces: Vec<Complex64>,
    /// Whether the curve turns back between the point before and this one.
    pub turned: bool,
}

/// How a curve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SweepStatus {
    /// At the end of the range.
    Finished,
    /// Back at the start of the range, by a turning point.
    Returned,
    /// No first point.
    NoStart,
    /// The steps became too short.
    Stalled,
    /// The points ran out.
    PointLimit,
}

/// A response curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The points in order.
    pub points: Vec<Point>,
    /// How the curve ended.
    pub status: SweepStatus,
    /// Marches through the contacts' periods.
    pub evaluations: usize,
    /// Jacobians.
    pub linearisations: usize,
}

/// Points the predictor goes through.
const MEMORY: usize = 4;
/// Shortest step, as a share of the range.
const SHORTEST: f64 = 1e-7;

/// The plane across the predictor: `Σ t (y − y₀) = 0` in scaled variables.
struct Plane<'a> {
    network: &'a Network,
    sweep: &'a Sweep,
    order: usize,
    base: State,
    normal: Vec<f64>,
    force_scale: f64,
    scales: [f64; 1],
}

impl Conditions for Plane<'_> {
    fn lines(&self, unknowns: &[f64]) -> Result<Lines, ForwardError> {
        self.network.lines(unknowns[0], self.order, self.sweep.level)
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn values(&self, _: &Lines, forces: &[Complex64], unknowns: &[f64], values: &mut [f64]) {
        let moved: Vec<_> = forces.iter().zip(&self.base.forces).map(|(f, b)| f - b).collect();
        let mut packed = vec![0.0; self.normal.len() - 1];
        pack(&moved, self.order, &mut packed);
        let along: f64 = packed.iter().zip(&self.normal).map(|(x, t)| x * t / self.force_scale).sum();
        let last = self.normal[packed.len()];
        values[0] = along + last * (unknowns[0] - self.base.unknowns[0]) / self.scales[0];
    }

    fn gradient(&self, _: &Lines, _: usize, row: &mut [f64]) {
        row.iter_mut().zip(&self.normal).for_each(|(r, t)| *r = t / self.force_scale);
    }
}

/// Points behind the predictor with their arclengths, the newest last.
struct Track {
    states: Vec<(f64, State)>,
    width: f64,
    force_scale: f64,
}

impl Track {
    /// Polynomial through the points at `s`, and its derivative.
    fn predict(&self, s: f64) -> (State, State) {
        let (_, first) = &self.states[0];
        let zero = || State { forces: vec![Complex64::ZERO; first.forces.len()], unknowns: vec![0.0] };
        let (mut at, mut slope) = (zero(), zero());
        for (i, (si, state)) in self.states.iter().enumerate() {
            let others = || self.states.iter().enumerate().filter(move |(j, _)| *j != i);
            let weight: f64 = others().map(|(_, (sj, _))| (s - sj) / (si - sj)).product();
            let change: f64 = others()
                .map(|(k, (sk, _))| {
                    let rest = others().filter(|(j, _)| *j != k).map(|(_, (sj, _))| (s - sj) / (si - sj));
                    rest.product::<f64>() / (si - sk)
                })
                .sum();
            for (target, factor) in [(&mut at, weight), (&mut slope, change)] {
                target.forces.iter_mut().zip(&state.forces).for_each(|(t, f)| *t += f * factor);
                target.unknowns[0] += state.unknowns[0] * factor;
            }
        }
        (at, slope)
    }

    fn distance(&self, a: &State, b: &State) -> f64 {
        let forces: f64 = a.forces.iter().zip(&b.forces).map(|(x, y)| (x - y).norm_sqr()).sum();
        (forces / self.force_scale.powi(2) + ((a.unknowns[0] - b.unknowns[0]) / self.width).powi(2)).sqrt()
    }

    fn push(&mut self, state: State) {
        let s = self.states.last().map_or(0.0, |(s, last)| s + self.distance(last, &state));
        self.states.push((s, state));
        if self.states.len() > MEMORY {
            self.states.remove(0);
        }
    }
}

impl Solver {
    /// Follows the response of a network with contacts over a range of base frequencies.
    ///
    /// # Errors
    /// A problem that is not one: see [`ForwardError`].
    pub fn follow(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        sweep: &Sweep,
    ) -> Result<Curve, ForwardError> {
        let [from, to] = sweep.range;
        let width = (to - from).abs();
        let mut curve =
            Curve { points: Vec::new(), status: SweepStatus::NoStart, evaluations: 0, linearisations: 0 };
        let mut track = Track { states: Vec::new(), width, force_scale: 1.0 };
        let first = 0.2 * sweep.longest;
        for omega in [from, from + first * (to - from)] {
            let start = curve.points.last().map(|p| p.forces.clone());
            let lines = network.lines(omega, self.settings().order, sweep.level)?;
            let solution = self.solve(&Problem { lines: &lines, contacts }, start.as_deref())?;
            curve.evaluations += solution.evaluations;
            curve.linearisations += solution.linearisations;
            if solution.status != Status::Converged {
                return Ok(curve);
            }
            track.force_scale = size(&solution.forces);
            track.push(State { forces: solution.forces.clone(), unknowns: vec![omega] });
            curve.points.push(Point { omega, forces: solution.forces, turned: false });
        }
        let mut corrector = Corrector::default();
        curve.status = self.march_on(network, contacts, sweep, (&mut curve, &mut track, &mut corrector))?;
        let Effort { evaluations, linearisations } = corrector.effort;
        curve.evaluations += evaluations;
        curve.linearisations += linearisations;
        Ok(curve)
    }

    fn march_on(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        sweep: &Sweep,
        (curve, track, corrector): (&mut Curve, &mut Track, &mut Corrector),
    ) -> Result<SweepStatus, ForwardError> {
        let mut step = 0.2 * sweep.longest;
        while curve.points.len() < sweep.points {
            let s = track.states.last().map_or(0.0, |(s, _)| *s);
            let (predicted, slope) = track.predict(s + step);
            let plane = self.plane(network, sweep, track, (&predicted, &slope));
            let mut state = predicted.clone();
            let converged = corrector.correct(self, contacts, &plane, &mut state)?;
            let error = track.distance(&state, &predicted);
            if !converged || error > 30.0 * sweep.resolution {
                step *= 0.4;
                corrector.forget();
                if step < SHORTEST {
                    return Ok(SweepStatus::Stalled);
                }
                continue;
            }
            let growth = (sweep.resolution / error.max(1e-12)).powf(1.0 / track.states.len() as f64);
            step = (step * (0.9 * growth).clamp(0.4, 2.0)).min(sweep.longest);
            if let Some(status) = self.accept(network, contacts, sweep, (curve, track, state))? {
                return Ok(status);
            }
        }
        Ok(SweepStatus::PointLimit)
    }

    fn plane<'a>(
        &self,
        network: &'a Network,
        sweep: &'a Sweep,
        track: &Track,
        (predicted, slope): (&State, &State),
    ) -> Plane<'a> {
        let order = self.settings().order;
        let count = slope.forces.len() / (order + 1) * (2 * order + 1);
        let mut normal = vec![0.0; count + 1];
        pack(&slope.forces, order, &mut normal[..count]);
        normal[..count].iter_mut().for_each(|t| *t /= track.force_scale);
        normal[count] = slope.unknowns[0] / track.width;
        Plane {
            network,
            sweep,
            order,
            base: predicted.clone(),
            normal,
            force_scale: track.force_scale,
            scales: [track.width],
        }
    }

    /// Adds a point; one beyond the range is put on its end.
    fn accept(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        sweep: &Sweep,
        (curve, track, state): (&mut Curve, &mut Track, State),
    ) -> Result<Option<SweepStatus>, ForwardError> {
        let [from, to] = sweep.range;
        let share = (state.unknowns[0] - from) / (to - from);
        let status = match share {
            x if x >= 1.0 => Some((SweepStatus::Finished, to)),
            x if x <= 0.0 => Some((SweepStatus::Returned, from)),
            _ => None,
        };
        if let Some((status, end)) = status {
            let lines = network.lines(end, self.settings().order, sweep.level)?;
            let solution = self.solve(&Problem { lines: &lines, contacts }, Some(&state.forces))?;
            curve.evaluations += solution.evaluations;
            curve.linearisations += solution.linearisations;
            curve.points.push(Point { omega: end, forces: solution.forces, turned: false });
            return Ok(Some(status));
        }
        let last = curve.points.len();
        let turned = last >= 2 && {
            let before = curve.points[last - 1].omega - curve.points[last - 2].omega;
            (state.unknowns[0] - curve.points[last - 1].omega) * before < 0.0
        };
        track.force_scale = size(&state.forces).max(0.1 * track.force_scale);
        curve.points.push(Point { omega: state.unknowns[0], forces: state.forces.clone(), turned });
        track.push(state);
        Ok(None)
    }
}

fn size(forces: &[Complex64]) -> f64 {
    forces.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt().max(f64::MIN_POSITIVE)
}
