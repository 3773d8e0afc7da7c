//! Wedge damper: a wedge pressed by its centrifugal force between the inclined platforms of two blades.
//!
//! B.-D. Yang, C.-H. Menq, *Modeling of friction contact and its application to the design of shroud contact / wedge
//! dampers*, J. Eng. Gas Turbines Power 120 (1998) 410 and 418. Only the abstracts were read: the equations are derived here.
//!
//! # Equation
//! The wedge has no mass. Its faces stand at the angle `α` to its axis `y`; `n_i`, `t_i` are the normal of face `i`, out of the
//! wedge, and its tangent:
//! ```text
//! n = (∓cos α, sin α)      t = (±sin α, cos α)      Σ N_i n_i + T_i t_i = (0, P)
//! N_i = max(N_0 + k_n n_i·(w − p_i), 0)      dT_i = k_t t_i·(dw − dp_i) while |T_i| < μ N_i, else T_i = ±μ N_i
//! ```
//! with the wedge's displacement `w`, the platforms' `p_1 = (u, 0)` and `p_2 = (ρ u, 0)`, and `N_0 = P/(2 sin α)`. Both faces are
//! coupled by the balance of the wedge: it is solved for each pair of states (stick, slip either way, open), and the pair
//! that contradicts no inequality holds. The force is that on the first platform against `u`, its static part left out.
//!
//! # Analytic criteria
//! Within a pair of states all quantities are linear in `u`: stick ends where `T_i = ±μ N_i`, slip where its rate turns, contact
//! where `N_i = 0`. For neighbours out of phase, `ρ = −1`, both faces do the same, and slip goes on at constant
//! `N_± = P/(2(sin α ± μ cos α))`, so that the damper is a bilinear loop with unequal limits: see [`WedgeDamper::opposed`].
//!
//! # Limits
//! `tan α > μ`, else the wedge locks itself. `ρ = 1`: it moves along and does nothing.

use super::contact::{ContactLaw, Family};
use frettrace_friction::{Scalar, Step};

/// A wedge damper between two platforms that move sideways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WedgeDamper {
    /// Angle `α` of the faces to the wedge's axis (rad), `tan α > μ`.
    pub angle: f64,
    /// Force `P` along the axis that presses the wedge (N).
    pub centrifugal_force: f64,
    /// Stiffness `k_n` across a face (N/m).
    pub normal_stiffness: f64,
    /// Stiffness `k_t` along a face (N/m).
    pub tangential_stiffness: f64,
    /// Friction coefficient `μ`.
    pub friction_coefficient: f64,
    /// Motion `ρ` of the second platform over that of the first.
    pub neighbour: f64,
}

/// What an interface does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface {
    /// Sticks.
    Stick,
    /// Slips, the wedge forwards along the tangent.
    Forward,
    /// Slips, the wedge backwards along the tangent.
    Backward,
    /// Open.
    Open,
}

/// A wedge damper with neighbours out of phase, as a bilinear loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpposedLoop {
    /// Stiffness against the motion of a platform while both faces stick (N/m).
    pub stiffness: f64,
    /// Least and largest force against the motion of a platform (N), the static force left out.
    pub limits: [f64; 2],
}

impl OpposedLoop {
    /// First harmonic of the loop over `u = A cos τ`, divided by `A`: stiffness and loss (N/m); the force is `(k + i h) u`.
    #[must_use]
    pub fn equivalent(&self, amplitude: f64) -> [f64; 2] {
        let width = self.limits[1] - self.limits[0];
        let limit = 0.5 * width;
        let ratio = 1.0 - 2.0 * limit / (self.stiffness * amplitude);
        if ratio <= -1.0 {
            return [self.stiffness, 0.0];
        }
        let theta = ratio.acos();
        let scale = self.stiffness / std::f64::consts::PI;
        [scale * (theta - 0.5 * (2.0 * theta).sin()), scale * theta.sin().powi(2)]
    }
}

/// All pairs of states, sticking before slipping before opening.
const STATES: [Interface; 4] = [Interface::Stick, Interface::Forward, Interface::Backward, Interface::Open];
/// A face counts as sticking up to this much above its limit, and as slipping with as little: rounding, relative.
const SLACK: f64 = 1e-12;

