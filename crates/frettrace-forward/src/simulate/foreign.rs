//! A contact whose effects have other functional forms than those of the model that explains it.
//!
//! ```text
//! F_t = P·(b + σ1(v) ż) + viscous(v) + k u,   db/dt = σ0 v φ(r),   r = b sgn(v)/μ(v, u, N, …),   P = max(N, 0)
//! ```
//! What an effect does has one name and as many formulas as there are laboratories: a Stribeck curve may be rational instead
//! of exponential, a lag may saturate. A search that only finds its own formula has found nothing. The state is marched by the
//! classical Runge-Kutta rule on the slip's Hermite cubic, apart from the closed strokes of `frettrace-friction`.

use frettrace_friction::{FrictionLaw, Step};

/// The declared law as a bristle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristle {
    /// Presliding stiffness over the normal force (1/m).
    pub sigma0: f64,
    /// Kinetic friction coefficient.
    pub mu_k: f64,
    /// Rise towards rest `μ_s − μ_k`, its velocity (m/s) and exponent.
    pub stribeck: [f64; 3],
    /// Presliding damping (s/m) and the velocity over which it fades (m/s).
    pub damping: [f64; 2],
    /// Viscous coefficient (N·s/m).
    pub sigma2: f64,
    /// Exponent of Dahl's law.
    pub exponent: f64,
    /// Elastic share; 0 for laws without it.
    pub breakaway: f64,
}

/// An effect in a form that the explaining model does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Form {
    /// No effect.
    #[default]
    None,
    /// `μ_k + rise/(1 + (|v|/v_s)^δ)`.
    RationalStribeck([f64; 3]),
    /// `c |v|^p sgn v`: coefficient (N at 1 m/s), power.
    ViscousPower([f64; 2]),
    /// A Stribeck weight `w` with `ẇ = tanh(3(w_ss − w))/(3τ)`: rise, velocity, exponent, time.
    SaturatingLag([f64; 4]),
    /// `μ/(1 + h·loss/(1 − loss))`, `ḣ = (x/(1 + x) − h)/τ`, `x = |v|/v_b`: loss, rise time, fall time, velocity.
    RationalFilm([f64; 4]),
    /// `μ(1 + gain(1 − e^{−age/time}))`: gain, distance that renews the contact, time.
    SaturatingAgeing([f64; 3]),
    /// `μ(1 + share·tanh(v/v_0))`.
    SmoothAsymmetry([f64; 2]),
    /// The elastic share of the deflection, followed by a straight rise instead of half a sine.
    StraightBreakaway(f64),
    /// `φ = 1 − sgn(r)|r|^n`.
    PowerBristle(f64),
    /// `σ1/(1 + (v/v_d)²)`.
    RationalDamping([f64; 2]),
    /// `μ(1 + share·tanh(u/d))`.
    SaturatingPosition([f64; 2]),
    /// A triangle wave of the slip: share, wavelength.
    TrianglePosition([f64; 2]),
    /// `μ(1 + s(1 − N/N_ref))`: slope, reference (N).
    StraightNormalDependence([f64; 2]),
    /// `μ(1 + c(1 − e^{−4p})/(1 − e^{−4}))` at the place `p` of the run between first (0) and last (1).
    SettlingWear(f64),
    /// A spring in series with the bristle (N/m).
    SeriesSpring(f64),
    /// A spring beside the contact (N/m).
    ParallelSpring(f64),
    /// Play that closes gradually: half of it (m).
    GradualBacklash(f64),
    /// `μ_k + rise·max(0, 1 − |v|/v_s)`: rise, velocity (m/s).
    StraightStribeck([f64; 2]),
    /// `f·arsinh(v/v_0)`: force (N), velocity (m/s). Eyring's film.
    EyringViscous([f64; 2]),
    /// `μ(1 + gain·(age/time)^p)`: gain, distance that renews the contact, time, power.
    PowerAgeing([f64; 4]),
    /// `σ1·e^{−|v|/v_d}`.
    ExponentialDamping([f64; 2]),
    /// `μ(1 + share·(u/d)²)`.
    ParabolicPosition([f64; 2]),
    /// `μ(1 + share·arctan(6 sin 2πu/λ)/arctan 6)`: share, wavelength.
    SquarePosition([f64; 2]),
    /// `μ(1 + s(N_ref/N − 1))`: adhesion as a share of the reference force (N).
    Adhesion([f64; 2]),
    /// `μ(1 + c√p)` at the place `p` of the run between first (0) and last (1).
    RootWear(f64),
    /// `c v²`, whatever the direction (N·s²/m²): in nobody's list.
    SpeedSquare(f64),
    /// The normal force acts on friction with a delay of first order (s): in nobody's list.
    NormalMemory(f64),
}

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForeignLaw {
    /// The declared law.
    pub bristle: Bristle,
    /// Up to two effects.
    pub forms: [Form; 2],
    /// Place of the run between the first (0) and the last (1).
    pub progress: f64,
}

