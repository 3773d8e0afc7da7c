//! Every example prints what `expected/` says it prints.

use std::{collections::BTreeSet, fs, path::Path, process::Command};

const HERE: &str = env!("CARGO_MANIFEST_DIR");

/// Examples are built beside this test, one folder up.
fn run(name: &str) -> std::io::Result<std::process::Output> {
    let test = std::env::current_exe()?;
    let folder = test.parent().and_then(Path::parent).map(|folder| folder.join("examples"));
    let program = folder.unwrap_or_default().join(name).with_extension(std::env::consts::EXE_EXTENSION);
    Command::new(program).current_dir(Path::new(HERE).join("..")).output()
}

#[test]
fn printed_output_is_the_expected_one() {
    let mut compared = 0;
    for entry in fs::read_dir(Path::new(HERE).join("expected")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let output = run(&name).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(String::from_utf8_lossy(&output.stdout), fs::read_to_string(&path).unwrap(), "{name}");
        compared += 1;
    }
    assert!(compared > 0);
}

/// No example without an expected output, none over 80 lines.
#[test]
fn every_example_is_short_and_compared() {
    let manifest = fs::read_to_string(Path::new(HERE).join("Cargo.toml")).unwrap();
    let listed: BTreeSet<&str> =
        manifest.lines().filter_map(|line| line.strip_prefix("path = \"")?.strip_suffix(".rs\"")).collect();
    for name in &listed {
        let code = fs::read_to_string(Path::new(HERE).join(name).with_extension("rs")).unwrap();
        assert!(code.lines().count() <= 80, "{name} has {} lines", code.lines().count());
        assert!(Path::new(HERE).join("expected").join(name).with_extension("txt").exists(), "{name}");
    }
    let files = fs::read_dir(HERE).unwrap().filter_map(|entry| entry.unwrap().file_name().into_string().ok());
    let files: BTreeSet<String> =
        files.filter_map(|name| Some(name.strip_suffix(".rs")?.to_owned())).collect();
    assert_eq!(files.iter().map(String::as_str).collect::<BTreeSet<_>>(), listed);
}
