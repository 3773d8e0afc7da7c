//! What acts on the structure: one friction contact, local loads, known loads.

use super::structure::Structure;

/// A structure with everything that acts on it.
#[derive(Clone, Debug)]
pub struct Assembly<L> {
    /// The linear structure.
    pub structure: Structure,
    /// Ports of the loads known in time, in the order in which their values are given.
    pub inputs: Vec<usize>,
    /// The friction contact, where there is one.
    pub friction: Option<FrictionContact<L>>,
    /// Local loads without memory.
    pub loads: Vec<LocalLoad>,
}

/// A friction contact: the law acts with `−F_t` on the slip's port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionContact<L> {
    /// The law.
    pub law: L,
    /// Port whose motion is the slip.
    pub slip_port: usize,
    /// Its normal force.
    pub normal: Normal,
}

/// The normal force `N = max(P(t) − k w − k₃ w³, 0)` with the preload `P(t) = N₀ (1 + m cos(ωt + ψ))`.
///
/// The structure holds the linear spring `k`. What the contact does beside it, `k₃` and lift-off, acts on the structure
/// as a further load: see [`Self::deviation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    /// Preload `N₀` (N).
    pub preload: f64,
    /// Port of the displacement `w` under the contact; `None`: the normal force is the preload.
    pub port: Option<usize>,
    /// Stiffness of the support spring (N/m), already in the structure.
    pub stiffness: f64,
    /// Cubic stiffness (N/m³), not in the structure.
    pub cubic: f64,
    /// Sharpness `s` of an exponential contact: `(P/s)(e^{−s k w/P} − 1)` in place of `−k w`; 0 is the straight spring.
    pub sharpness: f64,
    /// Power `p` of a contact between round bodies: `P((1 − k w/(pP))^p − 1)` in place of `−k w`, nothing where they part; 3/2 is Hertz's, up to 1 is
    /// the straight spring.
    pub power: f64,
    /// Whether the contact can open; if not the normal force may turn negative (laws then use 0) and the spring pulls.
    pub lifts_off: bool,
    /// Modulation of the preload.
    pub modulation: Option<Modulation>,
}

/// A relative modulation `m cos(ωt + ψ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulation {
    /// Relative size `m`.
    pub share: f64,
    /// Shape `s`: `tanh(s cos)/tanh s` in place of the cosine; 0 is the cosine itself.
    pub shape: f64,
    /// Skewness `b`: `cos(φ + b cos φ)` in place of `cos φ`, which rises faster than it falls and has no mean.
    pub skewness: f64,
    /// Angular frequency (rad/s).
    pub omega: f64,
    /// Phase (rad).
    pub phase: f64,
}

impl Modulation {
    /// Its value at a time (s).
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let phase = self.omega * time + self.phase;
        let wave = (phase + self.skewness * phase.cos()).cos();
        self.share * if self.shape > 0.0 { (self.shape * wave).tanh() / self.shape.tanh() } else { wave }
    }
}

impl Normal {
    /// A normal force that stays at the preload.
    #[must_use]
    pub fn constant(preload: f64) -> Self {
        Self {
            preload,
            port: None,
            stiffness: 0.0,
            cubic: 0.0,
            sharpness: 0.0,
            power: 0.0,
            lifts_off: false,
            modulation: None,
        }
    }

    /// Preload at a time (N).
    #[must_use]
    pub fn preload_at(&self, time: f64) -> f64 {
        self.preload * (1.0 + self.modulation.map_or(0.0, |m| m.at(time)))
    }

    /// Normal force (N) at a displacement.
    #[must_use]
    pub fn force(&self, displacement: f64, time: f64) -> f64 {
        let preload = self.preload_at(time);
        let straight = -self.stiffness * displacement;
        let spring = if self.sharpness > 0.0 {
            (self.sharpness * straight / preload).exp_m1() * preload / self.sharpness
        } else if self.power > 1.0 {
            preload * ((1.0 + straight / (self.power * preload)).max(0.0).powf(self.power) - 1.0)
        } else {
            straight
        };
        let force = preload + spring - self.cubic * displacement.powi(3);
        if self.lifts_off { force.max(0.0) } else { force }
    }

    /// Load on the structure at the normal port beside its linear spring: `N − (P − k w)`.
    ///
    /// The modulation of the preload itself is a load of the loading device and reaches the beam through the contact in
    /// equilibrium with it; only the contact's departure from the linear spring acts on the beam.
    #[must_use]
    pub fn deviation(&self, displacement: f64, time: f64) -> f64 {
        self.force(displacement, time) - (self.preload_at(time) - self.stiffness * displacement)
    }

