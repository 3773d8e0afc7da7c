//! Memoryless forces at single degrees of freedom of the structure.

/// Coefficients a port may have.
pub const COEFFICIENTS: usize = 4;

/// Length (m) over which a sharp corner of a stop is rounded.
pub const SHARP: f64 = 1e-9;

/// Force law of a port as a function of the displacement `d` and velocity `ḋ` of its degree of freedom; positive
/// values resist positive displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PortLaw {
    /// `c₀ d + c₁ ḋ + c₂ d³ + c₃ ḋ|ḋ|`.
    Polynomial,
    /// A stop on one side: `c₀ (d − c₁)⁺ + c₂ ḋ` while in touch, its corner rounded over `|c₃|`; the side is the sign of `c₃`, and a corner
    /// that is one has [`SHARP`] there.
    Stop,
    /// A support spring with a damper beside it that cannot pull: `c ḋ − (k d + c ḋ − P)⁺` with `k = c₀`, `P = c₁`, `c = c₂`; the
    /// spring itself is part of the structure.
    LiftOff,
    /// `c₀ d² + c₁ d³ + c₂ d⁴ + c₃ d⁵`.
    Stiffening,
    /// Play on both sides: `c₀ (|d| − c₁)⁺ sgn d + c₂ ḋ` while in touch, its corners rounded over `|c₃|`.
    Gap,
    /// Coulomb friction smoothed over a displacement-free velocity: `c₀ tanh(ḋ/c₁) + c₂ d`.
    Friction,
    /// A cubic spring that yields: `c₀ d³/(1 + (d/c₁)²)`.
    Yielding,
    /// Damping by a power of the velocity: `c₀ |ḋ/c₂|^c₁ sgn ḋ`; the reference velocity `c₂` is not fitted.
    Power,
    /// A stop on one side whose asperities touch one after the other, the more the nearer: `c₀ w ln(1 + e^{(d − c₁)/w}) + c₂ ḋ` while in touch,
    /// `w = |c₃|`; the side is the sign of `c₃`.
    Rough,
    /// A round stop on one side: `c₀ ((d − c₁)⁺)^{3/2}`; the side is the sign of `c₃` (not fitted).
    Round,
}

/// Force and its derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct PortForce {
    /// Force (N).
    pub force: f64,
    /// `∂f/∂d`.
    pub stiffness: f64,
    /// `∂f/∂ḋ`.
    pub damping: f64,
    /// `∂f/∂c_k`.
    pub coefficients: [f64; COEFFICIENTS],
}

/// `(x)⁺` rounded over `width` by half a hyperbola, and its slope.
fn positive(x: f64, width: f64) -> (f64, f64) {
    let root = (x * x + width * width).sqrt();
    (0.5 * (x + root), 0.5 * (1.0 + x / root))
}

impl PortLaw {
    /// Whether it answers a motion about rest with a mean force, so that it matters where the motion rests.
    #[must_use]
    pub fn one_sided(self) -> bool {
        matches!(self, Self::Stop | Self::Rough | Self::Round)
    }

    /// Whether it has a corner whose length is a coefficient.
    #[must_use]
    pub fn has_corner(self) -> bool {
        matches!(self, Self::Stop | Self::Rough | Self::Gap)
    }

