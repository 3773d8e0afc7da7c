//! Memoryless forces at single degrees of freedom of the structure.

/// Coefficients a port may have.
pub const COEFFICIENTS: usize = 4;

/// Force law of a port as a function of the displacement `d` and velocity `ḋ` of its degree of freedom; positive
/// values resist positive displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PortLaw {
    /// `c₀ d + c₁ ḋ + c₂ d³ + c₃ ḋ|ḋ|`.
    Polynomial,
    /// A stop on one side: `c₀ (d − c₁)⁺ + c₂ ḋ` while in touch; the side is the sign of `c₃` (not fitted).
    Stop,
    /// A support spring that cannot pull: `−(k d − P)⁺` with `k = c₀`, `P = c₁`.
    LiftOff,
    /// `c₀ d² + c₁ d³`.
    Stiffening,
    /// Play on both sides: `c₀ (|d| − c₁)⁺ sgn d + c₂ ḋ`.
    Gap,
    /// Coulomb friction smoothed over a displacement-free velocity: `c₀ tanh(ḋ/c₁) + c₂ d`.
    Friction,
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
            Self::LiftOff => {
                let (gap, slope) = positive(c[0] * d - c[1], 1e-6 * c[1].abs());
                PortForce {
                    force: -gap,
                    stiffness: -slope * c[0],
                    damping: 0.0,
                    coefficients: [-slope * d, slope, 0.0, 0.0],
                }
            }
            Self::Stiffening => PortForce {
                force: c[0] * d * d + c[1] * d * d * d,
                stiffness: 2.0 * c[0] * d + 3.0 * c[1] * d * d,
                damping: 0.0,
                coefficients: [d * d, d * d * d, 0.0, 0.0],
            },
            Self::Gap => gap(c, d, v),
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

fn stop(c: &[f64; COEFFICIENTS], d: f64, v: f64) -> PortForce {
    let side = if c[3] < 0.0 { -1.0 } else { 1.0 };
    let (depth, slope) = positive(side * d - c[1], 1e-3 * c[1].abs() + 1e-9);
    PortForce {
        force: side * c[0] * depth + c[2] * v * slope,
        stiffness: c[0] * slope,
        damping: c[2] * slope,
        coefficients: [side * depth, -side * c[0] * slope, v * slope, 0.0],
    }
}

fn gap(c: &[f64; COEFFICIENTS], d: f64, v: f64) -> PortForce {
    let side = if d < 0.0 { -1.0 } else { 1.0 };
    let (depth, slope) = positive(d.abs() - c[1], 1e-3 * c[1].abs() + 1e-9);
    PortForce {
        force: side * c[0] * depth + c[2] * v * slope,
        stiffness: c[0] * slope,
        damping: c[2] * slope,
        coefficients: [side * depth, -side * c[0] * slope, v * slope, 0.0],
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
            (PortLaw::Stop, [2.0, 0.1, 0.4, -1.0]),
            (PortLaw::LiftOff, [3.0, 0.5, 0.0, 0.0]),
            (PortLaw::Stiffening, [2.0, 4.0, 0.0, 0.0]),
            (PortLaw::Gap, [2.0, 0.1, 0.4, 0.0]),
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
                for k in 0..3 {
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
