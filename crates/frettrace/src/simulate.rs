//! A rig to a measurement file and what only the simulation knows.

mod foreign;
mod law;
mod recorded;

use std::f64::consts::TAU;

use frettrace_beam::{Boundary, ModalModel, ModalOptions};
use frettrace_forward::march::{Characteristic, Modulation, Settling};
use frettrace_forward::simulate as forward;
use frettrace_forward::simulate::{Attached, Chain, Marching, SimulatedRig, SimulatedRun};
use frettrace_measurement::{Measurement, Truth};
use rayon::prelude::*;

use recorded::{measurement, run_id, truth};

use crate::reconstruct::told_apart;
use crate::rig::{Effect, Rig, RigRuns, RigSlip};
use crate::{Progress, StudyError};

/// What `simulate` makes.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// What the file declares and the channels.
    pub measurement: Measurement,
    /// What only the simulation knows.
    pub truth: Truth,
    /// For each run whether it had settled when it was recorded.
    pub settled: Vec<Settling>,
    /// For each run how finely it was marched.
    pub marching: Vec<Marching>,
}

/// Modes marched; the inverse and the harmonic balance use other numbers.
pub const MODES: usize = 72;
/// Change of the accelerations by the march's last tightening, over the noise of a sensor.
const SHARE_OF_NOISE: f64 = 0.1;

/// Marches every run of the rig, in parallel.
///
/// # Errors
/// [`StudyError`] where the beam cannot be computed, an effect does not fit the law or a march comes to no motion.
pub fn simulate(rig: &Rig, progress: &Progress) -> Result<Simulation, StudyError> {
    let simulated = simulated_rig(rig)?;
    let runs = simulated_runs(rig);
    progress.start(runs.len() as u64, "marching");
    let records = runs
        .par_iter()
        .enumerate()
        .map(|(index, (_, run))| {
            let record = forward::simulate(&simulated, run, index as u64);
            progress.step();
            record
        })
        .collect::<Result<Vec<_>, _>>()?;
    progress.finish();
    let moves =
        |record: &forward::SimulatedRecord| record.acceleration.iter().flatten().all(|a| a.is_finite());
    if let Some(run) = records.iter().position(|record| !moves(record)) {
        return Err(StudyError::NoMotion { run: run_id(run) });
    }
    let settled = records.iter().map(|record| record.settling).collect();
    let marching = records.iter().map(|record| record.marching).collect();
    let truth = truth(rig, &records);
    Ok(Simulation { measurement: measurement(rig, &runs, records)?, truth, settled, marching })
}

fn boundary(rig: &Rig) -> Boundary {
    Boundary {
        clamp_rotational_stiffness: rig.clamp.rotational_stiffness_n_m_per_rad,
        support_stiffness: told_apart(
            rig.support.normal_stiffness_n_per_m.unwrap_or(0.0),
            &rig.beam.uniform(),
        ),
        support_rotational_stiffness: 0.0,
    }
}

/// Natural frequencies (rad/s) and damping ratios of the structure as it is declared, the first `count`.
fn declared_modes(rig: &Rig, boundary: &Boundary, count: usize) -> Result<[Vec<f64>; 2], StudyError> {
    let options = ModalOptions {
        modes: count.max(rig.modes.natural_frequency_hz.len()).max(rig.modes.damping_ratio.len()),
        natural_frequency: rig.modes.natural_frequency_hz.iter().map(|f| TAU * f).collect(),
        damping_ratio: rig.modes.damping_ratio.clone(),
        ..ModalOptions::default()
    };
    let model = ModalModel::new(&rig.beam.uniform(), boundary, &options)?;
    Ok([model.natural_frequency()[..count].to_vec(), model.damping_ratio()[..count].to_vec()])
}

/// Shape of a modulation that is nearly a square wave: flat over two thirds of the period.
const SQUARENESS: f64 = 3.0;
/// Skewness of a modulation that rises in a third of the period and falls in two.
const SKEWNESS: f64 = 0.6;