    /// Whether there is any deviation.
    #[must_use]
    pub fn deviates(&self) -> bool {
        let bent = self.cubic != 0.0 || self.sharpness > 0.0 || self.power > 1.0;
        self.port.is_some() && (self.lifts_off || bent)
    }
}

/// A load without memory at a port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalLoad {
    /// The port.
    pub port: usize,
    /// The load against the motion.
    pub characteristic: Characteristic,
}

/// Load on the structure against displacement and velocity of its port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Characteristic {
    /// `−k y` (N/m).
    Spring(f64),
    /// `−k₃ y³` (N/m³).
    CubicSpring(f64),
    /// `−c ẏ` (N·s/m).
    Dashpot(f64),
    /// `−c |ẏ| ẏ` (N·s²/m²).
    QuadraticDashpot(f64),
    /// `−k (y − gap)` where `y > gap`, nothing elsewhere (N/m, m).
    Stop {
        /// Stiffness (N/m).
        stiffness: f64,
        /// Clearance (m); negative where the stop is pressed on at rest.
        gap: f64,
    },
    /// `−k₃ y³/(1 + (y/d)²)`: a cubic spring that yields beyond its scale.
    YieldingCubicSpring {
        /// Cubic stiffness at small motion (N/m³).
        stiffness: f64,
        /// Scale `d` (m).
        scale: f64,
    },
    /// `−6 k₃ d³ (sinh(y/d) − y/d)`: a cubic spring that hardens further beyond its scale.
    HyperbolicSpring {
        /// Cubic stiffness at small motion (N/m³).
        stiffness: f64,
        /// Scale `d` (m).
        scale: f64,
    },
    /// `−k ε ln(1 + e^{(y − gap)/ε})`: a stop that is met gradually.
    SmoothStop {
        /// Stiffness (N/m).
        stiffness: f64,
        /// Clearance (m).
        gap: f64,
        /// Length `ε` over which it is met (m).
        smoothness: f64,
    },
    /// `−c |ẏ|^{p−1} ẏ`.
    PowerDashpot {
        /// Coefficient (N at 1 m/s).
        damping: f64,
        /// Power.
        power: f64,
    },
    /// `−k (y − gap)^{3/2}` where `y > gap`: a round stop.
    RoundStop {
        /// Stiffness (N/m^{3/2}).
        stiffness: f64,
        /// Clearance (m).
        gap: f64,
    },
    /// `−k₂ y²`: a restoring force that does not change sign.
    EvenSpring(f64),
    /// `−(F_c tanh(v/ε))` with its level (N) and regularisation velocity (m/s): smooth Coulomb friction.
    SmoothCoulomb {
        /// Level (N).
        level: f64,
        /// Velocity at which 76 % of the level is reached (m/s).
        velocity: f64,
    },
}

impl Characteristic {
    /// Load on the structure.
    #[must_use]
    pub fn load(&self, displacement: f64, velocity: f64) -> f64 {
        match *self {
            Self::Spring(stiffness) => -stiffness * displacement,
            Self::CubicSpring(stiffness) => -stiffness * displacement.powi(3),
            Self::Dashpot(damping) => -damping * velocity,
            Self::QuadraticDashpot(damping) => -damping * velocity.abs() * velocity,
            Self::Stop { stiffness, gap } => -stiffness * (displacement - gap).max(0.0),
            Self::YieldingCubicSpring { stiffness, scale } => {
                -stiffness * displacement.powi(3) / (1.0 + (displacement / scale).powi(2))
            }
            Self::HyperbolicSpring { stiffness, scale } => {
                let ratio = displacement / scale;
                -6.0 * stiffness * scale.powi(3) * (ratio.sinh() - ratio)
            }
            Self::SmoothStop { stiffness, gap, smoothness } => {
                let ratio = (displacement - gap) / smoothness;
                -stiffness * smoothness * (ratio.max(0.0) + (-ratio.abs()).exp().ln_1p())
            }
            Self::PowerDashpot { damping, power } => -damping * velocity.abs().powf(power).copysign(velocity),
            Self::RoundStop { stiffness, gap } => -stiffness * (displacement - gap).max(0.0).powf(1.5),
            Self::EvenSpring(stiffness) => -stiffness * displacement * displacement,
            Self::SmoothCoulomb { level, velocity: scale } => -level * (velocity / scale).tanh(),
        }
    }
}
