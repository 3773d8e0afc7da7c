//! The model of the accelerations: its derivatives against differences, and its solutions however they are reached.

#![expect(clippy::unwrap_used, reason = "helpers of tests may unwrap")]

use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::accelerations::{
    AccelerationModel, Port, PortLaw, PortPlace, Prediction, Quantity, Rig, RunLines, SHARP, Setting,
};
use frettrace_friction::effects::{Hook, ModifiedLaw};
use num_complex::Complex64;

const LENGTH: f64 = 0.5;
const SUPPORT: f64 = 5e6;
const MODES: usize = 5;
const ORDER: usize = 9;

fn beam() -> UniformBeam {
    UniformBeam::rectangular(LENGTH, [0.03, 0.0075], 2e11, 7850.0)
}

/// Two runs near the first resonance of 99 Hz, below and above the level at which the contact slides, solved to 1e-9 of the
/// largest acceleration and better.
fn model() -> AccelerationModel {
    let rig = Rig {
        beam: beam(),
        boundary: Boundary::spring(SUPPORT),
        exciter: 0.23,
        sensors: vec![0.12, 0.27, 0.41],
        lever: Some(0.0037),
        known_support: None,
        modes: 40,
    };
    let run = |force: f64, progress: f64| {
        let mut lines = vec![Complex64::ZERO; ORDER + 1];
        lines[1] = force.into();
        RunLines {
            omega: std::f64::consts::TAU * 94.3,
            preload: 70.0,
            progress,
            worked: [progress; 2],
            force: lines,
            acceleration: vec![vec![Complex64::ZERO; ORDER + 1]; 3],
            deviation: vec![vec![1e-8; ORDER + 1]; 3],
            base_phase: 0.0,
            known_force: Vec::new(),
            contact_order: 24,
            samples: 256,
        }
    };
    AccelerationModel::new(rig, vec![run(0.6, 0.3), run(2.5, 1.0)]).unwrap()
}

/// As [`model`], at a tenth of its forces and solved to a hundredth of its imbalance, so that small effects can be differenced: a law with
/// a breakaway sticks and forgets nothing.
fn stuck() -> AccelerationModel {
    let model = model();
    let mut runs = model.runs.clone();
    for run in &mut runs {
        run.force.iter_mut().for_each(|force| *force *= 0.1);
        run.deviation.iter_mut().flatten().for_each(|deviation| *deviation *= 0.01);
    }
    model.with_runs(runs).unwrap()
}

/// A prediction corrected by what a grid with three times the lines of contact force adds is that of the fine grid, and so is the one beside the derivatives;
/// those are the coarse grid's, and a model with other runs has none of it.
#[test]
fn a_corrected_prediction_is_that_of_the_finer_grid() {
    let (coarse, setting) = (model(), setting());
    let mut runs = coarse.runs.clone();
    for run in &mut runs {
        (run.contact_order, run.samples) = (3 * run.contact_order, 1024);
    }
    let fine = coarse.with_runs(runs).unwrap();
    let predicted =
        |model: &AccelerationModel| model.predict(&setting, &[0, 1], &mut model.memory()).unwrap();
    let [plain, wanted] = [&coarse, &fine].map(predicted);
    let apart = difference(&wanted, &plain, 1.0);
    assert!(size(&apart) > 1e-6 * size(&wanted), "{:e}", size(&apart) / size(&wanted));
    // The first run keeps its own.
    let corrected = coarse.corrected(vec![None, Some(apart[1].clone())]).unwrap();
    let found = predicted(&corrected);
    assert_eq!(found[0], plain[0]);
    assert!(size(&difference(&found[1..], &wanted[1..], 1.0)) < 1e-12 * size(&wanted));
    let slopes = |model: &AccelerationModel| {
        let quantity = [Quantity::Law(Hook::MuKinetic)];
        model.linearise(&setting, &quantity, &[1], &mut model.memory()).unwrap().swap_remove(0)
    };
    let [own, beside] = [&coarse, &corrected].map(slopes);
    assert_eq!(beside.columns, own.columns);
    assert!(size(&difference(&[beside.prediction], &wanted[1..], 1.0)) < 1e-9 * size(&wanted));
    assert_eq!(predicted(&corrected.with_runs(corrected.runs.clone()).unwrap()), plain);
}