/// The rig with all its effects.
pub(crate) fn simulated_rig(rig: &Rig) -> Result<SimulatedRig, StudyError> {
    let count = rig.modes.declared.max(20);
    let [natural_frequency, damping_ratio] = declared_modes(rig, &boundary(rig), count)?;
    let chain = Chain {
        noise: rig.sensors.noise_std_m_per_s2,
        noise_correlation: rig.sensors.noise_correlation,
        ..Chain::default()
    };
    let sensor =
        |&position: &f64| forward::SimulatedSensor { position, chain: chain.clone(), cross_talk: None };
    let mut simulated = SimulatedRig {
        beam: rig.beam.uniform(),
        boundary: boundary(rig),
        modes: MODES,
        natural_frequency,
        damping_ratio,
        slip: match rig.support.slip {
            RigSlip::Rotation => {
                forward::Slip::Rotation { lever_arm: rig.support.lever_arm_m.unwrap_or_default() }
            }
            RigSlip::Transverse => forward::Slip::Transverse,
        },
        normal: forward::NormalContact::default(),
        law: law::true_law(rig)?,
        exciter: rig.exciter.position_m,
        sensors: rig.sensors.position_m.iter().map(sensor).collect(),
        attached: Vec::new(),
        second_support: None,
        base: None,
        exciter_lever: 0.0,
        second_force: None,
        sampling: forward::Sampling {
            rate: rig.sampling.rate_hz,
            samples: rig.sampling.samples,
            oversampling: rig.sampling.oversampling(),
            steps: steps(rig),
        },
        seed: rig.seed,
    };
    if let Some(second) = &rig.second_support {
        simulated.second_support = Some(0);
        let stop = Characteristic::Stop { stiffness: second.stiffness_n_per_m, gap: second.gap_m };
        simulated.attached.push((second.position_m, Attached::Load(stop)));
    }
    for effect in &rig.effects {
        structure_effect(rig, effect, &mut simulated)?;
        channel_effect(effect, &mut simulated);
        foreign::structure_effect(effect, &mut simulated);
        foreign::channel_effect(effect, &mut simulated);
    }
    Ok(simulated)
}

/// Steps of the march: those given, else what the noise asks for.
fn steps(rig: &Rig) -> forward::Steps {
    let fine = rig.sampling.fine_rate_hz();
    match rig.sampling.march_rate_hz {
        // A multiple of the fine rate must not become the next one by rounding.
        Some(rate) => forward::Steps::Given((rate / fine - 1e-9).ceil().max(1.0) as usize),
        None => forward::Steps::Within(SHARE_OF_NOISE * rig.sensors.noise_std_m_per_s2),
    }
}

/// Effects of the structure, the normal contact and the base.
fn structure_effect(rig: &Rig, effect: &Effect, simulated: &mut SimulatedRig) -> Result<(), StudyError> {
    let load = |characteristic| Attached::Load(characteristic);
    let attached = match *effect {
        Effect::CubicStiffness { position_m, stiffness_n_per_m3 } => {
            Some((position_m, load(Characteristic::CubicSpring(stiffness_n_per_m3))))
        }
        Effect::QuadraticDamping { position_m, damping_n_s2_per_m2 } => {
            Some((position_m, load(Characteristic::QuadraticDashpot(damping_n_s2_per_m2))))
        }
        Effect::AddedMass { position_m, mass_kg } => Some((position_m, Attached::Mass(mass_kg))),
        Effect::SecondSupport { position_m, stiffness_n_per_m, gap_m } => {
            Some((position_m, load(Characteristic::Stop { stiffness: stiffness_n_per_m, gap: gap_m })))
        }
        Effect::LiftOff => {
            simulated.normal.lifts_off = true;
            None
        }
        Effect::NormalStiffening { cubic_n_per_m3 } => {
            simulated.normal.cubic = cubic_n_per_m3;
            None
        }
        Effect::BaseMotion { acceleration_m_per_s2, frequency_ratio, phase_rad } => {
            simulated.base = Some(forward::BaseMotion {
                acceleration: acceleration_m_per_s2,
                frequency_ratio,
                phase: phase_rad,
            });
            None
        }
        Effect::ModalFrequency { mode, relative_change } => {
            simulated.natural_frequency[mode - 1] *= 1.0 + relative_change;
            None
        }
        Effect::ModalDamping { mode, relative_change } => {
            simulated.damping_ratio[mode - 1] *= 1.0 + relative_change;
            None
        }
        Effect::ClampCompliance { rotational_stiffness_n_m_per_rad } => {
            soften_clamp(rig, rotational_stiffness_n_m_per_rad, simulated)?;
            None
        }
        _ => None,
    };
    simulated.attached.extend(attached);
    Ok(())
}

