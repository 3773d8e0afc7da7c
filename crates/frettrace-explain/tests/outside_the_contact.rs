//! Effects outside the friction contact on rigs from the time march: 72 modes at 131 kHz, where the model that explains them
//! sums 40 modes on harmonics.

#![expect(clippy::unwrap_used, reason = "helpers of tests may unwrap")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use frettrace_beam::{Boundary, ModalModel, ModalOptions, UniformBeam};
use frettrace_explain::{
    Case, ChannelFault, Control, DeclaredModes, Outcome, Place, Question, RunRecord, RunSamples, Split,
    Study, Verdict, controls, explain, records,
};
use frettrace_forward::accelerations::{Quantity, Rig};
use frettrace_forward::march::Characteristic;
use frettrace_forward::simulate::{
    Attached, Chain, CrossTalk, Hum, NormalContact, Sampling, SimulatedLaw, SimulatedRecord, SimulatedRig,
    SimulatedRun, SimulatedSensor, Slip, Steps, simulate,
};
use frettrace_friction::Law;
use frettrace_friction::effects::{Hook, ModifiedLaw};
use frettrace_identify::contact::Family;

const LENGTH: f64 = 0.5;
const RATE: f64 = 4096.0;
const NOISE: f64 = 0.05;
/// Close below the first resonance of 99 Hz; the record holds no whole number of periods.
const FREQUENCY: f64 = 94.3;
const MODES: usize = 6;

fn beam() -> UniformBeam {
    UniformBeam::rectangular(LENGTH, [0.03, 0.0075], 2.0e11, 7850.0)
}

fn rig() -> SimulatedRig {
    let parameters =
        BTreeMap::from([("sigma0", 5e5), ("mu_k", 0.25), ("exponent", 1.0)].map(|(n, v)| (n.to_owned(), v)));
    let sensor = |position| SimulatedSensor {
        position,
        chain: Chain { noise: NOISE, ..Chain::default() },
        cross_talk: None,
    };
    SimulatedRig {
        beam: beam(),
        boundary: Boundary::spring(5e6),
        modes: 72,
        natural_frequency: Vec::new(),
        damping_ratio: vec![0.02],
        slip: Slip::Rotation { lever_arm: 0.0037 },
        normal: NormalContact::default(),
        law: SimulatedLaw::Declared(Law::Dahl.with_named(&parameters).unwrap()),
        exciter: 0.23,
        exciter_lever: 0.0,
        second_force: None,
        sensors: [0.09, 0.16, 0.27, 0.36, 0.45].map(sensor).to_vec(),
        attached: Vec::new(),
        second_support: None,
        base: None,
        sampling: Sampling { rate: RATE, samples: 2048, oversampling: 32, steps: Steps::Given(1) },
        seed: 11,
    }
}

fn measured(rig: &SimulatedRig, amplitudes: &[f64]) -> Vec<SimulatedRecord> {
    let run = |force_amplitude| SimulatedRun {
        force_amplitude,
        beat: None,
        omega: TAU * FREQUENCY,
        preload: 70.0,
        modulation: None,
        frequency_factor: 1.0,
        progress: 0.0,
    };
    amplitudes.iter().enumerate().map(|(k, &a)| simulate(rig, &run(a), k as u64).unwrap()).collect()
}

fn samples(measured: &[SimulatedRecord]) -> Vec<RunSamples<'_>> {
    measured.iter().map(|record| run(FREQUENCY, &record.force, &record.acceleration)).collect()
}

fn run<'a>(excitation_frequency: f64, force: &'a [f64], acceleration: &'a [Vec<f64>]) -> RunSamples<'a> {
    RunSamples { sampling_rate: RATE, excitation_frequency, preload: 70.0, force, acceleration }
}

/// What a file would declare: nothing of what is attached or wrong.
fn declared(rig: &SimulatedRig, measured: &[SimulatedRecord]) -> Case {
    let noise = vec![NOISE; rig.sensors.len()];
    let (records, faults) = records(&samples(measured), Some(&noise)).unwrap();
    let options = ModalOptions { modes: MODES, ..ModalOptions::default() };
    let frequency = ModalModel::new(&rig.beam, &rig.boundary, &options).unwrap().natural_frequency().to_vec();
    let mut case = Case {
        rig: Rig {
            beam: rig.beam,
            boundary: rig.boundary,
            exciter: rig.exciter,
            sensors: rig.sensors.iter().map(|s| s.position).collect(),
            lever: Some(0.0037),
            known_support: None,
            modes: 40,
        },
        records,
        modes: DeclaredModes {
            frequency_std: frequency.iter().map(|f| 1e-5 * f).collect(),
            damping: vec![0.02; MODES],
            damping_std: vec![2e-5; MODES],
            measured: MODES,
            frequency,
        },
        law: Family::Dahl,
        faults,
        shaken: None,
        without: Vec::new(),
        aside: Vec::new(),
    };
    case.leave_out_saturated().unwrap();
    case
}

