//! Wavenumbers of the uniform beam against the roots of its characteristic equations.

use crate::case::{Case, Outcome, Row};
use frettrace_beam::{Boundary, UniformBeam, mode_shapes};

/// The case.
pub const CASE: Case = Case { name: "verify_beam_modes", run };

/// Roots of `cos λ cosh λ = −1` (free end) and of `tan λ = tanh λ` (pinned end), to ten digits.
const CANTILEVER: [f64; 3] = [1.875_104_068_7, 4.694_091_133_0, 7.854_757_438_2];
const PINNED: [f64; 3] = [3.926_602_312_0, 7.068_582_745_6, 10.210_176_122_8];

fn run() -> anyhow::Result<Outcome> {
    let unit = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };
    let mut rows = Vec::new();
    for (end, boundary, roots) in
        [("free end", Boundary::cantilever(), CANTILEVER), ("pinned end", Boundary::pinned(), PINNED)]
    {
        for (index, (shape, root)) in mode_shapes(&unit, &boundary, 3)?.iter().zip(roots).enumerate() {
            rows.push(Row {
                quantity: format!("wavenumber {} with {end}", index + 1),
                unit: "1",
                source: "characteristic equation",
                expected: Some(root),
                found: shape.wavenumber(),
                tolerance: 1e-9,
                reason: "the roots are given to ten digits",
            });
        }
    }
    Ok(Outcome::Ran(rows))
}
