//! One run of the rig, recorded.

use std::f64::consts::TAU;

use frettrace_beam::{Dof, ModalModel, ModalOptions};
use frettrace_friction::effects::{Circumstance, ModifiedLaw, ModifiedState};
use frettrace_friction::{FrictionLaw, Step, Visitor};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::filter::{LowPass, REACH};
use super::fineness::{Fine, Marched, Marching};
use super::foreign::ForeignLaw;
use super::rig::{Attached, CrossTalk, SimulatedLaw, SimulatedRig, SimulatedRun, SimulatedSensor, Slip};
use crate::ForwardError;
use crate::march::{
    Assembly, FrictionContact, LocalLoad, March, Modulation, Normal, Port, Settling, Structure,
};

/// What a run hands over, and what only the simulation knows; one number a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedRecord {
    /// Accelerations (m/s²), one vector a sensor.
    pub acceleration: Vec<Vec<f64>>,
    /// Excitation force (N).
    pub force: Vec<f64>,
    /// Friction force (N).
    pub friction_force: Vec<f64>,
    /// Normal force (N).
    pub normal_force: Vec<f64>,
    /// Slip (m).
    pub slip: Vec<f64>,
    /// Slip velocity (m/s).
    pub slip_velocity: Vec<f64>,
    /// Load of the second support on the beam (N).
    pub second_support_force: Option<Vec<f64>>,
    /// Whether the run had settled when it was recorded.
    pub settling: Settling,
    /// How finely it was marched.
    pub marching: Marching,
}

/// Simulates run number `index` of the rig.
///
/// # Errors
/// [`ForwardError`] where the beam cannot be computed.
pub fn simulate(rig: &SimulatedRig, run: &SimulatedRun, index: u64) -> Result<SimulatedRecord, ForwardError> {
    let job = Job { rig, run, index };
    match &rig.law {
        SimulatedLaw::Declared(model) => model.visit(job),
        SimulatedLaw::Modified(law) => {
            let circumstance =
                Circumstance { preload: run.preload, progress: run.progress, ..Circumstance::default() };
            job.visit(&Circumstantial { law: *law, circumstance })
        }
        SimulatedLaw::Foreign(law) => job.visit(&ForeignLaw { progress: run.progress, ..*law }),
    }
}

/// A modified law in the circumstances of one run.
#[derive(Clone, Copy)]
struct Circumstantial {
    law: ModifiedLaw<f64>,
    circumstance: Circumstance,
}

impl FrictionLaw<f64> for Circumstantial {
    type State = ModifiedState<f64>;

    fn rest(&self) -> Self::State {
        self.law.rest_at(0.0)
    }

    fn step(&self, state: Self::State, step: &Step<f64>) -> (Self::State, f64) {
        self.law.advance(state, step, &self.circumstance)
    }
}

#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) rig: &'a SimulatedRig,
    pub(super) run: &'a SimulatedRun,
    index: u64,
}

/// Where the things of the rig are in the list of ports.
const EXCITER: usize = 0;
const SLIP: usize = 1;
const NORMAL: usize = 2;
pub(super) const SENSORS: usize = 3;

impl Visitor<f64> for Job<'_> {
    type Output = Result<SimulatedRecord, ForwardError>;

    fn visit<L: FrictionLaw<f64>>(self, law: &L) -> Self::Output {
        let mut random =
            Pcg64::seed_from_u64(self.rig.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(self.index));
        // Records begin anywhere, each in another period: what is driven at a part of the frequency is not alike in all.
        let phase = random.random_range(0.0..TAU) + TAU * self.index as f64;
        let marched = self.resolve(law, phase)?;
        Ok(self.sample(&marched, &mut random))
    }
}

