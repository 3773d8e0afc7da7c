use super::drive::{Shift, forces, start_of, tangents};
use super::{ContactHistory, Family};
use crate::{Model, NoSolution, Parameter, Prior, Transform};
use nalgebra::DMatrix;

/// What is fitted beside the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extras {
    /// Mass that moves with the contact (kg): a known one adds `m·a` to the force.
    pub known_mass: Option<f64>,
    /// Whether the moving mass is wanted.
    pub wanted_mass: bool,
    /// Whether the force may have a constant offset: its largest size (N).
    pub offset: Option<f64>,
}

/// Force predicted from the motion alone, against the force measured.
#[derive(Clone, Debug)]
pub struct ContactModel<'a> {
    family: Family,
    histories: Vec<&'a ContactHistory>,
    parameters: Vec<Parameter>,
    extras: Extras,
    /// `1/s` of each counted sample.
    weights: Vec<Vec<f64>>,
}

/// Deflections at the start of periodic histories, and scratch.
#[derive(Clone, Debug, Default)]
pub struct ContactMemory {
    starts: Vec<f64>,
    force: Vec<f64>,
    slopes: Vec<f64>,
}

impl<'a> ContactModel<'a> {
    /// A model of the histories with weights by their force noise alone; `typical` are values of the law's
    /// parameters around which bounds are laid.
    #[must_use]
    pub fn new(family: Family, histories: Vec<&'a ContactHistory>, typical: &[f64], extras: Extras) -> Self {
        let mut parameters = family.parameters(typical);
        if extras.wanted_mass {
            parameters.push(
                Parameter::positive("moving_mass", "kg", (1e-9, 1e9))
                    .told_by("runs at two accelerations and one speed"),
            );
        }
        if let Some(size) = extras.offset {
            parameters.push(Parameter {
                transform: Transform::Linear { scale: size },
                bounds: (-10.0 * size, 10.0 * size),
                ..Parameter::declared("force_offset", "N", Prior { mean: 0.0, std: size })
            });
        }
        let weights =
            histories.iter().map(|h| vec![1.0 / h.force_std.max(f64::MIN_POSITIVE); h.len()]).collect();
        Self { family, histories, parameters, extras, weights }
    }

    /// The law.
    #[must_use]
    pub fn family(&self) -> Family {
        self.family
    }

    /// The histories.
    #[must_use]
    pub fn histories(&self) -> &[&'a ContactHistory] {
        &self.histories
    }

    pub(super) fn set_weights(&mut self, weights: Vec<Vec<f64>>) {
        self.weights = weights;
    }

    pub(super) fn weights(&self) -> &[Vec<f64>] {
        &self.weights
    }

    fn law_count(&self) -> usize {
        self.family.parameter_names().len()
    }

    /// Force of the moving mass and the offset at a sample.
    fn beside(&self, history: &ContactHistory, values: &[f64], k: usize) -> f64 {
        let law = self.law_count();
        let acceleration = history.acceleration.as_ref().map_or(0.0, |a| a[k]);
        let mass = if self.extras.wanted_mass { values[law] } else { self.extras.known_mass.unwrap_or(0.0) };
        let offset = if self.extras.offset.is_some() { values[values.len() - 1] } else { 0.0 };
        mass * acceleration + offset
    }

    /// Predicted force of one history, with errors of the motion where wanted.
    pub(super) fn predict(&self, index: usize, values: &[f64], shift: Option<&Shift<'_>>, out: &mut [f64]) {
        let history = self.histories[index];
        let law = &values[..self.law_count()];
        let start = start_of(self.family, law, history, 0.0);
        forces((self.family, law), history, (start, shift), out);
        for (k, force) in out.iter_mut().enumerate() {
            *force += self.beside(history, values, k);
        }
        self.centre(history, out);
    }

    /// Moves a prediction to the mean of the measured force where that mean was not seen.
    fn centre(&self, history: &ContactHistory, out: &mut [f64]) {
        if history.mean_is_seen {
            return;
        }
        let counted = history.counted();
        let count = counted.len() as f64;
        let miss: f64 = counted.map(|k| out[k] - history.force[k]).sum::<f64>() / count;
        out.iter_mut().for_each(|force| *force -= miss);
    }

