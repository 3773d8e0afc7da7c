//! The book's code comes from examples that are compiled and run: every include and every chapter is resolved here.

use std::{collections::BTreeSet, fs, path::Path};

const BOOK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../book/src");

fn chapters() -> BTreeSet<String> {
    let summary = include_str!("../../book/src/SUMMARY.md");
    summary
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(file, _)| file.to_owned())
        .collect()
}

/// Every chapter of the summary is there, and every page is in the summary.
#[test]
fn summary_and_pages_agree() {
    let pages = fs::read_dir(BOOK).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut expected = chapters();
    expected.insert("SUMMARY.md".into());
    assert_eq!(pages.collect::<BTreeSet<_>>(), expected);
}

/// Every include names a file, and an anchor that begins and ends in it.
#[test]
fn every_include_resolves() {
    let mut resolved = 0;
    for chapter in chapters() {
        let text = fs::read_to_string(Path::new(BOOK).join(&chapter)).unwrap();
        for include in text.split("{{#include ").skip(1) {
            let target = include.split("}}").next().unwrap();
            let (file, anchor) = target.split_once(':').unwrap();
            let code = fs::read_to_string(Path::new(BOOK).join(file)).unwrap();
            if !anchor.starts_with(|c: char| c.is_ascii_digit()) {
                for mark in [format!("// ANCHOR: {anchor}\n"), format!("// ANCHOR_END: {anchor}\n")] {
                    assert_eq!(code.matches(&mark).count(), 1, "{chapter}: {mark}");
                }
            }
            resolved += 1;
        }
    }
    assert!(resolved >= 4, "{resolved} includes");
}

/// Code in the book stands in examples only: a fenced block of Rust holds one include and nothing else.
#[test]
fn no_code_is_written_in_the_book() {
    for chapter in chapters() {
        let text = fs::read_to_string(Path::new(BOOK).join(&chapter)).unwrap();
        for block in text.split("```rust\n").skip(1) {
            assert!(block.starts_with("{{#include ") && block.lines().nth(1) == Some("```"), "{chapter}");
        }
    }
}

/// The table of effects says of each candidate what the candidate's own file says.
#[test]
fn effects_are_those_of_the_candidates() {
    let table = fs::read_to_string(Path::new(BOOK).join("effects.md")).unwrap().replace("\\|", "|");
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/frettrace-explain/src/effects");
    let mut compared = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let Ok(code) = fs::read_to_string(&path) else { continue };
        let Some(id) = code.strip_prefix("//! `").and_then(|rest| rest.split('`').next()) else { continue };
        let said: Vec<&str> = ["*Adds*: ", "*Shows as*: "]
            .iter()
            .filter_map(|head| code.split(head).nth(1)?.split("\n//!\n").next())
            .collect();
        assert_eq!(said.len(), 2, "{}", path.display());
        for text in said {
            let text = text.replace("\n//! ", " ");
            assert!(table.contains(text.trim_end_matches('.')), "{id}: {text}");
        }
        assert!(table.contains(&format!("| `{id}` |")), "{id}");
        compared += 1;
    }
    assert_eq!(table.matches("\n| `").count(), compared);
}
