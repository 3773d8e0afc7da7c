//! Laws of a recovered force: line by line against what they answer to the recovered motion.

use frettrace_forward::accelerations::{Balance, COEFFICIENTS, PortLaw, PortPlace, SHARP, settled_mean};
use frettrace_fourier::Grid;
use num_complex::Complex64;

mod regression;

pub(crate) use regression::{Answer, CUBIC_BELOW, linear, range, regress, regress_resting, thresholds};
use regression::{left_by, mean_force, stopped, with_gap};

/// Samples of a period on which laws of the force are tried.
const SAMPLES: usize = 512;
/// Lines of the force that are used.
const LINES: usize = 48;
/// Relative accuracy of a recovered force: what is left of the structure's errors.
const RELATIVE_ACCURACY: f64 = 5e-4;
/// χ² by which a run must tell where it rests.
const TELLS: f64 = 9.0;
/// A law that a force may follow.
pub(crate) struct Shape {
    /// The effect it speaks for.
    pub id: &'static str,
    pub law: PortLaw,
    /// Coefficients that are fitted.
    pub free: &'static [usize],
    /// Coefficients that enter linearly.
    linear: &'static [usize],
    /// The side of a stop, and the length of its corner.
    side: f64,
}

/// Laws a force at a place may follow.
pub(crate) fn shapes(place: PortPlace) -> Vec<Shape> {
    let polynomial =
        |id, free: &'static [usize]| Shape { id, law: PortLaw::Polynomial, free, linear: free, side: 0.0 };
    let support = |law, free, linear, side| Shape { id: "structure.second-support", law, free, linear, side };
    let scaled = |id, law| Shape { id, law, free: &[0, 1], linear: &[0], side: 0.0 };
    let smooth =
        [polynomial("structure.cubic-stiffness", &[2]), polynomial("structure.quadratic-damping", &[3])];
    match place {
        // A moment is only located.
        PortPlace::Turn(_) => Vec::new(),
        PortPlace::Mode(_) => smooth.into(),
        PortPlace::At(_) => smooth
            .into_iter()
            .chain([
                scaled("structure.cubic-stiffness", PortLaw::Yielding),
                scaled("structure.quadratic-damping", PortLaw::Power),
                polynomial("structure.second-support", &[0, 1]),
                polynomial("structure.second-support", &[0, 1, 2]),
                support(PortLaw::Gap, &[0, 1, 2], &[0, 2], 0.0),
                support(PortLaw::Stop, &[0, 1, 2], &[0, 2], SHARP),
                support(PortLaw::Stop, &[0, 1, 2], &[0, 2], -SHARP),
                support(PortLaw::Round, &[0, 1], &[0], SHARP),
                support(PortLaw::Round, &[0, 1], &[0], -SHARP),
                support(PortLaw::Friction, &[0, 1, 2], &[0, 2], 0.0),
            ])
            .collect(),
        PortPlace::Support => [&[0, 1][..], &[0, 1, 2, 3]]
            .map(|free| Shape {
                id: "contact.normal-stiffening",
                law: PortLaw::Stiffening,
                free,
                linear: free,
                side: 0.0,
            })
            .into(),
    }
}

/// Laws without a name, for the question whether a force answers to the motion at all: any smooth spring, and a spring and a damper
/// with their powers.
pub(crate) fn nameless() -> [Shape; 2] {
    [PortLaw::Stiffening, PortLaw::Polynomial].map(|law| {
        let all = &[0, 1, 2, 3];
        Shape { id: "", law, free: all, linear: all, side: 0.0 }
    })
}

/// Name and unit of each coefficient of a law; modal ones act on a coordinate in m·√kg.
pub(crate) fn names(law: PortLaw, modal: bool) -> [(&'static str, &'static str); COEFFICIENTS] {
    match (law, modal) {
        (PortLaw::Polynomial, true) => [
            ("modal_stiffness", "1/s^2"),
            ("modal_damping", "1/s"),
            ("modal_cube", "1/(s^2·m^2·kg)"),
            ("modal_square_damping", "1/(m·√kg)"),
        ],
        (PortLaw::Polynomial, false) => [
            ("stiffness", "N/m"),
            ("damping", "N·s/m"),
            ("cubic_stiffness", "N/m^3"),
            ("quadratic_damping", "N·s^2/m^2"),
        ],
        (PortLaw::Stiffening, _) => {
            [("quadratic_stiffness", "N/m^2"), ("cubic_stiffness", "N/m^3"), QUARTIC, QUINTIC]
        }
        (PortLaw::Yielding, _) => [("cubic_stiffness", "N/m^3"), ("yield_displacement", "m"), NONE, NONE],
        (PortLaw::Power, _) => [("damping_force", "N"), ("power", "1"), NONE, NONE],
        (PortLaw::Round, _) => [("stiffness", "N/m^1.5"), ("gap", "m"), NONE, NONE],
        (PortLaw::Friction, _) => {
            [("friction_force", "N"), ("transition_velocity", "m/s"), ("stiffness", "N/m"), NONE]
        }
        (PortLaw::LiftOff, _) => [("stiffness", "N/m"), ("preload", "N"), NONE, NONE],
        (PortLaw::Gap | PortLaw::Stop | PortLaw::Rough, _) => {
            [("stiffness", "N/m"), ("gap", "m"), ("damping", "N·s/m"), ("corner", "m")]
        }
    }
}

