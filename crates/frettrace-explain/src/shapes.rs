//! The residual's own shape: what it follows, in numbers that a person can look at.
//!
//! Quadratic means of the residual, in standard deviations of the noise (1 is noise alone), against one quantity at a
//! time. Slip, slip velocity and normal force are those of the contact recovered without a law, as shares of their
//! largest value in each run, so that runs of all levels add up.

use crate::Exhibit;

/// Bins against a quantity of the contact: enough to see a side, an end or a reversal.
const BINS: usize = 20;

/// The residual against one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The quantity.
    pub against: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Centres of the bins.
    pub centre: Vec<f64>,
    /// Residual of the declared model and of the model with the effects, in standard deviations of the noise.
    pub residual: [Vec<f64>; 2],
}

/// Shapes against slip, slip velocity, normal force, phase, level, time (the order of the runs) and sensor; none without exhibits.
#[must_use]
pub fn shapes(shown: &[Exhibit]) -> Vec<Shape> {
    if shown.is_empty() {
        return Vec::new();
    }
    let share = "share of the largest in each run";
    let contact = ["slip", "slip velocity", "normal force"];
    let mut found: Vec<Shape> = (0..3)
        .map(|k| binned(shown, (contact[k], share), |e, t| 0.5 * (e.traces.shares[k][t] + 1.0)))
        .collect();
    found.retain(|shape| shape.centre.len() > 1);
    let phase = |exhibit: &Exhibit, t: usize| t as f64 / exhibit.time.len() as f64;
    let mut by_phase = binned(shown, ("phase", "periods"), phase);
    by_phase.centre.iter_mut().for_each(|centre| *centre = 0.5 * (*centre + 1.0));
    found.extend([by_phase, by_level(shown), by_time(shown), by_sensor(shown)]);
    found
}

/// Against a quantity of every time, given as its place between 0 and 1; bin centres from −1 to 1.
fn binned(
    shown: &[Exhibit],
    (against, unit): (&'static str, &'static str),
    place: impl Fn(&Exhibit, usize) -> f64,
) -> Shape {
    let mut sums = [[0.0; 2]; BINS];
    let mut counts = [0.0; BINS];
    for exhibit in shown {
        for t in 0..exhibit.traces.residual[0].len() {
            let bin = ((place(exhibit, t) * BINS as f64) as usize).min(BINS - 1);
            counts[bin] += 1.0;
            for (sum, residual) in sums[bin].iter_mut().zip(&exhibit.traces.residual) {
                *sum += residual[t] * residual[t];
            }
        }
    }
    let filled = || (0..BINS).filter(|bin| counts[*bin] > 0.0);
    let side = |k: usize| filled().map(|bin| (sums[bin][k] / counts[bin]).sqrt()).collect();
    let centre = filled().map(|bin| (2.0 * bin as f64 + 1.0) / BINS as f64 - 1.0).collect();
    Shape { against, unit, centre, residual: [side(0), side(1)] }
}

fn by_level(shown: &[Exhibit]) -> Shape {
    let mut order: Vec<&Exhibit> = shown.iter().collect();
    order.sort_by(|a, b| a.traces.mean_square.total_cmp(&b.traces.mean_square));
    let centre = order.iter().map(|exhibit| exhibit.traces.mean_square.sqrt()).collect();
    Shape { against: "level", unit: "m/s² RMS of all sensors", centre, residual: of_runs(&order) }
}

fn by_time(shown: &[Exhibit]) -> Shape {
    let order: Vec<&Exhibit> = shown.iter().collect();
    let centre = order.iter().map(|exhibit| exhibit.run as f64 + 1.0).collect();
    Shape {
        against: "time",
        unit: "number of the run, in the order measured",
        centre,
        residual: of_runs(&order),
    }
}

fn of_runs(order: &[&Exhibit]) -> [Vec<f64>; 2] {
    [0, 1].map(|side| order.iter().map(|exhibit| quadratic_mean(&exhibit.residual[side])).collect())
}

fn by_sensor(shown: &[Exhibit]) -> Shape {
    let sensors = shown[0].residual[0].len();
    let of = |side: usize, sensor: usize| {
        quadratic_mean(&shown.iter().map(|exhibit| exhibit.residual[side][sensor]).collect::<Vec<_>>())
    };
    Shape {
        against: "sensor",
        unit: "index",
        centre: (0..sensors).map(|sensor| sensor as f64).collect(),
        residual: [0, 1].map(|side| (0..sensors).map(|sensor| of(side, sensor)).collect()),
    }
}

fn quadratic_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exhibit::Traces;

    /// A residual that lives at one end of the slip shows in the bins of that end and in no other.
    #[test]
    fn a_residual_shows_where_it_lives() {
        let slip: Vec<f64> = (0..400).map(|k| (0.01 * std::f64::consts::PI * f64::from(k)).sin()).collect();
        let before: Vec<f64> = slip.iter().map(|&u| if u > 0.5 { 3.0 } else { 1.0 }).collect();
        let traces = Traces {
            shares: [slip.clone(), slip.clone(), vec![0.0; slip.len()]],
            residual: [before, vec![1.0; slip.len()]],
            sensors: Default::default(),
            mean_square: 4.0,
        };
        let exhibit = Exhibit {
            run: 2,
            time: vec![0.0; 400],
            residual: [vec![3.0, 4.0], vec![1.0, 1.0]],
            traces,
            ..Exhibit::default()
        };
        let found = shapes(&[exhibit]);
        // The normal force that does not move has no shape.
        let names: Vec<_> = found.iter().map(|shape| shape.against).collect();
        assert_eq!(names, ["slip", "slip velocity", "phase", "level", "time", "sensor"]);
        for (centre, residual) in found[0].centre.iter().zip(&found[0].residual[0]) {
            assert!((residual - if *centre > 0.5 { 3.0 } else { 1.0 }).abs() < 1e-12, "{centre}: {residual}");
        }
        assert_eq!((found[3].centre[0], found[4].centre[0]), (2.0, 3.0));
        // √((3² + 4²)/2)
        assert!((found[4].residual[0][0] - 12.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(found[5].residual[0], [3.0, 4.0]);
    }
}
