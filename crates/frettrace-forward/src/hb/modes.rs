//! Nonlinear modes: amplitude-dependent frequency and damping, as extended periodic motion.
//!
//! The excitation is left out and a negative damper `ε` that feeds every mode alike (`q̈_n + (2ζ_nω_n − ε) q̇_n + …`) makes
//! up for what friction takes, so that the motion is periodic at any amplitude (M. Krack, *Nonlinear modal analysis of
//! nonconservative systems: extension of the periodic motion concept*, Comput. Struct. 154 (2015) 59). Its frequency is the
//! frequency of the mode, `ε/(2ω)` its damping ratio.
//!
//! | specified | unknown | equations |
//! |---|---|---|
//! | amplitude `a` of line 1 of a channel | `f̂`, `ω`, `ε` | `f̂ = F(−G(ω, ε) f̂)`, `x̂_1 = a` |

use super::bordered::{Conditions, Corrector, State};
use super::contact::Contact;
use super::lines::Lines;
use super::network::Network;
use super::solver::Solver;
use super::system::Problem;
use crate::ForwardError;
use num_complex::Complex64;

/// Newton steps for the start.
const START_LIMIT: usize = 30;
/// Corrections from one amplitude to the next before the mode counts as lost.
const REACH_LIMIT: usize = 100;

/// Which mode is followed, and over which amplitudes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes {
    /// Mode of the structure without contact forces from which the mode rises, from 0.
    pub mode: usize,
    /// Channel whose line 1 is the amplitude.
    pub channel: usize,
    /// First and last amplitude, in the channel's unit.
    pub amplitudes: [f64; 2],
    /// Points, spaced evenly on the logarithm.
    pub points: usize,
}

/// A nonlinear mode at one amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct ModePoint {
    /// Amplitude of line 1 of the channel.
    pub amplitude: f64,
    /// Frequency of the mode (rad/s).
    pub omega: f64,
    /// Damping ratio of the mode.
    pub damping_ratio: f64,
    /// Lines of the contact forces (N).
    pub forces: Vec<Complex64>,
}

struct Mode<'a> {
    network: &'a Network,
    channel: usize,
    order: usize,
    amplitude: f64,
    scales: [f64; 2],
}

impl Conditions for Mode<'_> {
    fn lines(&self, unknowns: &[f64]) -> Result<Lines, ForwardError> {
        let network = Network { feed: unknowns[1], ..self.network.clone() };
        network.lines(unknowns[0], self.order, 0.0)
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    fn values(&self, lines: &Lines, forces: &[Complex64], _: &[f64], values: &mut [f64]) {
        let row = self.order + 1;
        let terms = (0..lines.forces()).map(|d| lines.receptance(self.channel, d)[1] * forces[d * row + 1]);
        let motion: Complex64 = -terms.sum::<Complex64>() / self.amplitude;
        values[0] = motion.re - 1.0;
        values[1] = motion.im;
    }

    fn gradient(&self, lines: &Lines, condition: usize, row: &mut [f64]) {
        row.fill(0.0);
        for d in 0..lines.forces() {
            let gain = -lines.receptance(self.channel, d)[1] / self.amplitude;
            let at = d * (2 * self.order + 1) + 1;
            let pair = if condition == 0 { [gain.re, -gain.im] } else { [gain.im, gain.re] };
            row[at..at + 2].copy_from_slice(&pair);
        }
    }
}

impl Solver {
    /// Follows a nonlinear mode over amplitudes; ends early where it is lost.
    ///
    /// Only structures whose first contact moves the mode: its slip must be the channel or move with it.
    ///
    /// # Errors
    /// A problem that is not one: see [`ForwardError`].
    pub fn follow_mode(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        modes: &Modes,
    ) -> Result<Vec<ModePoint>, ForwardError> {
        let available = network.structure.mode_count();
        if modes.mode >= available {
            return Err(ForwardError::Index { contact: 0, what: "mode", index: modes.mode, available });
        }
        let mut points: Vec<ModePoint> = Vec::new();
        let ratio = (modes.amplitudes[1] / modes.amplitudes[0]).ln();
        let mut last = (modes.amplitudes[0], self.mode_start(network, contacts, modes)?);
        for index in 0..modes.points {
            let share = index as f64 / (modes.points.max(2) - 1) as f64;
            let target = modes.amplitudes[0] * (ratio * share).exp();
            let Some(state) = self.reach(network, contacts, modes, (&last, target))? else {
                return Ok(points);
            };
            points.push(ModePoint {
                amplitude: target,
                omega: state.unknowns[0],
                damping_ratio: state.unknowns[1] / (2.0 * state.unknowns[0]),
                forces: state.forces.clone(),
            });
            last = (target, state);
        }
        Ok(points)
    }