const NONE: (&str, &str) = ("", "");
const QUARTIC: (&str, &str) = ("quartic_stiffness", "N/m^4");
const QUINTIC: (&str, &str) = ("quintic_stiffness", "N/m^5");

/// Recovered motion and force of one run.
pub(crate) struct History {
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    /// Lines `1..=H` of the force over their standard deviations.
    force: Vec<Complex64>,
    /// Their standard deviations.
    deviation: Vec<f64>,
    /// Displacement (m) lost by a unit of mean force.
    compliance: f64,
    grid: Grid,
}

impl History {
    /// Motion and force of the last port of a balance with free ports; `None` where it has none.
    pub fn new(balance: &Balance, omega: f64) -> Option<Self> {
        Self::along(balance, omega, |_| 1.0)
    }

    /// The same with the acceleration in the place of the displacement.
    pub fn inertial(balance: &Balance, omega: f64) -> Option<Self> {
        Self::along(balance, omega, |h| -(h as f64 * omega).powi(2))
    }

    fn along(balance: &Balance, omega: f64, factor: impl Fn(usize) -> f64) -> Option<Self> {
        let (force, std) = (balance.beside.last()?, balance.beside_deviation.last()?);
        let (motion, gain) = (balance.motion.last()?, balance.motion_gain.last()?);
        let order = force.len().saturating_sub(1).min(LINES);
        let grid = Grid::new(order, SAMPLES).ok()?;
        let mut scratch = grid.scratch();
        let mut sampled = |of: &dyn Fn(usize) -> Complex64| {
            let lines: Vec<Complex64> = (0..=order).map(of).collect();
            let mut out = vec![0.0; SAMPLES];
            grid.evaluate(&lines, &mut out, &mut scratch);
            out
        };
        let displacement = sampled(&|h| motion[h] * factor(h));
        let velocity = sampled(&|h| motion[h] * Complex64::new(0.0, h as f64 * omega));
        let peak = force.iter().map(|f| f.norm()).fold(0.0, f64::max);
        let widest = motion.iter().map(|d| d.norm()).fold(0.0, f64::max);
        // An error of the force moves the motion by the receptance, and that moves the law's answer by its stiffness.
        let stiffness = peak / widest.max(f64::MIN_POSITIVE);
        let deviation: Vec<f64> = (1..=order)
            .map(|h| {
                let known = std[h] * (1.0 + stiffness * gain[h].norm());
                known.hypot(RELATIVE_ACCURACY * peak / h as f64)
            })
            .collect();
        let force = (1..=order).map(|h| force[h] / deviation[h - 1]).collect();
        let compliance = gain.first().map_or(0.0, |gain| gain.re);
        Some(Self { displacement, velocity, force, deviation, compliance, grid })
    }

    /// Where the motion rests (m) beside what the mean force of a stop makes of it; nothing where it does not tell, by a χ² of
    /// [`TELLS`], that it rests anywhere else.
    pub fn rest(&self, law: PortLaw, at: &[f64; COEFFICIENTS]) -> f64 {
        let own = stopped(self, law, at);
        let mean = |gap: f64| mean_force(self, law, &with_gap(at, gap));
        let natural = at[1] - settled_mean(0.0, self.compliance, |mean_motion| mean(at[1] - mean_motion));
        match own {
            Some((gap, left)) if left + TELLS < left_by(self, law, &with_gap(at, natural)) => {
                at[1] - gap + self.compliance * mean(gap)
            }
            _ => 0.0,
        }
    }

    /// Real values that a law is compared with.
    pub fn count(&self) -> usize {
        2 * self.force.len()
    }

    /// χ² of a law that answers nothing.
    pub fn chi(&self) -> f64 {
        self.force.iter().map(Complex64::norm_sqr).sum()
    }

