use super::mean::mean_slip;
use super::*;
use crate::Scales;
use crate::effects::ALL;
use crate::series::Series;
use frettrace_forward::accelerations::Quantity;
use frettrace_friction::effects::Circumstance;
use frettrace_identify::Model;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A slip of two lines under a normal force that varies: in periods of 50 ms it goes 20 µm to and fro.
fn motion(rigid: bool) -> Recovered {
    let (samples, order, omega) = (256, 24, TAU / 0.05);
    let at = |of: fn(f64) -> f64, size: f64| -> Vec<f64> {
        (0..samples).map(|k| size * of(TAU * k as f64 / samples as f64)).collect()
    };
    let slip = at(|t| t.cos() + 0.3 * (2.0 * t).sin(), 2e-5);
    let velocity = at(|t| -t.sin() + 0.6 * (2.0 * t).cos(), 2e-5 * omega);
    let trial = if rigid { velocity.iter().map(|v| 4e3 * v).collect() } else { Vec::new() };
    Recovered {
        run: 0,
        slip,
        velocity,
        normal: at(|t| 50.0 + 12.0 * t.sin(), 1.0),
        force: vec![Complex64::ZERO; order + 1],
        deviation: vec![0.01; order + 1],
        trial,
        grid: Grid::new(order, samples).unwrap(),
        dt: 0.05 / samples as f64,
        preload: 50.0,
        progress: 0.4,
        worked: [0.7; 2],
        driven: 1,
        base_phase: 0.3,
        give: 1e-4,
        first: 1,
    }
}

fn laws() -> [ModifiedLaw<f64>; 3] {
    let dahl = ModifiedLaw::dahl(1.5e5, 0.4);
    let mut lugre = dahl;
    let velocity = 5e-4;
    for (hook, value) in [
        (Hook::StribeckRise, 0.15),
        (Hook::StribeckVelocity, velocity),
        (Hook::StribeckExponent, 1.7),
        (Hook::Sigma1, 3.0),
        (Hook::DampingVelocity, 2.0 * velocity),
        (Hook::Viscous, 40.0),
    ] {
        lugre.set(hook, value);
    }
    let mut hybrid = lugre;
    hybrid.set(Hook::Breakaway, 0.4);
    [dahl, lugre, hybrid]
}

/// The derivatives of every form of every effect of the contact, with those of the law and of the mean slip, against central
/// differences: they are the same but for the square of the step.
#[test]
fn derivatives_are_those_of_differences() {
    let scales = Scales {
        slip: 2.6e-5,
        velocity: 4e-3,
        period: 0.05,
        preload: 50.0,
        length: 1.0,
        mass: 1.0,
        subharmonic: 1,
    };
    let (mut compared, mut apart) = (0, Vec::new());
    for (law, rigid) in laws().into_iter().zip([false; 3]).chain([(laws()[0], true)]) {
        let recovered = Contacts { periodic: vec![motion(rigid)], series: Vec::new(), leeway: None };
        for effect in ALL {
            for form in effect.contact_forms(&law, &scales) {
                let mut law = law;
                let own: Vec<Hook> = Hook::ALL.into_iter().filter(|h| law.get(*h).is_some()).collect();
                form.changes.iter().for_each(|change| law.set(change.hook, change.start));
                let brought = form.changes.iter().filter(|c| c.parameter.is_some()).map(|c| c.hook);
                let hooks: Vec<Hook> = own.into_iter().chain(brought).collect();
                let mean = law.depends_on_place().then_some(4e-6);
                let values: Vec<f64> = hooks.iter().filter_map(|h| law.get(*h)).chain(mean).collect();
                let free = vec![true; values.len()];
                let problem = ContactProblem::new(
                    &recovered,
                    (law, form.modulation.unwrap_or(FrequencyRatio::ONE)),
                    (hooks.clone(), Vec::new()),
                );
                let rows = problem.residual_count();
                let mut residual = vec![0.0; rows];
                let mut jacobian = DMatrix::zeros(rows, values.len());
                problem
                    .linearise(&values, &free, &mut problem.memory(), (&mut residual, &mut jacobian))
                    .unwrap();
                for j in 0..values.len() {
                    let step = if values[j] == 0.0 { 1e-6 } else { 1e-5 * values[j] };
                    let moved = |by: f64| {
                        let mut values = values.clone();
                        values[j] += by;
                        let mut out = vec![0.0; rows];
                        problem.residual(&values, &mut problem.memory(), &mut out).unwrap();
                        out
                    };
                    let (above, below) = (moved(step), moved(-step));
                    let slopes = above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * step));
                    let column = jacobian.column(j);
                    let error: f64 = slopes.zip(column.iter()).map(|(d, s)| (d - s).powi(2)).sum();
                    let size = column.norm();
                    // Rounding of the residuals, of the size of the force over its deviation, is divided by the step.
                    let rounding = 1e-14 * residual.iter().map(|r| r * r).sum::<f64>().sqrt() / step.abs();
                    if error.sqrt() > 1e-3 * size + rounding {
                        let error = error.sqrt();
                        apart.push(format!("{} {:?}: {error:.1e} of {size:.1e}", effect.id(), hooks.get(j)));
                    }
                    compared += 1;
                }
            }
        }
    }
    assert!(apart.is_empty(), "{apart:#?}");
    assert!(compared > 500, "{compared}");
}

