//! What is wrong with the channels, found from the samples and from the balance.

use crate::balance::{LineBalance, LineData};
use crate::calibration::Equations;
use crate::contact::Setting;
use crate::dynamics::{LineReceptances, Load};
use crate::{Rig, RunData, RunLines};
use frettrace_beam::{Dof, Freedom};
use num_complex::Complex64;

/// What a person should look at before trusting the result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Finding {
    /// A sensor that does not move although its neighbours do.
    DeadSensor {
        /// Index of the sensor.
        sensor: usize,
    },
    /// A sensor whose extreme values repeat: its range is too small.
    ClippedSensor {
        /// Index of the sensor.
        sensor: usize,
        /// Name of the run.
        run: String,
    },
    /// Two sensors with the same samples.
    DuplicatedSensors {
        /// Their indices.
        sensors: [usize; 2],
    },
    /// Two sensors that fit the beam only when exchanged.
    SwappedSensors {
        /// Their indices.
        sensors: [usize; 2],
    },
    /// One sensor alone contradicts the others; with this gain on it the balance closes.
    SensorGain {
        /// Index of the sensor.
        sensor: usize,
        /// Measured over true; 0.102 means that it is in units of g.
        gain: f64,
    },
    /// All sensors contradict the force alike; with this gain on all of them the balance closes.
    CommonGain {
        /// Measured over what the force makes; 0.102 means that all are in units of g.
        gain: f64,
    },
    /// A sensor at a node of a measured mode: it says nothing of it.
    SensorAtNode {
        /// Index of the sensor.
        sensor: usize,
        /// The mode, from 0.
        mode: usize,
    },
    /// A single run: friction's own stiffness and an error of a natural frequency may be confused.
    SingleRun,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::DeadSensor { sensor } => write!(out, "sensor {sensor} is dead: check its cable"),
            Self::ClippedSensor { sensor, run } => {
                write!(out, "sensor {sensor} is clipped in run {run}: widen its range")
            }
            Self::DuplicatedSensors { sensors: [a, b] } => {
                write!(out, "sensors {a} and {b} have the same samples: one channel was recorded twice")
            }
            Self::SwappedSensors { sensors: [a, b] } => {
                write!(out, "sensors {a} and {b} fit the beam only when exchanged: check the cables")
            }
            Self::SensorGain { sensor, gain } => {
                write!(
                    out,
                    "sensor {sensor} reads {gain:.4} of what the others imply: check its calibration or unit"
                )
            }
            Self::CommonGain { gain } => {
                write!(
                    out,
                    "all sensors read {gain:.4} of what the force makes: check the unit of the accelerations and of the force"
                )
            }
            Self::SensorAtNode { sensor, mode } => {
                write!(out, "sensor {sensor} sits at a node of mode {}: it says nothing of it", mode + 1)
            }
            Self::SingleRun => {
                write!(
                    out,
                    "one run only: a stiff contact and a natural frequency that is off may be confused"
                )
            }
        }
    }
}

impl Finding {
    /// Whether other findings say why: a channel that is clipped, or another one's copy, has the wrong gain too.
    pub(crate) fn follows(&self, from: &[Self]) -> bool {
        let Self::SensorGain { sensor, .. } = self else { return false };
        from.iter().any(|other| match other {
            Self::ClippedSensor { sensor: clipped, .. } => clipped == sensor,
            Self::DuplicatedSensors { sensors } => sensors.contains(sensor),
            _ => false,
        })
    }
}

/// Share of the largest level below which a sensor is dead: nodes of the motion leave more.
const DEAD: f64 = 1e-5;
/// Share of samples at the extreme value from which a channel is clipped.
const CLIPPED: f64 = 0.01;
/// Share of a mode's largest value at the sensors below which a sensor is at its node.
const NODE: f64 = 0.01;
/// Reduced chi-square of the balance from which a sensor is suspected, and the share that may be left without the fault.
const CONSPICUOUS: f64 = 20.0;
const LEFT: f64 = 0.02;
/// A unit that is taken for another is off by this factor at least, and by no phase: the imaginary share that noise may leave.
const UNIT: f64 = 2.0;
const PHASE: f64 = 0.05;
/// Lines that are looked at: the strongest ones stand first.
const LINES: usize = 3;