/// A turning clamp changes shapes and frequencies; given frequencies move by the beam's own ratio.
fn soften_clamp(rig: &Rig, stiffness: f64, simulated: &mut SimulatedRig) -> Result<(), StudyError> {
    let soft = Boundary { clamp_rotational_stiffness: stiffness, ..boundary(rig) };
    let count = simulated.natural_frequency.len();
    let options = ModalOptions { modes: count, ..ModalOptions::default() };
    let plain = ModalModel::new(&simulated.beam, &boundary(rig), &options)?;
    let turned = ModalModel::new(&simulated.beam, &soft, &options)?;
    for (mode, frequency) in simulated.natural_frequency.iter_mut().enumerate() {
        *frequency *= turned.natural_frequency()[mode] / plain.natural_frequency()[mode];
    }
    simulated.boundary = soft;
    Ok(())
}

/// Effects of one measuring chain.
fn channel_effect(effect: &Effect, simulated: &mut SimulatedRig) {
    let Some(sensor) = effect.sensor().and_then(|index| simulated.sensors.get_mut(index)) else { return };
    let chain = &mut sensor.chain;
    match *effect {
        Effect::Gain { factor, .. } => chain.gain = factor,
        Effect::Delay { delay_s, .. } => chain.delay = delay_s,
        Effect::Hum { amplitude_m_per_s2, frequency_hz, .. } => {
            chain.hum = Some(forward::Hum {
                amplitude: amplitude_m_per_s2,
                frequency: frequency_hz,
                phase: 0.0,
                third: 0.0,
            });
        }
        Effect::Clipping { limit_m_per_s2, .. } => chain.limit = limit_m_per_s2,
        Effect::SensorPosition { shift_m, .. } => sensor.position += shift_m,
        Effect::Dropout { start_share, length_share, .. } => {
            chain.dropouts.push([start_share, start_share + length_share]);
        }
        Effect::Offset { offset_m_per_s2, .. } => chain.offset = offset_m_per_s2,
        _ => {}
    }
}

/// One simulated run for every amplitude of every table.
fn simulated_runs(rig: &Rig) -> Vec<(&RigRuns, SimulatedRun)> {
    let all: Vec<(&RigRuns, f64)> =
        rig.runs.iter().flat_map(|runs| runs.force_amplitude_n.iter().map(move |&f| (runs, f))).collect();
    let last = all.len().saturating_sub(1).max(1) as f64;
    let one = |(index, (runs, force_amplitude)): (usize, (_, f64))| -> (&RigRuns, SimulatedRun) {
        let runs: &RigRuns = runs;
        let progress = index as f64 / last;
        let omega = TAU * runs.frequency_hz;
        let wave = |[share, ratio, phase]: [f64; 3], [shape, skewness]: [f64; 2]| Modulation {
            share,
            shape,
            skewness,
            omega: ratio * omega,
            phase,
        };
        let mut run = SimulatedRun {
            force_amplitude,
            beat: runs.beat(),
            omega,
            preload: runs.preload_n,
            modulation: None,
            frequency_factor: 1.0,
            progress,
        };
        for effect in &rig.effects {
            match *effect {
                Effect::FrequencyDrift { relative_change } => {
                    run.frequency_factor += relative_change * progress
                }
                Effect::PreloadModulation { share, frequency_ratio, phase_rad } => {
                    run.modulation = Some(wave([share, frequency_ratio, phase_rad], [0.0; 2]));
                }
                Effect::SquareModulation { share, frequency_ratio, phase_rad } => {
                    run.modulation = Some(wave([share, frequency_ratio, phase_rad], [SQUARENESS, 0.0]));
                }
                Effect::SkewedModulation { share, frequency_ratio, phase_rad } => {
                    run.modulation = Some(wave([share, frequency_ratio, phase_rad], [0.0, SKEWNESS]));
                }
                Effect::SettlingDrift { relative_change } => {
                    run.frequency_factor +=
                        relative_change * (-4.0 * progress).exp_m1() / (-4.0_f64).exp_m1();
                }
                _ => {}
            }
        }
        (runs, run)
    };
    all.into_iter().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests;