    /// From one amplitude to another, in as many steps as it takes.
    fn reach(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        modes: &Modes,
        (from, target): (&(f64, State), f64),
    ) -> Result<Option<State>, ForwardError> {
        let mut corrector = Corrector::default();
        let (mut at, mut state) = from.clone();
        let mut factor = target / at;
        for _ in 0..REACH_LIMIT {
            let last = target / at / factor;
            let amplitude = if (last - 1.0).abs() < 1e-6 { target } else { at * factor };
            let omega = state.unknowns[0];
            let condition = Mode {
                network,
                channel: modes.channel,
                order: self.settings().order,
                amplitude,
                scales: [omega, 0.1 * omega],
            };
            let mut trial = state.clone();
            // A sliding contact keeps its force, a stuck one its stiffness: the former is the nearer start in between.
            corrector.forget();
            if corrector.correct(self, contacts, &condition, &mut trial)? {
                (at, state) = (amplitude, trial);
                if at == target {
                    return Ok(Some(state));
                }
                // Twice the step that succeeded: from the whole way again each would cost all the steps that fail.
                let rest = target / at;
                factor = if rest.ln().abs() < 2.0 * factor.ln().abs() { rest } else { factor * factor };
            } else {
                factor = factor.sqrt();
                if (factor - 1.0).abs() < 1e-4 {
                    return Ok(None);
                }
            }
        }
        Ok(None)
    }

    /// The mode with the contact as stiff as it is in a harmonic motion of the first amplitude.
    fn mode_start(
        &mut self,
        network: &Network,
        contacts: &[Contact],
        modes: &Modes,
    ) -> Result<State, ForwardError> {
        let order = self.settings().order;
        let still = network.lines(network.structure.natural_frequency()[modes.mode], order, 0.0)?;
        let mut moved = Lines::zeros(still.omega(), order, [still.channels(), still.forces()]);
        for channel in 0..still.channels() {
            moved.free_mut(channel)[0] = still.free(channel)[0];
        }
        moved.free_mut(modes.channel)[1] = modes.amplitudes[0].into();
        let problem = Problem { lines: &moved, contacts };
        problem.check()?;
        let mut forces = vec![Complex64::ZERO; still.forces() * (order + 1)];
        let zeros = forces.clone();
        self.system.evaluate(&problem, &zeros, &mut forces);
        let stiffness = forces[1] / modes.amplitudes[0];
        let omega = stuck_frequency(network, modes, stiffness.re);
        let ratio = network.structure.damping_ratio()[modes.mode];
        let unknowns = self::linearised(network, modes, stiffness, [omega, 2.0 * ratio * omega])?;
        Ok(State { forces, unknowns: unknowns.to_vec() })
    }
}

/// Newton on `1 + k G(ω, ε) = 0` with the complex stiffness `k` of the sliding contact: its loss is no small correction.
fn linearised(
    network: &Network,
    modes: &Modes,
    stiffness: Complex64,
    start: [f64; 2],
) -> Result<[f64; 2], ForwardError> {
    let balance = |[omega, feed]: [f64; 2]| -> Result<Complex64, ForwardError> {
        let lines = Network { feed, ..network.clone() }.lines(omega, 1, 0.0)?;
        // The reciprocal of G is nearly linear in both unknowns near a resonance.
        Ok(stiffness + lines.receptance(modes.channel, 0)[1].inv())
    };
    let mut at = start;
    for _ in 0..START_LIMIT {
        let value = balance(at)?;
        let step = 1e-7 * at[0];
        let slope = [
            (balance([at[0] + step, at[1]])? - value) / step,
            (balance([at[0], at[1] + step])? - value) / step,
        ];
        let determinant = slope[0].re * slope[1].im - slope[1].re * slope[0].im;
        let change = [
            (slope[1].re * value.im - slope[1].im * value.re) / determinant,
            (slope[0].im * value.re - slope[0].re * value.im) / determinant,
        ];
        if !change.iter().all(|c| c.is_finite() && c.abs() < 0.5 * at[0]) {
            return Ok(start);
        }
        at = [at[0] + change[0], at[1] + change[1]];
        if change.iter().all(|c| c.abs() < 1e-9 * at[0]) {
            break;
        }
    }
    Ok(at)
}

/// Root of `1 + k G(ω) = 0` without damping, above the mode for `k > 0`, by bisection.
fn stuck_frequency(network: &Network, modes: &Modes, stiffness: f64) -> f64 {
    let frequency = network.structure.natural_frequency();
    let row = network.structure.row(network.channels[modes.channel].port);
    let low = frequency[modes.mode];
    let high = frequency.get(modes.mode + 1).copied().unwrap_or(1e3 * low + stiffness.abs());
    let balance = |omega: f64| -> f64 {
        let terms = frequency.iter().zip(row).map(|(w, r)| r * r / (w * w - omega * omega));
        1.0 + stiffness * terms.sum::<f64>()
    };
    let (mut below, mut above) = (low, high);
    for _ in 0..100 {
        let middle = 0.5 * (below + above);
        if balance(middle) < 0.0 { below = middle } else { above = middle }
    }
    if stiffness > 0.0 { 0.5 * (below + above) } else { low }
}