    /// Relative RMS of measured minus predicted force over all histories, means removed where they are unseen.
    #[must_use]
    pub fn relative_error(&self, values: &[f64]) -> f64 {
        let (mut miss, mut size) = (0.0, 0.0);
        for (index, history) in self.histories.iter().enumerate() {
            let mut out = vec![0.0; history.len()];
            self.predict(index, values, None, &mut out);
            for k in history.counted() {
                miss += (out[k] - history.force[k]).powi(2);
                size += history.force[k].powi(2);
            }
        }
        (miss / f64::max(size, f64::MIN_POSITIVE)).sqrt()
    }

    /// Residual of one history in newtons.
    #[must_use]
    pub fn force_residual(&self, index: usize, values: &[f64]) -> Vec<f64> {
        let history = self.histories[index];
        let mut out = vec![0.0; history.len()];
        self.predict(index, values, None, &mut out);
        history.counted().map(|k| out[k] - history.force[k]).collect()
    }
}

impl Model for ContactModel<'_> {
    type Memory = ContactMemory;

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual_count(&self) -> usize {
        self.histories.iter().map(|h| h.counted().len()).sum()
    }

    fn memory(&self) -> ContactMemory {
        ContactMemory { starts: vec![0.0; self.histories.len()], ..ContactMemory::default() }
    }

    fn residual(
        &self,
        values: &[f64],
        memory: &mut ContactMemory,
        residual: &mut [f64],
    ) -> Result<(), NoSolution> {
        let law = &values[..self.law_count()];
        let mut row = 0;
        for (index, history) in self.histories.iter().enumerate() {
            memory.force.resize(history.len(), 0.0);
            let start = start_of(self.family, law, history, memory.starts[index]);
            memory.starts[index] = start;
            forces((self.family, law), history, (start, None), &mut memory.force);
            for (k, force) in memory.force.iter_mut().enumerate() {
                *force += self.beside(history, values, k);
            }
            self.centre(history, &mut memory.force);
            for k in history.counted() {
                residual[row] = (memory.force[k] - history.force[k]) * self.weights[index][k];
                row += 1;
            }
        }
        if residual.iter().all(|r| r.is_finite()) { Ok(()) } else { Err(NoSolution) }
    }

    fn linearise(
        &self,
        values: &[f64],
        _free: &[bool],
        memory: &mut ContactMemory,
        (residual, jacobian): (&mut [f64], &mut DMatrix<f64>),
    ) -> Result<(), NoSolution> {
        self.residual(values, memory, residual)?;
        let count = self.law_count();
        let law = &values[..count];
        let mut row = 0;
        for (index, history) in self.histories.iter().enumerate() {
            memory.force.resize(history.len(), 0.0);
            memory.slopes.resize(history.len() * count, 0.0);
            let target = (&mut memory.force[..], &mut memory.slopes[..]);
            tangents((self.family, law), history, memory.starts[index], target);
            let mean = unseen_means(history, &memory.slopes, count);
            for k in history.counted() {
                let weight = self.weights[index][k];
                for j in 0..count {
                    jacobian[(row, j)] = (memory.slopes[k * count + j] - mean[j]) * weight;
                }
                if self.extras.wanted_mass {
                    jacobian[(row, count)] = history.acceleration.as_ref().map_or(0.0, |a| a[k]) * weight;
                }
                if self.extras.offset.is_some() {
                    jacobian[(row, values.len() - 1)] = if history.mean_is_seen { weight } else { 0.0 };
                }
                row += 1;
            }
        }
        Ok(())
    }
}

/// Means of the slopes over the counted samples where the mean of the force is unseen, else zeros.
fn unseen_means(history: &ContactHistory, slopes: &[f64], count: usize) -> Vec<f64> {
    let mut mean = vec![0.0; count];
    if !history.mean_is_seen {
        let counted = history.counted();
        let share = 1.0 / counted.len().max(1) as f64;
        for k in counted {
            for (m, slope) in mean.iter_mut().zip(&slopes[k * count..]) {
                *m += share * slope;
            }
        }
    }
    mean
}
