use super::{Fit, Status, step::Linearised};
use crate::{IdentifyError, Model, Transform};
use nalgebra::{DMatrix, DVector};

/// Where the fit stands, and the step it tries.
pub(super) struct State<'a, M: Model> {
    model: &'a M,
    free: Vec<bool>,
    bounds: Vec<(f64, f64)>,
    coordinates: Vec<f64>,
    residual: Vec<f64>,
    pub(super) cost: f64,
    memory: M::Memory,
    jacobian: DMatrix<f64>,
    trial: Trial<M::Memory>,
}

struct Trial<T> {
    coordinates: Vec<f64>,
    values: Vec<f64>,
    residual: Vec<f64>,
    cost: f64,
    memory: T,
}

impl<'a, M: Model> State<'a, M> {
    pub(super) fn new(
        model: &'a M,
        start: &[f64],
        free: Vec<bool>,
        memory: &M::Memory,
    ) -> Result<Self, IdentifyError> {
        let parameters = model.parameters();
        let count = model.residual_count();
        let free_count = free.iter().filter(|f| **f).count();
        if start.len() != parameters.len() {
            return Err(IdentifyError::StartLength { expected: parameters.len(), found: start.len() });
        }
        if count == 0 || free_count == 0 {
            return Err(IdentifyError::Empty { parameters: free_count, residuals: count });
        }
        let bounds: Vec<_> = parameters.iter().map(crate::Parameter::coordinate_bounds).collect();
        let mut coordinates = Vec::with_capacity(start.len());
        for ((parameter, value), (low, high)) in parameters.iter().zip(start).zip(&bounds) {
            let positive = parameter.transform != Transform::Log || *value > 0.0;
            if !value.is_finite() || !positive {
                return Err(IdentifyError::StartValue { name: parameter.name.clone(), value: *value });
            }
            coordinates.push(parameter.transform.coordinate(*value).clamp(*low, *high));
        }
        let trial = Trial {
            coordinates,
            values: start.to_vec(),
            residual: vec![0.0; count],
            cost: 0.0,
            memory: memory.clone(),
        };
        let mut state = Self {
            model,
            free,
            bounds,
            coordinates: trial.coordinates.clone(),
            residual: vec![0.0; count],
            cost: f64::INFINITY,
            memory: memory.clone(),
            jacobian: DMatrix::zeros(count, start.len()),
            trial,
        };
        state.attempt(&vec![0.0; start.len()]).ok_or(IdentifyError::NoStart { starts: 1 })?;
        state.accept();
        Ok(state)
    }

    fn values(&self, coordinates: &[f64]) -> Vec<f64> {
        self.model.parameters().iter().zip(coordinates).map(|(p, c)| p.transform.value(*c)).collect()
    }

    /// χ² after a step of the coordinates, cut at the bounds; `None` where the model has no solution.
    pub(super) fn attempt(&mut self, step: &[f64]) -> Option<f64> {
        let trial = &mut self.trial;
        for (j, (low, high)) in self.bounds.iter().enumerate() {
            trial.coordinates[j] = (self.coordinates[j] + step[j]).clamp(*low, *high);
            trial.values[j] = self.model.parameters()[j].transform.value(trial.coordinates[j]);
        }
        trial.memory.clone_from(&self.memory);
        self.model.residual(&trial.values, &mut trial.memory, &mut trial.residual).ok()?;
        trial.cost = trial.residual.iter().map(|r| r * r).sum::<f64>();
        for (parameter, c) in self.model.parameters().iter().zip(&trial.coordinates) {
            trial.cost += parameter.prior_residual(*c).map_or(0.0, |(r, _)| r * r);
        }
        trial.cost.is_finite().then_some(trial.cost)
    }

    /// Goes where the last attempt was; the attempt's place becomes the one that was left.
    pub(super) fn accept(&mut self) {
        std::mem::swap(&mut self.coordinates, &mut self.trial.coordinates);
        std::mem::swap(&mut self.residual, &mut self.trial.residual);
        self.cost = self.trial.cost;
        std::mem::swap(&mut self.memory, &mut self.trial.memory);
    }