/// A bristle that holds without flowing up to half its friction, where the path pushes it to the side.
fn breakaway() -> Setting {
    let mut law = ModifiedLaw::dahl(5e5, 0.25);
    let hooks = [
        (Hook::StribeckRise, 0.1),
        (Hook::StribeckVelocity, 5e-3),
        (Hook::StribeckExponent, 2.0),
        (Hook::Sigma1, 3.0),
        (Hook::DampingVelocity, 1e-3),
        (Hook::Viscous, 4.0),
        (Hook::Breakaway, 0.5),
        (Hook::Position, 2e4),
    ];
    hooks.iter().for_each(|&(hook, value)| law.set(hook, value));
    Setting { law, ..setting() }
}

/// Everything that may be in a model, each at a value of its own.
fn setting() -> Setting {
    let options = ModalOptions { modes: MODES, ..ModalOptions::default() };
    let modes = ModalModel::new(&beam(), &Boundary::spring(SUPPORT), &options).unwrap();
    let law = ModifiedLaw::dahl(5e5, 0.25);
    let mut setting = Setting::new(modes.natural_frequency().to_vec(), vec![0.02; MODES], law, 3);
    let place = PortPlace::At(0.31);
    setting.ports = vec![Port { place, law: PortLaw::Polynomial, coefficients: [800.0, 0.3, 1e9, 2.0] }];
    setting.mass = Some([0.004, 0.2]);
    setting.base = Some([2e-8, -1e-8]);
    (setting.frequency_scale, setting.damping_scale) = (1e-4, 0.03);
    setting.clamp_compliance = 1e-3;
    setting.drift = 2e-4;
    setting.drift_course = [2.0, 0.5];
    setting.contact_compliance = 1e-9;
    let sensor = &mut setting.sensors[1];
    (sensor.gain, sensor.delay, sensor.lag, sensor.shift, sensor.offset) = (1.03, 2e-5, 4e-5, 1e-3, 0.2);
    setting
}

