//! Sets whose truth is known: where they lie and what they are called.

use std::path::{Path, PathBuf};

/// What would mend that the sets are absent.
pub const ABSENT: &str =
    "sets with known truth are absent; FRETTRACE_DATA names their folder, the one above or the one beside";

/// The folder of the sets: the first of `FRETTRACE_DATA` itself, `practice` in it, `practice` beside it, and
/// `../shared/data/practice` beside the repository that holds any.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    found(std::env::var_os("FRETTRACE_DATA").map(PathBuf::from).as_deref(), &repository)
}

fn found(data: Option<&Path>, repository: &Path) -> Option<PathBuf> {
    let beside = |data: &Path| data.parent().map(|above| above.join("practice"));
    let told = data.into_iter().flat_map(|data| {
        [Some(data.to_owned()), Some(data.join("practice")), beside(data)].into_iter().flatten()
    });
    let usual = repository.join("../shared/data/practice");
    told.chain([usual]).find(|folder| !names(folder).is_empty())
}

/// Names of the sets of a folder in order: `NAME.truth.h5` beside `NAME.h5`.
#[must_use]
pub fn names(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let name = |entry: std::fs::DirEntry| {
        entry.file_name().to_str().and_then(|name| name.strip_suffix(".truth.h5")).map(str::to_owned)
    };
    let mut names: Vec<String> = entries.flatten().filter_map(name).collect();
    names.retain(|name| folder.join(format!("{name}.h5")).is_file());
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(folder: &Path, name: &str) {
        std::fs::create_dir_all(folder).unwrap();
        for ending in ["h5", "truth.h5"] {
            std::fs::write(folder.join(format!("{name}.{ending}")), "").unwrap();
        }
    }

    /// Every place is found, the ones nearer to what was told before the others; a truth without its set is none.
    #[test]
    fn sets_are_found_wherever_the_data_are_told_to_be() {
        let root = tempfile::tempdir().unwrap();
        let at = |place: &str| root.path().join(place);
        let repository = at("repository");
        std::fs::create_dir_all(&repository).unwrap();
        std::fs::create_dir_all(at("data/measured")).unwrap();
        let told = at("data/measured");
        assert_eq!(found(Some(&told), &repository), None);
        let usual = repository.join("../shared/data/practice");
        for place in [&usual, &at("data/practice"), &told.join("practice"), &told] {
            set(place, "a");
            assert_eq!(found(Some(&told), &repository).as_ref(), Some(place));
        }
        assert_eq!(found(None, &repository), Some(usual));
        std::fs::write(told.join("b.truth.h5"), "").unwrap();
        assert_eq!(names(&told), ["a"]);
    }
}