const LEVELS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];

fn explained(rig: &SimulatedRig, without: &[&str]) -> Outcome {
    let measured = measured(rig, &LEVELS);
    let mut case = declared(rig, &measured);
    case.without = without.iter().map(|id| (*id).to_owned()).collect();
    explain(&case).unwrap()
}

/// Issue 8: placed within 1 % of the length, error left within 1.2 of the noise on runs that nothing was fitted to.
fn check_placed(outcome: &Outcome, id: &str, position: f64) {
    assert_eq!(outcome.verdict, Verdict::Explained);
    let named: Vec<&str> = outcome.effects.iter().map(|e| e.id).collect();
    assert_eq!(named, [id]);
    let found = outcome.effects[0].position.unwrap();
    assert!((found - position).abs() < 0.01 * LENGTH, "{id} at {found} m, put at {position} m");
    let [before, after] = outcome.held_out.unwrap();
    assert!(
        before.ratio() > 1.5 && after.ratio() < 1.2,
        "{} before, {} after",
        before.ratio(),
        after.ratio()
    );
}

#[test]
fn nothing_is_missed_where_nothing_is_missing() {
    let outcome = explained(&rig(), &[]);
    assert_eq!(outcome.verdict, Verdict::NothingMissing, "{:?}", outcome.effects);
    assert!(outcome.place.is_none());
}

/// The same rig under another law, everything else as declared.
fn clean(family: Family, law: Law, values: &[(&str, f64)]) -> Outcome {
    let parameters: BTreeMap<String, f64> = values.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect();
    let mut rig = rig();
    rig.law = SimulatedLaw::Declared(law.with_named(&parameters).unwrap());
    let mut case = declared(&rig, &measured(&rig, &LEVELS));
    case.law = family;
    explain(&case).unwrap()
}

/// Friction that is set-valued at rest is fitted as such: it sticks throughout at the lowest level and slides at the others.
/// The march places a jump within a step of its 32 a sample, 1e-4 of a period: μ to 2e-3.
#[test]
fn coulomb_friction_needs_no_effect_to_be_met() {
    let outcome = clean(Family::Coulomb, Law::Coulomb, &[("mu_k", 0.25)]);
    assert_eq!(outcome.verdict, Verdict::NothingMissing, "{:?}", outcome.effects);
    let found = outcome.model.fitted.setting.law.get(Hook::MuKinetic).unwrap();
    assert!((found / 0.25 - 1.0).abs() < 2e-3, "{found}");
}

/// Twice the lines divide the error of a rigid contact's phase grid by about three: half of what parts two grids is more than what parts the
/// finer one from one that is finer still. It is counted among the deviations of the lines, beside the noise.
#[test]
fn a_phase_grid_is_doubted_by_what_it_leaves() {
    let parameters = BTreeMap::from([("mu_k".to_owned(), 0.25)]);
    let mut rig = rig();
    rig.law = SimulatedLaw::Declared(Law::Coulomb.with_named(&parameters).unwrap());
    let mut case = declared(&rig, &measured(&rig, &LEVELS));
    case.law = Family::Coulomb;
    let (study, setting) = Study::new(&case, Split::First).unwrap();
    let fitted = study.fit(setting, &case.unknowns(), &study.model.memory(), 10).unwrap();
    let mut finer = study.refined().unwrap().unwrap();
    finer.doubt_grid(&fitted).unwrap();
    let finest = finer.refined().unwrap().unwrap();
    let runs = study.training.clone();
    let [now, next] = [&finer, &finest].map(|study| study.predictions(&fitted, &runs));
    let mut slid = 0;
    for ((&run, now), next) in runs.iter().zip(now).zip(next) {
        let known = &case.records[run].lines.deviation;
        let (mut left, mut doubted) = (0.0, 0.0);
        for (s, (now, next)) in now.unwrap().iter().zip(next.unwrap()).enumerate() {
            for (h, (now, next)) in now.iter().zip(next).enumerate() {
                let std = finer.model.runs[run].deviation[s][h];
                assert!(std >= known[s][h]);
                left += (now - next).norm_sqr();
                doubted += std * std - known[s][h] * known[s][h];
            }
        }
        assert!(left <= doubted, "run {run}: {left:.2e} {doubted:.2e}");
        slid += usize::from(doubted > 0.0);
    }
    assert!(slid > 0);
}

/// A rigid contact with more friction than any level asks for holds all the time: nothing of its law shows but that, and no law
/// that slides may stand in its place.
#[test]
fn a_contact_that_never_slides_lacks_nothing() {
    let values = [("mu_k", 8.0), ("mu_s", 10.0), ("v_s", 1e-3), ("delta", 2.0), ("sigma2", 0.0)];
    let outcome = clean(Family::Stribeck, Law::Stribeck, &values);
    assert_eq!(outcome.verdict, Verdict::NothingMissing, "{:?}", outcome.effects);
    assert!(outcome.error[0].ratio() < 1.05, "{:?}", outcome.error);
}

