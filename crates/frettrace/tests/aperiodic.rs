//! `explain` on records of which no run is periodic: a force that beats, and a base that moves by itself.
//!
//! The records come from the time march of 72 modes in steps of its own; neither the bins of the inverse nor the steps of the laws that are
//! fitted to what it recovers made the data.

use std::path::Path;

use frettrace::explain::{ExplainOptions, explain};
use frettrace::results::{Explanation, Place, Verdict};
use frettrace::rig::parse_rig;
use frettrace::simulate::simulate;
use frettrace::{Progress, StudyError};
use frettrace_measurement::Recording;

/// A beam whose end slides sideways; the beat is no fraction of small numbers of the excitation.
const RIG: &str = r#"
title = "beat"
seed = 11
[beam]
length_m = 0.52
width_m = 0.030
thickness_m = 0.0070
youngs_modulus_pa = 2.05e11
density_kg_per_m3 = 7840.0
[modes]
damping_ratio = [0.0052, 0.0047, 0.0050]
declared = 5
frequency_relative_std = 2e-5
damping_relative_std = 2e-3
[support]
slip = "transverse"
law = "dahl"
[support.parameters]
sigma0_per_m = 2.0e4
mu_k = 0.24
exponent = 1.0
[exciter]
position_m = 0.212
[sensors]
position_m = [0.083, 0.161, 0.254, 0.337, 0.441]
noise_std_m_per_s2 = 0.1
[sampling]
rate_hz = 4096.0
samples = 2048
[[run]]
frequency_hz = 93.7
preload_n = 20.0
force_amplitude_n = [0.8, 1.4, 2.4, 4.0]
"#;

const BEAT: &str = "beat_share = 0.5\nbeat_frequency_ratio = 0.1617\n";

fn explained(more: &str) -> Result<Explanation, StudyError> {
    explained_with(more, &ExplainOptions::default())
}

fn explained_with(more: &str, options: &ExplainOptions) -> Result<Explanation, StudyError> {
    explained_on(RIG, more, options)
}

fn explained_on(rig: &str, more: &str, options: &ExplainOptions) -> Result<Explanation, StudyError> {
    let rig = parse_rig(&format!("{rig}{more}"), Path::new("rig.toml"))?;
    let made = simulate(&rig, &Progress::silent())?;
    explain(&Recording::Measurement(made.measurement), options, &Progress::silent())
}

fn names(found: &Explanation) -> Vec<&str> {
    found.effects.iter().map(|effect| effect.id.as_str()).collect()
}

#[track_caller]
fn is_near(found: &Explanation, name: &str, value: f64, share: f64) {
    let got = found.model.parameters[name].value;
    assert!((got / value - 1.0).abs() < share, "{name}: {got}, not {value}");
}

/// Nothing is missing, and the law is the one that made the record: a force is known to 1 % as a whole.
#[test]
fn a_clean_record_without_a_period_lacks_nothing() {
    let found = explained(BEAT).unwrap();
    assert_eq!((found.verdict, found.place), (Verdict::NothingMissing, None), "{:?}", found.notes);
    assert!(found.effects.is_empty());
    is_near(&found, "mu_k", 0.24, 0.01);
    is_near(&found, "sigma0", 2.0e4, 0.01);
    assert!(
        found.notes.iter().any(|note| note.contains("fewer than three runs are periodic")),
        "{:?}",
        found.notes
    );
    assert_eq!(found.held_out.unwrap().runs.len(), 1);
}

/// Friction that falls with speed by a half of itself is named, with its values to a twentieth.
#[test]
fn falling_friction_is_named_without_a_period() {
    let effect = "[[effect]]\nid = \"friction.stribeck\"\nmu_s = 0.36\nv_s_m_per_s = 3e-2\ndelta = 1.4\n";
    let found = explained(&format!("{BEAT}{effect}")).unwrap();
    assert_eq!((found.verdict, found.place), (Verdict::Explained, Some(Place::Contact)), "{:?}", found.notes);
    assert_eq!(names(&found), ["friction.stribeck"]);
    is_near(&found, "mu_rise", 0.12, 0.05);
    let held_out = found.held_out.unwrap();
    assert!(held_out.after < 1.05 * held_out.noise_floor && held_out.after < 0.3 * held_out.before);
}

/// A floor that moves by itself, 0.7 m/s² at 0.2393 of the excitation's frequency: no contact force closes that line, a motion of the base does, and
/// beside it the law lacks nothing.
#[test]
fn a_motion_of_the_base_is_named_without_a_period() {
    let effect = "[[effect]]\nid = \"excitation.base-motion\"\nacceleration_m_per_s2 = 0.7\nfrequency_ratio = 0.2393\nphase_rad = 0.3\n";
    let found = explained(effect).unwrap();
    assert_eq!(names(&found), ["excitation.base-motion"], "{:?}", found.notes);
    let told = &found.effects[0].parameters;
    assert!((told["base_frequency"].value / (0.2393 * 93.7) - 1.0).abs() < 1e-3, "{told:?}");
    assert!((told["base_acceleration"].value / 0.7 - 1.0).abs() < 0.02, "{told:?}");
    is_near(&found, "mu_k", 0.24, 0.01);
}

