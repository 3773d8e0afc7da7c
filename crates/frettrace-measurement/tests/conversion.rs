//! Conversion: units, signs, pieces, resampling; what is refused, and what is doubted.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use std::fmt::Write as _;
use std::path::PathBuf;

use frettrace_measurement::{
    ContactRecord, ContactRun, Converted, Error, Measurement, Recording, convert, guess, read,
};

/// A folder with a file of numbers and a description; kept until dropped.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new(data: &str, description: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("run.csv"), data).unwrap();
        std::fs::write(folder.path().join("convert.toml"), description).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn convert(&self) -> Result<Converted, Error> {
        convert(&[self.path("run.csv")], self.path("convert.toml"))
    }

    fn contact(&self) -> (ContactRecord, Vec<String>) {
        let converted = self.convert().unwrap();
        match converted.recording {
            Recording::Contact(record) => (record, converted.remarks),
            Recording::Measurement(_) => panic!("a contact record was asked for"),
        }
    }

    fn measurement(&self) -> (Measurement, Vec<String>) {
        let converted = self.convert().unwrap();
        match converted.recording {
            Recording::Measurement(measurement) => (measurement, converted.remarks),
            Recording::Contact(_) => panic!("a measurement was asked for"),
        }
    }

    /// The message, without the path of the temporary folder.
    fn refusal(&self) -> String {
        let message = self.convert().unwrap_err().to_string();
        message.replace(&format!("{}/", self.folder.path().display()), "")
    }
}

/// Columns t (s), f [kip], u [in], a [g] with u = sin(ωt) in, f in phase with velocity, a the second derivative of u in g.
fn loops(sign: f64) -> String {
    let mut text = String::from("t,f,u,v,a\n");
    let omega = 20.0;
    for k in 0..400 {
        let phase: f64 = omega * f64::from(k) / 1000.0;
        let velocity = omega * phase.cos();
        let acceleration = -omega * omega * phase.sin() * 0.0254 / 9.80665;
        let force = sign * 2.0 * phase.cos();
        let t = f64::from(k) / 1000.0;
        writeln!(text, "{t:.4},{force:.9},{:.9},{velocity:.9},{acceleration:.9}", phase.sin()).unwrap();
    }
    text
}

const CONTACT: &str = r#"
kind = "contact"
title = "a damper"
law = "dahl"
[channels]
time = { column = "t", unit = "s" }
force = { column = "f", unit = "kip" }
slip_displacement = { column = 3, unit = "in" }
"#;

fn first(record: &ContactRecord) -> &ContactRun {
    &record.runs[0]
}

#[test]
fn inches_and_kips_become_metres_and_newtons() {
    let bench = Bench::new(&loops(1.0), CONTACT);
    let (record, remarks) = bench.contact();
    let run = first(&record);
    assert_eq!(run.sampling_rate.map(|rate| (rate * 1e6).round() / 1e6), Some(1000.0));
    // 2 kip at the start; 1 kip = 4448.2216152605 N (NIST SP 811). Nine digits are printed.
    assert!((run.force[0] / (2.0 * 4_448.221_615_260_5) - 1.0).abs() < 1e-8);
    let greatest = run.slip_displacement.iter().copied().fold(0.0, f64::max);
    // The largest of the samples of the sine is within (ωΔt)²/8 = 5e-5 of 1 in.
    assert!((greatest / 0.0254 - 1.0).abs() < 1e-4);
    assert!(remarks.is_empty(), "{remarks:?}");

    let written = bench.path("out.h5");
    bench.convert().unwrap().write(&written).unwrap();
    assert!(matches!(read(&written).unwrap(), Recording::Contact(again) if again == record));
}

#[test]
fn a_force_that_drives_is_doubted_and_its_sign_can_be_turned() {
    let (_, remarks) = Bench::new(&loops(-1.0), CONTACT).contact();
    assert_eq!(remarks, ["run 0001: the friction force drives the motion: turn its sign (sign = -1)"]);
    let turned = CONTACT.replace("unit = \"kip\"", "unit = \"kip\", sign = -1");
    let (_, remarks) = Bench::new(&loops(-1.0), &turned).contact();
    assert!(remarks.is_empty(), "{remarks:?}");
}

#[test]
fn an_acceleration_in_g_read_as_si_is_noticed() {
    let wrong = format!("{CONTACT}slip_acceleration = {{ column = \"a\", unit = \"m/s^2\" }}\n");
    let (_, remarks) = Bench::new(&loops(1.0), &wrong).contact();
    assert!(remarks[0].contains("0.1020 times") && remarks[0].contains("g read as m/s^2"), "{remarks:?}");
    let right = wrong.replace("m/s^2", "g");
    assert!(Bench::new(&loops(1.0), &right).contact().1.is_empty());

    let wrong = format!("{CONTACT}slip_velocity = {{ column = \"v\", unit = \"mm/s\" }}\n");
    let (_, remarks) = Bench::new(&loops(1.0), &wrong).contact();
    assert!(remarks[0].contains("inches and millimetres mixed up"), "{remarks:?}");
}

