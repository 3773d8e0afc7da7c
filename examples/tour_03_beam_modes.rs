//! Tour 3: modes of the clamped beam on its support, and why a bare modal sum is not enough.

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace_beam::{Boundary, Dof, ExactBeam, ModalModel, ModalOptions, Receptance, UniformBeam};
use std::f64::consts::TAU;

fn main() -> anyhow::Result<()> {
    // Parameters: steel, 0.6 m × 25 mm × 6 mm, resting on a support that only lets it turn.
    let beam = UniformBeam::rectangular(0.6, [0.025, 0.006], 2.05e11, 7850.0);
    let boundary = Boundary::pinned();
    let contact = Dof::rotation(0.6);

    // Problem: the rotation of the contact face per unit moment there, between the first two modes.
    let omega = TAU * 150.0;

    // Solve: closed form, and modal sums of 6 modes with and without the static residual.
    // ANCHOR: solve
    let exact = ExactBeam::new(&beam, &boundary, 0.0)?.receptance(contact, contact, omega).re;
    let model = ModalModel::new(&beam, &boundary, &ModalOptions { modes: 6, ..ModalOptions::default() })?;
    let with_residual = model.receptance(contact, contact, omega).re;
    let bare = with_residual - model.residual(contact, contact);
    // ANCHOR_END: solve

    // Look
    for (index, frequency) in model.natural_frequency().iter().take(3).enumerate() {
        println!("mode {}: {:.3} Hz", index + 1, frequency / TAU);
    }
    println!("six modes alone are wrong by       {:.2} %", 100.0 * (bare / exact - 1.0).abs());
    println!("six modes and residual by          {:.4} %", 100.0 * (with_residual / exact - 1.0).abs());
    Ok(())
}