impl WedgeDamper {
    /// The static force across a face, `P/(2 sin α)` (N).
    #[must_use]
    pub fn static_normal_force(&self) -> f64 {
        self.centrifugal_force / (2.0 * self.angle.sin())
    }

    /// The closed form for neighbours out of phase (`ρ = −1`).
    ///
    /// Sticking, the balance along the axis gives `w_y = (k_t − k_n) sin α cos α u/K`, `K = k_n sin²α + k_t cos²α`, so that
    /// `T = −(k_n k_t sin α/K) u` and `N = N_0 + (k_n k_t cos α/K) u`: the force `N cos α − T sin α` against `u` has the stiffness
    /// `k_n k_t/K`. Slipping, `N = P/(2 (sin α ± μ cos α))` and the force is `N (cos α ∓ μ sin α)`.
    #[must_use]
    pub fn opposed(&self) -> OpposedLoop {
        let (sin, cos) = self.angle.sin_cos();
        let (across, along, mu) =
            (self.normal_stiffness, self.tangential_stiffness, self.friction_coefficient);
        let stiffness = across * along / (across * sin * sin + along * cos * cos);
        let force = |mu: f64| {
            let normal = self.centrifugal_force / (2.0 * (sin + mu * cos));
            normal * (cos - mu * sin) - self.static_normal_force() * cos
        };
        OpposedLoop { stiffness, limits: [force(mu), force(-mu)] }
    }

    /// Normals and tangents of both faces.
    fn faces(&self) -> [[[f64; 2]; 2]; 2] {
        let (sin, cos) = self.angle.sin_cos();
        [[[-cos, sin], [sin, cos]], [[cos, sin], [-sin, cos]]]
    }

    /// The balance of the wedge for one pair of states: displacement, normal and tangential forces; `None` where it floats.
    fn balance<T: Scalar>(&self, states: [Interface; 2], known: &Known<T>) -> Option<Balance<T>> {
        let faces = self.faces();
        let (kn, kt, mu) = (self.normal_stiffness, self.tangential_stiffness, self.friction_coefficient);
        let mut matrix = [[0.0; 2]; 2];
        let mut right = [T::zero(), T::from(self.centrifugal_force)];
        for (i, [normal, tangent]) in faces.into_iter().enumerate() {
            let pull = match states[i] {
                Interface::Open => continue,
                Interface::Stick => [normal, tangent],
                slip => [[0, 1].map(|c| normal[c] + direction(slip) * mu * tangent[c]), [0.0; 2]],
            };
            let offset =
                [known.normal[i], if states[i] == Interface::Stick { known.spring[i] } else { T::zero() }];
            for row in 0..2 {
                for column in 0..2 {
                    matrix[row][column] +=
                        kn * pull[0][row] * normal[column] + kt * pull[1][row] * tangent[column];
                }
                right[row] -= offset[0] * pull[0][row] + offset[1] * pull[1][row];
            }
        }
        let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
        if determinant.abs() < SLACK * kn * kt.max(kn) {
            return None;
        }
        let wedge = [
            (right[0] * matrix[1][1] - right[1] * matrix[0][1]) / determinant,
            (right[1] * matrix[0][0] - right[0] * matrix[1][0]) / determinant,
        ];
        let along = |vector: [f64; 2]| wedge[0] * vector[0] + wedge[1] * vector[1];
        let mut balance =
            Balance { wedge, normal: known.normal, trial: known.spring, tangential: known.spring };
        for (i, [normal, tangent]) in faces.into_iter().enumerate() {
            balance.normal[i] += along(normal) * kn;
            balance.trial[i] += along(tangent) * kt;
            balance.tangential[i] = match states[i] {
                Interface::Stick => balance.trial[i],
                Interface::Open => T::zero(),
                slip => balance.normal[i] * (direction(slip) * mu),
            };
        }
        Some(balance)
    }

