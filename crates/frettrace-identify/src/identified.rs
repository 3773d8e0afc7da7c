use crate::fit::{Fit, FitSettings, Status, stacked};
use crate::{Identifiability, IdentifiedParameter, IdentifyError, Model, NoSolution, Parameter, profile};
use nalgebra::DMatrix;

/// Half of a 95 % interval of a normal quantity, in its standard deviations.
pub const HALF_INTERVAL95: f64 = 1.96;

/// How a fit is judged.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifySettings {
    /// Settings of the re-fits along profiles.
    pub fit: FitSettings,
    /// Which parameters get a profile-likelihood interval; empty means all. Others get the linear one.
    pub profiled: Vec<bool>,
    /// Widest half interval that still counts as identified, relative to the value: 0.35 is about a sixth of the
    /// value as standard deviation.
    pub widest: f64,
    /// Effective number of independent residuals, where neighbours are correlated; `None`: all are independent.
    pub effective_count: Option<f64>,
}

impl Default for IdentifySettings {
    fn default() -> Self {
        Self { fit: FitSettings::default(), profiled: Vec::new(), widest: 0.35, effective_count: None }
    }
}

/// What is left after the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualStatistics {
    /// χ² of the data.
    pub chi_squared: f64,
    /// Residuals.
    pub count: usize,
    /// Effective number of independent residuals.
    pub effective_count: f64,
    /// Parameters the data (with priors) determine: rank of the column-scaled Jacobian.
    pub rank: usize,
    /// Condition number of the column-scaled Jacobian.
    pub condition: f64,
    /// Factor on the covariance: what χ² per degree of freedom exceeds 1, and the correlation of the residuals.
    pub inflation: f64,
}

/// A model with its identified parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// All parameters in the order of the model.
    pub parameters: Vec<IdentifiedParameter>,
    /// Covariance of the free coordinates (logarithms, scaled values), inflated; zero rows for fixed ones.
    pub covariance: DMatrix<f64>,
    /// Outcome of the minimisation.
    pub status: Status,
    /// Residual statistics.
    pub statistics: ResidualStatistics,
}

impl Identified {
    /// Physical values.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// The parameter of that name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&IdentifiedParameter> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// Adds a covariance of the coordinates (all parameters, in their order) and widens the intervals with it.
    pub(crate) fn add_covariance(&mut self, added: &DMatrix<f64>, described: &[Parameter]) {
        for (j, parameter) in self.parameters.iter_mut().enumerate() {
            let before = self.covariance[(j, j)];
            if before > 0.0 {
                parameter.stretch((1.0 + added[(j, j)] / before).sqrt(), &described[j]);
            }
        }
        self.covariance += added;
    }

    /// Moves the coordinate of a parameter, and its interval with it, within its bounds.
    pub(crate) fn move_by(&mut self, j: usize, shift: f64, described: &Parameter) {
        let transform = described.transform;
        let (low, high) = described.coordinate_bounds();
        let moved = |value: f64| transform.value((transform.coordinate(value) + shift).clamp(low, high));
        let parameter = &mut self.parameters[j];
        parameter.value = moved(parameter.value);
        parameter.interval95 = parameter.interval95.map(|(a, b)| (moved(a), moved(b)));
    }

    /// Judges the intervals anew once all that is not known has widened them: a parameter whose interval is wider than
    /// `widest` (as in [`IdentifySettings`]) is not identifiable, and has none.
    pub fn settle(&mut self, described: &[Parameter], widest: f64) {
        for (parameter, described) in self.parameters.iter_mut().zip(described) {
            let transform = described.transform;
            let Some((low, high)) = parameter.interval95.filter(|_| parameter.is_identifiable()) else {
                continue;
            };
            let width = transform.coordinate(high) - transform.coordinate(low);
            let known = 2.0 * described.widest(transform.coordinate(parameter.value), widest);
            if width > known || width.is_nan() {
                parameter.loosen((low, high), &described.experiment);
            }
        }
    }

    /// Takes all intervals back: a model that does not describe the data has no parameters to know.
    pub fn withhold(&mut self, reason: &str, experiment: &str) {
        self.withhold_those(|_| true, reason, experiment);
    }

    /// Takes the intervals of some parameters back.
    pub fn withhold_those(&mut self, these: impl Fn(&str) -> bool, reason: &str, experiment: &str) {
        for parameter in self.parameters.iter_mut().filter(|p| p.is_bounded() && these(&p.name)) {
            parameter.std = None;
            parameter.interval95 = None;
            parameter.identifiability = Identifiability::NotIdentifiable {
                bounded: false,
                reason: reason.to_owned(),
                experiment: experiment.to_owned(),
            };
        }
    }

