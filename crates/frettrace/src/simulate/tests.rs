use std::path::Path;

use frettrace_measurement::{read_measurement, write_measurement};

use super::*;
use crate::rig::{parse_rig, tests::RIG};

fn rig(effect: &str) -> Rig {
    parse_rig(&format!("{RIG}\n{effect}"), Path::new("RIG.toml")).unwrap()
}

#[test]
fn a_simulated_file_is_read_back() {
    let simulation = simulate(&rig(""), &Progress::silent()).unwrap();
    assert_eq!(simulation.measurement.runs.len(), 2);
    assert_eq!(simulation.measurement.runs[1].acceleration.len(), 3);
    assert_eq!(simulation.truth.runs[1].friction_force.len(), 1024);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.h5");
    write_measurement(&path, &simulation.measurement, Some(&simulation.truth)).unwrap();
    let read = read_measurement(&path).unwrap();
    assert_eq!(read.support, simulation.measurement.support);
    assert_eq!(read.modes, simulation.measurement.modes);
    assert_eq!(read.runs[0].id, "0001");
}

#[test]
fn declared_modes_have_errors_of_the_stated_size() {
    let exact = declared_modes(&rig(""), &boundary(&rig("")), 6).unwrap();
    let modes = simulate(&rig(""), &Progress::silent()).unwrap().measurement.modes.unwrap();
    for ((found, std), omega) in modes.frequency.iter().zip(&modes.frequency_std).zip(&exact[0]) {
        let deviation = (found - omega / TAU).abs() / std;
        assert!(deviation < 4.0 && deviation > 0.0, "{deviation}");
        assert!((std / found - 1e-5).abs() < 1e-9);
    }
}

/// Every effect can be simulated and changes what it should: the measured channels or, for those of the contact, the force.
#[test]
fn every_effect_changes_the_record() {
    let effects = [
        "friction.stribeck\"\nmu_s = 0.4\nv_s_m_per_s = 0.002\ndelta = 2.0",
        "friction.viscous\"\nsigma2_n_s_per_m = 100.0",
        "friction.lag\"\ntime_s = 1e-3\nmu_s = 0.4\nv_s_m_per_s = 0.002\ndelta = 2.0",
        "friction.film\"\nloss = 0.4\nrise_time_s = 1e-3\nfall_time_s = 2e-3\nvelocity_m_per_s = 0.01",
        "friction.ageing\"\ngain = 0.2\ndistance_m = 1e-6\ntime_s = 1e-3",
        "friction.asymmetry\"\nshare = 0.2",
        "friction.breakaway\"\nbreakaway = 0.6",
        "friction.exponent\"\nexponent = 0.5",
        "friction.presliding-damping\"\nsigma1_s_per_m = 50.0\nv_d_m_per_s = 0.01",
        "friction.position\"\nslope_per_m = 1e4",
        "friction.position-periodic\"\nshare = 0.2\nwavelength_m = 5e-6",
        "friction.normal-dependence\"\nexponent = 0.2",
        "friction.wear\"\nrelative_change = 0.2",
        "contact.lift-off\"",
        "contact.normal-stiffening\"\ncubic_n_per_m3 = 1e15",
        "contact.tangential-stiffness\"\nseries_stiffness_n_per_m = 1e7",
        "contact.backlash\"\nhalf_play_m = 1e-6",
        "structure.cubic-stiffness\"\nposition_m = 0.3\nstiffness_n_per_m3 = 1e10",
        "structure.quadratic-damping\"\nposition_m = 0.3\ndamping_n_s2_per_m2 = 20.0",
        "structure.clamp-compliance\"\nrotational_stiffness_n_m_per_rad = 2e4",
        "structure.added-mass\"\nposition_m = 0.3\nmass_kg = 0.01",
        "structure.second-support\"\nposition_m = 0.3\nstiffness_n_per_m = 1e5",
        "structure.modal-frequency\"\nmode = 1\nrelative_change = 0.01",
        "structure.modal-damping\"\nmode = 1\nrelative_change = 0.3",
        "structure.frequency-drift\"\nrelative_change = 0.01",
        "excitation.preload-modulation\"\nshare = 0.3\nfrequency_ratio = 1.0\nphase_rad = 0.0",
        "excitation.base-motion\"\nacceleration_m_per_s2 = 1.0\nfrequency_ratio = 1.0\nphase_rad = 0.0",
        "measurement.gain\"\nsensor = 1\nfactor = 1.1",
        "measurement.delay\"\nsensor = 1\ndelay_s = 1e-4",
        "measurement.hum\"\nsensor = 1\namplitude_m_per_s2 = 1.0\nfrequency_hz = 50.0",
        "measurement.clipping\"\nsensor = 1\nlimit_m_per_s2 = 20.0",
        "measurement.position\"\nsensor = 1\nshift_m = 0.01",
        "measurement.dropout\"\nsensor = 1\nstart_share = 0.2\nlength_share = 0.1",
        "measurement.offset\"\nsensor = 1\noffset_m_per_s2 = 0.5",
    ];
    assert_changes(&effects);
}