/// Where the contact is at one moment.
#[derive(Clone, Copy)]
struct At {
    slip: f64,
    velocity: f64,
    normal: f64,
    normal_rate: f64,
}

/// Deflection `b`, and one memory for each effect.
type State = [f64; 3];

/// Largest share of a relaxation (of the bristle, of a memory) in one Runge-Kutta step.
const TRAVEL: f64 = 0.4;
/// Most Runge-Kutta steps in one step of the march.
const MOST_STEPS: f64 = 64.0;
/// Smallest friction coefficient an effect may leave.
const LEAST_FRICTION: f64 = 1e-6;
/// Share of the reference force below which adhesion grows no more.
const LEAST_LOAD: f64 = 0.05;

impl ForeignLaw {
    fn forms(&self) -> impl Iterator<Item = (usize, Form)> {
        self.forms.into_iter().enumerate().map(|(index, form)| (index + 1, form))
    }

    /// The friction coefficient of the declared law alone.
    fn declared_coefficient(&self, speed: f64) -> f64 {
        let [rise, velocity, exponent] = self.bristle.stribeck;
        // A lag carries the declared curve itself.
        let lags = self.forms.iter().any(|form| matches!(form, Form::SaturatingLag(_)));
        if rise == 0.0 || lags {
            return self.bristle.mu_k;
        }
        self.bristle.mu_k + rise * (-(speed / velocity).powf(exponent)).exp()
    }

    fn coefficient(&self, state: &State, at: &At) -> f64 {
        let speed = at.velocity.abs();
        let mut mu = self.declared_coefficient(speed);
        for (index, form) in self.forms() {
            let memory = state[index];
            match form {
                Form::RationalStribeck([rise, velocity, exponent]) => {
                    mu += rise / (1.0 + (speed / velocity).powf(exponent));
                }
                Form::StraightStribeck([rise, velocity]) => mu += rise * (1.0 - speed / velocity).max(0.0),
                Form::SaturatingLag([rise, ..]) => mu += rise * memory,
                Form::PowerAgeing([gain, _, time, power]) => {
                    mu *= 1.0 + gain * (memory.max(0.0) / time).powf(power);
                }
                Form::ParabolicPosition([share, distance]) => {
                    mu *= 1.0 + share * (at.slip / distance).powi(2)
                }
                Form::SquarePosition([share, wavelength]) => {
                    let wave = (6.0 * (std::f64::consts::TAU * at.slip / wavelength).sin()).atan();
                    mu *= 1.0 + share * wave / 6.0_f64.atan();
                }
                Form::Adhesion([share, reference]) => {
                    mu *= 1.0 + share * (reference / at.normal.max(LEAST_LOAD * reference) - 1.0);
                }
                Form::RootWear(change) => mu *= 1.0 + change * self.progress.sqrt(),
                Form::RationalFilm([loss, ..]) => mu /= 1.0 + memory * loss / (1.0 - loss),
                Form::SaturatingAgeing([gain, _, time]) => mu *= 1.0 - gain * (-memory / time).exp_m1(),
                Form::SmoothAsymmetry([share, velocity]) => {
                    mu *= 1.0 + share * (at.velocity / velocity).tanh()
                }
                Form::SaturatingPosition([share, distance]) => {
                    mu *= 1.0 + share * (at.slip / distance).tanh()
                }
                Form::TrianglePosition([share, wavelength]) => {
                    mu *= 1.0 + share * triangle(at.slip / wavelength)
                }
                Form::StraightNormalDependence([slope, reference]) => {
                    mu *= 1.0 + slope * (1.0 - at.normal / reference);
                }
                Form::SettlingWear(change) => {
                    mu *= 1.0 + change * (-4.0 * self.progress).exp_m1() / (-4.0_f64).exp_m1();
                }
                _ => {}
            }
        }
        mu.max(LEAST_FRICTION)
    }

