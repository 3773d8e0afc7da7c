//! What cannot be used is refused before anything is computed.

use crate::{InverseError, Rig, RunData};

pub(crate) fn rig(rig: &Rig) -> Result<(), InverseError> {
    let length = rig.structure.beam().length;
    let unknowns = 1 + usize::from(rig.second_support.is_some());
    if rig.sensors.len() < unknowns {
        return Err(InverseError::TooFewSensors { sensors: rig.sensors.len(), unknowns });
    }
    let sensors = rig.sensors.iter().enumerate().map(|(s, sensor)| (format!("sensor {s}"), sensor.position));
    let others = [("exciter".to_owned(), rig.exciter)];
    let second = rig.second_support.map(|position| ("second support".to_owned(), position));
    for (what, position) in sensors.chain(others).chain(second) {
        // The end itself may be off by rounding.
        if !(0.0..=length * (1.0 + 1e-9)).contains(&position) {
            return Err(InverseError::OffTheBeam { what, position, length });
        }
    }
    Ok(())
}

pub(crate) fn runs(rig: &Rig, runs: &[RunData<'_>]) -> Result<(), InverseError> {
    if runs.is_empty() {
        return Err(InverseError::NoRuns);
    }
    runs.iter().try_for_each(|run| one(rig, run))
}

fn one(rig: &Rig, run: &RunData<'_>) -> Result<(), InverseError> {
    let shape = |what, found, expected| {
        let name = run.id.to_owned();
        if found == expected { Ok(()) } else { Err(InverseError::Shape { run: name, what, found, expected }) }
    };
    shape("acceleration channels", run.accelerations.len(), rig.sensors.len())?;
    for acceleration in &run.accelerations {
        shape("samples in an acceleration", acceleration.len(), run.force.len())?;
    }
    for (what, value) in
        [("sampling rate [Hz]", run.sampling_rate), ("excitation frequency [Hz]", run.excitation_frequency)]
    {
        if !(value > 0.0 && value.is_finite()) {
            return Err(InverseError::OutOfRange { run: run.id.to_owned(), what, value });
        }
    }
    let named = std::iter::once(("the force".to_owned(), run.force))
        .chain(run.accelerations.iter().enumerate().map(|(s, a)| (format!("sensor {s}"), *a)));
    for (channel, values) in named {
        if let Some(sample) = values.iter().position(|v| !v.is_finite()) {
            return Err(InverseError::NotFinite { run: run.id.to_owned(), channel, sample });
        }
    }
    if run.force.iter().all(|f| *f == 0.0) {
        return Err(InverseError::NoForce { run: run.id.to_owned() });
    }
    Ok(())
}