/// A friction coefficient that falls along the path by 0.3 over the stroke, around a mean slip of a fifth of the stroke: a contact
/// that is centred misses it, and its mean is found again from the force's lines. The law's answer makes the lines, on four times
/// the samples, and its mean is held by a structure of just the static compliance that it asks for.
#[test]
fn a_mean_slip_shows_in_a_friction_that_depends_on_the_place() {
    let mut law = laws()[0];
    law.set(Hook::Position, 0.3 / 2.6e-5);
    let (mean, samples, omega) = (4e-6, 1024, TAU / 0.05);
    let at = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..samples).map(|k| of(TAU * f64::from(k) / f64::from(samples))).collect()
    };
    let fine = Recovered {
        slip: at(&|t| mean + 2e-5 * (t.cos() + 0.3 * (2.0 * t).sin())),
        velocity: at(&|t| 2e-5 * omega * (-t.sin() + 0.6 * (2.0 * t).cos())),
        normal: at(&|t| 50.0 + 12.0 * t.sin()),
        grid: Grid::new(24, samples as usize).unwrap(),
        dt: 0.05 / f64::from(samples),
        ..motion(false)
    };
    let force = fine.lines(&fine.settled(&law, FrequencyRatio::ONE).1);
    let give = -mean / force[0].re;
    let mut seen = Recovered { force, give, ..motion(false) };
    seen.force[0] = Complex64::ZERO;
    let cost = |run: &Recovered| {
        let mut left = vec![0.0; run.count()];
        run.residual(&law, FrequencyRatio::ONE, &mut left);
        left.iter().map(|r| r * r).sum::<f64>()
    };
    assert!(cost(&seen.around(mean)) < 1e-3 * cost(&seen), "{} {}", cost(&seen.around(mean)), cost(&seen));
    let found = mean_slip(&seen, (law, FrequencyRatio::ONE)).unwrap();
    assert!((found - mean).abs() < 0.02 * mean, "{found:e}");
}

/// Both values of the structure would go five deviations up: the second may, to 12.5, the first ends before its 20.
const BOUNDS: (f64, f64) = (7.8, 15.0);