/// The same with modes that are known to a thousandth, a fifth of the half-width of a resonance: no contact force closes the balance with what is
/// declared of them, and what the runs say of them does.
#[test]
fn modes_within_their_deviations_are_calibrated_without_a_period() {
    let loose = RIG.replace("frequency_relative_std = 2e-5", "frequency_relative_std = 1e-3");
    assert_ne!(loose, RIG);
    let found = explained_on(&loose, BEAT, &ExplainOptions::default()).unwrap();
    assert_eq!((found.verdict, found.place), (Verdict::NothingMissing, None), "{:?}", found.notes);
    is_near(&found, "mu_k", 0.24, 0.02);
}

/// A natural frequency ten of its deviations from where it was measured: no contact makes that, the balance that closes with another one tells which,
/// and the structure is said to lack something.
#[test]
fn a_mode_beyond_its_deviation_is_no_contact_without_a_period() {
    let quiet = RIG.replace("noise_std_m_per_s2 = 0.1", "noise_std_m_per_s2 = 0.02");
    let loose = quiet.replace("frequency_relative_std = 2e-5", "frequency_relative_std = 2e-4");
    let effect = "[[effect]]\nid = \"structure.modal-frequency\"\nmode = 2\nrelative_change = 0.002\n";
    let found = explained_on(&loose, &format!("{BEAT}{effect}"), &ExplainOptions::default()).unwrap();
    assert_eq!(
        (found.verdict, found.place),
        (Verdict::Unexplained, Some(Place::Structure)),
        "{:?}",
        found.notes
    );
    assert!(found.notes.iter().any(|note| note.contains("natural frequency of mode 2")), "{:?}", found.notes);
}

/// A sensor that reads nothing for a part of every record: the contact is recovered without it, and that it breaks off is named with what the balance of
/// the accelerations gains; where it is not asked for, the measurement lacks what has no name.
#[test]
fn a_sensor_that_breaks_off_is_named_without_a_period() {
    let effect =
        "[[effect]]\nid = \"measurement.dropout\"\nsensor = 1\nstart_share = 0.4\nlength_share = 0.05\n";
    let found = explained(&format!("{BEAT}{effect}")).unwrap();
    assert_eq!(
        (found.verdict, found.place),
        (Verdict::Explained, Some(Place::Measurement)),
        "{:?}",
        found.notes
    );
    assert_eq!(names(&found), ["measurement.dropout"]);
    assert_eq!(found.effects[0].sensor, Some(1));
    let held_out = found.held_out.unwrap();
    for [before, after, floor] in [
        [found.error.before, found.error.after, found.error.noise_floor],
        [held_out.before, held_out.after, held_out.noise_floor],
    ] {
        assert!(after < 1.2 * floor && before > 5.0 * floor, "{before} {after} {floor}");
    }
    let without = ExplainOptions { without: vec!["measurement.dropout".into()], ..ExplainOptions::default() };
    let found = explained_with(&format!("{BEAT}{effect}"), &without).unwrap();
    assert_eq!(
        (found.verdict, found.place),
        (Verdict::Unexplained, Some(Place::Measurement)),
        "{:?}",
        found.notes
    );
}

/// A stop that the beam reaches in the loudest run alone, which has no period: all periodic runs lack nothing, and a force at the stop closes
/// the balance of that run. The place to 1 % of the length; without the name something is missing in the structure.
#[test]
fn a_stop_that_only_a_run_without_a_period_reaches_is_found() {
    let effect = "[[run]]\nfrequency_hz = 93.7\npreload_n = 20.0\nforce_amplitude_n = [20.0]\nbeat_share = 0.5\nbeat_frequency_ratio = 0.1617\n[[effect]]\nid = \"structure.second-support\"\nposition_m = 0.3\nstiffness_n_per_m = 2e4\ngap_m = 9e-5\n";
    let found = explained(effect).unwrap();
    assert_eq!(
        (found.verdict, found.place),
        (Verdict::Explained, Some(Place::Structure)),
        "{:?}",
        found.notes
    );
    assert_eq!(names(&found), ["structure.second-support"]);
    let support = &found.effects[0];
    assert!((support.position_m.unwrap() - 0.3).abs() < 0.0052, "{support:?}");
    let without = ["structure.second-support".to_owned()].into();
    let left_out = explained_with(effect, &ExplainOptions { without, ..ExplainOptions::default() }).unwrap();
    assert_eq!((left_out.verdict, left_out.place), (Verdict::Unexplained, Some(Place::Structure)));
}

/// Controls draw periodic runs: where there are none, one line says so.
#[test]
fn controls_are_refused_without_a_period() {
    let options = ExplainOptions { controls: 1, ..ExplainOptions::default() };
    let refused = explained_with(BEAT, &options).unwrap_err().to_string();
    assert!(refused.contains("leave --controls out") && !refused.contains('\n'), "{refused}");
}