/// A rigid contact of which one run slides, its friction falling within a twentieth of the top speed: what it holds at rest is beyond
/// what the recovered motion resolves, and a law that holds too much has no answer. The structure is off by up to the 5e-4 that its
/// declaration allows.
#[test]
fn a_contact_of_which_one_run_slides_lacks_nothing() {
    let values = [("mu_k", 0.3), ("mu_s", 0.45), ("v_s", 2.4e-3), ("delta", 1.0), ("sigma2", 28.0)];
    let parameters: BTreeMap<String, f64> = values.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect();
    let mut rig = rig();
    rig.slip = Slip::Transverse;
    rig.boundary = Boundary::spring(0.0);
    rig.law = SimulatedLaw::Declared(Law::Stribeck.with_named(&parameters).unwrap());
    rig.sampling.oversampling = 64;
    let mut case = declared(&rig, &measured(&rig, &[2.0, 4.0, 8.0, 30.0]));
    case.law = Family::Stribeck;
    case.rig.lever = None;
    for (frequency, share) in case.modes.frequency.iter_mut().zip([4e-4, -3e-4, 5e-4, -4e-4, 2e-4, -5e-4]) {
        *frequency *= 1.0 + share;
    }
    case.modes.frequency_std = case.modes.frequency.iter().map(|f| 5e-4 * f).collect();
    let outcome = explain(&case).unwrap();
    assert_eq!(outcome.verdict, Verdict::NothingMissing, "{:?}", outcome.effects);
    let found = outcome.model.fitted.setting.law.get(Hook::MuKinetic).unwrap();
    assert!((found / 0.3 - 1.0).abs() < 0.02, "{found}");
}

/// A bristle whose range is a thousandth of the slip answers on all lines of the balance.
#[test]
fn a_stiff_bristle_is_met() {
    let outcome = clean(Family::Dahl, Law::Dahl, &[("sigma0", 2e7), ("mu_k", 0.25), ("exponent", 1.0)]);
    assert_eq!(outcome.verdict, Verdict::NothingMissing, "{:?}", outcome.effects);
}

#[test]
fn a_stop_along_the_beam_is_a_second_support_in_its_place() {
    let mut rig = rig();
    // Touched at the three higher levels, where the beam moves by 0.03 to 0.1 mm there.
    rig.attached = vec![(0.31, Attached::Load(Characteristic::Stop { stiffness: 4e4, gap: 1.5e-5 }))];
    check_placed(&explained(&rig, &[]), "structure.second-support", 0.31);
}

#[test]
fn a_cubic_spring_is_told_from_a_support_by_its_shape() {
    let mut rig = rig();
    rig.attached = vec![(0.34, Attached::Load(Characteristic::CubicSpring(5e12)))];
    check_placed(&explained(&rig, &[]), "structure.cubic-stiffness", 0.34);
}

/// The same spring where its name is not asked for: a support with a cubic spring beside a stiffness of nothing follows the runs as well, and
/// is no support.
#[test]
fn a_support_that_does_not_carry_is_none() {
    let mut rig = rig();
    rig.attached = vec![(0.34, Attached::Load(Characteristic::CubicSpring(5e12)))];
    let outcome = explained(&rig, &["structure.cubic-stiffness"]);
    assert_eq!(outcome.verdict, Verdict::Unexplained, "{:?}", outcome.effects);
    assert_eq!(outcome.place, Some(Place::Structure));
}

/// The first mode declared with five sixths of its damping, each damping to a thousandth. Its true value is found to a hundredth.
#[test]
fn a_mode_is_damped_otherwise_than_declared() {
    let rig = rig();
    let mut case = declared(&rig, &measured(&rig, &LEVELS));
    case.modes.damping[0] = 0.02 / 1.2;
    let outcome = explain(&case).unwrap();
    assert_eq!(outcome.verdict, Verdict::Explained);
    let named: Vec<&str> = outcome.effects.iter().map(|e| e.id).collect();
    assert_eq!(named, ["structure.modal-damping"]);
    let found = outcome.model.fitted.setting.damping[0];
    assert!((found / 0.02 - 1.0).abs() < 0.01, "{found}");
}

/// The first natural frequency declared 4.7 of its deviations off is another one, and says so while every error is at its floor; 2.5 are chance.
#[test]
fn a_frequency_beyond_its_deviation_is_named() {
    let rig = rig();
    let mut case = declared(&rig, &measured(&rig, &LEVELS));
    let frequency = case.modes.frequency[0];
    for (deviations, named) in [(2.5, None), (4.7, Some("structure.modal-frequency"))] {
        case.modes.frequency[0] = frequency * (1.0 + deviations * 1e-5);
        let outcome = explain(&case).unwrap();
        assert_eq!(outcome.effects.first().map(|e| e.id), named, "{deviations}");
        assert!(outcome.effects.len() < 2 && outcome.error[0].ratio() < 1.02, "{deviations}");
        if named.is_some() {
            let found = outcome.model.fitted.setting.frequency[0];
            assert!((found / frequency - 1.0).abs() < 1e-5, "{found} instead of {frequency}");
        }
    }
}