/// The residual and its derivatives with the structure's leeway against the dense formulas: `(I + D Dᵀ)^(−1/2) r` by the eigenvectors of
/// the whole matrix, `δ̂ = −Dᵀ (I + D Dᵀ)⁻¹ r` by its inverse, within the bounds of each value. Two runs, two values of the structure that move slip and force, and a law whose mean
/// slips add rows that the structure has no part in.
#[test]
fn leeway_whitens_as_its_formula_says() {
    let shifted = |slip: f64, force: f64| {
        let mut run = motion(false);
        run.slip.iter_mut().for_each(|u| *u *= 1.0 + slip);
        run.force[1] += Complex64::new(force, -0.5 * force);
        run
    };
    let plain = vec![motion(false), shifted(0.2, 3.0)];
    let moved = |quantity, std, slip, force| Moved {
        quantity,
        value: 10.0,
        std,
        bounds: BOUNDS,
        contacts: vec![shifted(slip, force), shifted(0.2 + slip, 3.0 - force)],
    };
    let values = vec![
        moved(Quantity::ModeFrequency(0), 2.0, 0.01, 0.1),
        moved(Quantity::ModeDamping(0), 0.5, -0.02, 0.0),
    ];
    let [law, ..] = laws();
    let mut placed = law;
    placed.set(Hook::Position, 0.3 / 2.6e-5);
    for law in [law, placed] {
        let leeway = Leeway::new(plain.clone(), clones(&values), (&law, FrequencyRatio::ONE)).map(Arc::new);
        let with = Contacts { periodic: plain.clone(), series: Vec::new(), leeway };
        let without = Contacts { leeway: None, ..with.clone() };
        let problem = |contacts| {
            ContactProblem::new(contacts, (law, FrequencyRatio::ONE), (vec![Hook::Sigma0], vec![]))
        };
        let (open, tight) = (problem(&with), problem(&without));
        let rows = tight.residual_count();
        let mut at = vec![law.get(Hook::Sigma0).unwrap()];
        at.resize(open.parameters().len() + 1, 0.0);
        let linear = |problem: &ContactProblem<'_>| {
            let (mut residual, mut jacobian) = (vec![0.0; rows], DMatrix::zeros(rows, at.len()));
            let target = (&mut residual[..], &mut jacobian);
            problem.linearise(&at, &vec![true; at.len()], &mut problem.memory(), target).unwrap();
            (DMatrix::from_column_slice(rows, 1, &residual), jacobian)
        };
        let directions = directions(&law, [&plain, &values[0].contacts, &values[1].contacts], rows);
        let covariance = DMatrix::identity(rows, rows) + &directions * directions.transpose();
        let parts = covariance.clone().symmetric_eigen();
        let root = parts.eigenvalues.map(|value| value.sqrt().recip());
        let whitening = &parts.eigenvectors * DMatrix::from_diagonal(&root) * parts.eigenvectors.transpose();
        let ((residual, jacobian), (whitened, slopes)) = (linear(&tight), linear(&open));
        assert!((&whitening * &residual - whitened).amax() < 1e-9 * residual.amax());
        assert!((&whitening * &jacobian - slopes).amax() < 1e-9 * jacobian.amax());
        let off = -directions.transpose() * covariance.try_inverse().unwrap() * &residual;
        let likely = open.structure(&at);
        for ((found, off), std) in likely.iter().zip(off.iter()).zip([2.0, 0.5]) {
            let expected = (10.0 + std * off.clamp(-5.0, 5.0)).clamp(BOUNDS.0, BOUNDS.1);
            assert!((found.1 - expected).abs() < 1e-6, "{found:?} {expected}");
        }
    }
}

fn clones(values: &[Moved]) -> Vec<Moved> {
    let same = |one: &Moved| Moved { contacts: one.contacts.clone(), ..*one };
    values.iter().map(same).collect()
}

/// What each value of the structure changes of the residual of a law, row by row; the rows of the means stay as they are.
fn directions(
    law: &ModifiedLaw<f64>,
    [plain, first, second]: [&Vec<Recovered>; 3],
    rows: usize,
) -> DMatrix<f64> {
    let means = if law.depends_on_place() { 2 } else { 0 };
    let left = |runs: &[Recovered]| {
        let of_run = |run: &Recovered| {
            let mut left = vec![0.0; run.count()];
            run.residual(law, FrequencyRatio::ONE, &mut left);
            std::iter::repeat_n(0.0, means).chain(left).collect::<Vec<f64>>()
        };
        DMatrix::from_vec(rows, 1, runs.iter().flat_map(of_run).collect())
    };
    let columns = [first, second].map(|moved| left(moved) - left(plain));
    DMatrix::from_columns(&columns.map(|column| column.column(0).into_owned()))
}

