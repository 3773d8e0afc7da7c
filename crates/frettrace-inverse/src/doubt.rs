//! How far the structure itself is in doubt: what the balance leaves beyond the noise.
//!
//! Shapes, positions, gains and everything else that is declared are right to some share `ε` only. Then each sensor of each
//! line carries, beside its noise `v`, the variance `ε² p` with the power `p = |H_e F_e|² + Σ_u |H_u f_u|²` of what the loads make
//! of it. `ε` follows from the chi-squares of the lines, and forces, bands and calibration are made with `v + ε² p`: an
//! imperfect structure widens the bands instead of hiding behind strong lines.

use crate::balance::LineBalance;
use crate::calibration::Equations;
use crate::contact::Setting;
use crate::dynamics::{LineReceptances, Load};
use rayon::prelude::*;

/// Rounds of reweighting.
const ROUNDS: usize = 5;
/// Standard deviations from which a run has a doubt of its own.
const OWN: f64 = 3.0;

/// A line's chi-square, its degrees of freedom, and the mean of `p/v` over the sensors.
struct LineExcess {
    chi_square: f64,
    freedom: f64,
    ratio: f64,
}

/// Sums from which `ε² = numerator/information` follows.
#[derive(Clone, Copy, Default)]
struct Sums {
    numerator: f64,
    information: f64,
}

impl Sums {
    /// Method of moments, `E χ²_h/d_h − 1 = ε² m_h`, weighted by the inverse variance `d_h/(1 + ε² m_h)²` of each line.
    fn of(lines: &[LineExcess], square: f64) -> Self {
        lines.iter().fold(Self::default(), |sums, line| {
            let weight = line.freedom / (1.0 + square * line.ratio).powi(2);
            Self {
                numerator: sums.numerator + weight * line.ratio * (line.chi_square / line.freedom - 1.0),
                information: sums.information + weight * line.ratio.powi(2),
            }
        })
    }

    fn square(self) -> f64 {
        if self.information > 0.0 { (self.numerator / self.information).max(0.0) } else { 0.0 }
    }

    /// Standard deviations of the excess beyond another doubt.
    fn beyond(self, square: f64) -> f64 {
        (self.square() - square) * (0.5 * self.information).sqrt()
    }
}

/// Adds the variance of the structure's doubt to the equations of all runs; whether there is any.
///
/// All runs share one `ε`; a run whose lines leave more than that by [`OWN`] standard deviations has its own.
pub(crate) fn add(setting: &Setting<'_>, runs: &mut [Equations<'_>]) -> bool {
    let found: Vec<(Vec<LineExcess>, Vec<Vec<f64>>)> =
        runs.par_iter().map(|run| excess(setting, run)).collect();
    let square = solve(found.iter().map(|f| f.0.as_slice()));
    let mut any = false;
    for (run, (lines, powers)) in runs.iter_mut().zip(&found) {
        let own = solve(std::iter::once(lines.as_slice()));
        let conspicuous =
            Sums::of(lines, own).square() > square && Sums::of(lines, square).beyond(square) > OWN;
        let here = if conspicuous { own } else { square };
        run.doubt(here, powers);
        any |= here > 0.0;
    }
    any
}

fn solve<'a>(runs: impl Iterator<Item = &'a [LineExcess]> + Clone) -> f64 {
    let mut square = 0.0;
    for _ in 0..ROUNDS {
        let sums = runs.clone().map(|lines| Sums::of(lines, square)).fold(Sums::default(), |a, b| Sums {
            numerator: a.numerator + b.numerator,
            information: a.information + b.information,
        });
        square = sums.square();
    }
    square
}

/// Excess of each line, and the power `p` of each sensor of each line.
fn excess(setting: &Setting<'_>, run: &Equations<'_>) -> (Vec<LineExcess>, Vec<Vec<f64>>) {
    if run.lines.form == crate::Form::Aperiodic {
        return (Vec::new(), Vec::new());
    }
    let free = vec![f64::INFINITY; run.loads.len()];
    let (mut line, mut balance) = (LineReceptances::default(), LineBalance::default());
    let (mut excesses, mut powers) = (Vec::new(), Vec::new());
    for h in 1..=run.order() {
        setting.dynamics.fill_sensors_upon(&setting.structure.model, run.fixed, h, &mut line);
        let data = run.data(h);
        balance.renew(&line, data, &run.loads, &free);
        let power: Vec<f64> = (0..data.accelerations.len())
            .map(|s| {
                let exciter = (line.acceleration(s, Load::Exciter) * data.force).norm_sqr();
                let contact = run.loads.iter().zip(&balance.forces);
                exciter + contact.map(|(load, f)| (line.acceleration(s, *load) * f).norm_sqr()).sum::<f64>()
            })
            .collect();
        let freedom = balance.freedom() as f64;
        if freedom > 0.0 {
            let ratios = power.iter().zip(&data.variances).filter(|(_, v)| **v > 0.0).map(|(p, v)| p / v);
            let ratio = ratios.sum::<f64>() / power.len() as f64;
            excesses.push(LineExcess { chi_square: balance.chi_square(), freedom, ratio });
        }
        powers.push(power);
    }
    (excesses, powers)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines whose chi-square is what `ε = 0.02` makes of it give that back; lines of noise alone give none.
    #[test]
    fn share_is_recovered() {
        let lines = |square: f64| -> Vec<LineExcess> {
            [1e6, 1e4, 10.0, 0.1]
                .map(|ratio| LineExcess { chi_square: 8.0 * (1.0 + square * ratio), freedom: 8.0, ratio })
                .into()
        };
        let found = solve(std::iter::once(lines(4e-4).as_slice()));
        assert!((found - 4e-4).abs() < 1e-10, "{found}");
        assert_eq!(solve(std::iter::once(lines(0.0).as_slice())), 0.0);
    }
}
