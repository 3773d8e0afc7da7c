//! Profile likelihood: χ² re-fitted with one parameter held.

use crate::Model;
use crate::fit::{FitSettings, fit_with_memory};
use crate::identified::Judged;

/// 95 % quantile of χ² with one degree of freedom.
const QUANTILE: f64 = 3.841_458_820_694_124;

/// Interval of the linearised model, in the coordinate; `None` where it is wider than any parameter may be.
pub(crate) fn linear_interval<M: Model>(judged: &Judged<'_, M>, j: usize) -> Option<(f64, f64)> {
    let transform = judged.model.parameters()[j].transform;
    let centre = transform.coordinate(judged.fit.values[j]);
    let half = (QUANTILE * judged.covariance[(j, j)]).sqrt();
    // In the coordinate everything is of order one: a hundred times that is no bound at all.
    (half.is_finite() && half < 100.0).then_some((centre - half, centre + half))
}

/// Interval of the profile likelihood, in the coordinate; `None` where one side does not close within the bounds.
pub(crate) fn interval<M: Model>(judged: &Judged<'_, M>, j: usize) -> Option<(f64, f64)> {
    Some((side(judged, j, -1.0)?, side(judged, j, 1.0)?))
}

/// The end of the interval on one side: a secant on `√Δχ²`, which is linear for a linear model.
fn side<M: Model>(judged: &Judged<'_, M>, j: usize, sign: f64) -> Option<f64> {
    let parameter = &judged.model.parameters()[j];
    let centre = parameter.transform.coordinate(judged.fit.values[j]);
    let (low, high) = parameter.coordinate_bounds();
    let room = if sign < 0.0 { centre - low } else { high - centre };
    let wanted = QUANTILE.sqrt();
    let widest = parameter.widest(centre, judged.settings.widest);
    let mut distance = (QUANTILE * judged.covariance[(j, j)]).sqrt().min(room).min(2.0 * widest);
    let mut walker = Walker { judged, j, values: judged.fit.values.clone(), memory: judged.memory.clone() };
    let (mut inside, mut outside): ((f64, f64), Option<(f64, f64)>) = ((0.0, 0.0), None);
    // A secant on an almost linear function needs two or three; eight bracket any other.
    for _ in 0..8 {
        let height = walker.height(centre + sign * distance)?;
        if (height - wanted).abs() < 0.03 * wanted {
            return Some(centre + sign * distance);
        }
        if height < wanted {
            if distance >= room || distance > 2.0 * widest {
                return None;
            }
            inside = (distance, height);
        } else {
            outside = Some((distance, height));
        }
        distance = next_distance(inside, outside, wanted).min(room);
    }
    // Not met within 3 %: the bracket's outer end is the careful answer.
    outside.map(|(d, _)| centre + sign * d)
}

fn next_distance(inside: (f64, f64), outside: Option<(f64, f64)>, wanted: f64) -> f64 {
    match outside {
        Some(far) => {
            let share = (wanted - inside.1) / (far.1 - inside.1).max(f64::MIN_POSITIVE);
            inside.0 + (far.0 - inside.0) * share.clamp(0.1, 0.9)
        }
        None => inside.0 * (1.1 * wanted / inside.1.max(0.1 * wanted)).min(4.0),
    }
}

/// Re-fits along one parameter, each from the last.
struct Walker<'a, 'b, M: Model> {
    judged: &'a Judged<'b, M>,
    j: usize,
    values: Vec<f64>,
    memory: M::Memory,
}

impl<M: Model> Walker<'_, '_, M> {
    /// `√(Δχ²/inflation)` with the parameter held at `coordinate`; infinite where the model has no solution.
    fn height(&mut self, coordinate: f64) -> Option<f64> {
        let judged = self.judged;
        self.values[self.j] = judged.model.parameters()[self.j].transform.value(coordinate);
        self.foresee(coordinate);
        let mut free = judged.fit.free.clone();
        free[self.j] = false;
        let settings = FitSettings { free, absolute_tolerance: 0.03, ..judged.settings.fit.clone() };
        let cost = if settings.free.iter().any(|f| *f) {
            let fit = fit_with_memory(judged.model, &self.values, &settings, &mut self.memory);
            let Ok(fit) = fit else { return Some(f64::INFINITY) };
            self.values = fit.values;
            fit.cost
        } else {
            let mut residual = vec![0.0; judged.model.residual_count()];
            judged.model.residual(&self.values, &mut self.memory, &mut residual).ok()?;
            residual.iter().map(|r| r * r).sum()
        };
        Some(((cost - judged.fit.cost).max(0.0) / judged.statistics.inflation).sqrt())
    }

    /// Moves the other parameters where the linear model would have them.
    fn foresee(&mut self, coordinate: f64) {
        let (judged, j) = (self.judged, self.j);
        let variance = judged.covariance[(j, j)];
        let fitted = judged.model.parameters()[j].transform.coordinate(judged.fit.values[j]);
        for (i, parameter) in judged.model.parameters().iter().enumerate() {
            if i == j || !judged.fit.free[i] || variance <= 0.0 {
                continue;
            }
            let shift = (coordinate - fitted) * judged.covariance[(i, j)] / variance;
            let (low, high) = parameter.coordinate_bounds();
            let c = parameter.transform.coordinate(judged.fit.values[i]);
            self.values[i] = parameter.transform.value((c + shift).clamp(low, high));
        }
    }
}