impl Job<'_> {
    /// Marches with all modes; where the contact then chatters, or the motion does not stay the same as steps get shorter, with those
    /// that the fine time base can carry: of the others the flexibility stays, damped so that it does not ring.
    fn resolve<L: FrictionLaw<f64>>(&self, law: &L, phase: f64) -> Result<Marched, ForwardError> {
        let carried = self.carried_modes()?;
        let attempt = |modes: usize| {
            let assembly = self.assembly(*law, phase, modes)?;
            Ok::<_, ForwardError>(self.march(March::new(&assembly, 1.0), (phase, modes)))
        };
        let whole = attempt(self.rig.modes)?;
        let met = |marched: &Option<Marched>| marched.as_ref().is_some_and(|m| m.marching.is_met());
        let fewer = if met(&whole) || carried == self.rig.modes { None } else { attempt(carried)? };
        if let Some(marched) = if met(&fewer) { fewer } else { whole.or(fewer) } {
            return Ok(marched);
        }
        let assembly = self.assembly(*law, phase, carried)?;
        Ok(self.chattering(March::new(&assembly, 1.0), (phase, carried)))
    }

    /// Modes below half the rate of the fine samples, which carry no more; those that are declared at least.
    fn carried_modes(&self) -> Result<usize, ForwardError> {
        let model = self.model(self.rig.modes)?;
        let highest = 0.5 * TAU * self.fine_rate();
        let carried = model.natural_frequency().iter().filter(|&&frequency| frequency <= highest).count();
        Ok(carried.max(self.rig.natural_frequency.len()).max(1).min(self.rig.modes))
    }

    fn model(&self, modes: usize) -> Result<ModalModel, ForwardError> {
        let options = ModalOptions {
            modes,
            natural_frequency: first(&self.rig.natural_frequency, modes),
            damping_ratio: first(&self.rig.damping_ratio, modes),
            ..ModalOptions::default()
        };
        let mut model = ModalModel::new(&self.rig.beam, &self.rig.boundary, &options)?;
        for mode in 0..model.mode_count() {
            let (frequency, ratio) = (model.natural_frequency()[mode], model.damping_ratio()[mode]);
            model.set_mode(mode, frequency * self.run.frequency_factor, ratio);
        }
        Ok(model)
    }

    fn ports(&self) -> Vec<Port> {
        let end = self.rig.beam.length;
        let displacement = |position: f64| Port { dof: Dof::displacement(position), factor: 1.0 };
        let slip = match self.rig.slip {
            Slip::Rotation { lever_arm } => Port { dof: Dof::rotation(end), factor: lever_arm },
            Slip::Transverse => displacement(end),
        };
        let sensors = self.rig.sensors.iter().map(|sensor| displacement(sensor.position));
        let attached = self.rig.attached.iter().map(|&(position, _)| displacement(position));
        let moment = Port { dof: Dof::rotation(self.rig.exciter), factor: self.rig.exciter_lever };
        let second = self.rig.second_force.map(|force| displacement(force.position));
        [displacement(self.rig.exciter), slip, displacement(end)]
            .into_iter()
            .chain(sensors)
            .chain(attached)
            .chain([moment])
            .chain(second)
            .collect()
    }

    fn assembly<L>(&self, law: L, phase: f64, modes: usize) -> Result<Assembly<L>, ForwardError> {
        let model = self.model(modes)?;
        let mut structure = Structure::from_beam(&model, &self.ports())?;
        let first = SENSORS + self.rig.sensors.len();
        let moment = first + self.rig.attached.len();
        let mut inputs = vec![EXCITER, moment];
        inputs.extend(self.rig.second_force.map(|_| moment + 1));
        if self.rig.base.is_some() {
            inputs.push(structure.add_base(&model));
        }
        let mut loads = Vec::new();
        for (index, &(_, attached)) in self.rig.attached.iter().enumerate() {
            match attached {
                Attached::Mass(mass) => structure.add_mass(first + index, mass)?,
                Attached::Load(characteristic) => {
                    loads.push(LocalLoad { port: first + index, characteristic })
                }
            }
        }
        let normal = Normal {
            port: matches!(self.rig.slip, Slip::Rotation { .. }).then_some(NORMAL),
            stiffness: self.rig.boundary.reaction_stiffness()?,
            cubic: self.rig.normal.cubic,
            sharpness: self.rig.normal.sharpness,
            power: self.rig.normal.power,
            lifts_off: self.rig.normal.lifts_off,
            modulation: self
                .run
                .modulation
                .map(|m| Modulation { phase: m.phase + m.omega / self.run.omega * phase, ..m }),
            ..Normal::constant(self.run.preload)
        };
        Ok(Assembly {
            structure,
            inputs,
            friction: Some(FrictionContact { law, slip_port: SLIP, normal }),
            loads,
        })
    }

    /// Frequencies of the input loads over the excitation's, in the order of the assembly.
    pub(super) fn frequency_ratios(&self) -> Vec<f64> {
        let second = self.rig.second_force.map(|force| force.frequency_ratio);
        let base = self.rig.base.map(|base| base.frequency_ratio);
        [1.0, 1.0].into_iter().chain(second).chain(base).collect()
    }

    /// The input loads at a time, in the order of the assembly; returns the acceleration of the base.
    ///
    /// `phase` is the excitation's at time nought; all that is driven keeps its phase to it.
    pub(super) fn known(&self, phase: f64, time: f64, loads: &mut [f64]) -> f64 {
        let angle = self.run.omega * time + phase;
        let beat = self.run.beat.map_or(0.0, |beat| beat.share * (beat.frequency_ratio * angle).sin());
        loads[0] = self.run.force_amplitude * (1.0 + beat) * angle.sin();
        loads[1] = loads[0];
        if let Some(force) = self.rig.second_force {
            loads[2] = force.amplitude * (force.frequency_ratio * angle + force.phase).cos();
        }
        let (Some(base), Some(last)) = (self.rig.base, loads.last_mut()) else { return 0.0 };
        *last = base.acceleration * (base.frequency_ratio * angle + base.phase).cos();
        *last
    }

    /// Rate at which the march is recorded (Hz).
    pub(super) fn fine_rate(&self) -> f64 {
        self.rig.sampling.rate * self.rig.sampling.oversampling as f64
    }

    /// Fine samples before the first sample of the record: the filter's reach, the latest channel, the differences.
    pub(super) fn margin(&self) -> usize {
        let late = self.rig.sensors.iter().map(|s| s.chain.delay.abs()).fold(0.0, f64::max);
        REACH * self.rig.sampling.oversampling + (late * self.fine_rate()).ceil() as usize + DIFFERENCE / 2
    }

    /// Place of the second support among the local loads (masses are none).
    pub(super) fn second_support(&self) -> Option<usize> {
        let index = self.rig.second_support?;
        let is_load = |attached: &&(f64, Attached)| matches!(attached.1, Attached::Load(_));
        Some(self.rig.attached[..index].iter().filter(is_load).count())
    }

    /// A fine channel as the record has it, late by `delay` (s).
    fn decimated(&self, channel: &[f64], delay: f64) -> Vec<f64> {
        let sampling = &self.rig.sampling;
        let filter = LowPass::new(sampling.oversampling, delay * self.fine_rate());
        let margin = self.margin();
        (0..sampling.samples).map(|k| filter.at(channel, margin + k * sampling.oversampling)).collect()
    }

    /// Accelerations of the sensors' places as perfect chains record them (m/s²).
    pub(super) fn perfect(&self, fine: &Fine) -> Vec<Vec<f64>> {
        let record = |channel: &Vec<f64>| {
            self.decimated(&second_derivative(channel, &fine.base, self.fine_rate()), 0.0)
        };
        fine.displacement.iter().map(record).collect()
    }

    fn sample(&self, marched: &Marched, random: &mut Pcg64) -> SimulatedRecord {
        let fine = &marched.fine;
        let acceleration = fine
            .displacement
            .iter()
            .zip(&self.rig.sensors)
            .map(|(channel, sensor)| {
                let motion = self.heard(channel, sensor, fine);
                let mut signal = self.decimated(&motion, sensor.chain.delay);
                sensor.chain.apply(&mut signal, self.rig.sampling.rate, random);
                signal
            })
            .collect();
        let [force, friction_force, normal_force, slip, slip_velocity] =
            fine.contact.each_ref().map(|channel| self.decimated(channel, 0.0));
        SimulatedRecord {
            acceleration,
            force,
            friction_force,
            normal_force,
            slip,
            slip_velocity,
            second_support_force: fine.second.as_ref().map(|channel| self.decimated(channel, 0.0)),
            settling: marched.settling,
            marching: marched.marching,
        }
    }
}

