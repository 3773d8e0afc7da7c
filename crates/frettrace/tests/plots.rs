//! `frettrace plot` and names as laboratories give them, as a person or a script meets them.
#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const RIG: &str = include_str!("../../../data/demo/rig.toml");

fn frettrace(arguments: &[&Path]) -> std::io::Result<Output> {
    Command::new(env!("CARGO_BIN_EXE_frettrace")).args(arguments).output()
}

/// Runs a command that has to succeed.
fn done(arguments: &[&Path]) -> String {
    let output = frettrace(arguments).unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that has to fail for the file's sake, and gives its one line.
fn refused(arguments: &[&Path]) -> String {
    let output = frettrace(arguments).unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty() && error.lines().count() == 1, "{error}");
    error
}

fn names(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        files.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn p(path: &str) -> &Path {
    Path::new(path)
}

/// The repository's own measurement.
fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo/rig.h5")
}

/// A measurement has signals and spectra of each of its 8 runs and its modes; as PNG besides where that is asked for.
#[test]
fn a_measurement_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let (all, some) = (folder.path().join("all"), folder.path().join("some"));
    done(&[p("plot"), &demo(), p("-o"), &all]);
    assert_eq!(names(&all).len(), 8 + 8 + 1);
    done(&[p("plot"), &demo(), p("-o"), &some, p("--only"), p("modes"), p("--png")]);
    assert_eq!(names(&some), ["modes.png", "modes.svg"]);
    assert!(std::fs::read(some.join("modes.png")).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"));
    let spectrum = std::fs::read_to_string(all.join("spectrum-0001.svg")).unwrap();
    for part in ["noise floor (declared)", "frequency [Hz]", "amplitude [m/s²]"] {
        assert!(spectrum.contains(part), "{part}");
    }
}

/// What a file does not hold is refused in one line that says what there is, and nothing is written.
#[test]
fn a_wrong_combination_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("figures");
    let line = refused(&[p("plot"), &demo(), p("-o"), &out, p("--only"), p("evidence,modes")]);
    let said = ": a measurement file has no evidence; it has signals, spectra, modes\n";
    assert!(line.ends_with(said), "{line}");
    let line = refused(&[p("plot"), &demo(), p("-o"), &out, p("--report"), &folder.path().join("r.html")]);
    assert!(
        line.contains("a measurement file has no report") && line.contains("frettrace explain"),
        "{line}"
    );
    let line = refused(&[p("plot"), &demo(), p("-o"), &out, p("--measured"), &demo()]);
    assert!(line.contains("is not compared with a measurement"), "{line}");
    let other = folder.path().join("other.json");
    std::fs::write(&other, "{\"answer\": 42}").unwrap();
    let line = refused(&[p("plot"), &other, p("-o"), &out]);
    assert!(line.contains("neither a verdict nor a law"), "{line}");
    assert_eq!(names(folder.path()), ["other.json"]);
    let unknown = frettrace(&[p("plot"), &demo(), p("-o"), &out, p("--only"), p("pies")]).unwrap();
    assert_eq!(unknown.status.code(), Some(2));
}

/// A reconstruction has loops, forces and spectra; beside its measurement also waveforms measured and rebuilt and maps of what is
/// left, and beside another one nothing.
#[test]
fn a_reconstruction_is_drawn_beside_its_measurement() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let (rec, alone, both) = (place("rec.h5"), place("alone"), place("both"));
    done(&[p("reconstruct"), &demo(), p("-o"), &rec]);
    done(&[p("plot"), &rec, p("-o"), &alone]);
    assert_eq!(names(&alone).len(), 8 * 4);
    done(&[p("plot"), &rec, p("-o"), &both, p("--measured"), &demo()]);
    assert_eq!(names(&both).len(), 8 * 5 + 2);
    let rebuilt = std::fs::read_to_string(both.join("rebuilt-0008.svg")).unwrap();
    assert!(rebuilt.contains("measured") && rebuilt.contains("rebuilt"));
    let other = place("other.h5");
    let short = place("short.toml");
    std::fs::write(&short, RIG.replace("samples = 1024", "samples = 512")).unwrap();
    done(&[p("simulate"), &short, p("-o"), &other]);
    let line = refused(&[p("plot"), &rec, p("-o"), &place("none"), p("--measured"), &other]);
    assert!(line.contains("give the file it was reconstructed from"), "{line}");
}

/// Names with blanks and letters beyond ASCII go through every command that reads or writes files, and labels reach the figures.
#[test]
fn names_may_be_those_of_any_language() {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path().join("Messung für Zoë, 测量 №1");
    std::fs::create_dir(&home).unwrap();
    let place = |name: &str| home.join(name);
    let (rig, file) = (place("rig größe.toml"), place("µ Prüfstand.h5"));
    std::fs::write(&rig, RIG.replace("demonstration rig", "Prüfstand Ω")).unwrap();
    done(&[p("simulate"), &rig, p("-o"), &file]);
    let (result, report) = (place("Erklärung 1.json"), place("Bericht für Åse.html"));
    done(&[p("explain"), &file, p("-o"), &result, p("--report"), &report]);
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(page.contains("<title>Prüfstand Ω</title>"));
    let figures = place("Bilder ü");
    done(&[p("plot"), &result, p("-o"), &figures, p("--png"), p("--only"), p("evidence")]);
    assert_eq!(names(&figures), ["errors.png", "errors.svg", "evidence.png", "evidence.svg"]);
    // One level: names are what this is about.
    let curve = place("Antwort é.h5");
    std::fs::write(&rig, RIG.replace("[0.6, 0.8, 1.1, 1.5, 2.1, 3.0, 4.2, 6.0]", "[1.1]")).unwrap();
    done(&[p("response"), &rig, p("-o"), &curve, p("--without-stability")]);
    done(&[p("plot"), &curve, p("-o"), &place("Kurven ß")]);
}

/// Conversion of a file whose name, columns and labels are in another language; run labels with dots stay whole in file names.
#[test]
fn converted_names_stay_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let (data, rig, file) = (place("Lauf №1 ж.csv"), place("Beschreibung ü.toml"), place("Kontakt ñ.h5"));
    let rows = (0..200).map(|k| {
        let phase = 0.1 * f64::from(k);
        format!("{};{};{}\n", 0.001 * f64::from(k), phase.cos(), phase.sin())
    });
    std::fs::write(&data, format!("Zeit;Kraft ä;Weg 位\n{}", rows.collect::<String>())).unwrap();
    let text = "kind = \"contact\"\ntitle = \"Dämpfer µ\"\nlaw = \"dahl\"\n[channels]\n\
        time = { column = \"Zeit\", unit = \"s\" }\nforce = { column = \"Kraft ä\", unit = \"N\" }\n\
        slip_displacement = { column = \"Weg 位\", unit = \"mm\" }\n[[runs]]\nlabel = \"1.5 Hz, trocken é\"\n";
    std::fs::write(&rig, text).unwrap();
    done(&[p("convert"), &data, p("--guess")]);
    done(&[p("convert"), &data, p("--rig"), &rig, p("-o"), &file]);
    let figures = place("Bilder");
    done(&[p("plot"), &file, p("-o"), &figures]);
    let drawn = names(&figures);
    assert_eq!(drawn, ["force-0001.svg", "loop-0001.svg", "spectrum-0001.svg"]);
    assert!(std::fs::read_to_string(figures.join("loop-0001.svg")).unwrap().contains("1.5 Hz, trocken é"));
}