fn size(lines: &[Prediction]) -> f64 {
    lines.iter().flatten().flatten().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

fn difference(a: &[Prediction], b: &[Prediction], scale: f64) -> Vec<Prediction> {
    let lines =
        |a: &Vec<Complex64>, b: &Vec<Complex64>| a.iter().zip(b).map(|(a, b)| (a - b) * scale).collect();
    let run = |a: &Prediction, b: &Prediction| a.iter().zip(b).map(|(a, b)| lines(a, b)).collect();
    a.iter().zip(b).map(|(a, b)| run(a, b)).collect()
}

/// Derivatives by every quantity are central differences: a step of 1e-5 of its size `h` errs by `h²` and by what the solutions
/// are apart from the balance over `h`.
#[test]
fn derivatives_are_differences() {
    derivatives_agree(&model(), &setting());
}

/// The same where the contact sticks: what it came to from rest stays in it, and moves with the motion at the first sample.
#[test]
fn a_contact_that_forgets_nothing_keeps_what_it_came_to() {
    derivatives_agree(&stuck(), &breakaway());
}

fn derivatives_agree(model: &AccelerationModel, setting: &Setting) {
    let quantities = [
        (Quantity::ModeFrequency(0), 600.0),
        (Quantity::ModeDamping(0), 0.02),
        (Quantity::FrequencyScale, 1e-2),
        (Quantity::DampingScale, 1.0),
        (Quantity::Law(Hook::Sigma0), 5e5),
        (Quantity::Law(Hook::MuKinetic), 0.25),
        (Quantity::Port(0, 0), 800.0),
        (Quantity::Port(0, 2), 1e13),
        (Quantity::Port(0, 3), 2.0),
        (Quantity::PortPosition(0), 0.31),
        (Quantity::AddedMass, 0.004),
        (Quantity::MassPosition, 0.2),
        (Quantity::ClampCompliance, 1.0),
        (Quantity::Drift, 1e-2),
        (Quantity::DriftRate, 10.0),
        (Quantity::DriftSlowing, 10.0),
        (Quantity::ContactCompliance, 1e-8),
        (Quantity::BaseReal, 2e-7),
        (Quantity::BaseImaginary, 2e-7),
        (Quantity::Gain(1), 1.0),
        (Quantity::Delay(1), 1e-4),
        (Quantity::Lag(1), 1e-4),
        (Quantity::Shift(1), 1e-1),
        (Quantity::CommonShift, 1e-1),
        (Quantity::Offset(1), 1.0),
    ];
    let asked: Vec<Quantity> = quantities.iter().map(|(quantity, _)| *quantity).collect();
    let mut memory = model.memory();
    let found = model.linearise(setting, &asked, &[0, 1], &mut memory).unwrap();
    for (k, (quantity, scale)) in quantities.into_iter().enumerate() {
        let step = 1e-5 * scale;
        let moved = |by: f64| {
            let mut moved = setting.clone();
            moved.set(quantity, setting.get(quantity).unwrap() + by);
            model.predict(&moved, &[0, 1], &mut memory.clone()).unwrap()
        };
        let expected = difference(&moved(step), &moved(-step), 0.5 / step);
        let column: Vec<Prediction> = found.iter().map(|run| run.columns[k].clone()).collect();
        // What does not slide answers nothing to what only sliding knows.
        let error = size(&difference(&column, &expected, 1.0)) / size(&expected).max(f64::MIN_POSITIVE);
        assert!(error < 2e-4, "{quantity:?}: {error:e}");
    }
}

/// All natural frequencies by a share `s` more are those of a beam and a support `(1 + s)²` as stiff, with its static flexibility; all
/// damping ratios by a share more are so declared.
#[test]
fn scales_are_another_modulus_and_another_damping() {
    let sideways = |model: &AccelerationModel, stiffer: f64| {
        let mut rig = Rig { lever: None, ..model.rig().clone() };
        rig.beam.bending_stiffness *= stiffer;
        rig.boundary = Boundary::spring(SUPPORT * stiffer);
        AccelerationModel::new(rig, model.runs.clone()).unwrap()
    };
    let (frequency, damping) = (0.012, 0.4);
    let law = ModifiedLaw::dahl(2e3, 0.25);
    let plain = Setting::new(setting().frequency[..2].to_vec(), vec![0.01, 0.02], law, 3);
    let scaled = Setting { frequency_scale: frequency, damping_scale: damping, ..plain.clone() };
    let declared = Setting {
        frequency: plain.frequency.iter().map(|f| f * (1.0 + frequency)).collect(),
        damping: plain.damping.iter().map(|d| d * (1.0 + damping)).collect(),
        ..plain
    };
    let predicted = |model: AccelerationModel, setting: &Setting| {
        model.predict(setting, &[0, 1], &mut model.memory()).unwrap()
    };
    let found = predicted(sideways(&model(), 1.0), &scaled);
    let expected = predicted(sideways(&model(), (1.0 + frequency).powi(2)), &declared);
    assert!(size(&difference(&found, &expected, 1.0)) < 1e-9 * size(&expected));
}

/// What follows the exciter does so wherever a record begins: with the force a number of samples of the phase grid later, all lines
/// are later by as much.
#[test]
fn a_modulated_preload_follows_the_excitation() {
    let mut law = ModifiedLaw::dahl(5e5, 0.25);
    law.set(Hook::ModulationCosine, 0.2);
    law.set(Hook::ModulationSine, -0.1);
    let plain = Setting { law, ..setting() };
    let model = model();
    let later = |line: usize| Complex64::from_polar(1.0, -std::f64::consts::TAU * 40.0 / 256.0 * line as f64);
    let mut runs = model.runs.clone();
    for run in &mut runs {
        run.force.iter_mut().enumerate().for_each(|(h, force)| *force *= later(h));
    }
    RunLines::follow_excitation(&mut runs);
    let moved = model.with_runs(runs).unwrap();
    let mut expected = model.predict(&plain, &[0, 1], &mut model.memory()).unwrap();
    for lines in expected.iter_mut().flatten() {
        lines.iter_mut().enumerate().for_each(|(h, line)| *line *= later(h));
    }
    let found = moved.predict(&plain, &[0, 1], &mut moved.memory()).unwrap();
    let error = size(&difference(&found, &expected, 1.0)) / size(&expected);
    assert!(error < 1e-7, "{error:e}");
}

/// A stop that a run strikes 3 µm farther out because its friction holds the beam away is a stop with a gap 3 µm wider where nothing does;
/// what the law itself makes of the mean of the friction moves neither. Without a stop the mean of the friction is seen nowhere.
#[test]
fn a_stop_feels_where_friction_holds_the_beam() {
    let model = model();
    let stop = |gap: f64, rests: Vec<f64>| {
        let place = PortPlace::At(0.31);
        let port = Port { place, law: PortLaw::Stop, coefficients: [2e5, gap, 5.0, SHARP] };
        Setting { ports: vec![port], rests: (0, rests), ..setting() }
    };
    let predict = |setting: &Setting| model.predict(setting, &[0, 1], &mut model.memory()).unwrap();
    let held = predict(&stop(4e-6, vec![-3e-6; 2]));
    let wider = predict(&stop(7e-6, vec![0.0; 2]));
    let free = predict(&stop(4e-6, vec![0.0; 2]));
    let error = |a: &[Prediction], b: &[Prediction]| size(&difference(a, b, 1.0)) / size(b);
    // A mean force of the stop that is not quite balanced shows on no line itself: the tolerance lets it be off by as much.
    assert!(error(&held, &wider) < 5e-5, "{:e}", error(&held, &wider));
    assert!(error(&free, &wider) > 1e-2, "{:e}", error(&free, &wider));
}

/// A stop on one side, touched or pressed before anything moves, presses back with a mean that no accelerometer sees: from accelerations that were
/// read, a balance begins with that mean and comes to the motion that was read. From no mean it came to no balance.
#[test]
fn a_balance_begins_with_what_its_stop_answers() {
    let model = model();
    for (stiffness, gap) in [(3e8, -1e-5), (3e8, -4e-5), (1e9, 1e-6), (1e9, 0.0)] {
        let place = PortPlace::At(0.31);
        let port = Port { place, law: PortLaw::Round, coefficients: [stiffness, gap, 0.0, 1.0] };
        let setting = Setting { ports: vec![port], ..setting() };
        // The motion by a way of its own: the stop is made stiffer step by step.
        let (mut memory, mut known) = (model.memory(), Vec::new());
        for step in 0..=20 {
            let mut softer = setting.clone();
            softer.ports[0].coefficients[0] *= f64::from(step) / 20.0;
            known = model.approach(&softer, &[0, 1], &mut memory).unwrap();
        }
        let mut runs = model.runs.clone();
        runs.iter_mut().zip(&known).for_each(|(run, read)| run.acceleration.clone_from(read));
        let read = model.with_runs(runs).unwrap();
        let found = read.predict(&setting, &[0, 1], &mut read.memory()).unwrap();
        let error = size(&difference(&found, &known, 1.0)) / size(&known);
        assert!(error < 1e-8, "{error:e}");
    }
}

/// A channel with a low pass reads `1/√2` of a line at its corner, an eighth of a period late.
#[test]
fn a_low_pass_has_its_corner() {
    let (model, mut setting) = (model(), setting());
    setting.sensors[1] = Default::default();
    let mut memory = model.memory();
    let plain = model.predict(&setting, &[1], &mut memory).unwrap();
    setting.sensors[1].lag = 1.0 / (3.0 * model.runs[1].omega);
    let late = model.predict(&setting, &[1], &mut memory).unwrap();
    let ratio = late[0][1][3] / plain[0][1][3];
    let corner = Complex64::from_polar(std::f64::consts::FRAC_1_SQRT_2, -std::f64::consts::FRAC_PI_4);
    assert!((ratio - corner).norm() < 1e-9, "{ratio}");
    assert_eq!(late[0][0], plain[0][0]);
}

/// The gradient of χ² of the balance, `2 Re Σ left* ∂left`, against central differences, for readings that no model of this structure
/// makes: a structure with another first mode and a sensor that is off, beside what is not of any line.
#[test]
fn gradients_of_the_balance_are_differences() {
    let (mut model, mut setting) = (model(), setting());
    setting.ports.clear();
    let mut other = setting.clone();
    other.frequency[0] *= 1.004;
    other.sensors[2].gain = 0.97;
    let read = model.predict(&other, &[0, 1], &mut model.memory()).unwrap();
    let largest = read.iter().flatten().flatten().map(|line| line.norm()).fold(0.0, f64::max);
    for (run, read) in model.runs.iter_mut().zip(read) {
        run.acceleration = read;
        for (s, lines) in run.acceleration.iter_mut().enumerate() {
            for (h, line) in lines.iter_mut().enumerate() {
                *line += Complex64::from_polar(1e-2 * largest, (3 * s + 2 * h) as f64);
            }
        }
        run.deviation = vec![vec![1e-3 * largest; ORDER + 1]; 3];
    }
    let quantities = [
        (Quantity::ModeFrequency(0), 600.0),
        (Quantity::ModeDamping(1), 0.02),
        (Quantity::AddedMass, 0.004),
        (Quantity::MassPosition, 0.2),
        (Quantity::ClampCompliance, 1.0),
        (Quantity::Drift, 1e-2),
        (Quantity::DriftRate, 10.0),
        (Quantity::BaseReal, 2e-7),
        (Quantity::BaseImaginary, 2e-7),
        (Quantity::Gain(1), 1.0),
        (Quantity::Delay(1), 1e-4),
        (Quantity::Lag(1), 1e-4),
        (Quantity::Shift(1), 1e-1),
        (Quantity::CommonShift, 1e-1),
        (Quantity::Offset(1), 1.0),
    ];
    let asked: Vec<Quantity> = quantities.iter().map(|(quantity, _)| *quantity).collect();
    let found = model.balance_slopes(&setting, &asked, &[0, 1]).unwrap();
    let plain = model.balance(&setting, &[0, 1]).unwrap();
    for ((balance, _), plain) in found.iter().zip(&plain) {
        assert_eq!(balance.left, plain.left);
    }
    let chi = |setting: &Setting| -> f64 {
        let balances = model.balance(setting, &[0, 1]).unwrap();
        balances.iter().flat_map(|b| b.left.iter().flatten()).map(Complex64::norm_sqr).sum()
    };
    for (k, (quantity, scale)) in quantities.into_iter().enumerate() {
        let step = 1e-6 * scale;
        let moved = |by: f64| {
            let mut moved = setting.clone();
            moved.set(quantity, setting.get(quantity).unwrap() + by);
            chi(&moved)
        };
        let expected = (moved(step) - moved(-step)) / (2.0 * step);
        let product = |(left, change): (&Complex64, &Complex64)| 2.0 * (left.conj() * change).re;
        let slopes = found.iter().flat_map(|(balance, columns)| {
            balance.left.iter().flatten().zip(columns[k].iter().flatten()).map(product)
        });
        let slope: f64 = slopes.sum();
        assert!((slope - expected).abs() < 1e-3 * expected.abs(), "{quantity:?}: {slope:e} {expected:e}");
    }
}

/// Where friction changes with the place, the static compliance holds the contact where its mean force is `F̄ = −ū/R₀`; without
/// that it is centred, whatever its force.
#[test]
fn friction_that_changes_with_the_place_has_its_place() {
    let (model, mut setting) = (model(), setting());
    // What a spring along the beam holds of the mean is no part of the compliance without it.
    setting.ports.clear();
    setting.law.set(Hook::StribeckRise, 0.05);
    setting.law.set(Hook::StribeckVelocity, 1e-3);
    setting.law.set(Hook::Asymmetry, 0.2);
    let mean = |samples: &[f64]| samples.iter().sum::<f64>() / samples.len() as f64;
    let centred = model.contact(&setting, 1, &mut model.memory()).unwrap();
    assert!(mean(&centred.slip).abs() < 1e-12 && mean(&centred.force).abs() > 0.1);
    setting.law.set(Hook::Position, 2e3);
    let mut memory = model.memory();
    let placed = model.contact(&setting, 1, &mut memory).unwrap();
    let give = model.balance(&setting, &[1]).unwrap()[0].slip_gain[0].re;
    let (slip, force) = (mean(&placed.slip), mean(&placed.force));
    assert!(slip.abs() > 1e-8 && (slip / (-give * force) - 1.0).abs() < 1e-6, "{slip:e} {force:e} {give:e}");
    // The derivatives know that the place moves.
    let asked = [Quantity::Law(Hook::Position), Quantity::Law(Hook::MuKinetic), Quantity::ModeFrequency(0)];
    let found = model.linearise(&setting, &asked, &[1], &mut memory).unwrap();
    for (k, (quantity, step)) in asked.into_iter().zip([2e-2, 2.5e-6, 6e-3]).enumerate() {
        let moved = |by: f64| {
            let mut moved = setting.clone();
            moved.set(quantity, setting.get(quantity).unwrap() + by);
            model.predict(&moved, &[1], &mut memory.clone()).unwrap()
        };
        let expected = difference(&moved(step), &moved(-step), 0.5 / step);
        let column = [found[0].columns[k].clone()];
        // What does not slide answers nothing to what only sliding knows.
        let error = size(&difference(&column, &expected, 1.0)) / size(&expected).max(f64::MIN_POSITIVE);
        assert!(error < 2e-4, "{quantity:?}: {error:e}");
    }
}

/// A bristle that does not flow keeps `z = σ₀ u` from rest, its mean with it, and the force of a modulated preload is `P (1 + m cos θ) σ₀ u`: the
/// mean slip is `ū = −R₀ F̄`, and what it makes of the modulation, `P m σ₀ ū cos θ`, is a force on the excitation's line.
#[test]
fn a_bristle_that_forgets_nothing_feels_its_mean_through_the_preload() {
    let (sigma, share) = (5e5, 0.2);
    let mut law = ModifiedLaw::dahl(sigma, 0.25);
    law.set(Hook::Breakaway, 0.9);
    law.set(Hook::ModulationCosine, share);
    law.set(Hook::ModulationSine, 0.0);
    let mut setting = Setting { law, ..setting() };
    derivatives_agree(&stuck(), &setting);
    // What a spring along the beam holds of the mean is no part of the compliance without it.
    setting.ports.clear();
    let model = stuck();
    let found = model.contact(&setting, 1, &mut model.memory()).unwrap();
    let samples = found.slip.len() as f64;
    let preload = model.runs[1].preload;
    for (k, ((slip, normal), force)) in found.slip.iter().zip(&found.normal).zip(&found.force).enumerate() {
        let pressed = normal + preload * share * (std::f64::consts::TAU * k as f64 / samples).cos();
        let expected = pressed * sigma * slip;
        assert!((force - expected).abs() < 1e-6 * preload * 0.25, "{k}: {force} {expected}");
    }
    let mean = |samples: &[f64]| samples.iter().sum::<f64>() / samples.len() as f64;
    let give = model.balance(&setting, &[1]).unwrap()[0].slip_gain[0].re;
    let (slip, force) = (mean(&found.slip), mean(&found.force));
    assert!(slip.abs() > 1e-10 && (slip / (-give * force) - 1.0).abs() < 1e-6, "{slip:e} {force:e} {give:e}");
}

/// One that slid on its way has another deflection `z₀` where its period begins, and keeps `z₀ + σ₀ (u − u(0))`: a value of the run, by which
/// the modulation's force on the excitation's line is another one. Where the law's bristle would settle, it does not.
#[test]
fn a_contact_that_has_not_settled_has_a_deflection_of_its_own() {
    let (sigma, share, deflection) = (5e5, 0.2, 0.03);
    let mut law = ModifiedLaw::dahl(sigma, 0.25);
    law.set(Hook::Breakaway, 0.9);
    law.set(Hook::ModulationCosine, share);
    law.set(Hook::ModulationSine, 0.0);
    let mut setting = Setting { law, deflections: vec![Some(deflection); 2], ..setting() };
    derivatives_agree(&stuck(), &setting);
    let model = stuck();
    let found = model.contact(&setting, 1, &mut model.memory()).unwrap();
    let (samples, preload) = (found.slip.len() as f64, model.runs[1].preload);
    for (k, ((slip, normal), force)) in found.slip.iter().zip(&found.normal).zip(&found.force).enumerate() {
        let pressed = normal + preload * share * (std::f64::consts::TAU * k as f64 / samples).cos();
        let expected = pressed * (deflection + sigma * (slip - found.slip[0]));
        assert!((force - expected).abs() < 1e-6 * preload * 0.25, "{k}: {force} {expected}");
    }
    assert!((found.deflection - deflection).abs() < 1e-12 && found.creep.abs() < 1e-9);
    // A bristle that yields from the start forgets, and creeps towards what it would settle to.
    setting.law.set(Hook::Breakaway, 0.0);
    derivatives_agree(&stuck(), &setting);
    let found = model.contact(&setting, 1, &mut model.memory()).unwrap();
    setting.deflections.clear();
    let settled = model.contact(&setting, 1, &mut model.memory()).unwrap();
    assert!((found.deflection - deflection).abs() < 1e-12 && settled.creep == 0.0);
    let away = deflection - settled.deflection;
    assert!(found.creep * away < 0.0 && found.creep.abs() < away.abs(), "{:e} of {away:e}", found.creep);
}

/// A contact that only pushes along or against its motion has the same slopes at every instant: what grows with `s` meets the slip per
/// force of all modes, `R(s) = Σ (r φ'_n)²/(s² + 2ζ_n ω_n s + ω_n²)`, and the margin is the least `1 + (K + cs)R(s)` of what lines do not follow.
#[test]
fn margin_of_stability_is_that_of_the_frozen_contact() {
    let model = model();
    let modal = ModalModel::new(
        &beam(),
        &Boundary::spring(SUPPORT),
        &ModalOptions { modes: model.rig().modes, damping_ratio: vec![0.02], ..ModalOptions::default() },
    )
    .unwrap();
    let probe = modal.probe(&[Dof::rotation(LENGTH)]);
    let lever = model.rig().lever.unwrap();
    let receptance = |s: f64| -> f64 {
        let modes = modal.natural_frequency().iter().enumerate();
        modes.map(|(n, w)| (lever * probe.shape(n)[0]).powi(2) / (s * s + 0.04 * w * s + w * w)).sum()
    };
    let highest = modal.natural_frequency()[model.rig().modes - 1];
    // A sixteenth of the contact's last line.
    let slowest = 24.0 / 16.0 * model.runs[0].omega;
    let rates = || (0..20_000).map(|k| slowest * (4.0 * highest / slowest).powf(f64::from(k) / 20_000.0));
    let mut setting = Setting::new(Vec::new(), Vec::new(), ModifiedLaw::dahl(1e-6, 1e-9), 3);
    (setting.frequency, setting.damping) = (vec![modal.natural_frequency()[0]], vec![0.02]);
    let margin = |hook: Hook, value: f64| {
        let mut setting = setting.clone();
        setting.law.set(hook, value);
        let found = model.stability_margin(&setting, &[0, 1], &mut model.memory()).unwrap();
        [0, 1].map(|run| found[run].unwrap())
    };
    // What holds, and what damps, is no danger.
    assert_eq!(margin(Hook::Viscous, 300.0), [1.0; 2]);
    assert_eq!(margin(Hook::ParallelStiffness, 1e5), [1.0; 2]);
    // Half of what meets the beam: damping where it grows fast, a spring at the slowest rate that is asked.
    let fastest = rates().map(|s| s * receptance(s)).fold(0.0, f64::max);
    let found = margin(Hook::Viscous, -0.5 / fastest);
    assert!(found.iter().all(|margin| (margin - 0.5).abs() < 2e-3), "{found:?}");
    let found = margin(Hook::ParallelStiffness, -0.5 / receptance(slowest));
    assert!(found.iter().all(|margin| (margin - 0.5).abs() < 2e-3), "{found:?}");
}
