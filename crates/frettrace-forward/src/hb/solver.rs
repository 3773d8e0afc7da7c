//! The solver: balance, Newton, and what is said about the outcome.

use super::lines::Lines;
use super::newton::{Counts, Newton, Status, Vectors};
use super::system::{Problem, System};
use crate::ForwardError;
use num_complex::Complex64;

/// Corrections are not followed below this: rounding of a few hundred samples.
const ROUNDING: f64 = 1e-12;
/// A correction below which rounding, not a bad start, keeps Newton from its tolerance.
const NEAR: f64 = 1e-6;

/// A Jacobian from so many times fewer samples costs as much less and misses the kinks by as much more.
const COARSER: usize = 4;
/// Samples a line from which on that is done.
const PLENTY: usize = 16;

/// How a balance is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Highest harmonic `H` of the contact forces.
    pub order: usize,
    /// Samples a period `N > 2H`; a law with kinks wants `N ≥ 4H`.
    pub samples: usize,
    /// Largest last correction of the forces, relative to their size.
    pub tolerance: f64,
    /// Most Newton steps with a new Jacobian.
    pub iterations: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { order: 31, samples: 256, tolerance: 1e-9, iterations: 30 }
    }
}

/// Contact forces in balance with the structure.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Lines of the contact forces (N), `D × (H + 1)`, force by force.
    pub forces: Vec<Complex64>,
    /// How the solution ended.
    pub status: Status,
    /// Newton steps with a new Jacobian.
    pub linearisations: usize,
    /// Marches through the contacts' periods.
    pub evaluations: usize,
    /// Last correction, relative to the forces.
    pub correction: f64,
    /// What the harmonics cut off would move: root sum square of `G_h F_h` over `h > H`, relative to the motion of
    /// the contacts' channels; 0 where no line above `H` is given.
    pub truncation: f64,
}

impl Solution {
    /// Lines of force `d`, `H + 1`.
    #[must_use]
    pub fn force(&self, d: usize, forces: usize) -> &[Complex64] {
        let row = self.forces.len() / forces.max(1);
        &self.forces[d * row..(d + 1) * row]
    }
}

/// Harmonic balance with memory that is kept from run to run; one a thread.
pub struct Solver {
    pub(super) settings: Settings,
    pub(super) system: System,
    /// The same balance on fewer samples, for the Jacobians of curves, where that many are still plenty.
    pub(super) coarse: Option<System>,
    vectors: Vectors,
}

impl Solver {
    /// A solver with these settings.
    ///
    /// # Errors
    /// [`ForwardError::Grid`] unless `samples > 2·order`.
    pub fn new(settings: Settings) -> Result<Self, ForwardError> {
        let few = settings.samples / COARSER;
        let plenty = settings.samples.is_multiple_of(COARSER) && few >= PLENTY * (settings.order + 1);
        Ok(Self {
            system: System::new(settings.order, settings.samples)?,
            coarse: if plenty { Some(System::new(settings.order, few)?) } else { None },
            settings,
            vectors: Vectors::default(),
        })
    }