    /// `φ(r)` of the state equation.
    fn flow(&self, ratio: f64) -> f64 {
        for form in self.forms {
            match form {
                Form::PowerBristle(power) => return 1.0 - ratio.signum() * ratio.abs().powf(power),
                Form::StraightBreakaway(share) => {
                    return 1.0 - ((ratio - share) / (1.0 - share)).clamp(0.0, 1.0) * ratio;
                }
                _ => {}
            }
        }
        let Bristle { breakaway, exponent, .. } = self.bristle;
        if breakaway > 0.0 {
            let place = ((ratio - breakaway) / (1.0 - breakaway)).clamp(0.0, 1.0);
            let rise = 0.5 + 0.5 * ((place - 0.5) * std::f64::consts::PI).sin();
            return 1.0 - rise * ratio;
        }
        let left = 1.0 - ratio;
        if exponent == 1.0 { left } else { left.signum() * left.abs().powf(exponent) }
    }

    /// Velocity of the bristle's own contact, `φ` and the rates of the memories.
    fn motion(&self, state: &State, at: &At) -> (f64, f64, [f64; 2]) {
        let mut velocity = at.velocity;
        let mu = self.coefficient(state, at);
        let mut flow = self.flow(state[0] * sense(velocity) / mu);
        let mut rates = [0.0; 2];
        for (index, form) in self.forms() {
            match form {
                Form::SeriesSpring(stiffness) => {
                    let driven = stiffness * velocity - at.normal_rate * state[0];
                    flow = self.flow(state[0] * sense(driven) / mu);
                    let bristle = at.normal.max(0.0) * self.bristle.sigma0 * flow.max(0.0);
                    velocity = driven / (stiffness + bristle);
                }
                Form::GradualBacklash(play) => {
                    let taken = (state[index] * sense(velocity) / play).clamp(0.0, 1.0).powi(8);
                    rates[index - 1] = velocity * (1.0 - taken);
                    velocity *= taken;
                }
                _ => rates[index - 1] = memory_rate(&form, state[index], at),
            }
        }
        (velocity, flow, rates)
    }

    fn rates(&self, state: &State, at: &At) -> State {
        let (velocity, flow, [first, second]) = self.motion(state, at);
        [self.bristle.sigma0 * velocity * flow, first, second]
    }

    /// Friction force at a moment.
    fn force(&self, state: &State, at: &At) -> f64 {
        let (velocity, flow, _) = self.motion(state, at);
        let [sigma1, fade] = self.bristle.damping;
        let mut pressed = at.normal.max(0.0);
        let mut ratio = state[0];
        if sigma1 > 0.0 {
            ratio += sigma1 * (-(at.velocity / fade).powi(2)).exp() * velocity * flow;
        }
        let mut force = self.bristle.sigma2 * at.velocity;
        for (index, form) in self.forms() {
            match form {
                Form::RationalDamping([sigma1, fade]) => {
                    ratio += sigma1 / (1.0 + (at.velocity / fade).powi(2)) * velocity * flow;
                }
                Form::ExponentialDamping([sigma1, fade]) => {
                    ratio += sigma1 * (-at.velocity.abs() / fade).exp() * velocity * flow;
                }
                Form::EyringViscous([level, scale]) => force += level * (at.velocity / scale).asinh(),
                Form::ViscousPower([coefficient, power]) => {
                    force += coefficient * at.velocity.abs().powf(power) * sense(at.velocity);
                }
                Form::ParallelSpring(stiffness) => force += stiffness * at.slip,
                Form::SpeedSquare(coefficient) => force += coefficient * at.velocity * at.velocity,
                Form::NormalMemory(_) => pressed = state[index].max(0.0),
                _ => {}
            }
        }
        force + pressed * ratio
    }
}

