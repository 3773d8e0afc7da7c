//! Made sets that are kept in a folder: marching a set takes as long as asking about it, and a change of `explain` changes no set.

use super::made::{Made, make};
use super::plan::Planned;
use frettrace::rig::Effect;
use frettrace_measurement::{Measurement, read_measurement, write_measurement};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// A set that `explain` can be asked about.
#[derive(Clone, Debug)]
pub struct Asked {
    /// What the program is given.
    pub measurement: Measurement,
    /// What is known of it.
    pub known: Known,
}

/// What is known of a set beside its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// Its effects.
    pub effects: Vec<Effect>,
    /// Error over noise floor of the model with true parameters and without an effect.
    pub visible: f64,
}

impl From<Made> for Asked {
    fn from(made: Made) -> Self {
        let known = Known { effects: made.rig.effects, visible: made.visible };
        Self { measurement: made.simulation.measurement, known }
    }
}

/// A planned set: read where the folder has it, else made, and kept there where there is a folder. Whoever changes the simulator empties it.
///
/// # Errors
/// Where it cannot be made or kept.
pub fn asked(planned: &Planned, folder: Option<&Path>) -> anyhow::Result<Asked> {
    let Some(folder) = folder else { return Ok(make(planned)?.into()) };
    let stem = format!("{}_{:x}", planned.name.replace([' ', '/', ':'], "_"), planned.seed);
    let [file, beside] = ["h5", "json"].map(|end| folder.join(format!("{stem}.{end}")));
    let known = fs::read_to_string(&beside).ok().and_then(|text| serde_json::from_str(&text).ok());
    if let Some(known) = known {
        return Ok(Asked { measurement: read_measurement(&file)?, known });
    }
    let asked = Asked::from(make(planned)?);
    fs::create_dir_all(folder)?;
    write_measurement(&file, &asked.measurement, None)?;
    // Last, so that a set that was broken off is made anew.
    fs::write(beside, serde_json::to_string(&asked.known)?)?;
    Ok(asked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::plan::plan;
    use crate::sweep::{CLEAN, SEED};

    /// Measurement and effect of a set with one.
    #[test]
    fn a_kept_set_is_the_one_that_was_made() {
        let plan = plan(SEED, CLEAN);
        let planned = plan.iter().find(|set| set.name == "measurement.gain 1 dahl rotation").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let made = asked(planned, None).unwrap();
        let written = asked(planned, Some(folder.path())).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
        let read = asked(planned, Some(folder.path())).unwrap();
        for kept in [&written, &read] {
            assert_eq!(kept.known, made.known);
            assert_eq!(kept.measurement.runs[0].acceleration, made.measurement.runs[0].acceleration);
        }
    }
}
