//! Tour 5: the friction law and its parameters, with what the recording cannot tell.

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace::Progress;
use frettrace::identify::{IdentifyOptions, identify};
use frettrace_measurement::read;

fn main() -> anyhow::Result<()> {
    // Parameters
    let options = IdentifyOptions { law: Some("lugre".to_owned()) };

    // Data
    let recording = read("data/demo/rig.h5")?;

    // Solve
    // ANCHOR: solve
    let found = identify(&recording, &options, &Progress::silent())?;
    // ANCHOR_END: solve

    // Look
    for (name, parameter) in &found.parameters {
        let [low, high] = parameter.interval95;
        if parameter.identifiable {
            println!("{name} is between {low:.2e} and {high:.2e} {}", parameter.unit);
        } else {
            println!("{name} is not known");
        }
    }
    Ok(())
}
