//! A further force on the structure, found without its law: where it acts, and what it answers to.

use crate::balance_fit::BalanceCandidate;
use crate::effects::{ALL, FREE, StructureForm};
use crate::{Study, Unknown, signed};
use frettrace_forward::accelerations::{FreeForce, Port, PortLaw, PortPlace, Quantity, Setting};
use frettrace_fourier::Grid;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use rayon::prelude::*;

/// Where a further force acts best, and what is left with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Located {
    pub place: PortPlace,
    /// χ² over its degrees of freedom, with any force there.
    pub reduced: f64,
}

/// Places tried along the beam before the best is refined.
const PLACES: usize = 48;
/// Samples of a period on which laws of the force are tried.
const SAMPLES: usize = 256;
/// Lines of the force that are used.
const LINES: usize = 32;

impl Study<'_> {
    fn reduced_at(&self, setting: &Setting, place: PortPlace) -> f64 {
        let setting = with_only(setting, place);
        self.model.free_force(&setting, &self.training).map_or(f64::INFINITY, |found| {
            let sum =
                found.iter().fold((0.0, 0), |sum, f| (sum.0 + f.chi_squared.0, sum.1 + f.chi_squared.1));
            sum.0 / sum.1.max(1) as f64
        })
    }

    /// The places of a further force, best first: along the beam, at the support, on one of the first modes.
    pub(crate) fn locate(&self, setting: &Setting) -> Vec<Located> {
        if self.case.rig.sensors.len() < 3 {
            return Vec::new();
        }
        let length = self.scales.length;
        let mut places: Vec<PortPlace> =
            (1..PLACES).map(|k| PortPlace::At(length * k as f64 / PLACES as f64)).collect();
        places.push(PortPlace::Support);
        places.extend((0..setting.frequency.len().min(3)).map(PortPlace::Mode));
        let mut found: Vec<Located> = places
            .par_iter()
            .map(|&place| Located { place, reduced: self.reduced_at(setting, place) })
            .collect();
        found.sort_by(|a, b| a.reduced.total_cmp(&b.reduced));
        if let Some(best) = found.iter().position(|l| matches!(l.place, PortPlace::At(_))) {
            found[best] = self.refine(setting, found[best]);
        }
        found.sort_by(|a, b| a.reduced.total_cmp(&b.reduced));
        found
    }

    /// Golden section around a place.
    fn refine(&self, setting: &Setting, start: Located) -> Located {
        let PortPlace::At(centre) = start.place else { return start };
        let step = self.scales.length / PLACES as f64;
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut low, mut high) = (centre - step, centre + step);
        for _ in 0..14 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if self.reduced_at(setting, PortPlace::At(a)) < self.reduced_at(setting, PortPlace::At(b)) {
                high = b;
            } else {
                low = a;
            }
        }
        let place = PortPlace::At(0.5 * (low + high));
        Located { place, reduced: self.reduced_at(setting, place) }
    }

    /// Forms of a further force where one closes the balance far better than `best`, as candidates of equal standing.
    pub(crate) fn force_candidates(&self, setting: &Setting, best: f64) -> Vec<BalanceCandidate> {
        let located = self.locate(setting);
        let Some(first) = located.first().filter(|l| l.reduced < 0.3 * best) else { return Vec::new() };
        let count = self.residual_count() as f64;
        let near = located.iter().filter(|l| l.reduced < 1.3 * first.reduced).take(2);
        near.flat_map(|place| {
            self.force_forms(setting, place).into_iter().map(|(id, form)| BalanceCandidate {
                effect: ALL.iter().position(|e| e.id() == id).unwrap_or_default(),
                sensor: None,
                setting: form.setting,
                criterion: place.reduced * count,
                reduced: place.reduced,
                unknowns: form.unknowns,
            })
        })
        .collect()
    }

    /// Forms of a force at a place whose laws fit what was recovered there, best first, with the id each speaks for.
    pub(crate) fn force_forms(
        &self,
        setting: &Setting,
        located: &Located,
    ) -> Vec<(&'static str, StructureForm)> {
        let single = with_only(setting, located.place);
        let Ok(found) = self.model.free_force(&single, &self.training) else { return Vec::new() };
        let histories: Vec<History> = (self.training.iter().zip(&found))
            .filter_map(|(&run, force)| history(force, self.model.runs[run].omega))
            .collect();
        let mut forms = Vec::new();
        for (id, law, used) in shapes(located.place) {
            forms.extend(regress(&histories, law, used).map(|(cost, c)| (cost, id, law, c, used.to_vec())));
        }
        forms.retain(|(_, id, ..)| self.case.allows(id));
        forms.sort_by(|a, b| a.0.total_cmp(&b.0));
        forms.truncate(3);
        forms
            .into_iter()
            .map(|(_, id, law, coefficients, used)| {
                (id, self.form(setting, Port { place: located.place, law, coefficients }, &used))
            })
            .collect()
    }

    fn form(&self, setting: &Setting, port: Port, used: &[usize]) -> StructureForm {
        let mut setting = setting.clone();
        setting.ports.push(port);
        let index = setting.ports.len() - 1;
        let mut unknowns: Vec<Unknown> = used
            .iter()
            .map(|&k| {
                let value = port.coefficients[k];
                let name = format!("coefficient_{k}");
                signed(Quantity::Port(index, k), (&name, "SI"), 0.1 * value.abs().max(1e-30), FREE)
            })
            .collect();
        if matches!(port.place, PortPlace::At(_)) {
            let length = self.scales.length;
            let bounds = (0.01 * length, 0.99 * length);
            unknowns.push(signed(Quantity::PortPosition(index), ("position", "m"), 0.003 * length, bounds));
        }
        StructureForm { setting, unknowns, sensor: None }
    }
}