    /// Lines of the sensitivities of a law to its coefficients, over the standard deviations.
    fn columns(&self, law: PortLaw, at: &[f64; COEFFICIENTS], linear: &[usize]) -> Vec<Vec<Complex64>> {
        let slopes: Vec<[f64; COEFFICIENTS]> = (self.displacement.iter().zip(&self.velocity))
            .map(|(d, v)| law.force(at, *d, *v).coefficients)
            .collect();
        let mut scratch = self.grid.scratch();
        let mut lines = vec![Complex64::ZERO; self.force.len() + 1];
        linear
            .iter()
            .map(|&k| {
                let values: Vec<f64> = slopes.iter().map(|s| s[k]).collect();
                self.grid.project(&values, &mut lines, &mut scratch);
                lines[1..].iter().zip(&self.deviation).map(|(l, d)| l / d).collect()
            })
            .collect()
    }
}

/// χ² that is left of recovered forces which do not ask what the structure does: on each line of every run one amplitude, the
/// same in all runs or in proportion to the excitation's, with a phase that is the excitation's and a constant (a share of the
/// exciter's force) or any (another machine); `ln n` for each value. `drives` are the excitation's first lines (N).
pub(crate) fn driven(histories: &[History], drives: &[Complex64]) -> f64 {
    let lines = histories.iter().map(|h| h.force.len()).max().unwrap_or_default();
    let count: usize = histories.iter().map(History::count).sum();
    let price = (count as f64).ln();
    let left = |size: &dyn Fn(Complex64) -> f64| {
        let of_line = |h: usize| {
            let (mut all, mut locked, mut loose, mut square, mut runs) =
                (0.0, Complex64::ZERO, 0.0, 0.0, 0.0);
            for (history, drive) in histories.iter().zip(drives).filter(|(one, _)| one.force.len() > h) {
                let expected = size(*drive) / history.deviation[h];
                let force = history.force[h];
                all += force.norm_sqr();
                locked += force * Complex64::from_polar(expected, -((h + 1) as f64) * drive.arg());
                loose += force.norm() * expected;
                square += expected * expected;
                runs += 1.0;
            }
            let taken = |sum: f64, values: f64| sum * sum / square.max(f64::MIN_POSITIVE) - values * price;
            // Values that take nothing are not used.
            all - taken(locked.norm(), 2.0).max(taken(loose, 1.0 + runs)).max(0.0)
        };
        (0..lines).map(of_line).sum::<f64>()
    };
    left(&|_| 1.0).min(left(&|drive| drive.norm()))
}

#[cfg(test)]
mod tests {
    use super::{History, SAMPLES, driven, regress, regress_resting, shapes};
    use frettrace_forward::accelerations::{PortLaw, PortPlace};
    use frettrace_fourier::Grid;
    use num_complex::Complex64;

    /// Six runs whose excitation doubles from run to run, with a phase of its own in each; two lines of a force with the given
    /// amplitude and phase, over a deviation of 1e-3.
    fn runs(of: impl Fn(f64, f64) -> Complex64) -> (Vec<History>, Vec<Complex64>) {
        let drive = |run: i32| Complex64::from_polar(2.0_f64.powi(run), 1.3 * f64::from(run * run));
        let history = |run: i32| History {
            displacement: Vec::new(),
            velocity: Vec::new(),
            force: [1.0, 2.0]
                .map(|line| of(drive(run).norm(), line) * Complex64::from_polar(1e3, line * drive(run).arg()))
                .into(),
            deviation: vec![1e-3; 2],
            compliance: 0.0,
            grid: Grid::new(2, 16).unwrap(),
        };
        ((0..6).map(history).collect(), (0..6).map(drive).collect())
    }

    /// What is left of forces that are told by the excitation is the price of their values: 4 of them, or 14 with free phases;
    /// `ln 24` each. A force that grows with the square of the excitation leaves most of itself.
    #[test]
    fn forces_that_do_not_ask_the_motion_are_told() {
        let price = 24.0_f64.ln();
        let near = |found: f64, values: f64| assert!((found - values * price).abs() < 1e-6, "{found}");
        let (histories, drives) = runs(|_, line| Complex64::from_polar(0.3 / line, 0.4));
        near(driven(&histories, &drives), 4.0);
        let (histories, drives) = runs(|drive, line| Complex64::from_polar(0.3 * drive / line, -0.9));
        near(driven(&histories, &drives), 4.0);
        let (histories, drives) = runs(|drive, line| Complex64::from_polar(0.3 / line, 5.0 * drive));
        near(driven(&histories, &drives), 14.0);
        let (histories, drives) = runs(|drive, _| Complex64::from(0.01 * drive * drive));
        let all: f64 = histories.iter().map(History::chi).sum();
        // 1 − (Σ s³)²/(Σ s² Σ s⁴) over s = 1, 2 … 32 is 0.0814, and the prices are small beside it.
        assert!((driven(&histories, &drives) / all - 0.0814).abs() < 1e-3);
    }