/// Findings from the samples alone and from the declared positions.
pub(crate) fn of_channels(rig: &Rig, runs: &[RunData<'_>]) -> Vec<Finding> {
    let mut found = Vec::new();
    if runs.len() == 1 {
        found.push(Finding::SingleRun);
    }
    let ranges: Vec<Vec<Range>> = (0..rig.sensors.len())
        .map(|s| runs.iter().map(|run| Range::of(run.accelerations[s])).collect())
        .collect();
    let levels: Vec<f64> =
        ranges.iter().map(|runs| runs.iter().map(Range::span).fold(0.0, f64::max)).collect();
    let loudest = levels.iter().copied().fold(0.0, f64::max);
    for (sensor, level) in levels.iter().enumerate() {
        if *level <= DEAD * loudest {
            found.push(Finding::DeadSensor { sensor });
        } else if let Some((run, _)) =
            runs.iter().zip(&ranges[sensor]).find(|(run, range)| range.is_clipping(run.accelerations[sensor]))
        {
            found.push(Finding::ClippedSensor { sensor, run: run.id.to_owned() });
        }
        let twin = (0..sensor).find(|other| {
            *level > 0.0 && runs.iter().all(|run| run.accelerations[*other] == run.accelerations[sensor])
        });
        found.extend(twin.map(|other| Finding::DuplicatedSensors { sensors: [other, sensor] }));
    }
    found.extend(nodes(rig));
    found
}

/// Extreme values of a channel.
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// Values side by side: one after the other each comparison would wait for the one before.
    const LANES: usize = 8;

    fn of(x: &[f64]) -> Self {
        let (blocks, others) = x.as_chunks::<{ Self::LANES }>();
        let (mut low, mut high) = ([f64::INFINITY; Self::LANES], [f64::NEG_INFINITY; Self::LANES]);
        for block in blocks {
            low.iter_mut().zip(block).for_each(|(low, v)| *low = low.min(*v));
            high.iter_mut().zip(block).for_each(|(high, v)| *high = high.max(*v));
        }
        let others = || others.iter().copied();
        Self {
            low: low.into_iter().chain(others()).fold(f64::INFINITY, f64::min),
            high: high.into_iter().chain(others()).fold(f64::NEG_INFINITY, f64::max),
        }
    }

    fn span(&self) -> f64 {
        self.high - self.low
    }

    /// Whether the extreme values of a channel repeat.
    fn is_clipping(&self, x: &[f64]) -> bool {
        let at = |limit: f64| x.iter().filter(|v| **v == limit).count() as f64;
        self.low < self.high && at(self.high).max(at(self.low)) > (CLIPPED * x.len() as f64).max(3.0)
    }
}

fn nodes(rig: &Rig) -> Vec<Finding> {
    let shapes = rig.structure.shapes();
    let at = |mode: usize, sensor: usize| {
        let position = rig.sensors[sensor].position;
        shapes[mode].at(Dof { position, freedom: Freedom::Displacement }).abs()
    };
    let sensors = 0..rig.sensors.len();
    (0..rig.trust.len().min(shapes.len()))
        .flat_map(|mode| {
            let largest = sensors.clone().map(|s| at(mode, s)).fold(0.0, f64::max);
            sensors
                .clone()
                .filter(move |s| at(mode, *s) < NODE * largest)
                .map(move |sensor| Finding::SensorAtNode { sensor, mode })
        })
        .collect()
}

