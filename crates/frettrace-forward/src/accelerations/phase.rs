//! The phase that everything the exciter drives shares with it.
//!
//! Records of one rig begin anywhere in a period. What is driven together with the excitation – a preload, a base – keeps its
//! phase to it and not to the first sample: with the excitation `F_ν` on line `ν` of the base frequency, line `h` of such a thing
//! is `e^{ihφ}` times what it is in a record that begins at the crest of the excitation, `φ = (arg F_ν + 2πj)/ν`.
//!
//! For multiples of `ν` every `j` is the same. For the lines between, the excitation alone cannot tell which of its `ν` periods a
//! record begins in; the motion can: runs of one rig have their lines between in nearly the same phase when all are counted from
//! the same one of the `ν` periods. Which one that is in the first run is free, for it turns all runs alike.

use super::run::RunLines;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A frequency over that of the excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrequencyRatio {
    /// So many times …
    pub over: usize,
    /// … this part of it.
    pub under: usize,
}

impl FrequencyRatio {
    /// The excitation's own frequency.
    pub const ONE: Self = Self { over: 1, under: 1 };
    /// Twice that.
    pub const TWO: Self = Self { over: 2, under: 1 };
    /// Three times that.
    pub const THREE: Self = Self { over: 3, under: 1 };

    /// Its line in a run whose excitation is on line `driven` of the base frequency: runs of one rig may answer on different parts of the
    /// excitation's frequency. `None` where it lies between lines.
    #[must_use]
    pub fn line(self, driven: usize) -> Option<usize> {
        (self.over * driven).is_multiple_of(self.under).then(|| self.over * driven / self.under)
    }
}

impl RunLines {
    /// Counts the phase of what follows the exciter from the excitation, alike in all runs.
    pub fn follow_excitation<'a>(runs: impl IntoIterator<Item = &'a mut Self>) {
        let mut runs: Vec<&mut Self> = runs.into_iter().collect();
        for run in &mut runs {
            let driven = run.driven();
            run.base_phase = run.force.get(driven).map_or(0.0, |f| f.arg()) / driven as f64;
        }
        // From the run that shows its lines between best to the one that hardly has any.
        runs.sort_by(|a, b| b.between().total_cmp(&a.between()));
        let mut before: Vec<Complex64> = Vec::new();
        for run in runs {
            let driven = run.driven();
            let likeness = |period: usize| -> f64 {
                let phase = run.base_phase + TAU * period as f64 / driven as f64;
                run.first_lines(phase).zip(&before).map(|(now, before)| (now * before.conj()).re).sum()
            };
            let best = (0..driven).max_by(|a, b| likeness(*a).total_cmp(&likeness(*b))).unwrap_or(0);
            run.base_phase += TAU * best as f64 / driven as f64;
            if driven > 1 {
                let now: Vec<Complex64> = run.first_lines(run.base_phase).collect();
                before.resize(now.len(), Complex64::ZERO);
                before.iter_mut().zip(now).for_each(|(sum, now)| *sum += now);
            }
        }
    }

    /// First line of every sensor over its deviation, as a record has it that begins where the base line has no phase.
    fn first_lines(&self, phase: f64) -> impl Iterator<Item = Complex64> {
        let turn = Complex64::from_polar(1.0, -phase);
        let of =
            move |(lines, deviation): (&Vec<Complex64>, &Vec<f64>)| match (lines.get(1), deviation.get(1)) {
                (Some(line), Some(deviation)) => line * turn / *deviation,
                _ => Complex64::ZERO,
            };
        self.acceleration.iter().zip(&self.deviation).map(of)
    }

    /// How strongly the run shows a motion on the first line below the excitation.
    fn between(&self) -> f64 {
        if self.driven() > 1 { self.first_lines(0.0).map(|line| line.norm_sqr()).sum() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run at half the excitation's frequency whose record begins `start` base periods after the excitation's crest.
    fn run(start: f64, response: f64) -> RunLines {
        let line = |h: f64, value: Complex64| value * Complex64::from_polar(1.0, TAU * h * start);
        let half = Complex64::from_polar(response, 0.7);
        RunLines {
            omega: 100.0,
            preload: 50.0,
            progress: 0.0,
            worked: [0.0; 2],
            force: vec![Complex64::ZERO, Complex64::ZERO, line(2.0, 3.0.into())],
            acceleration: vec![vec![Complex64::ZERO, line(1.0, half), line(2.0, Complex64::new(0.0, 4.0))]],
            deviation: vec![vec![1e-2; 3]],
            base_phase: 0.0,
            known_force: Vec::new(),
            contact_order: 3,
            samples: 64,
        }
    }

    /// Three halves of the excitation are line 3 where the motion has half its frequency, line 6 where it has a quarter, and none where it
    /// has its own.
    #[test]
    fn a_ratio_has_its_line_in_every_run() {
        let ratio = FrequencyRatio { over: 3, under: 2 };
        assert_eq!([1, 2, 4].map(|driven| ratio.line(driven)), [None, Some(3), Some(6)]);
        assert_eq!([1, 3].map(|driven| FrequencyRatio::TWO.line(driven)), [Some(2), Some(6)]);
    }

    /// Wherever the records begin, the phase is that of the first sample in the base period, up to whole periods of the
    /// excitation that all runs share.
    #[test]
    fn runs_that_begin_anywhere_count_from_the_same_period() {
        let starts = [0.1, 0.85, 0.4, 0.6, 0.25];
        let mut runs: Vec<RunLines> = starts.iter().zip(1..).map(|(s, k)| run(*s, f64::from(k))).collect();
        RunLines::follow_excitation(&mut runs);
        let shift = |k: usize| (runs[k].base_phase - TAU * starts[k]).rem_euclid(TAU);
        let first = shift(0);
        assert!((2.0 * first).sin().abs() < 1e-12, "{first}");
        for k in 1..starts.len() {
            let apart = (shift(k) - first).sin().abs() + (1.0 - (shift(k) - first).cos());
            assert!(apart < 1e-12, "run {k}: {} against {first}", shift(k));
        }
    }
}