/// Another formula of an effect goes by the effect's name; what has no name says so, and where it acts.
#[test]
fn every_foreign_effect_changes_the_record() {
    assert_changes(&[
        "friction.stribeck/rational\"\nmu_s = 0.4\nv_s_m_per_s = 0.002\ndelta = 2.0",
        "friction.viscous/power\"\nforce_at_1_m_per_s_n = 500.0\npower = 1.5",
        "friction.lag/saturating\"\ntime_s = 1e-3\nmu_s = 0.4\nv_s_m_per_s = 0.002\ndelta = 2.0",
        "friction.film/rational\"\nloss = 0.4\nrise_time_s = 1e-3\nfall_time_s = 2e-3\nvelocity_m_per_s = 0.01",
        "friction.ageing/saturating\"\ngain = 0.3\ndistance_m = 1e-6\ntime_s = 1e-3",
        "friction.asymmetry/smooth\"\nshare = 0.2\nvelocity_m_per_s = 1e-3",
        "friction.breakaway/straight\"\nbreakaway = 0.6",
        "friction.exponent/power\"\npower = 2.0",
        "friction.presliding-damping/rational\"\nsigma1_s_per_m = 50.0\nv_d_m_per_s = 0.01",
        "friction.position/saturating\"\nshare = 0.3\ndistance_m = 1e-5",
        "friction.position-periodic/triangle\"\nshare = 0.2\nwavelength_m = 5e-6",
        "friction.normal-dependence/straight\"\nslope = 0.3\nreference_n = 70.0",
        "friction.wear/settling\"\nrelative_change = 0.2",
        "contact.normal-stiffening/exponential\"\nsharpness = 0.5",
        "contact.tangential-stiffness/series\"\nseries_stiffness_n_per_m = 1e7",
        "contact.tangential-stiffness/parallel\"\nstiffness_n_per_m = 1e6",
        "contact.backlash/gradual\"\nhalf_play_m = 1e-6",
        "structure.cubic-stiffness/yielding\"\nposition_m = 0.3\nstiffness_n_per_m3 = 1e10\nscale_m = 1e-3",
        "structure.quadratic-damping/power\"\nposition_m = 0.3\nforce_at_1_m_per_s_n = 20.0\npower = 1.7",
        "structure.second-support/round\"\nposition_m = 0.3\nstiffness_n_per_m_3_2 = 1e7\ngap_m = 0.0",
        "structure.second-support/rubbing\"\nposition_m = 0.3\nlevel_n = 1.0\nvelocity_m_per_s = 1e-3",
        "structure.frequency-drift/settling\"\nrelative_change = 0.01",
        "excitation.preload-modulation/square\"\nshare = 0.3\nfrequency_ratio = 1.0\nphase_rad = 0.0",
        "measurement.delay/low-pass\"\nsensor = 1\ntime_s = 1e-4",
        "measurement.hum/third-harmonic\"\nsensor = 1\namplitude_m_per_s2 = 1.0\nfrequency_hz = 50.0\nthird_share = 0.5",
        "measurement.clipping/soft\"\nsensor = 1\nlimit_m_per_s2 = 200.0",
        "measurement.dropout/hold\"\nsensor = 1\nstart_share = 0.2\nlength_share = 0.1",
        "measurement.offset/drift\"\nsensor = 1\noffset_m_per_s2 = 0.5",
        "friction.stribeck/straight\"\nmu_s = 0.4\nv_s_m_per_s = 0.004",
        "friction.viscous/eyring\"\nforce_n = 2.0\nvelocity_m_per_s = 0.005",
        "friction.ageing/power\"\ngain = 0.3\ndistance_m = 1e-6\ntime_s = 1e-3\npower = 0.3",
        "friction.presliding-damping/exponential\"\nsigma1_s_per_m = 50.0\nv_d_m_per_s = 0.01",
        "friction.position/parabola\"\nshare = 0.3\ndistance_m = 1e-5",
        "friction.position-periodic/square\"\nshare = 0.2\nwavelength_m = 5e-6",
        "friction.normal-dependence/adhesion\"\nshare = 0.3\nreference_n = 70.0",
        "friction.wear/root\"\nrelative_change = 0.2",
        "contact.normal-stiffening/round\"\npower = 1.5",
        "structure.cubic-stiffness/hyperbolic\"\nposition_m = 0.3\nstiffness_n_per_m3 = 1e10\nscale_m = 1e-3",
        "structure.second-support/smooth\"\nposition_m = 0.3\nstiffness_n_per_m = 1e5\ngap_m = 0.0\nsmoothness_m = 1e-4",
        "excitation.preload-modulation/skewed\"\nshare = 0.3\nfrequency_ratio = 1.0\nphase_rad = 0.0",
        "measurement.delay/two-low-passes\"\nsensor = 1\ntime_s = 1e-4",
        "measurement.clipping/one-sided\"\nsensor = 1\nlimit_m_per_s2 = 200.0",
        "measurement.offset/settling\"\nsensor = 1\noffset_m_per_s2 = 0.5",
        "unlisted:contact/speed-square\"\ncoefficient_n_s2_per_m2 = 1e5",
        "unlisted:contact/normal-memory\"\ntime_s = 1e-3",
        "unlisted:structure/even-stiffness\"\nposition_m = 0.3\nstiffness_n_per_m2 = 1e7",
        "unlisted:excitation/moment\"\nlever_m = 0.01",
        "unlisted:excitation/second-force\"\nposition_m = 0.3\namplitude_n = 0.5\nfrequency_ratio = 2.0\nphase_rad = 0.0",
        "unlisted:measurement/quadratic-gain\"\nsensor = 1\ncoefficient_s2_per_m = 1e-4",
        "unlisted:measurement/high-pass\"\nsensor = 1\ncorner_hz = 5.0",
        "unlisted:measurement/cross-talk\"\nsensor = 1\nfrom = 0\nshare = 0.02",
    ]);
}