/// Findings from the balance of one run: exchanged sensors, or one sensor's gain.
pub(crate) fn of_balance(setting: &Setting<'_>, run: &Equations<'_>) -> Option<Finding> {
    let sensors = run.lines.accelerations.len();
    if sensors < run.loads.len() + 2 {
        return None;
    }
    let before = reduced(setting, run, run.lines);
    if before < CONSPICUOUS {
        return None;
    }
    let exchanged = (0..sensors)
        .flat_map(|b| (0..b).map(move |a| [a, b]))
        .map(|pair| {
            let mut lines = run.lines.clone();
            lines.accelerations.swap(pair[0], pair[1]);
            (pair, reduced(setting, run, &lines))
        })
        .min_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((sensors, after)) = exchanged
        && after < LEFT * before
    {
        return Some(Finding::SwappedSensors { sensors });
    }
    let (sensor, after) = (0..sensors)
        .map(|sensor| (sensor, reduced(setting, run, &without(run.lines, sensor))))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    if after < LEFT * before {
        return Some(Finding::SensorGain { sensor, gain: gain(setting, run, sensor)? });
    }
    common_gain(setting, run, before)
}

/// A gain `g` on all sensors, `a = g (H_e F_e + H_u f_u)`: with the exciter's force as one more unknown the balance closes, and that force is
/// `g F_e`. It is told on the line where the force is strongest.
fn common_gain(setting: &Setting<'_>, run: &Equations<'_>, before: f64) -> Option<Finding> {
    let mut lines = run.lines.clone();
    lines.force.coefficients.fill(Complex64::ZERO);
    let loads = run.loads.iter().copied().chain([Load::Exciter]).collect();
    let freed = run.with_loads(loads);
    if reduced(setting, &freed, &lines) >= LEFT * before {
        return None;
    }
    let gains = balances(setting, &freed, &lines).into_iter().filter_map(|(line, balance)| {
        let measured = run.lines.force.coefficients[(line.omega() / lines.force.base).round() as usize];
        Some((measured.norm(), balance.forces.last()? / measured))
    });
    let (_, gain) = gains.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let is_unit = !(UNIT.recip()..UNIT).contains(&gain.re) && gain.im.abs() < PHASE * gain.re;
    is_unit.then_some(Finding::CommonGain { gain: gain.re })
}

/// The lines with one sensor's weight taken away.
fn without(lines: &RunLines, sensor: usize) -> RunLines {
    let mut lines = lines.clone();
    lines.accelerations[sensor].variance.fill(f64::INFINITY);
    lines
}

/// Reduced chi-square of the strongest lines.
fn reduced(setting: &Setting<'_>, run: &Equations<'_>, lines: &RunLines) -> f64 {
    let (mut chi, mut freedom) = (0.0, 0);
    for balance in balances(setting, run, lines) {
        chi += balance.1.chi_square();
        freedom += balance.1.freedom();
    }
    chi / freedom.max(1) as f64
}

fn balances(
    setting: &Setting<'_>,
    run: &Equations<'_>,
    lines: &RunLines,
) -> Vec<(LineReceptances, LineBalance)> {
    let mut strength: Vec<(usize, f64)> = (1..=run.order())
        .map(|h| (h, lines.accelerations.iter().map(|a| a.coefficients[h].norm_sqr()).sum()))
        .collect();
    strength.sort_by(|a, b| b.1.total_cmp(&a.1));
    let free = vec![f64::INFINITY; run.loads.len()];
    strength
        .iter()
        .take(LINES)
        .map(|(h, _)| {
            let mut line = LineReceptances::default();
            setting.dynamics.fill_upon(&setting.structure.model, run.fixed, *h, &mut line);
            let balance = LineBalance::solve(&line, &LineData::of(lines, *h), &run.loads, &free);
            (line, balance)
        })
        .collect()
}

/// Measured over predicted acceleration of a sensor on the strongest line, predicted from the other sensors.
fn gain(setting: &Setting<'_>, run: &Equations<'_>, sensor: usize) -> Option<f64> {
    let lines = without(run.lines, sensor);
    let (line, balance) = balances(setting, run, &lines).into_iter().next()?;
    let h = (line.omega() / lines.force.base).round() as usize;
    let mut predicted = line.acceleration(sensor, Load::Exciter) * run.lines.force.coefficients[h];
    for (load, force) in run.loads.iter().zip(&balance.forces) {
        predicted += line.acceleration(sensor, *load) * force;
    }
    let measured = run.lines.accelerations[sensor].coefficients[h];
    Some((measured / predicted).re)
}
