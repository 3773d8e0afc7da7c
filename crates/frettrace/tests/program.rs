//! The program as a person or a script meets it: exit codes, one clear line, nothing half-written, silence in a pipe.

use std::process::{Command, Output};

fn frettrace(arguments: &[&str]) -> std::io::Result<Output> {
    Command::new(env!("CARGO_BIN_EXE_frettrace")).args(arguments).output()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Names of all commands, from the program's own help.
fn commands() -> std::io::Result<Vec<String>> {
    let help = text(&frettrace(&["--help"])?.stdout);
    let listed =
        help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    Ok(listed
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect())
}

/// Every command has help with an example that starts with its own name.
#[test]
fn every_command_shows_an_example() {
    let commands = commands().unwrap();
    assert!(commands.len() >= 2, "{commands:?}");
    for command in commands {
        let output = frettrace(&[&command, "--help"]).unwrap();
        let help = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0));
        assert!(
            help.contains("Example") && help.contains(&format!("  frettrace {command}")),
            "{command}: {help}"
        );
    }
}

/// Wrong usage ends with 2 and says how it is meant.
#[test]
fn wrong_usage_ends_with_two() {
    for arguments in [&[][..], &["no-such-command"], &["inspect"], &["inspect", "a.h5", "--no-such-option"]] {
        let output = frettrace(arguments).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && text(&output.stderr).contains("Usage"), "{arguments:?}");
    }
}

/// A file that is not there, or is no such file, ends with 1 and one line; nothing reaches standard output.
#[test]
fn a_bad_file_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.h5");
    std::fs::write(&bad, "not HDF5").unwrap();
    for path in [folder.path().join("missing.h5"), bad] {
        let path = path.display().to_string();
        let output = frettrace(&["inspect", &path]).unwrap();
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(output.stdout.is_empty());
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with(&format!("frettrace: {path}: ")), "{error}");
    }
}

/// A failed command leaves no file, not even beside its place.
#[test]
fn a_failed_command_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("explain.json"), folder.path().join("figures"));
    std::fs::write(&input, "{\"verdict\": 3}").unwrap();
    let done =
        frettrace(&["plot", &input.display().to_string(), "-o", &output.display().to_string()]).unwrap();
    assert_eq!(done.status.code(), Some(1));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the input is there");
}

/// A rig that is wrong ends both commands that take one with 1 and one line, and no file.
#[test]
fn a_bad_rig_is_one_clear_line() {
    let right = include_str!("../../../data/demo/rig.toml");
    let folder = tempfile::tempdir().unwrap();
    let (rig, output) = (folder.path().join("RIG.toml"), folder.path().join("out.h5"));
    let wrong = [
        "",
        "[beam",
        &right.replace("mu_k = 0.24", "mu_k = nan"),
        &right.replace("_m = 0.52", "_mm = 520.0"),
    ];
    for text in wrong {
        std::fs::write(&rig, text).unwrap();
        for command in ["simulate", "response"] {
            let done = frettrace(&[command, &rig.display().to_string(), "-o", &output.display().to_string()]);
            let done = done.unwrap();
            let error = crate::text(&done.stderr);
            assert_eq!(done.status.code(), Some(1), "{error}");
            assert!(error.starts_with(&format!("frettrace: {}: ", rig.display())), "{error}");
            assert!(error.lines().count() == 1 && done.stdout.is_empty(), "{error}");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the rig is there");
        }
    }
}

/// The demonstration's file is what its rig file makes today: the same declarations, and channels within the tenth of the noise of 0.2 m/s² that
/// is asked of the march (the noise itself is drawn from the seed).
#[test]
fn the_demonstrations_file_is_what_its_rig_makes() {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let folder = tempfile::tempdir().unwrap();
    let made = folder.path().join("rig.h5");
    let [rig, output] = [data.join("rig.toml"), made.clone()].map(|path| path.display().to_string());
    let done = frettrace(&["simulate", &rig, "-o", &output, "--without-truth"]).unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    let [mut made, mut stored] =
        [made, data.join("rig.h5")].map(|path| frettrace_measurement::read_measurement(path).unwrap());
    let root_mean_square = |a: &[f64], b: &[f64]| {
        (a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
    };
    for (run, other) in made.runs.iter_mut().zip(&mut stored.runs) {
        for (signal, other) in run.acceleration.drain(..).zip(other.acceleration.drain(..)) {
            assert!(root_mean_square(&signal, &other) < 0.02, "run {}: remake data/demo/rig.h5", run.id);
        }
        let [force, other] = [std::mem::take(&mut run.force), std::mem::take(&mut other.force)];
        assert!(root_mean_square(&force, &other) < 1e-6, "run {}: remake data/demo/rig.h5", run.id);
    }
    assert_eq!(made, stored, "declarations");
}

/// The README shows what the demonstration prints, to the letter, and the demonstration finds what its rig file states: the
/// only effect in `data/demo/rig.toml`, of which the measurement file says nothing.
#[test]
fn the_demonstration_finds_what_was_hidden() {
    let output = frettrace(&["demo"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let (printed, readme) = (text(&output.stdout), include_str!("../../../README.md"));
    let shown = readme.split("<!-- demo -->\n```text\n").nth(1).unwrap();
    assert_eq!(printed, shown.split("```").next().unwrap());
    let hidden = include_str!("../../../data/demo/rig.toml").split("id = \"").nth(1).unwrap();
    assert!(printed.contains(hidden.split('"').next().unwrap()));
}

/// The demonstration's rig over its eight levels: the file, one figure a sensor and two more, and a resonance that softens.
#[test]
fn the_response_of_a_rig_is_written_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).display().to_string();
    let rig = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/demo/rig.toml");
    let (file, figures) = (place("response.h5"), place("figures"));
    let output = frettrace(&["response", rig, "-o", &file, "--figures", &figures, "--json"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let levels = answer["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 8);
    let resonance = |level: &serde_json::Value| {
        let points = level["points"].as_array().unwrap();
        let slip = |point: &serde_json::Value| point["slip_m"].as_f64().unwrap();
        let largest = points.iter().max_by(|a, b| slip(a).total_cmp(&slip(b))).unwrap();
        largest["frequency_hz"].as_f64().unwrap()
    };
    assert!(levels.iter().all(|level| level["status"] == "finished"));
    assert!(resonance(&levels[7]) < resonance(&levels[0]));
    assert!(answer["backbone"].as_array().unwrap().len() > 10);
    assert_eq!(std::fs::read_dir(&figures).unwrap().count(), 5 + 2);
    assert_eq!(frettrace(&["plot", &file, "-o", &place("again")]).unwrap().status.code(), Some(0));
    let wrong = frettrace(&["response", rig, "-o", &file, "--range", "90", "90"]).unwrap();
    assert_eq!(wrong.status.code(), Some(1));
}