fn with_only(setting: &Setting, place: PortPlace) -> Setting {
    let mut setting = setting.clone();
    setting.ports = vec![Port { place, law: PortLaw::Polynomial, coefficients: [0.0; 4] }];
    setting
}

/// Laws a force may follow, the id each speaks for, and the coefficients fitted.
fn shapes(place: PortPlace) -> Vec<(&'static str, PortLaw, &'static [usize])> {
    match place {
        PortPlace::At(_) => vec![
            ("structure.cubic-stiffness", PortLaw::Polynomial, &[2]),
            ("structure.quadratic-damping", PortLaw::Polynomial, &[3]),
            ("structure.second-support", PortLaw::Polynomial, &[0, 1]),
            ("structure.second-support", PortLaw::Polynomial, &[0, 1, 2]),
            ("structure.second-support", PortLaw::Gap, &[0, 1, 2]),
            ("structure.second-support", PortLaw::Stop, &[0, 1, 2]),
            ("structure.second-support", PortLaw::Friction, &[0, 1, 2]),
        ],
        PortPlace::Support => vec![("contact.normal-stiffening", PortLaw::Stiffening, &[0, 1])],
        PortPlace::Mode(_) => vec![
            ("structure.cubic-stiffness", PortLaw::Polynomial, &[2]),
            ("structure.quadratic-damping", PortLaw::Polynomial, &[3]),
        ],
    }
}

/// Recovered motion and force of one run on a grid.
struct History {
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
}

fn history(found: &FreeForce, omega: f64) -> Option<History> {
    let order = (found.force.len() - 1).min(LINES);
    let grid = Grid::new(order, SAMPLES).ok()?;
    let mut scratch = grid.scratch();
    let mut sampled = |of: &dyn Fn(usize) -> Complex64| {
        let lines: Vec<Complex64> = (0..=order).map(of).collect();
        let mut out = vec![0.0; SAMPLES];
        grid.evaluate(&lines, &mut out, &mut scratch);
        out
    };
    let known = |h: usize| found.force[h].norm() > 3.0 * found.deviation[h];
    Some(History {
        displacement: sampled(&|h| found.motion[h]),
        velocity: sampled(&|h| found.motion[h] * Complex64::new(0.0, h as f64 * omega)),
        force: sampled(&|h| if known(h) { found.force[h] } else { Complex64::ZERO }),
    })
}

