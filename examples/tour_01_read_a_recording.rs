//! Tour 1: what a measurement file holds, and whether its signals are good enough to start.

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace_measurement::{quality::judge, read_measurement};

fn main() -> anyhow::Result<()> {
    // Data: the repository's own measurement, made by `frettrace simulate`.
    // ANCHOR: read
    let measurement = read_measurement("data/demo/rig.h5")?;
    // ANCHOR_END: read

    // Look
    let beam = &measurement.beam;
    println!("beam {:.3} m × {:.1} mm × {:.1} mm", beam.length, 1e3 * beam.width, 1e3 * beam.thickness);
    println!("law {}, {} sensors", measurement.support.law, measurement.sensors.position.len());
    println!("run   frequency [Hz]  level [m/s²]  harmonics  order");
    for run in &measurement.runs {
        let quality = judge(run, &measurement.sensors)?;
        println!(
            "{}  {:14.3}  {:12.2}  {:7.1} %  {:5}",
            quality.id,
            quality.frequency,
            quality.level,
            100.0 * quality.harmonic_share,
            quality.subharmonic_order
        );
    }
    Ok(())
}