fn sense(value: f64) -> f64 {
    if value < 0.0 { -1.0 } else { 1.0 }
}

/// A triangle wave of period 1 between −1 and 1, odd: `(2/π) arcsin(sin 2πx)`.
fn triangle(x: f64) -> f64 {
    std::f64::consts::FRAC_2_PI * (std::f64::consts::TAU * x).sin().asin()
}

/// Rate of the memory of an effect.
fn memory_rate(form: &Form, memory: f64, at: &At) -> f64 {
    let speed = at.velocity.abs();
    match *form {
        Form::SaturatingLag([_, velocity, exponent, time]) => {
            let steady = (-(speed / velocity).powf(exponent)).exp();
            (3.0 * (steady - memory)).tanh() / (3.0 * time)
        }
        Form::RationalFilm([_, rise, fall, velocity]) => {
            let steady = speed / (velocity + speed);
            (steady - memory) / if steady > memory { rise } else { fall }
        }
        Form::SaturatingAgeing([_, distance, _]) | Form::PowerAgeing([_, distance, ..]) => {
            1.0 - speed * memory / distance
        }
        Form::NormalMemory(time) => (at.normal - memory) / time,
        _ => 0.0,
    }
}

/// Relaxation times of the memory of an effect that pass in a step, with its travel.
fn relaxation(form: &Form, travel: f64, duration: f64) -> f64 {
    match *form {
        Form::SaturatingLag([.., time]) | Form::NormalMemory(time) => duration / time,
        Form::RationalFilm([_, rise, fall, _]) => duration / rise.min(fall),
        Form::SaturatingAgeing([_, distance, _]) | Form::PowerAgeing([_, distance, ..]) => travel / distance,
        // The gate of the play rises over an eighth of it.
        Form::GradualBacklash(play) => 8.0 * travel / play,
        _ => 0.0,
    }
}

impl FrictionLaw<f64> for ForeignLaw {
    type State = State;

    fn rest(&self) -> State {
        [0.0; 3]
    }

    fn step(&self, mut state: State, step: &Step<f64>) -> (State, f64) {
        let normal_rate = (step.normal[1] - step.normal[0]) / step.dt;
        let at = |fraction: f64| {
            let (slip, velocity) = step.at(fraction);
            At { slip, velocity, normal: step.normal[0] + normal_rate * step.dt * fraction, normal_rate }
        };
        let travel = step.dt * step.velocity[0].abs().max(step.velocity[1].abs());
        let fastest =
            self.forms.iter().fold(travel * self.bristle.sigma0 / self.bristle.mu_k, |most, form| {
                most.max(relaxation(form, travel, step.dt))
            });
        let count = (fastest / TRAVEL).ceil().clamp(1.0, MOST_STEPS);
        let h = step.dt / count;
        for k in 0..count as usize {
            let [start, middle, end] = [0.0, 0.5, 1.0].map(|part| at((k as f64 + part) / count));
            let along = |rates: State, h: f64| std::array::from_fn(|i| state[i] + h * rates[i]);
            let k1 = self.rates(&state, &start);
            let k2 = self.rates(&along(k1, 0.5 * h), &middle);
            let k3 = self.rates(&along(k2, 0.5 * h), &middle);
            let k4 = self.rates(&along(k3, h), &end);
            state = std::array::from_fn(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        (state, self.force(&state, &at(1.0)))
    }
}

#[cfg(test)]
mod tests;