    /// The system whose Jacobian is taken along curves.
    pub(super) fn slopes(&mut self) -> &mut System {
        self.coarse.as_mut().unwrap_or(&mut self.system)
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Contact forces of a run, from the lines `start` (`D` rows of any length, cut or padded) or from none.
    /// Without success from there, the load is raised step by step.
    ///
    /// # Errors
    /// A problem that is not one: see [`ForwardError`]. A balance without solution is a [`Status`], not an error.
    pub fn solve(
        &mut self,
        problem: &Problem,
        start: Option<&[Complex64]>,
    ) -> Result<Solution, ForwardError> {
        problem.check()?;
        let count = problem.lines.forces();
        self.vectors.resize(count, self.settings.order);
        self.start(count, start.unwrap_or(&[]));
        let mut counts = Counts::default();
        let mut status = self.newton(*problem).run(&mut self.system, &mut self.vectors, &mut counts);
        let lost = status == Status::Stalled || status == Status::IterationLimit;
        if lost && (counts.correction.is_nan() || counts.correction >= NEAR) {
            status = self.ramp(problem, &mut counts);
        }
        Ok(Solution {
            forces: self.vectors.forces.clone(),
            status,
            linearisations: counts.linearisations,
            evaluations: counts.evaluations,
            correction: counts.correction,
            truncation: self.truncation(problem),
        })
    }

    fn newton<'a>(&self, problem: Problem<'a>) -> Newton<'a> {
        Newton { problem, tolerance: self.settings.tolerance.max(ROUNDING), limit: self.settings.iterations }
    }

    fn start(&mut self, count: usize, start: &[Complex64]) {
        let (row, given) = (self.settings.order + 1, start.len() / count.max(1));
        self.vectors.forces.fill(Complex64::ZERO);
        if given > 0 {
            for (to, from) in self.vectors.forces.chunks_exact_mut(row).zip(start.chunks_exact(given)) {
                let both = row.min(given);
                to[..both].copy_from_slice(&from[..both]);
            }
        }
    }

    /// Raises the alternating load from nothing, with steps that adapt, each start extrapolated from the last two.
    fn ramp(&mut self, problem: &Problem, counts: &mut Counts) -> Status {
        let (mut level, mut step) = (0.0_f64, 0.25_f64);
        self.vectors.forces.fill(Complex64::ZERO);
        let mut last = (0.0, self.vectors.forces.clone());
        let mut before: Option<(f64, Vec<Complex64>)> = None;
        while level < 1.0 {
            let next = (level + step).min(1.0);
            self.vectors.forces.copy_from_slice(&last.1);
            if let Some((at, forces)) = &before {
                let ratio = (next - last.0) / (last.0 - at);
                for ((f, new), old) in self.vectors.forces.iter_mut().zip(&last.1).zip(forces) {
                    *f = new + (new - old) * ratio;
                }
            }
            let lines = loaded(problem.lines, next);
            let scaled = Problem { lines: &lines, contacts: problem.contacts };
            let status = self.newton(scaled).run(&mut self.system, &mut self.vectors, counts);
            if status == Status::Converged {
                (level, step) = (next, step * 1.5);
                before = Some(std::mem::replace(&mut last, (level, self.vectors.forces.clone())));
            } else if step < 1e-3 || status == Status::LoopNotClosed {
                return status;
            } else {
                step /= 3.0;
            }
        }
        Status::Converged
    }

    fn truncation(&mut self, problem: &Problem) -> f64 {
        self.truncation_above(problem, [self.settings.order; 2])[0]
    }

    /// [`Solution::truncation`] of the motion that was evaluated last, for each of two orders at which it might be cut.
    pub(super) fn truncation_above(&mut self, problem: &Problem, cuts: [usize; 2]) -> [f64; 2] {
        let order = problem.lines.order().min((self.settings.samples - 1) / 2);
        if cuts.iter().all(|&cut| order <= cut) {
            return [0.0; 2];
        }
        let row = order + 1;
        let Some(forces) = self.system.spectrum(problem, order) else { return [f64::NAN; 2] };
        let (mut tails, mut whole) = ([0.0; 2], 0.0);
        for channel in problem.contacts.iter().map(|c| c.slip) {
            for h in 1..row {
                let moved: Complex64 = (0..problem.lines.forces())
                    .map(|d| problem.lines.receptance(channel, d)[h] * forces[d * row + h])
                    .sum();
                for (tail, _) in tails.iter_mut().zip(cuts).filter(|(_, cut)| h > *cut) {
                    *tail += moved.norm_sqr();
                }
                if h <= self.settings.order {
                    whole += (problem.lines.free(channel)[h] - moved).norm_sqr();
                }
            }
        }
        tails.map(|tail| if tail == 0.0 { 0.0 } else { (tail / whole).sqrt() })
    }
}

/// The lines with the alternating load scaled; the static load stays.
fn loaded(lines: &Lines, level: f64) -> Lines {
    let mut scaled = lines.clone();
    for channel in 0..lines.channels() {
        scaled.free_mut(channel).iter_mut().skip(1).for_each(|x| *x *= level);
    }
    scaled
}
