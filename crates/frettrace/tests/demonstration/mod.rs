//! The demonstration rig with other effects than its own.

use crate::answers;
use frettrace::rig::Rig;
use frettrace_measurement::Measurement;

const RIG: &str = include_str!("../../../../data/demo/rig.toml");

/// What the rig measures with `effects`, tables of its file, under a share of its forces (of a half its contact stays closed) and once it is changed.
pub fn measured(effects: &str, share: f64, change: impl FnOnce(&mut Rig)) -> Measurement {
    let text = RIG.split("[[effect]]").next().unwrap_or_default().to_owned() + effects;
    answers::measured(&text, |rig| {
        let forces = rig.runs.iter_mut().flat_map(|runs| &mut runs.force_amplitude_n);
        forces.for_each(|force| *force *= share);
        change(rig);
    })
}