impl Job<'_> {
    /// What the sensor's chain starts from: its own acceleration, what it hears of another, and its distortion.
    fn heard(&self, channel: &[f64], sensor: &SimulatedSensor, fine: &Fine) -> Vec<f64> {
        let mut motion = second_derivative(channel, &fine.base, self.fine_rate());
        if let Some(CrossTalk { from, share }) = sensor.cross_talk {
            let other = second_derivative(&fine.displacement[from], &fine.base, self.fine_rate());
            for (value, other) in motion.iter_mut().zip(other) {
                *value += share * other;
            }
        }
        if let Some(distortion) = sensor.chain.distortion {
            // A whole number of periods, over and over, runs a filter in.
            let period = TAU / self.run.omega * self.fine_rate();
            let whole = ((motion.len() as f64 / period).floor() * period).round() as usize;
            let warm_up = motion[..whole.min(motion.len())].repeat(WARM_UP);
            distortion.apply(&mut motion, self.fine_rate(), &warm_up);
        }
        motion
    }
}

fn first(values: &[f64], count: usize) -> Vec<f64> {
    values.iter().copied().take(count).collect()
}

/// Times that the record is gone through before a filter of a measuring chain counts as settled.
const WARM_UP: usize = 3;

/// Samples that the second difference takes.
const DIFFERENCE: usize = 7;

/// Acceleration from displacement by central differences of sixth order, plus the base's: `(ωΔt)⁶/560` of it is missing,
/// 3e-6 at the edge of the filter with eight fine samples a sample.
///
/// Modes above the fine rate ring at the kinks that the hold puts into the loads; sampled, that ringing folds onto the
/// lines. In displacements it is negligible, in modal accelerations it is not.
fn second_derivative(displacement: &[f64], base: &[f64], rate: f64) -> Vec<f64> {
    let mut acceleration = base.to_vec();
    for (window, value) in displacement.windows(DIFFERENCE).zip(&mut acceleration[DIFFERENCE / 2..]) {
        let around = |k: usize| window[3 - k] + window[3 + k];
        let sum = 270.0 * around(1) - 27.0 * around(2) + 2.0 * around(3) - 490.0 * window[3];
        *value += sum * rate * rate / 180.0;
    }
    acceleration
}