#[test]
fn a_unit_the_file_states_otherwise_is_noticed() {
    let data = loops(1.0).replacen("t,f,u,v,a", "t [s],f [lbf],u [in],v,a", 1);
    let (_, remarks) = Bench::new(&data, CONTACT).contact();
    assert_eq!(remarks.len(), 1);
    assert!(
        remarks[0].contains("the file gives column \"f\" in lbf, the description reads it as kip"),
        "{remarks:?}"
    );
}

#[test]
fn pieces_offsets_and_added_columns() {
    let data: String =
        (0..40).map(|k| format!("{}\t{}\t{}\n", 10 * k, 5.0 + f64::from(k % 4), 2.0)).collect();
    let description = r#"
kind = "contact"
law = "dahl"
force_noise_std = "0.1 N"
moving_mass = "unknown"
[channels]
time = { column = 1, unit = "ms" }
force = { column = 2, unit = "N", add = [{ column = 3, unit = "bar", factor = "-10 mm^2" }] }
slip_displacement = { column = 2, unit = "mm", offset = "mean" }
[[runs]]
file = "run.csv"
label = "middle"
from = "0.1 s"
to = "0.29 s"
preload = "2 kN"
"#;
    let (record, _) = Bench::new(&data, description).contact();
    let run = first(&record);
    assert_eq!((run.force.len(), run.label.as_str(), run.preload), (20, "middle", Some(2000.0)));
    assert!(record.moving_mass.unwrap().is_nan());
    // Sample 10: 5 + 10 % 4 = 7 N, less 2 bar on 10 mm² = 2 N.
    assert!((run.force[0] - 5.0).abs() < 1e-12);
    assert!(run.slip_displacement.iter().sum::<f64>().abs() < 1e-12);
    assert_eq!(run.time[0], 0.0);
}

#[test]
fn uneven_times_are_kept_or_resampled() {
    let time = |k: u32| 0.01 * f64::from(k) + if k.is_multiple_of(7) { 0.004 } else { 0.0 };
    let data: String = (0..60).map(|k| format!("{:.4},{},{}\n", time(k), time(k), 2.0 * time(k))).collect();
    let description = CONTACT.replace("\"t\"", "1").replace("\"f\"", "2");
    let (record, _) = Bench::new(&data, &description).contact();
    assert_eq!(first(&record).sampling_rate, None);
    let resampled = format!("resample = {{ rate = \"50 Hz\", method = \"linear\" }}\n{description}");
    let (record, remarks) = Bench::new(&data, &resampled).contact();
    let run = first(&record);
    assert_eq!(run.sampling_rate, Some(50.0));
    // A ramp is a ramp again, to the four digits printed; it starts at time(0) = 0.004 s.
    let right = |(k, slip): (usize, &f64)| (slip / 0.0254 - 2.0 * (0.004 + 0.02 * k as f64)).abs() < 1e-3;
    assert!(run.slip_displacement.iter().enumerate().all(right));
    // Between samples 6 and 7 lie 0.014 s.
    let expected = "run.csv: resampled to 50 Hz (Linear); the longest gap bridged is 0.014 s";
    assert!(remarks.iter().any(|remark| remark == expected), "{remarks:?}");
}

const RIG: &str = r#"
kind = "measurement"
title = "a beam"
law = "dahl"
sampling_rate = "2 kHz"
[channels]
force = { column = 1, unit = "lbf" }
[[channels.acceleration]]
column = 2
unit = "mV"
sensitivity = "100 mV/g"
position = "10 in"
noise_std = "1 mg"
[beam]
length = "20 in"
width = "30 mm"
thickness = "6 mm"
youngs_modulus = "200 GPa"
density = "7.85 gram/cm^3"
[modes]
frequency_hz = [100.0]
damping_ratio = [0.005]
[support]
position = "20 in"
slip = "rotation"
lever_arm = "3 mm"
normal_stiffness = "infinite"
[exciter]
position = "200 mm"
[[runs]]
label = "level 1"
preload = "50 N"
excitation_frequency = "100 Hz"
"#;

fn rig_data(millivolts: f64) -> String {
    (0..200).map(|k| 0.05 * std::f64::consts::TAU * f64::from(k)).fold(String::new(), |mut text, phase| {
        writeln!(text, "{:.9};{:.9}", phase.sin(), millivolts * phase.cos()).unwrap();
        text
    })
}

#[test]
fn a_rig_with_its_sensitivity() {
    let (rig, remarks) = Bench::new(&rig_data(300.0), RIG).measurement();
    assert!((rig.beam.length - 0.508).abs() < 1e-12);
    assert!((rig.beam.density - 7850.0).abs() < 1e-9);
    assert!((rig.sensors.position[0] - 0.254).abs() < 1e-12);
    assert!((rig.sensors.noise_std.as_ref().unwrap()[0] - 9.80665e-3).abs() < 1e-12);
    // 300 mV at 100 mV/g are 3 g.
    assert!((rig.runs[0].acceleration[0][0] - 3.0 * 9.80665).abs() < 1e-7);
    assert_eq!((rig.runs[0].sampling_rate, rig.support.normal_stiffness), (2000.0, f64::INFINITY));
    // 3 g on 0.72 kg against 1 lbf at a resonance: 4.7, believable.
    assert!(remarks.is_empty(), "{remarks:?}");
    // A tenth of it, as when g is read as m/s^2, is not.
    let (_, remarks) = Bench::new(&rig_data(30.0), RIG).measurement();
    assert!(remarks[0].contains("is it in g"), "{remarks:?}");
}

