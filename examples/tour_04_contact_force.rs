//! Tour 4: the contact force and the slip, from accelerations and the exciter's force, without a friction law.

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace::Progress;
use frettrace::reconstruct::{ReconstructOptions, reconstruct};
use frettrace_measurement::read_measurement;

fn main() -> anyhow::Result<()> {
    // Data
    let measurement = read_measurement("data/demo/rig.h5")?;

    // Solve: all runs together, since they share the beam's natural frequencies and damping.
    // ANCHOR: solve
    let found = reconstruct(&measurement, &ReconstructOptions::default(), &Progress::silent())?;
    // ANCHOR_END: solve

    // Look
    println!("run   friction [N]  slip [µm]  energy per cycle [µJ]  error over noise");
    for run in &found.result.runs {
        let (force, slip) = (&run.friction_force.values, &run.slip_displacement.values);
        let work: f64 = force.iter().zip(&run.slip_velocity.values).map(|(f, v)| f * v).sum();
        let energy = work / force.len() as f64 / run.fundamental_frequency;
        println!(
            "{}  {:12.2}  {:9.2}  {:21.2}  {:16.2}",
            run.id,
            peak(force),
            1e6 * peak(slip),
            1e6 * energy,
            run.acceleration_error / run.noise_floor
        );
    }
    Ok(())
}

fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
}