/// Natural frequencies that fall by 0.2 % while the rig warms up, `1 − e^{−4p}` of it by `p` of the runs: one name, its size to a
/// hundredth (its standard error is 0.4 %). The first and the last run are among the fitted ones; without the last the end is guessed.
#[test]
fn a_drift_may_settle() {
    let rig = rig();
    let levels = [2.0, 4.0, 16.0, 12.0, 1.0, 8.0];
    let run = |(k, force_amplitude): (usize, f64)| {
        let progress = k as f64 / (levels.len() - 1) as f64;
        let course = (-4.0 * progress).exp_m1() / (-4.0_f64).exp_m1();
        let one = SimulatedRun {
            force_amplitude,
            beat: None,
            omega: TAU * FREQUENCY,
            preload: 70.0,
            modulation: None,
            frequency_factor: 1.0 - 2e-3 * course,
            progress,
        };
        simulate(&rig, &one, k as u64).unwrap()
    };
    let measured: Vec<SimulatedRecord> = levels.into_iter().enumerate().map(run).collect();
    let outcome = explain(&declared(&rig, &measured)).unwrap();
    let named: Vec<&str> = outcome.effects.iter().map(|e| e.id).collect();
    assert_eq!(named, ["structure.frequency-drift"]);
    let drift = outcome.model.fitted.setting.drift;
    assert!((drift / -2e-3 - 1.0).abs() < 0.01, "{drift}");
}

/// Friction with waves of 60 µm under an end that slides sideways and that nothing but the beam's own stiffness centres: each run
/// settles around a mean slip of its own. The wave length is found to a hundredth.
#[test]
fn waves_along_the_path_are_found_around_any_mean() {
    let mut rig = rig();
    rig.slip = Slip::Transverse;
    rig.boundary = Boundary::spring(0.0);
    let mut law = ModifiedLaw::dahl(4e3, 0.04);
    let number = TAU / 6e-5;
    law.set(Hook::PeriodicCosine, 0.0);
    law.set(Hook::PeriodicSine, 0.2);
    law.set(Hook::PeriodicNumber, number);
    law.set(Hook::PeriodicCosine2, 0.0);
    law.set(Hook::PeriodicCosine3, 0.0);
    // A sine, and a wave that rises faster than it falls.
    for harmonics in [[0.0, 0.0], [0.06, 0.02]] {
        law.set(Hook::PeriodicSine2, harmonics[0]);
        law.set(Hook::PeriodicSine3, harmonics[1]);
        rig.law = SimulatedLaw::Modified(law);
        let mut case = declared(&rig, &measured(&rig, &[2.0, 4.0, 6.0, 9.0, 13.0, 20.0]));
        case.rig.lever = None;
        let outcome = explain(&case).unwrap();
        let named: Vec<&str> = outcome.effects.iter().map(|e| e.id).collect();
        assert_eq!(named, ["friction.position-periodic"], "{harmonics:?}");
        let found = outcome.model.fitted.setting.law.get(Hook::PeriodicNumber).unwrap();
        assert!((found / number - 1.0).abs() < 0.01, "{harmonics:?}: {found}");
    }
}

/// Corners of loops send lines of force beyond those of the grid: all runs bend the values in one direction, by more than the noise lets them
/// stray.
#[test]
fn what_the_phase_grid_bends_counts_in_the_intervals() {
    let mut rig = rig();
    let mut law = ModifiedLaw::dahl(5e5, 0.25);
    let truth =
        [(Hook::Sigma0, 5e5), (Hook::MuKinetic, 0.25), (Hook::Sigma1, 240.0), (Hook::DampingVelocity, 4e-3)];
    truth.iter().for_each(|&(hook, value)| law.set(hook, value));
    rig.law = SimulatedLaw::Modified(law);
    let outcome = explained(&rig, &[]);
    let named: Vec<&str> = outcome.effects.iter().map(|e| e.id).collect();
    assert_eq!(named, ["friction.presliding-damping"]);
    for (hook, value) in truth {
        let found = outcome.model.fitted.setting.law.get(hook).unwrap();
        let std = outcome.model.deviation(Quantity::Law(hook));
        assert!((found - value).abs() < 2.5 * std, "{hook:?} {found} ± {std}, {value} put in");
    }
}

#[test]
fn without_its_name_the_place_stays() {
    let mut rig = rig();
    rig.attached = vec![(0.34, Attached::Load(Characteristic::QuadraticDashpot(30.0)))];
    check_placed(&explained(&rig, &[]), "structure.quadratic-damping", 0.34);
    let nameless = explained(&rig, &["structure.quadratic-damping", "structure.second-support"]);
    assert_eq!(nameless.verdict, Verdict::Unexplained, "{:?}", nameless.effects);
    assert_eq!(nameless.place, Some(Place::Structure));
}

