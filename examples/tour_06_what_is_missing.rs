//! Tour 6: the file declares Dahl's law and keeps silent about one effect; which?

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace::explain::{ExplainOptions, explain};
use frettrace::{Progress, report::words};
use frettrace_measurement::read;

fn main() -> anyhow::Result<()> {
    // Data
    let recording = read("data/demo/rig.h5")?;

    // Solve
    // ANCHOR: solve
    let found = explain(&recording, &ExplainOptions::default(), &Progress::silent())?;
    // ANCHOR_END: solve

    // Look
    println!("{}", words::verdict(&found));
    for candidate in found.candidates.iter().take(3) {
        println!("tried {}: {}", candidate.id, words::meaning(&candidate.id));
    }
    Ok(())
}