    /// Linear least-squares problem of the free parameters in their coordinates.
    pub(super) fn linearise(&mut self) -> Option<Linearised> {
        let values = self.values(&self.coordinates);
        let target = (&mut self.residual[..], &mut self.jacobian);
        self.model.linearise(&values, &self.free, &mut self.memory, target).ok()?;
        self.stacked(&values)
    }

    /// The same right after a step, from what the step has shown: of all matrices that explain it the one nearest to the last,
    /// `J + (Δr − J δ) δᵀ/δᵀδ` in the coordinates (Broyden 1965).
    pub(super) fn updated(&mut self) -> Option<Linearised> {
        let (old, new) = (self.values(&self.trial.coordinates), self.values(&self.coordinates));
        let slope = |values: &[f64], j: usize| self.model.parameters()[j].transform.slope(values[j]);
        let step: Vec<f64> =
            self.coordinates.iter().zip(&self.trial.coordinates).map(|(new, old)| new - old).collect();
        let length: f64 = step.iter().map(|d| d * d).sum();
        let mut left = DVector::from_iterator(
            self.residual.len(),
            self.residual.iter().zip(&self.trial.residual).map(|(new, old)| new - old),
        );
        for j in (0..step.len()).filter(|&j| self.free[j]) {
            left.axpy(-step[j] * slope(&old, j), &self.jacobian.column(j), 1.0);
        }
        for j in (0..step.len()).filter(|&j| self.free[j]) {
            let mut column = self.jacobian.column_mut(j);
            column *= slope(&old, j) / slope(&new, j);
            column.axpy(step[j] / (length * slope(&new, j)), &left, 1.0);
        }
        self.stacked(&new)
    }

    fn stacked(&self, values: &[f64]) -> Option<Linearised> {
        let (jacobian, right) = stacked(self.model, values, &self.free, (&self.jacobian, &self.residual));
        if jacobian.iter().chain(right.iter()).any(|x| !x.is_finite()) {
            return None;
        }
        let columns: Vec<usize> = (0..self.free.len()).filter(|j| self.free[*j]).collect();
        let room = columns
            .iter()
            .map(|j| {
                let longest = self.model.parameters()[*j].transform.longest_step();
                let (low, high) = self.bounds[*j];
                (low - self.coordinates[*j], high - self.coordinates[*j], longest)
            })
            .collect();
        Some(Linearised::new(jacobian, right, (columns, self.free.len(), room)))
    }

    pub(super) fn finish(&self, iterations: usize, status: Status) -> Fit {
        let at_bound =
            self.coordinates.iter().zip(&self.bounds).map(|(c, (low, high))| c <= low || c >= high).collect();
        Fit {
            values: self.values(&self.coordinates),
            cost: self.cost,
            data_cost: self.residual.iter().map(|r| r * r).sum(),
            iterations,
            status,
            free: self.free.clone(),
            at_bound,
        }
    }

    pub(super) fn hand_back(self, memory: &mut M::Memory) {
        *memory = self.memory;
    }
}

/// Jacobian of the free coordinates and residual, with the rows of the priors below.
pub(crate) fn stacked<M: Model>(
    model: &M,
    values: &[f64],
    free: &[bool],
    (jacobian, residual): (&DMatrix<f64>, &[f64]),
) -> (DMatrix<f64>, DVector<f64>) {
    let columns: Vec<usize> = (0..free.len()).filter(|j| free[*j]).collect();
    let priors = columns.iter().filter(|j| model.parameters()[**j].prior.is_some()).count();
    let data = residual.len();
    let mut matrix = DMatrix::zeros(data + priors, columns.len());
    let mut right = DVector::zeros(data + priors);
    right.rows_mut(0, data).copy_from_slice(residual);
    let mut row = data;
    for (k, j) in columns.iter().enumerate() {
        let parameter = &model.parameters()[*j];
        let slope = parameter.transform.slope(values[*j]);
        matrix.view_mut((0, k), (data, 1)).copy_from(&(jacobian.column(*j) * slope));
        if let Some((value, derivative)) =
            parameter.prior_residual(parameter.transform.coordinate(values[*j]))
        {
            matrix[(row, k)] = derivative;
            right[row] = value;
            row += 1;
        }
    }
    (matrix, right)
}