/// A run without a period beside one with: its mean slip is a value of its own, by which the residual changes as differences say; it begins where
/// the periodic run rests.
#[test]
fn a_run_without_a_period_rests_somewhere_too() {
    let mut law = laws()[0];
    law.set(Hook::Position, 0.3 / 2.6e-5);
    let (dt, samples) = (1.0 / 2048.0, 2048);
    let tone = |rate: f64, k: usize| TAU * rate * k as f64 * dt;
    let slip = |k: usize| 2e-5 * (tone(20.0, k).sin() + 0.6 * tone(13.7, k).cos());
    let velocity = |k: usize| 2e-5 * TAU * (20.0 * tone(20.0, k).cos() - 0.6 * 13.7 * tone(13.7, k).sin());
    let mut series = Series {
        dt,
        slip: (0..samples).map(slip).collect(),
        velocity: (0..samples).map(velocity).collect(),
        normal: vec![50.0; samples],
        force: Vec::new(),
        deviation: vec![1e-3; samples / 2 + 1],
        open_share: 0.0,
    };
    let pressed = Circumstance { preload: 50.0, ..Circumstance::default() };
    series.force = series.answer(&law, &pressed, None);
    let contact = SeriesContact::new(&series, pressed, (false, usize::MAX)).unwrap();
    let recovered =
        Contacts { periodic: vec![motion(false)], series: vec![(5, Arc::new(contact))], leeway: None };
    let hooks = vec![Hook::Sigma0, Hook::MuKinetic, Hook::Position];
    let problem = ContactProblem::new(&recovered, (law, FrequencyRatio::ONE), (hooks.clone(), Vec::new()));
    assert_eq!(problem.means_from(&[(0, 4e-6)]), [4e-6, 4e-6]);
    assert_eq!(problem.means_from(&[(0, 4e-6), (5, 1e-6)]), [4e-6, 1e-6]);
    let values: Vec<f64> = hooks.iter().filter_map(|h| law.get(*h)).chain([4e-6, 3e-6]).collect();
    assert_eq!(problem.mean_slips(&values), [(0, 4e-6), (5, 3e-6)]);
    let rows = problem.residual_count();
    let (mut residual, mut jacobian) = (vec![0.0; rows], DMatrix::zeros(rows, values.len()));
    problem.linearise(&values, &[true; 5], &mut problem.memory(), (&mut residual, &mut jacobian)).unwrap();
    let moved = |by: f64| {
        let mut values = values.clone();
        values[4] += by;
        let mut out = vec![0.0; rows];
        problem.residual(&values, &mut problem.memory(), &mut out).unwrap();
        DVector::from_vec(out)
    };
    let slope = (moved(1e-9) - moved(-1e-9)) / 2e-9;
    let column = jacobian.column(4);
    assert!(column.norm() > 0.0 && (&slope - column).norm() < 1e-2 * slope.norm());
    // Rows of the periodic run do not know of it.
    assert!(column.iter().take(recovered.periodic[0].count() + 2).all(|x| *x == 0.0));
}

/// A contact that slides in every run: after a reversal a Dahl bristle loses its force over `ln 2` of `μ/σ0`, an elastic one over less, so
/// that the stiffness read off there is that of the law to a factor of 1.5, where the force over the slip tells a fifth of it.
#[test]
fn reversals_tell_the_stiffness_of_what_slides() {
    for law in [laws()[0], laws()[2]] {
        let mut one = motion(false);
        let (_, force) = one.settled(&law, FrequencyRatio::ONE);
        one.force = one.lines(&force)[..one.force.len()].to_vec();
        let contacts = Contacts { periodic: vec![one], series: Vec::new(), leeway: None };
        let [mu, sigma0] = contacts.sizes().unwrap();
        let [own_mu, own] = [Hook::MuKinetic, Hook::Sigma0].map(|hook| law.get(hook).unwrap());
        assert!((0.8..1.5).contains(&(mu / own_mu)), "{mu}");
        assert!((0.8..1.6).contains(&(sigma0 / own)), "{sigma0:e}");
    }
}
