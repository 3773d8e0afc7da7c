//! Friction coefficient, stiffness and velocity that recovered contacts show by their sizes: where the fit of a law may begin.

use super::{Contacts, Recovered};
use num_complex::Complex64;

impl Recovered {
    /// RMS of the friction force over the mean normal force; presliding stiffness (1/m) as it is where the contact sticks, that over the RMS
    /// of the slip, and as it is after reversals.
    fn sizes(&self) -> [f64; 3] {
        let samples = self.slip.len() as f64;
        let force = (0.5 * self.force.iter().skip(1).map(Complex64::norm_sqr).sum::<f64>()).sqrt();
        let share = force / (self.normal.iter().sum::<f64>() / samples).max(f64::MIN_POSITIVE);
        let stuck = share / self.stroke().max(f64::MIN_POSITIVE);
        [share, stuck, self.stiffness_after_reversals(force).unwrap_or(stuck)]
    }

    /// Median over the reversals of the period of `F/(N Δu)`: the force at a reversal over the mean normal force and the way to where the
    /// force is zero. It is the stiffness of a bristle that slides at the turn and yields linearly, 1/ln 2 of it for one that yields exponentially.
    fn stiffness_after_reversals(&self, size: f64) -> Option<f64> {
        let samples = self.slip.len();
        let mut lines = vec![Complex64::ZERO; self.grid.order() + 1];
        lines.iter_mut().zip(&self.force).skip(1).for_each(|(line, force)| *line = *force);
        let mut force = vec![0.0; samples];
        self.grid.evaluate(&lines, &mut force, &mut self.grid.scratch());
        let turns = |k: &usize| self.velocity[*k] * self.velocity[(k + 1) % samples] <= 0.0;
        let secant = |turn: usize| {
            let from = (turn + 1) % samples;
            let signs = (force[from].signum(), self.velocity[from].signum());
            let at = |step: usize| (from + step) % samples;
            let ways = (1..samples).take_while(|&step| self.velocity[at(step)] * signs.1 > 0.0);
            let zero = ways.into_iter().find(|&step| force[at(step)] * signs.0 <= 0.0)?;
            let normal = (0..=zero).map(|step| self.normal[at(step)]).sum::<f64>() / (zero + 1) as f64;
            let way = (self.slip[at(zero)] - self.slip[from]).abs();
            Some(force[from].abs() / (normal * way))
                .filter(|stiffness| stiffness.is_normal() && *stiffness > 0.0)
        };
        let loaded = (0..samples).filter(turns).filter(|k| force[(k + 1) % samples].abs() > 0.5 * size);
        let mut found: Vec<f64> = loaded.filter_map(secant).collect();
        found.sort_by(f64::total_cmp);
        found.get(found.len() / 2).copied()
    }
}

impl Contacts {
    /// Friction coefficient and presliding stiffness (1/m) by their sizes: the largest RMS of `F/N`, where the contact slides most, and the
    /// larger of `F/(N u)`, where it sticks most, and of what most runs show after reversals. `None` without periodic runs.
    pub fn sizes(&self) -> Option<[f64; 2]> {
        let runs: Vec<[f64; 3]> = self.periodic.iter().map(Recovered::sizes).collect();
        let largest = |k: usize| runs.iter().map(|sizes| sizes[k]).reduce(f64::max);
        let mut reversals: Vec<f64> = runs.iter().map(|sizes| sizes[2]).collect();
        reversals.sort_by(f64::total_cmp);
        let sizes = [largest(0)?, largest(1)?.max(*reversals.get(reversals.len() / 2)?)];
        sizes.iter().all(|x| x.is_normal()).then_some(sizes)
    }

    /// Largest slip velocity (m/s); `None` without periodic runs.
    pub fn fastest(&self) -> Option<f64> {
        let speeds = self.periodic.iter().flat_map(|one| &one.velocity).map(|v| v.abs());
        speeds.reduce(f64::max).filter(|v| v.is_normal())
    }
}