/// Each effect changes the record of the rig of these tests, and the truth has its id.
fn assert_changes(effects: &[&str]) {
    let last = |effect: &str| {
        let mut made = simulate(&rig(effect), &Progress::silent()).unwrap();
        (made.measurement.runs.swap_remove(1).acceleration.swap_remove(1), made.truth)
    };
    let (plain, _) = last("");
    for effect in effects {
        let (changed, truth) = last(&format!("[[effect]]\nid = \"{effect}"));
        let distance: f64 = plain.iter().zip(&changed).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 1024.0;
        let (formula, _) = effect.split_once('"').unwrap();
        let id = formula.split('/').next().unwrap();
        assert!(truth.words.contains(&("effect".to_owned(), id.to_owned())), "{formula}");
        if id == "contact.lift-off" {
            // The preload of 70 N exceeds the dynamic load of 56 N: nothing opens.
            assert!(distance.sqrt() < 1e-3, "{id}: {}", distance.sqrt());
        } else {
            // Noise is the same; the signal is 180 m/s² rms.
            assert!(distance.sqrt() > 0.05, "{formula}: {}", distance.sqrt());
            assert!(changed.iter().all(|x| x.is_finite()), "{formula}");
        }
    }
}

/// The contact in another formula without an effect of any size is the declared one: two integrations of one equation.
#[test]
fn a_foreign_effect_of_no_size_changes_nothing() {
    let record = |effect: &str| {
        let mut made = simulate(&rig(effect), &Progress::silent()).unwrap();
        made.measurement.runs.swap_remove(1).acceleration.swap_remove(1)
    };
    let plain = record("");
    let foreign = record("[[effect]]\nid = \"friction.wear/settling\"\nrelative_change = 0.0");
    let largest = plain.iter().zip(&foreign).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Of 180 m/s² rms; both integrations are of second order or better in steps of 8 µs.
    assert!(largest < 0.02, "{largest}");
}

