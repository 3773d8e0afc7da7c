//! Frequency response as a curve: pseudo-arclength continuation that follows turning points.
//!
//! The curve `(f̂, Ω)` is followed by its arclength `s`, forces measured in units of their size and frequency in units of
//! the range. The predictor is the polynomial through the last points; the step is chosen so that it errs by what is
//! asked; the corrector stays in the plane across the predictor. A step that fails is tried again, shorter, on the straight
//! line through the last two points and with the Jacobian of all samples: beside a kink neither a polynomial nor a Jacobian of
//! fewer samples holds.

use super::contact::Contact;
use super::follower::{Advance, Follower};
use super::network::Network;
use super::solver::Solver;
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
    /// Lines of the contact forces (N), `D × (H + 1)`; where the order adapts it differs from point to point.
    pub forces: Vec<Complex64>,
    /// [`super::Solution::truncation`] of the point; `None` where nothing adapts to it.
    pub truncation: Option<f64>,
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
    /// At a motion beside which what a contact answers is another one, by a finite step: a law that falls where it breaks away. The
    /// balance has no solution beside it, however short the step.
    Jumped,
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

impl Solver {
    /// Follows the response of a network with contacts over a range of base frequencies, at the solver's own order.
    ///
    /// # Errors
    /// A problem that is not one: see [`ForwardError`].
    pub fn follow(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        sweep: &Sweep,
    ) -> Result<Curve, ForwardError> {
        let mut follower = Follower::new(network, contacts, sweep);
        while follower.wants_start() {
            if follower.start(self)?.is_none() {
                return Ok(follower.curve(SweepStatus::NoStart));
            }
        }
        while follower.points() < sweep.points {
            match follower.advance(self)? {
                Advance::Rejected => {}
                Advance::Ended(status) => return Ok(follower.curve(status)),
                Advance::Reached(state) => {
                    if let Some(status) = follower.accept(self, state, None)? {
                        return Ok(follower.curve(status));
                    }
                }
            }
        }
        Ok(follower.curve(SweepStatus::PointLimit))
    }
}
