//! The table of requirements names tests that exist; every case has its page.

use std::{fs, path::Path};
use validation::cases;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

/// Each row of the table: a file, and functions in it.
#[test]
fn every_named_test_exists() {
    let table = include_str!("../README.md").lines().filter(|line| line.contains(".rs`: `"));
    let mut named = 0;
    for line in table {
        let words: Vec<&str> = line.split('`').skip(1).step_by(2).collect();
        let file = words.iter().position(|word| word.ends_with(".rs")).unwrap();
        let code = fs::read_to_string(Path::new(FOLDER).join("..").join(words[file])).unwrap();
        for test in &words[file + 1..] {
            assert!(
                code.contains(&format!("#[test]\nfn {test}()")) || code.contains(&format!("fn {test}()")),
                "{test}"
            );
            named += 1;
        }
    }
    assert!(named >= 8, "{named} tests named");
}

/// A case without its page, or a page without its case, is half a case.
#[test]
fn every_case_has_its_page() {
    let mut pages: Vec<String> = fs::read_dir(Path::new(FOLDER).join("cases"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    pages.sort();
    let mut listed: Vec<&str> = cases::ALL.iter().map(|case| case.name).collect();
    listed.sort_unstable();
    assert_eq!(pages, listed);
    for page in pages {
        let text = fs::read_to_string(Path::new(FOLDER).join("cases").join(&page).join("README.md")).unwrap();
        for part in ["**Question.**", "**Source.**", "**Compared.**", "**Remaining difference.**"] {
            assert!(text.contains(part), "{page}: {part}");
        }
    }
}