    /// Friction of 2 N on a beam that is eased by 0.05 N/m where it rubs: the spring of a support would pull, and is left out.
    #[test]
    fn what_rubs_need_not_carry() {
        let grid = Grid::new(15, SAMPLES).unwrap();
        let phase = |k: usize| std::f64::consts::TAU * k as f64 / SAMPLES as f64;
        let displacement: Vec<f64> = (0..SAMPLES).map(|k| phase(k).cos()).collect();
        let velocity: Vec<f64> = (0..SAMPLES).map(|k| -phase(k).sin()).collect();
        let motion = displacement.iter().zip(&velocity);
        let force: Vec<f64> = motion.map(|(d, v)| 2.0 * (v / 0.3).tanh() - 0.05 * d).collect();
        let mut lines = vec![Complex64::ZERO; 16];
        grid.project(&force, &mut lines, &mut grid.scratch());
        let force = lines[1..].iter().map(|line| line / 1e-3).collect();
        let deviation = vec![1e-3; 15];
        let histories = [History { displacement, velocity, force, deviation, compliance: 0.0, grid }];
        let shape =
            shapes(PortPlace::At(0.3)).into_iter().find(|shape| shape.law == PortLaw::Friction).unwrap();
        let found = regress(&histories, &shape).unwrap().coefficients;
        assert!((found[0] - 2.0).abs() < 1e-2 && (found[1] - 0.3).abs() < 1e-2, "{found:?}");
        assert_eq!(found[2], 0.0);
    }

    /// A run `d = a sin t + 0.3 a sin(2t + 1)` with a stop of 5 N/m from `gap` of it on, and 0.02 m lost by each newton of its mean force;
    /// the force is known to 1e-4 N in each of 24 lines.
    fn stopped(size: f64, gap: f64) -> History {
        let grid = Grid::new(24, SAMPLES).unwrap();
        let phase = |k: usize| std::f64::consts::TAU * k as f64 / SAMPLES as f64;
        let at = |k: usize| size * (phase(k).sin() + 0.3 * (2.0 * phase(k) + 1.0).sin());
        let speed = |k: usize| size * (phase(k).cos() + 0.6 * (2.0 * phase(k) + 1.0).cos());
        let displacement: Vec<f64> = (0..SAMPLES).map(at).collect();
        let force: Vec<f64> = displacement.iter().map(|d| 5.0 * (d - gap).max(0.0)).collect();
        let mut lines = vec![Complex64::ZERO; 25];
        grid.project(&force, &mut lines, &mut grid.scratch());
        History {
            displacement,
            velocity: (0..SAMPLES).map(speed).collect(),
            force: lines[1..].iter().map(|line| line / 1e-4).collect(),
            deviation: vec![1e-4; 24],
            compliance: 0.02,
            grid,
        }
    }

    /// Three runs that strike a stop, and one that stays short of it: friction holds each elsewhere, so that no gap meets all of them. With
    /// one in each, stiffness and dampers are those of the stop. The gap is that of the run that tells most of it, and there the
    /// motion rests where the mean force of the stop leaves it; a run that does not touch the stop tells nothing of where it rests.
    #[test]
    fn runs_that_rest_elsewhere_have_one_stop() {
        let gaps = [0.4, 0.1, 0.9, 1.0];
        let histories: Vec<History> =
            [1.0, 0.5, 2.0, 0.2].into_iter().zip(gaps).map(|(size, gap)| stopped(size, gap)).collect();
        let stops = shapes(PortPlace::At(0.3)).into_iter().filter(|shape| shape.law == PortLaw::Stop);
        let shape = stops.into_iter().find(|shape| shape.side > 0.0).unwrap();
        let plain = regress(&histories, &shape).unwrap();
        let found = regress_resting(&histories, &shape).unwrap();
        // The corner of a stop on a grid of 512 samples is off by a part in a thousand.
        assert!(plain.chi > 1e4 * found.chi && found.chi < 200.0, "{} {}", plain.chi, found.chi);
        let [stiffness, gap, damping, _] = found.coefficients;
        assert!((stiffness - 5.0).abs() < 5e-3 && damping.abs() < 5e-3, "{stiffness} {damping}");
        let mean = |k: usize| {
            let touched = histories[k].displacement.iter().map(|d| 5.0 * (d - gaps[k]).max(0.0));
            0.02 * touched.sum::<f64>() / SAMPLES as f64
        };
        assert!((gap - (gaps[2] - mean(2))).abs() < 2e-3, "{gap}");
        let rest = |k: usize| histories[k].rest(PortLaw::Stop, &found.coefficients);
        for k in [0, 1] {
            let expected = gaps[2] - mean(2) - (gaps[k] - mean(k));
            assert!((rest(k) - expected).abs() < 3e-3, "{k}: {} {expected}", rest(k));
        }
        assert!(rest(2).abs() < 3e-3, "{}", rest(2));
        assert_eq!(rest(3), 0.0);
    }
}
