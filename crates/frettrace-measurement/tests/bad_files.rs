//! Files that break one rule of the contract each, with the expected message beside them.
#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::PathBuf;

#[test]
fn every_bad_file_is_told_what_is_wrong() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/bad");
    let mut wrong = Vec::new();
    let mut files = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "h5") {
            continue;
        }
        files += 1;
        let text = std::fs::read_to_string(path.with_extension("txt")).unwrap();
        let expected = format!("{}: {}", path.display(), text.trim_end());
        match frettrace_measurement::read(&path) {
            Ok(_) => wrong.push(format!("{} is read without complaint", path.display())),
            Err(error) if error.to_string() == expected => {}
            Err(error) => wrong.push(format!("expected {expected}\nfound    {error}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // As many as `make_bad.py` writes.
    assert_eq!(files, 54);
}