#[test]
fn what_is_refused() {
    let refused =
        |from: &str, to: &str, base: &str, data: &str| Bench::new(data, &base.replace(from, to)).refusal();
    let contact = |from: &str, to: &str| refused(from, to, CONTACT, &loops(1.0));
    let rig = |from: &str, to: &str| refused(from, to, RIG, &rig_data(300.0));
    assert_eq!(
        contact("unit = \"kip\"", "unit = \"mm\""),
        "convert.toml: [channels] force, `unit`: \"mm\" does not fit; write a force (N, kN, lbf, kip)"
    );
    assert_eq!(
        contact("column = \"f\"", "column = \"load\""),
        "run.csv: channel `force`: there is no column `load`; the file has t, f, u, v, a"
    );
    assert_eq!(
        contact("law = \"dahl\"", "law = \"velvet\""),
        "convert.toml: law: `law` is \"velvet\"; write one of coulomb, stribeck, dahl, lugre, hybrid"
    );
    assert_eq!(
        contact("title", "colour"),
        "convert.toml: line 3: unknown field `colour`, expected one of `kind`, `title`, `simulated`, `law`, `slip_unit`, \
         `moving_mass`, `force_noise_std`, `sampling_rate`, `resample`, `channels`, `beam`, `modes`, `support`, \
         `second_support`, `exciter`, `runs`; `frettrace convert FILE --guess` proposes one to start from"
    );
    assert_eq!(
        contact("slip_displacement = { column = 3, unit = \"in\" }", ""),
        "convert.toml: [channels] slip_displacement: the entry is missing; add it to the description"
    );
    assert_eq!(
        rig("lever_arm = \"3 mm\"", "lever_arm = \"3 N\""),
        "convert.toml: [support] lever_arm: \"3 N\" does not fit; write a length (m, mm, in)"
    );
    assert_eq!(
        rig("sensitivity = \"100 mV/g\"", "sensitivity = \"100 pC/g\""),
        "convert.toml: [channels] acceleration, `sensitivity`: \"100 pC/g\" does not fit; write the column's unit over \
         that of an acceleration (m/s^2, g)"
    );
    assert_eq!(
        rig("label = \"level 1\"", "file = \"other.csv\""),
        "convert.toml: [[runs]]: the file `other.csv` is not among the inputs; give it, or the folder it lies in"
    );
    assert_eq!(
        rig("position = \"200 mm\"", "position = \"2 m\""),
        "convert.toml: what it makes of the files, /exciter: `position` is 2; it must be above 0 and at most the beam's \
         length, 0.508 m"
    );
    assert_eq!(
        rig("label = \"level 1\"", "from = \"3 s\""),
        "run.csv: [[runs]] from, to: the piece holds 0 samples; take a longer one"
    );
}

#[test]
fn a_guess_is_close_to_a_description() {
    let data = "Time [s],Load [kN],Stroke [mm]\n0,1,2\n0.01,2,3\n0.02,1,4\n0.03,2,1\n";
    let bench = Bench::new(data, "");
    let text = guess(bench.path("run.csv")).unwrap();
    for line in [
        "kind = \"contact\"",
        "time = { column = 1, unit = \"s\" }",
        "force = { column = 2, unit = \"kN\" }",
        "slip_displacement = { column = 3, unit = \"mm\" }",
        "file = \"run.csv\"",
    ] {
        assert!(text.lines().any(|found| found == line), "{line} is not in\n{text}");
    }
    let data = "t,load,accel 1,accel 2\n0,1,2,3\n0.01,2,3,4\n0.02,1,4,2\n";
    let bench = Bench::new(data, "");
    let text = guess(bench.path("run.csv")).unwrap();
    assert_eq!(text.matches("[[channels.acceleration]]").count(), 2, "{text}");
    assert!(text.contains("kind = \"measurement\"") && text.contains("unit = \"m/s^2\"   # unit?"), "{text}");
}

/// The proposed description is TOML whatever the file is called.
#[test]
fn a_guess_takes_any_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["Lauf 1 ü.csv", "a \"first\" try.csv", "it's.csv", "测量.csv"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "Time [s],Load [kN],Stroke [mm]\n0,1,2\n0.01,2,3\n0.02,1,4\n").unwrap();
        let text = guess(&path).unwrap();
        let line = text.lines().find(|line| line.starts_with("file = ")).unwrap();
        let read: toml::Table = toml::from_str(line).unwrap();
        assert_eq!(read["file"].as_str(), Some(name), "{line}");
    }
}