/// The rig of these tests with rigid friction.
fn coulomb() -> String {
    RIG.replace("law = \"dahl\"", "law = \"coulomb\"")
        .replace("sigma0_per_m = 5.0e5\n", "")
        .replace("exponent = 1.0\n", "")
}

/// Rigid friction that sticks and slips: the steps that the noise asks for leave no more than a tenth of it against eight times
/// the fine rate, with the same noise in both.
#[test]
fn steps_follow_the_noise() {
    let made =
        |text: &str| simulate(&parse_rig(text, Path::new("RIG.toml")).unwrap(), &Progress::silent()).unwrap();
    let text = coulomb();
    let finer = made(&text.replace("samples = 1024", "samples = 1024\nmarch_rate_hz = 524288.0"));
    let found = made(&text);
    for (run, other) in found.measurement.runs.iter().zip(&finer.measurement.runs) {
        for (signal, other) in run.acceleration.iter().zip(&other.acceleration) {
            let square: f64 = signal.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 1024.0;
            assert!(square.sqrt() < 0.1 * 0.05, "{}: {}", run.id, square.sqrt());
        }
    }
    assert!(found.marching.iter().all(|marching| marching.is_met() && marching.change.is_some()));
    assert!(finer.marching.iter().all(|marching| marching.change.is_none() && marching.rate >= 524_288.0));
    assert!(!found.truth.words.iter().any(|(name, _)| name == "note"));
    // No march follows a noise of 1e-9 m/s², and the truth says so.
    let quiet = text.replace("noise_std_m_per_s2 = 0.05", "noise_std_m_per_s2 = 1e-9");
    let quiet = made(&quiet.replace("[1.0, 8.0]", "[8.0]"));
    let note = quiet.truth.words.iter().find(|(name, _)| name == "note").map(|(_, note)| note.as_str());
    assert!(
        note.is_some_and(|note| note.contains("run 0001") && note.contains("1.00e-10 wanted")),
        "{note:?}"
    );
}

/// Rigid friction with a curve is the law of Stribeck, whoever declares it: the same march, to the last bit.
#[test]
fn rigid_friction_may_have_a_curve_that_nobody_declares() {
    let made = |text: &str| {
        let mut made =
            simulate(&parse_rig(text, Path::new("RIG.toml")).unwrap(), &Progress::silent()).unwrap();
        (made.measurement.support.law, made.measurement.runs.remove(0).acceleration)
    };
    let curve = "[[effect]]\nid = \"friction.stribeck\"\nmu_s = 0.4\nv_s_m_per_s = 0.01\ndelta = 2.0\n";
    let viscous = "[[effect]]\nid = \"friction.viscous\"\nsigma2_n_s_per_m = 5.0\n";
    let (law, found) = made(&format!("{}\n{curve}{viscous}", coulomb()));
    assert_eq!(law, made(&coulomb()).0);
    let own = "mu_s = 0.4\nv_s_m_per_s = 0.01\ndelta = 2.0\nsigma2_n_s_per_m = 5.0\nmu_k =";
    let declared = coulomb().replace("law = \"coulomb\"", "law = \"stribeck\"").replace("mu_k =", own);
    let (declared, expected) = made(&declared);
    assert_ne!(law, declared);
    assert_eq!(found, expected);
    assert_ne!(found, made(&coulomb()).1);
}

#[test]
fn a_friction_effect_needs_a_bristle() {
    let coulomb = coulomb();
    let plain = parse_rig(&coulomb, Path::new("RIG.toml")).unwrap();
    assert!(simulate(&plain, &Progress::silent()).is_ok());
    let text = format!("{coulomb}\n[[effect]]\nid = \"friction.asymmetry\"\nshare = 0.1");
    let refused = simulate(&parse_rig(&text, Path::new("RIG.toml")).unwrap(), &Progress::silent());
    assert!(matches!(refused, Err(StudyError::EffectOnLaw { effect: "friction.asymmetry", .. })));
}