/// A contact that stiffens as it is pressed, without its name: a force across the beam at the support closes the balance, as well as one a little
/// beside it would, and answers to the motion there.
#[test]
fn a_force_across_the_support_is_the_contacts() {
    let mut rig = rig();
    rig.normal.sharpness = 0.6;
    let nameless = explained(&rig, &["contact.normal-stiffening"]);
    assert_eq!(nameless.verdict, Verdict::Unexplained, "{:?}", nameless.effects);
    assert_eq!(nameless.place, Some(Place::Contact));
}

/// Two channels, one of which hears a little of the other: nearly the gain of a sensor beside which all move alike, and the error of all
/// samples together is within the noise with it. What its lines hold beyond the noise is left at that sensor alone.
#[test]
fn cross_talk_is_no_gain() {
    let mut rig = rig();
    rig.sensors[3].cross_talk = Some(CrossTalk { from: 1, share: 0.02 });
    let outcome = explained(&rig, &[]);
    assert_eq!((outcome.verdict, outcome.place), (Verdict::Unexplained, Some(Place::Measurement)));
}

/// A sensor 6 % too strong is named, and without the name the place is still the measurement chain.
#[test]
fn a_gain_belongs_to_its_sensor() {
    let mut rig = rig();
    rig.sensors[3].chain.gain = 1.06;
    let outcome = explained(&rig, &[]);
    assert_eq!(outcome.verdict, Verdict::Explained);
    assert_eq!((outcome.effects[0].id, outcome.effects[0].sensor), ("measurement.gain", Some(3)));
    let nameless = explained(&rig, &["measurement.gain", "measurement.position"]);
    assert_eq!(nameless.place, Some(Place::Measurement), "{:?}", nameless.verdict);
}

/// A clamp that gives way (a rotational stiffness of 800 `EI/L`, declared rigid) with a sensor that is 30 µs late, and a mass of half a per cent of the
/// beam's with a sensor 3 mm off: with either effect alone the model is as far off as the other one makes it.
#[test]
fn two_effects_outside_the_contact_are_told_together() {
    let plain = rig();
    let mut late = plain.clone();
    late.boundary.clamp_rotational_stiffness = 800.0 * late.beam.bending_stiffness / LENGTH;
    late.sensors[1].chain.delay = 3e-5;
    let mut shifted = plain.clone();
    shifted.attached = vec![(0.35, Attached::Mass(5e-3 * shifted.beam.mass_per_length * LENGTH))];
    shifted.sensors[3].position += 3e-3;
    let both = [
        (late, ["measurement.delay", "structure.clamp-compliance"]),
        (shifted, ["measurement.position", "structure.added-mass"]),
    ];
    for (rig, acting) in both {
        let mut case = declared(&rig, &measured(&rig, &LEVELS));
        let as_declared = declared(&plain, &[]);
        (case.rig, case.modes) = (as_declared.rig, as_declared.modes);
        let outcome = explain(&case).unwrap();
        let mut named: Vec<&str> = outcome.effects.iter().map(|e| e.id).collect();
        named.sort_unstable();
        assert_eq!(named, acting, "{:?}", outcome.held_out);
        let after = outcome.held_out.unwrap()[1].ratio();
        assert!(after < 1.2, "{acting:?}: {after}");
    }
}

/// A soft limit has no flat tops: the other sensors say what the channel should read. Its formula is not the one that is fitted.
#[test]
fn a_soft_limit_belongs_to_its_sensor() {
    let rig = rig();
    let mut measured = measured(&rig, &LEVELS);
    let loudest = measured[4].acceleration[3].iter().fold(0.0, |peak, a| a.abs().max(peak));
    let limit = 1.2 * loudest;
    for record in &mut measured {
        record.acceleration[3].iter_mut().for_each(|a| *a = limit * (*a / limit).tanh());
    }
    let outcome = explain(&declared(&rig, &measured)).unwrap();
    assert_eq!(outcome.verdict, Verdict::Explained);
    let named: Vec<(&str, Option<usize>)> = outcome.effects.iter().map(|e| (e.id, e.sensor)).collect();
    assert_eq!(named, [("measurement.clipping", Some(3))]);
    let [before, after] = outcome.error;
    assert!(before.ratio() > 1.5 && after.ratio() < 1.05, "{} {}", before.ratio(), after.ratio());
}