    /// How far a pair of states contradicts the inequalities, in forces; 0 where it does not.
    fn contradiction<T: Scalar>(&self, states: [Interface; 2], balance: &Balance<T>) -> f64 {
        let mut worst = 0.0_f64;
        for (i, state) in states.into_iter().enumerate() {
            let (normal, trial) = (balance.normal[i].re(), balance.trial[i].re());
            let limit = self.friction_coefficient * normal;
            let excess = match state {
                Interface::Open => normal,
                Interface::Stick => (trial.abs() - limit).max(-normal),
                slip => (limit - direction(slip) * trial).max(-normal),
            };
            worst = worst.max(excess);
        }
        worst
    }

    /// The states of both faces and the balance that hold: the pair that contradicts the inequalities least.
    fn resolve<T: Scalar>(&self, known: &Known<T>) -> ([Interface; 2], Balance<T>) {
        let slack = SLACK * self.static_normal_force();
        let mut best: Option<([Interface; 2], Balance<T>, f64)> = None;
        for first in STATES {
            for second in STATES {
                let Some(balance) = self.balance([first, second], known) else { continue };
                let excess = self.contradiction([first, second], &balance);
                if excess <= slack {
                    return ([first, second], balance);
                }
                if best.as_ref().is_none_or(|(_, _, least)| excess < *least) {
                    best = Some(([first, second], balance, excess));
                }
            }
        }
        let still = Balance {
            wedge: [T::zero(); 2],
            normal: known.normal,
            trial: known.spring,
            tangential: known.spring,
        };
        best.map_or(([Interface::Stick; 2], still), |(states, balance, _)| (states, balance))
    }

    /// What is known of a step before the wedge is put in balance, from the state `[w_x, w_y, T_1, T_2]`.
    fn known<T: Scalar>(&self, [x, y, first, second]: [T; 4], slip: [T; 2]) -> Known<T> {
        let share = [1.0, self.neighbour];
        let mut known = Known { normal: [T::from(self.static_normal_force()); 2], spring: [first, second] };
        for (i, [normal, tangent]) in self.faces().into_iter().enumerate() {
            known.normal[i] -= slip[1] * (self.normal_stiffness * share[i] * normal[0]);
            let wedge = x * tangent[0] + y * tangent[1];
            let platform = (slip[1] - slip[0]) * (share[i] * tangent[0]);
            known.spring[i] -= (wedge + platform) * self.tangential_stiffness;
        }
        known
    }

    /// States of both faces after a step from a state of the law, for a look inside.
    #[must_use]
    pub fn interfaces(&self, state: [f64; 4], slip: [f64; 2]) -> [Interface; 2] {
        self.resolve(&self.known(state, slip)).0
    }
}

fn direction(state: Interface) -> f64 {
    match state {
        Interface::Forward => 1.0,
        Interface::Backward => -1.0,
        _ => 0.0,
    }
}

/// Normal force without the wedge's displacement, tangential force were the wedge at its origin and stuck.
struct Known<T> {
    normal: [T; 2],
    spring: [T; 2],
}

struct Balance<T> {
    wedge: [T; 2],
    normal: [T; 2],
    trial: [T; 2],
    tangential: [T; 2],
}

impl Family for WedgeDamper {
    type Law<T: Scalar> = Self;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self {
        *self
    }
}

impl<T: Scalar> ContactLaw<T> for WedgeDamper {
    type State = [T; 4];

    const FORCES: usize = 1;
    const VELOCITY: bool = false;

    fn rest(&self) -> [T; 4] {
        [T::zero(); 4]
    }

    fn step(&self, state: [T; 4], step: &Step<T>) -> ([T; 4], [T; 2]) {
        let (states, balance) = self.resolve(&self.known(state, step.slip));
        let [normal, tangent] = self.faces()[0];
        let open = states[0] == Interface::Open;
        let pressed = if open { T::zero() } else { balance.normal[0] };
        let force = -(pressed * normal[0] + balance.tangential[0] * tangent[0]);
        let [x, y] = balance.wedge;
        let [first, second] = balance.tangential;
        ([x, y, first, second], [force - self.static_normal_force() * self.angle.cos(), T::zero()])
    }
}