    /// The sum of two parameters as one, with the interval their covariance gives, which may be narrow where those of the
    /// two are wide; not identifiable where it is wider than `widest` of its value, or the data do not bound both.
    #[must_use]
    pub fn sum(
        &self,
        (first, second): (usize, usize),
        described: &[Parameter],
        widest: f64,
    ) -> IdentifiedParameter {
        let (a, b) = (&self.parameters[first], &self.parameters[second]);
        let slope = |j: usize| described[j].transform.slope(self.parameters[j].value);
        let (sa, sb) = (slope(first), slope(second));
        let variance = sa * sa * self.covariance[(first, first)]
            + sb * sb * self.covariance[(second, second)]
            + 2.0 * sa * sb * self.covariance[(first, second)];
        let value = a.value + b.value;
        let unknown = [a, b].into_iter().find(|p| !p.is_bounded());
        let std = (unknown.is_none() && variance.is_finite()).then(|| variance.max(0.0).sqrt());
        let mut sum = IdentifiedParameter {
            name: format!("{} + {}", a.name, b.name),
            unit: a.unit.clone(),
            value,
            std,
            interval95: std.map(|s| (value - HALF_INTERVAL95 * s, value + HALF_INTERVAL95 * s)),
            identifiability: unknown.map_or(Identifiability::Identifiable, |p| p.identifiability.clone()),
        };
        if let Some((low, high)) =
            sum.interval95.filter(|(low, high)| high - low > 2.0 * widest * value.abs())
        {
            sum.loosen((low, high), &described[second].experiment);
        }
        sum
    }

    /// Widens intervals where a covariance that knows more of the noise is larger than that of the fit.
    ///
    /// `covariance` is that of the free coordinates, in their order.
    pub(crate) fn widen(&mut self, covariance: &DMatrix<f64>, described: &[Parameter]) {
        let mut k = 0;
        for (j, parameter) in self.parameters.iter_mut().enumerate() {
            if parameter.identifiability == Identifiability::Fixed {
                continue;
            }
            let ratio = (covariance[(k, k)] / self.covariance[(j, j)]).sqrt();
            k += 1;
            if ratio > 1.0 {
                parameter.stretch(ratio, &described[j]);
            }
        }
    }

    /// Bayesian information criterion `χ²·n_eff/n + k ln n_eff` with the effective sample size.
    #[must_use]
    pub fn information_criterion(&self) -> f64 {
        let s = &self.statistics;
        s.chi_squared * s.effective_count / s.count as f64 + s.rank as f64 * s.effective_count.ln()
    }
}

/// Judges a fit: covariance, rank, profile-likelihood intervals, identifiability.
///
/// The interval of a parameter is where the re-fitted χ² stays within 3.84 (times the inflation) of its minimum. A
/// parameter whose profile does not close within its bounds, or closes wider than `settings.widest`, is not
/// identifiable and gets no interval.
///
/// # Errors
/// [`IdentifyError::NoStart`] where the model has no solution at the fitted values.
pub fn identify<M: Model>(
    model: &M,
    fit: &Fit,
    settings: &IdentifySettings,
) -> Result<Identified, IdentifyError> {
    let judged =
        Judged::new(model, fit, settings).map_err(|NoSolution| IdentifyError::NoStart { starts: 1 })?;
    let count = fit.values.len();
    let profiled = |j: usize| settings.profiled.get(j).copied().unwrap_or(settings.profiled.is_empty());
    let parameters = (0..count)
        .map(|j| {
            let ends = fit.free[j].then(|| {
                let linear = profile::linear_interval(&judged, j);
                if profiled(j) && linear.is_some() { profile::interval(&judged, j) } else { linear }
            });
            judged.parameter(j, ends.flatten(), settings.widest)
        })
        .collect();
    Ok(Identified {
        parameters,
        covariance: judged.covariance.clone(),
        status: fit.status,
        statistics: judged.statistics,
    })
}

/// A fit with its curvature.
pub(crate) struct Judged<'a, M: Model> {
    pub(crate) model: &'a M,
    pub(crate) fit: &'a Fit,
    pub(crate) settings: &'a IdentifySettings,
    pub(crate) memory: M::Memory,
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) statistics: ResidualStatistics,
}

