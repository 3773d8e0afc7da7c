//! Tour 2: a record that holds no whole number of periods becomes lines, and its frequency is found on the way.

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace_fourier::{Harmonics, Lines, Projector, refine};
use num_complex::Complex64;
use std::f64::consts::TAU;

fn main() -> anyhow::Result<()> {
    // Parameters: half a second of a motion at 49.818 Hz whose file says 49.8 Hz.
    let (frequency, nominal, sampling_rate, samples) = (49.818, 49.8, 8192.0, 4096);

    // Data: x(t) = Re Σ x̂_h e^{ihΩt}; here cos Ωt + 0.1 sin 3Ωt.
    let given = vec![Complex64::ZERO, Complex64::ONE, Complex64::ZERO, Complex64::new(0.0, -0.1)];
    let record = Harmonics::exact(TAU * frequency, given).sample(sampling_rate, samples);

    // Problem: which frequency, and how much of each line?
    let nominal = Lines { base: TAU * nominal, order: 3, samples, sampling_rate, drift: 0 };

    // Solve
    // ANCHOR: solve
    let found = refine(nominal, &[&record])?;
    let lines = Projector::new(Lines { base: found.base, ..nominal })?.project(&record)?.harmonics;
    // ANCHOR_END: solve

    // Look
    println!("periods in the record {:.3}", frequency * samples as f64 / sampling_rate);
    println!("frequency [Hz]        {:.6}", found.base / TAU);
    for (line, value) in lines.coefficients.iter().enumerate().skip(1) {
        println!("line {line}: amplitude {:.6}", value.norm());
    }
    Ok(())
}