    /// The force at displacement `d` and velocity `v`.
    #[must_use]
    pub fn force(self, c: &[f64; COEFFICIENTS], d: f64, v: f64) -> PortForce {
        match self {
            Self::Polynomial => PortForce {
                force: c[0] * d + c[1] * v + c[2] * d * d * d + c[3] * v * v.abs(),
                stiffness: c[0] + 3.0 * c[2] * d * d,
                damping: c[1] + 2.0 * c[3] * v.abs(),
                coefficients: [d, v, d * d * d, v * v.abs()],
            },
            Self::Stop => stop(c, d, v),
            Self::Rough => rough(c, d, v),
            Self::LiftOff => {
                let (gap, slope) = positive(c[0] * d + c[2] * v - c[1], 1e-6 * c[1].abs());
                PortForce {
                    force: c[2] * v - gap,
                    stiffness: -slope * c[0],
                    damping: c[2] * (1.0 - slope),
                    coefficients: [-slope * d, slope, v * (1.0 - slope), 0.0],
                }
            }
            Self::Stiffening => {
                let powers = [d * d, d.powi(3), d.powi(4), d.powi(5)];
                PortForce {
                    force: c.iter().zip(powers).map(|(c, p)| c * p).sum(),
                    stiffness: 2.0 * c[0] * d
                        + 3.0 * c[1] * d * d
                        + 4.0 * c[2] * d.powi(3)
                        + 5.0 * c[3] * d.powi(4),
                    damping: 0.0,
                    coefficients: powers,
                }
            }
            Self::Gap => gap(c, d, v),
            Self::Yielding => yielding(c, d),
            Self::Power => power(c, v),
            Self::Round => round(c, d),
            Self::Friction => {
                let t = (v / c[1]).tanh();
                let slope = c[0] * (1.0 - t * t) / c[1];
                PortForce {
                    force: c[0] * t + c[2] * d,
                    stiffness: c[2],
                    damping: slope,
                    coefficients: [t, -slope * v / c[1], d, 0.0],
                }
            }
        }
    }
}

/// The side of a stop on one side.
fn side_of(c: &[f64; COEFFICIENTS]) -> f64 {
    if c[3] < 0.0 { -1.0 } else { 1.0 }
}

fn stop(c: &[f64; COEFFICIENTS], d: f64, v: f64) -> PortForce {
    pressed(c, side_of(c), d, v)
}

fn rough(c: &[f64; COEFFICIENTS], d: f64, v: f64) -> PortForce {
    let side = side_of(c);
    let width = c[3].abs().max(SHARP);
    let x = (side * d - c[1]) / width;
    let below = (-x.abs()).exp();
    let depth = width * (x.max(0.0) + below.ln_1p());
    let slope = if x < 0.0 { below } else { 1.0 } / (1.0 + below);
    let bend = slope * (1.0 - slope) / width;
    PortForce {
        force: side * c[0] * depth + c[2] * v * slope,
        stiffness: c[0] * slope + c[2] * v * side * bend,
        damping: c[2] * slope,
        coefficients: [
            side * depth,
            -side * c[0] * slope - c[2] * v * bend,
            v * slope,
            c[0] * (depth / width - x * slope) - c[2] * v * side * x * bend,
        ],
    }
}

fn gap(c: &[f64; COEFFICIENTS], d: f64, v: f64) -> PortForce {
    pressed(c, if d < 0.0 { -1.0 } else { 1.0 }, d, v)
}

/// A stop on one side of rest.
fn pressed(c: &[f64; COEFFICIENTS], side: f64, d: f64, v: f64) -> PortForce {
    let beyond = side * d - c[1];
    // A corner of no length has no tangent.
    let width = c[3].hypot(1e-3 * c[1].abs() + SHARP);
    let (depth, slope) = positive(beyond, width);
    let root = beyond.hypot(width);
    let corner = 0.5 * c[3] / root * (side * c[0] - c[2] * v * beyond / (root * root));
    PortForce {
        force: side * c[0] * depth + c[2] * v * slope,
        stiffness: c[0] * slope,
        damping: c[2] * slope,
        coefficients: [side * depth, -side * c[0] * slope, v * slope, corner],
    }
}

fn yielding(c: &[f64; COEFFICIENTS], d: f64) -> PortForce {
    let x = d / c[1];
    let below = 1.0 + x * x;
    let shape = d.powi(3) / below;
    PortForce {
        force: c[0] * shape,
        stiffness: c[0] * d * d * (3.0 + x * x) / (below * below),
        damping: 0.0,
        coefficients: [shape, 2.0 * c[0] * shape * x * x / (c[1] * below), 0.0, 0.0],
    }
}

