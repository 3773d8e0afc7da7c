//! The list against the files: a law cannot be written and left out, nor be listed without being described.

use std::collections::HashSet;
use std::fs;
use std::mem::discriminant;
use std::path::PathBuf;

use crate::Law;

const HEADINGS: [&str; 8] = [
    "Equation",
    "Parameters",
    "State",
    "Limits",
    "Energy per cycle",
    "What it cannot show",
    "References",
    "Example",
];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/laws")
}

/// Name of the file of a law: its own, but for the curves of regularised Coulomb.
fn module(law: Law) -> String {
    match law {
        Law::RegularisedCoulomb(_) => "regularised_coulomb".to_owned(),
        _ => law.name().replace('-', "_"),
    }
}

#[test]
fn every_file_of_a_law_is_listed() {
    let written: HashSet<String> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|name| name != "mod")
        .collect();
    let listed: HashSet<String> = Law::ALL.iter().copied().map(module).collect();
    assert_eq!(written, listed);
    let variants: HashSet<_> = Law::ALL.iter().map(discriminant).collect();
    assert_eq!(variants.len(), listed.len());
    let names: HashSet<&str> = Law::ALL.iter().map(|law| law.name()).collect();
    assert_eq!(names.len(), Law::ALL.len());
}

/// The eight headings in their order, none of them empty, and every parameter in the table with its unit.
#[test]
fn every_law_is_described_under_the_eight_headings() {
    for law in Law::ALL {
        let text = fs::read_to_string(folder().join(module(*law) + ".rs")).unwrap();
        let docs: Vec<&str> =
            text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim).collect();
        let found: Vec<&str> = docs.iter().filter_map(|line| line.strip_prefix("# ")).collect();
        assert_eq!(found, HEADINGS, "{}", law.name());
        let sections: Vec<String> = docs
            .split(|line| line.starts_with("# "))
            .map(|lines| lines.iter().filter(|line| !line.is_empty()).copied().collect::<Vec<_>>().join("\n"))
            .collect();
        assert!(sections.iter().all(|section| !section.is_empty()), "{}: an empty section", law.name());
        assert!(sections[8].starts_with("```\n"), "{}: the example does not run", law.name());
        for parameter in law.parameters() {
            // Numbered parameters stand once in the table.
            let name = match parameter.name.rsplit_once('_') {
                Some((base, number)) if number.parse::<u32>().is_ok() => base,
                _ => parameter.name,
            };
            let row = sections[2].lines().find(|row| row.contains(&format!("{name}`")));
            let row = row.unwrap_or_else(|| panic!("{}: '{name}' is not in the table", law.name()));
            assert!(row.contains(&format!("| {} |", parameter.unit)), "{}: unit of '{name}'", law.name());
        }
    }
}