/// Faults that the samples themselves show, with the sensor that has each; the runs stay periodic.
#[test]
fn faults_of_channels_are_seen_in_their_samples() {
    let mut rig = rig();
    rig.sensors[0].chain.offset = 0.3;
    rig.sensors[1].chain.hum = Some(Hum { amplitude: 0.4, frequency: 50.0, phase: 0.7, third: 0.0 });
    // The third sensor reads up to 60 m/s² at the highest level.
    rig.sensors[2].chain.limit = 30.0;
    rig.sensors[4].chain.dropouts = vec![[0.4, 0.47]];
    let measured = measured(&rig, &LEVELS);
    let noise = vec![NOISE; rig.sensors.len()];
    let (found, faults) = records(&samples(&measured), Some(&noise)).unwrap();
    let mut seen: Vec<(&str, usize)> = faults.iter().map(|f: &ChannelFault| (f.id, f.sensor)).collect();
    seen.sort_unstable();
    let expected = [
        ("measurement.clipping", 2),
        ("measurement.dropout", 4),
        ("measurement.hum", 1),
        ("measurement.offset", 0),
    ];
    assert_eq!(seen, expected);
    assert!(found.iter().all(|r| r.periodic));
    let value = |id: &str| faults.iter().find(|f| f.id == id).unwrap().parameters.clone();
    // The offset's standard error is below the noise over the root of all samples, 5e-4 m/s².
    assert!((value("measurement.offset")[0].2 - 0.3).abs() < 5e-3);
    assert!((value("measurement.clipping")[0].2 - 30.0).abs() < 1e-9);
    // The amplitude's is 7e-4 m/s² in each run.
    assert!((value("measurement.hum")[1].2 - 0.4).abs() < 5e-3);
    // 7 % of the record and two samples to each side.
    assert!((value("measurement.dropout")[0].2 - 0.07).abs() < 4e-3);
}

/// An offset that grows from nothing at the first run to 0.3 m/s² at the last; its slope's standard error is below 1e-3 m/s².
#[test]
fn an_offset_may_drift() {
    let rig = rig();
    let mut measured = measured(&rig, &LEVELS);
    for (k, record) in measured.iter_mut().enumerate() {
        record.acceleration[2].iter_mut().for_each(|a| *a += 0.3 * k as f64 / 4.0);
    }
    let (_, faults) = records(&samples(&measured), Some(&[NOISE; 5])).unwrap();
    let seen: Vec<(&str, usize)> = faults.iter().map(|f: &ChannelFault| (f.id, f.sensor)).collect();
    assert_eq!(seen, [("measurement.offset", 2)]);
    let values: Vec<f64> = faults[0].parameters.iter().map(|p| p.2).collect();
    assert!(values[0].abs() < 5e-3 && (values[1] - 0.3).abs() < 1e-2, "{values:?}");
}

/// An offset that grows over every record, from nothing to 0.3 m/s²: its mean is 0.15. It leaves something at every frequency, and
/// is neither hum nor a motion without a period. The ramp's standard error is `2 NOISE √(3/n)`, 4e-3 m/s² in each of five runs.
#[test]
fn an_offset_may_drift_over_the_record() {
    let mut rig = rig();
    rig.sensors[2].chain.offset_drift = 0.3;
    let (found, faults) = records(&samples(&measured(&rig, &LEVELS)), Some(&[NOISE; 5])).unwrap();
    let seen: Vec<(&str, usize)> = faults.iter().map(|f: &ChannelFault| (f.id, f.sensor)).collect();
    assert_eq!(seen, [("measurement.offset", 2)]);
    assert!(found.iter().all(|r| r.periodic));
    let value = |name: &str| faults[0].parameters.iter().find(|p| p.0 == name).unwrap().2;
    assert!((value("drift_over_record") - 0.3).abs() < 5e-3, "{faults:?}");
    assert!((value("offset") - 0.15).abs() < 5e-3, "{faults:?}");
}

/// A motion slower than the record by the shape of a mode, in one run or in all: loud in the last sensor alone (a ramp of 2.5
/// deviations, 1.94 are) and sure in three (0.54 are), or loud in most. What sensors see alike is a motion.
#[test]
fn a_slow_motion_is_no_drift() {
    let still = measured(&rig(), &LEVELS);
    let count = still[0].force.len() as f64;
    for sizes in [[0.1, 0.3, 0.8, 1.5, 2.5], [2.6, 0.3, 2.2, 2.8, 2.5]] {
        for runs in [3..4, 0..5] {
            let mut measured = still.clone();
            for (size, channel) in
                measured[runs].iter_mut().flat_map(|r| sizes.iter().zip(&mut r.acceleration))
            {
                for (k, a) in channel.iter_mut().enumerate() {
                    *a += size * NOISE * (2.0 * k as f64 / count - 1.0);
                }
            }
            let (_, faults) = records(&samples(&measured), Some(&[NOISE; 5])).unwrap();
            assert!(faults.is_empty(), "{faults:?}");
        }
    }
}