/// Coefficients of a law on recovered histories and the relative misfit with a charge for each coefficient.
fn regress(histories: &[History], law: PortLaw, used: &[usize]) -> Option<(f64, [f64; 4])> {
    let largest = |of: &dyn Fn(&History) -> &Vec<f64>| {
        histories.iter().flat_map(|h| of(h).iter()).fold(0.0, |m: f64, x| m.max(x.abs()))
    };
    let (reach, speed) = (largest(&|h| &h.displacement), largest(&|h| &h.velocity));
    let starts: Vec<[f64; 4]> = match law {
        PortLaw::Gap => [0.0, 0.2, 0.5, 0.8].map(|g| [1.0, g * reach, 0.0, 0.0]).to_vec(),
        PortLaw::Stop => [0.0, 0.2, 0.5, 0.8]
            .iter()
            .flat_map(|g| [1.0, -1.0].map(|side| [1.0, g * reach, 0.0, side]))
            .collect(),
        PortLaw::Friction => [0.01, 0.1].map(|v| [1.0, v * speed, 0.0, 0.0]).to_vec(),
        _ => vec![[0.0; 4]],
    };
    // Thresholds are held in the regression, factors are linear.
    let linear: Vec<usize> = match law {
        PortLaw::Gap | PortLaw::Stop | PortLaw::Friction => vec![0, 2],
        _ => used.to_vec(),
    };
    starts
        .into_iter()
        .filter_map(|start| least_squares(histories, law, start, &linear))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(cost, c)| (cost * (1.0 + 0.02 * used.len() as f64), c))
}

fn least_squares(
    histories: &[History],
    law: PortLaw,
    start: [f64; 4],
    linear: &[usize],
) -> Option<(f64, [f64; 4])> {
    let rows: usize = histories.iter().map(|h| h.force.len()).sum();
    let mut matrix = DMatrix::zeros(rows, linear.len());
    let mut right = DVector::zeros(rows);
    let mut at = 0;
    for history in histories {
        // Every level counts by its own size; the mean of a force is not seen.
        let size = history.force.iter().map(|f| f * f).sum::<f64>().sqrt().max(1e-300);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let slopes: Vec<[f64; 4]> = (history.displacement.iter().zip(&history.velocity))
            .map(|(d, v)| law.force(&start, *d, *v).coefficients)
            .collect();
        for (column, &k) in linear.iter().enumerate() {
            let values: Vec<f64> = slopes.iter().map(|s| s[k]).collect();
            let middle = mean(&values);
            for (row, value) in values.iter().enumerate() {
                matrix[(at + row, column)] = (value - middle) / size;
            }
        }
        let middle = mean(&history.force);
        for (row, force) in history.force.iter().enumerate() {
            right[at + row] = (force - middle) / size;
        }
        at += history.force.len();
    }
    let scale: Vec<f64> = (0..linear.len()).map(|c| matrix.column(c).norm().max(1e-300)).collect();
    for (c, s) in scale.iter().enumerate() {
        matrix.column_mut(c).unscale_mut(*s);
    }
    let normal =
        matrix.transpose() * &matrix + DMatrix::from_diagonal_element(linear.len(), linear.len(), 1e-12);
    let solution = normal.cholesky()?.solve(&(matrix.transpose() * &right));
    let left = (&right - &matrix * &solution).norm_squared() / histories.len() as f64;
    let mut coefficients = start;
    for (c, &k) in linear.iter().enumerate() {
        coefficients[k] = solution[c] / scale[c];
    }
    Some((left, coefficients))
}
