//! Simulated sets of another laboratory whose truth is known: where they lie.

use std::path::{Path, PathBuf};

/// What is said where there are none.
pub(super) const ABSENT: &str = "sets with known truth are absent: FRETTRACE_DATA names their folder, or one that has or lies beside `practice`";

/// Their folder: see [`found`]; `practice` beside this repository's shared data where nothing is named.
pub(super) fn folder() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/practice");
    let named = std::env::var_os("FRETTRACE_DATA").and_then(|data| found(Path::new(&data)));
    named.or_else(|| found(&beside))
}

/// The sets of a named folder: in it, in `practice` in it, or in `practice` beside it.
fn found(data: &Path) -> Option<PathBuf> {
    let practice = ["practice", "../practice"].map(|inner| data.join(inner));
    std::iter::once(data.to_owned()).chain(practice).find(|folder| !names(folder).is_empty())
}

/// Names of the sets of a folder: `NAME.truth.h5` beside `NAME.h5`.
pub(super) fn names(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let name = |entry: std::fs::DirEntry| {
        entry.file_name().to_str().and_then(|name| name.strip_suffix(".truth.h5")).map(str::to_owned)
    };
    let mut names: Vec<String> = entries.flatten().filter_map(name).collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sets in `data/practice`, named by that folder, by `data`, and by another folder in `data`.
    #[test]
    fn sets_are_found_from_either_side() {
        let data = tempfile::tempdir().unwrap();
        let [practice, measured] = ["practice", "measured"].map(|name| data.path().join(name));
        for folder in [&practice, &measured] {
            std::fs::create_dir(folder).unwrap();
        }
        assert_eq!(found(&practice), None);
        std::fs::write(practice.join("a.truth.h5"), "").unwrap();
        for named in [&practice, data.path(), &measured] {
            let folder = found(named).unwrap().canonicalize().unwrap();
            assert_eq!(folder, practice.canonicalize().unwrap(), "{}", named.display());
        }
        assert_eq!(names(&practice), ["a"]);
    }
}