/// A motion without a period in most runs, slow parts in it: a tone of 7.3 Hz, 3.65 periods in the record, by the shape of a mode, with
/// its sign and phase from run to run. What a polynomial makes of it is no drift of the sensor that hears it most.
#[test]
fn a_motion_without_a_period_is_no_drift() {
    let mut measured = measured(&rig(), &LEVELS);
    for (run, record) in measured.iter_mut().enumerate().skip(1) {
        for (size, channel) in [0.1, 0.3, 0.8, 1.5, 2.5].iter().zip(&mut record.acceleration) {
            for (k, a) in channel.iter_mut().enumerate() {
                let place = if *size > 2.0 { 0.4 * run as f64 } else { 0.9 * (run * run) as f64 * size };
                *a += 8.0 * size * NOISE * (TAU * 7.3 * k as f64 / RATE + place).sin();
            }
        }
    }
    let (_, faults) = records(&samples(&measured), Some(&[NOISE; 5])).unwrap();
    assert!(faults.is_empty(), "{faults:?}");
}

/// A motion whose 165th line is nearly as large as the noise is no less periodic than one without: models end at the 160th line, and what is
/// above it is in no error. So it is where half the frequency is in the motion too.
#[test]
fn lines_above_those_of_a_model_are_in_no_error() {
    for (half, subharmonic) in [(0.0, 1), (3.0, 2)] {
        check_lines_above(half, subharmonic);
    }
}

fn check_lines_above(half: f64, subharmonic: usize) {
    let line = |h: f64, k: usize| (TAU * h * k as f64 / 400.0).cos();
    // Bits mixed by a multiplication with the golden section.
    let white = |k: usize| ((k as f64 + 1.0) * 0.618_033_988_749_894_9).fract() - 0.5;
    let force: Vec<f64> = (0..8000).map(|k| line(1.0, k)).collect();
    let channel = |k: usize| {
        10.0 * line(1.0, k)
            + half * line(0.5, k)
            + NOISE * (0.8 * line(165.0, k) + 12.0_f64.sqrt() * white(k))
    };
    let acceleration = [(0..8000).map(channel).collect()];
    let run = run(RATE / 400.0, &force, &acceleration);
    let found = RunRecord::new(&run, Some(&[NOISE]), 0.0).unwrap();
    assert_eq!((found.subharmonic, found.periodic), (subharmonic, true));
    // √1.32 with it.
    let left = found.beside[0].sqrt() / NOISE;
    assert!((0.95..1.02).contains(&left), "{left}");
    let share = found.untrusted / (0.32 * NOISE * NOISE / found.power[0]);
    assert!((0.8..1.3).contains(&share), "{share}");
}