impl<'a, M: Model> Judged<'a, M> {
    fn new(model: &'a M, fit: &'a Fit, settings: &'a IdentifySettings) -> Result<Self, NoSolution> {
        let mut memory = model.memory();
        let count = model.residual_count();
        let mut residual = vec![0.0; count];
        let mut jacobian = DMatrix::zeros(count, fit.values.len());
        model.linearise(&fit.values, &fit.free, &mut memory, (&mut residual, &mut jacobian))?;
        let (stacked, _) = stacked(model, &fit.values, &fit.free, (&jacobian, &residual));
        // A decomposition of what is not finite never ends.
        if stacked.iter().any(|value| !value.is_finite()) {
            return Err(NoSolution);
        }
        let curvature = Curvature::new(stacked);
        let effective_count = settings.effective_count.unwrap_or(count as f64).min(count as f64);
        let freedom = (count as f64 - curvature.rank as f64).max(1.0);
        let inflation = (fit.data_cost / freedom).max(1.0) * count as f64 / effective_count;
        let mut covariance = DMatrix::zeros(fit.values.len(), fit.values.len());
        let columns: Vec<usize> = (0..fit.free.len()).filter(|j| fit.free[*j]).collect();
        for (a, i) in columns.iter().enumerate() {
            for (b, j) in columns.iter().enumerate() {
                covariance[(*i, *j)] = inflation * curvature.inverse[(a, b)];
            }
        }
        let statistics = ResidualStatistics {
            chi_squared: fit.data_cost,
            count,
            effective_count,
            rank: curvature.rank,
            condition: curvature.condition,
            inflation,
        };
        Ok(Self { model, fit, settings, memory, covariance, statistics })
    }

    fn parameter(&self, j: usize, ends: Option<(f64, f64)>, widest: f64) -> IdentifiedParameter {
        let parameter = &self.model.parameters()[j];
        let value = self.fit.values[j];
        let transform = parameter.transform;
        let named = |std, interval95, identifiability| IdentifiedParameter {
            name: parameter.name.clone(),
            unit: parameter.unit.clone(),
            value,
            std,
            interval95,
            identifiability,
        };
        let not = |reason: &str| Identifiability::NotIdentifiable {
            bounded: false,
            reason: reason.to_owned(),
            experiment: parameter.experiment.clone(),
        };
        if !self.fit.free[j] {
            return named(None, None, Identifiability::Fixed);
        }
        if self.fit.at_bound[j] {
            return named(None, None, not("the estimate lies on the bound of its range"));
        }
        let Some((low, high)) = ends else {
            return named(
                None,
                None,
                not("the data do not bound it: other parameters make up for any change"),
            );
        };
        let std = self.covariance[(j, j)].sqrt() * transform.slope(value).abs();
        let interval = (transform.value(low), transform.value(high));
        let mut found = named(Some(std), Some(interval), Identifiability::Identifiable);
        if high - low > 2.0 * parameter.widest(transform.coordinate(value), widest) {
            found.loosen(interval, &parameter.experiment);
        }
        found
    }
}

/// `(JᵀJ)⁻¹`, rank and condition by the singular values of the column-scaled Jacobian.
struct Curvature {
    inverse: DMatrix<f64>,
    rank: usize,
    condition: f64,
}

impl Curvature {
    fn new(jacobian: DMatrix<f64>) -> Self {
        let scale: Vec<f64> = jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        let mut triangle = jacobian.qr().r();
        for (mut column, s) in triangle.column_iter_mut().zip(&scale) {
            column /= *s;
        }
        let decomposition = triangle.svd(false, true);
        let largest = decomposition.singular_values.max();
        // Rounding of a product of hundreds of steps: a direction this weak is none.
        let floor = 1e-9 * largest;
        let rank = decomposition.singular_values.iter().filter(|s| **s > floor).count();
        let smallest = decomposition.singular_values.min();
        let n = scale.len();
        let mut inverse = DMatrix::zeros(n, n);
        if let Some(directions) = &decomposition.v_t {
            for (k, s) in decomposition.singular_values.iter().enumerate() {
                let direction = directions.row(k);
                inverse += direction.transpose() * direction / s.max(1e-3 * floor).powi(2);
            }
        }
        for i in 0..n {
            for j in 0..n {
                inverse[(i, j)] /= scale[i] * scale[j];
            }
        }
        Self { inverse, rank, condition: largest / smallest.max(f64::MIN_POSITIVE) }
    }
}