/// The corner at rest of a power below one is rounded over a thousandth of the reference velocity.
fn power(c: &[f64; COEFFICIENTS], v: f64) -> PortForce {
    let x = v / c[2];
    let size = (x * x + 1e-6).sqrt();
    let growth = size.powf(c[1] - 1.0);
    PortForce {
        force: c[0] * x * growth,
        stiffness: 0.0,
        damping: c[0] * growth / c[2] * (1.0 + (c[1] - 1.0) * x * x / (size * size)),
        coefficients: [x * growth, c[0] * x * growth * size.ln(), 0.0, 0.0],
    }
}

fn round(c: &[f64; COEFFICIENTS], d: f64) -> PortForce {
    let side = side_of(c);
    let (depth, slope) = positive(side * d - c[1], 1e-3 * c[1].abs() + 1e-9);
    let root = depth.sqrt();
    PortForce {
        force: side * c[0] * depth * root,
        stiffness: 1.5 * c[0] * root * slope,
        damping: 0.0,
        coefficients: [side * depth * root, -1.5 * side * c[0] * root * slope, 0.0, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives are central differences (step 1e-7 of the argument's size).
    #[test]
    fn derivatives_are_differences() {
        let cases = [
            (PortLaw::Polynomial, [2.0, 0.3, 5.0, 0.7]),
            (PortLaw::Stop, [2.0, 0.1, 0.4, -1e-3]),
            (PortLaw::Stop, [2.0, 0.1, 0.0, -0.3]),
            (PortLaw::Stop, [2.0, 0.1, 0.0, 0.2]),
            (PortLaw::LiftOff, [3.0, 0.5, 0.0, 0.0]),
            (PortLaw::LiftOff, [3.0, 0.5, 0.4, 0.0]),
            (PortLaw::Stiffening, [2.0, 4.0, -3.0, 5.0]),
            (PortLaw::Yielding, [2.0, 0.3, 0.0, 0.0]),
            (PortLaw::Power, [2.0, 1.4, 0.2, 0.0]),
            (PortLaw::Rough, [2.0, 0.1, 0.4, -0.3]),
            (PortLaw::Rough, [2.0, 0.1, 0.4, 0.2]),
            (PortLaw::Round, [2.0, 0.1, 0.0, -1.0]),
            (PortLaw::Gap, [2.0, 0.1, 0.4, 0.0]),
            (PortLaw::Gap, [2.0, 0.1, 0.0, 0.2]),
            (PortLaw::Friction, [2.0, 0.2, 1.0, 0.0]),
        ];
        for (law, c) in cases {
            for (d, v) in [(0.3, 0.1), (-0.4, -0.2), (0.05, 0.3)] {
                let at = law.force(&c, d, v);
                let e = 1e-6;
                let by_d = (law.force(&c, d + e, v).force - law.force(&c, d - e, v).force) / (2.0 * e);
                let by_v = (law.force(&c, d, v + e).force - law.force(&c, d, v - e).force) / (2.0 * e);
                assert!((at.stiffness - by_d).abs() < 1e-4, "{law:?} {d} {v}: {} {by_d}", at.stiffness);
                assert!((at.damping - by_v).abs() < 1e-4, "{law:?} {d} {v}: {} {by_v}", at.damping);
                let fitted = match law {
                    PortLaw::Power => 2,
                    PortLaw::Stop | PortLaw::Rough | PortLaw::Gap => 4,
                    _ => 3,
                };
                for k in 0..fitted {
                    let (mut up, mut down) = (c, c);
                    up[k] += e;
                    down[k] -= e;
                    let slope = (law.force(&up, d, v).force - law.force(&down, d, v).force) / (2.0 * e);
                    assert!(
                        (at.coefficients[k] - slope).abs() < 1e-3,
                        "{law:?} c{k}: {} {slope}",
                        at.coefficients[k]
                    );
                }
            }
        }
    }
}