/// Noise between -½ and ½: bits mixed as by splitmix64.
fn white(k: u64) -> f64 {
    let z = (k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}

/// What moves most runs with half the frequency is in a quiet one too, where its line of 0.002 m/s² is the 0.04th of the noise; a single loud run says nothing
/// of the others.
#[test]
fn what_most_runs_move_with_is_in_the_quiet_ones_too() {
    let excitation = 94.3;
    let line = |h: f64, k: u64| (TAU * h * excitation * k as f64 / RATE).cos();
    let force: Vec<f64> = (0..2048).map(|k| line(1.0, k)).collect();
    let channel = |run: u64, size: f64| {
        let one = |k: u64| size * (line(1.0, k) + 0.04 * line(0.5, k));
        (0..2048).map(|k| one(k) + NOISE * 12.0_f64.sqrt() * white(k + 2048 * run)).collect::<Vec<f64>>()
    };
    let subharmonics = |sizes: [f64; 3]| {
        let acceleration = [0, 1, 2].map(|run| [channel(run as u64, sizes[run])]);
        let runs: Vec<_> = acceleration.iter().map(|channels| run(excitation, &force, channels)).collect();
        let (found, _) = records(&runs, Some(&[NOISE])).unwrap();
        assert!(found.iter().all(|record| record.periodic));
        found.iter().map(|record| record.subharmonic).collect::<Vec<_>>()
    };
    assert_eq!(subharmonics([0.05, 10.0, 20.0]), [2, 2, 2]);
    assert_eq!(subharmonics([0.05, 0.1, 20.0]), [1, 1, 2]);
}

/// A free decay beside a line of 32.8 Hz: lines at the fifths of that, of which 6.56 Hz is near to its 6.9 Hz, hold most of it and leave
/// more than the noise. It is a motion that has not settled, by a share of its power of 4e-5, and no subharmonic one.
#[test]
fn what_has_not_settled_is_no_subharmonic() {
    let excitation = 32.8;
    let line = |k: u64| (TAU * excitation * k as f64 / RATE).cos();
    let decay = |k: u64| {
        let t = k as f64 / RATE;
        (-0.14 * t).exp() * (TAU * 6.9 * t).cos()
    };
    let force: Vec<f64> = (0..2048).map(line).collect();
    let channel = |k: u64| 60.0 * line(k) + 0.4 * decay(k) + NOISE * 12.0_f64.sqrt() * white(k);
    let acceleration = [(0..2048).map(channel).collect()];
    let run = run(excitation, &force, &acceleration);
    let found = RunRecord::new(&run, Some(&[NOISE]), 0.0).unwrap();
    assert_eq!((found.subharmonic, found.periodic), (1, true));
}

/// Mains of 60 Hz lie 0.21 Hz beside the third of an excitation of 179.36 Hz, a fortieth of a bin of an eighth of a second. Where one
/// sensor alone hears them they are no motion; where two do, a third of the excitation is what fits.
#[test]
fn what_one_sensor_hears_is_no_subharmonic() {
    let excitation = 179.36;
    let samples = (RATE / 8.0) as usize;
    let line = |f: f64, k: usize| (TAU * f * k as f64 / RATE).cos();
    let force: Vec<f64> = (0..samples).map(|k| line(excitation, k)).collect();
    for (hums, subharmonic) in [([4.0, 0.0], 1), ([4.0, 4.0], 3)] {
        let channel = |s: usize, k: usize| {
            let noise = 12.0_f64.sqrt() * white((k + samples * s) as u64);
            60.0 * line(excitation, k) + NOISE * (hums[s] * line(60.0, k) + noise)
        };
        let acceleration: Vec<Vec<f64>> =
            (0..2).map(|s| (0..samples).map(|k| channel(s, k)).collect()).collect();
        let run = run(excitation, &force, &acceleration);
        let found = RunRecord::new(&run, Some(&[NOISE; 2]), 0.0).unwrap();
        assert_eq!(found.subharmonic, subharmonic);
    }
}

/// Hum of 2 m/s² with a third harmonic over 24½ periods of the mains (49 halves of 41 samples): what a polynomial makes of the broken
/// one, about `2·2/(24.5 π)` = 0.05 m/s² at the ends of the record, is no drift. Its standard error is 7e-4 m/s² in each run.
#[test]
fn hum_over_a_broken_period_is_no_drift() {
    for phase in [0.0, 0.8, 1.6] {
        let mut rig = rig();
        rig.sensors[1].chain.hum = Some(Hum { amplitude: 2.0, frequency: 50.0, phase, third: 0.4 });
        let mut measured = measured(&rig, &LEVELS[..3]);
        for record in &mut measured {
            record.force.truncate(2007);
            record.acceleration.iter_mut().for_each(|a| a.truncate(2007));
        }
        let (_, faults) = records(&samples(&measured), Some(&[NOISE; 5])).unwrap();
        let seen: Vec<(&str, usize)> = faults.iter().map(|f: &ChannelFault| (f.id, f.sensor)).collect();
        assert_eq!(seen, [("measurement.hum", 1)], "{faults:?}");
        assert!((faults[0].parameters[1].2 - 2.0).abs() < 5e-3, "{faults:?}");
    }
}

/// A tone of 120 Hz in all sensors of one run and in no other, as a motion without a period has: mains would be in every run.
#[test]
fn a_tone_of_one_run_is_no_hum() {
    let mut measured = measured(&rig(), &LEVELS);
    for (size, channel) in [0.3, 0.4, 0.6, 0.7, 0.5].iter().zip(&mut measured[3].acceleration) {
        for (k, a) in channel.iter_mut().enumerate() {
            *a += size * (TAU * 120.0 * k as f64 / RATE).sin();
        }
    }
    let (_, faults) = records(&samples(&measured), Some(&[NOISE; 5])).unwrap();
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn sound_channels_have_no_faults() {
    let measured = measured(&rig(), &LEVELS);
    let (_, faults) = records(&samples(&measured), Some(&[NOISE; 5])).unwrap();
    assert!(faults.is_empty(), "{faults:?}");
}

/// Asked again where the answer is known: nothing is claimed on the declared model and noise, the name left out leaves something
/// missing, and the effect is found again at full and at half size.
#[test]
fn controls_answer_as_they_must() {
    let mut rig = rig();
    rig.attached = vec![(0.31, Attached::Mass(0.004))];
    let case = declared(&rig, &measured(&rig, &LEVELS));
    let outcome = explain(&case).unwrap();
    assert_eq!(outcome.effects[0].id, "structure.added-mass");
    let asked = controls(&case, &outcome, 2, 5).unwrap();
    let questions: Vec<Question> = asked.iter().map(|control| control.question).collect();
    let injected = [1.0, 0.5].map(Question::Injection);
    assert_eq!(
        questions,
        [Question::Surrogate, Question::Surrogate, Question::LeftOut, injected[0], injected[1]]
    );
    assert!(asked.iter().all(|control| control.right), "{asked:?}");
    let named = |control: &Control| control.named.clone();
    assert!(named(&asked[0]).is_empty() && named(&asked[3]) == ["structure.added-mass"]);
    assert_ne!(asked[2].verdict, Verdict::NothingMissing);
    // The same draws on every call, other draws from another seed.
    assert_eq!(controls(&case, &outcome, 2, 5).unwrap(), asked);
}
