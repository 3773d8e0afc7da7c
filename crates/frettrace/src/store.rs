//! Results written beside their place, then renamed: a failed command leaves no half-written file.

use crate::StudyError;
use crate::report::Figure;
use serde::{Serialize, de::DeserializeOwned};
use std::{
    io::{Read, Write},
    path::{Path, PathBuf},
};

/// Writes `text` to `path` in one act: the file is there complete, or not at all.
///
/// # Errors
/// [`StudyError::Write`] when the folder is missing or may not be written to.
pub fn write_text(path: &Path, text: &str) -> Result<(), StudyError> {
    write_bytes(path, text.as_bytes())
}

/// Writes `bytes` to `path` in one act.
///
/// # Errors
/// [`StudyError::Write`] when the folder is missing or may not be written to.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), StudyError> {
    let failed = |source| StudyError::Write { path: path.to_owned(), source };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut beside = tempfile::NamedTempFile::new_in(folder).map_err(failed)?;
    beside.write_all(bytes).map_err(failed)?;
    share(&beside).map_err(failed)?;
    beside.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// A temporary file is private; a result is readable as any other file.
#[cfg(unix)]
fn share(file: &tempfile::NamedTempFile) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn share(_: &tempfile::NamedTempFile) -> std::io::Result<()> {
    Ok(())
}

/// Writes figures into a folder, as SVG and where they were drawn so as PNG, and says where; the folder is made where it is
/// missing.
///
/// # Errors
/// [`StudyError::Write`] when the folder cannot be made or written to.
pub fn write_figures(folder: &Path, figures: &[Figure]) -> Result<Vec<PathBuf>, StudyError> {
    make_folder(folder)?;
    let mut files = Vec::new();
    for figure in figures {
        let forms = [("svg", Some(figure.svg.as_bytes())), ("png", figure.png.as_deref())];
        for (ending, bytes) in forms.into_iter().filter_map(|(ending, bytes)| Some((ending, bytes?))) {
            // Names of runs may hold dots, so that an ending is added and none replaced.
            let path = folder.join(format!("{}.{ending}", figure.name));
            write_bytes(&path, bytes)?;
            files.push(path);
        }
    }
    Ok(files)
}

/// Makes a folder where it is missing.
///
/// # Errors
/// [`StudyError::Write`] when it cannot be made.
pub fn make_folder(path: &Path) -> Result<(), StudyError> {
    std::fs::create_dir_all(path).map_err(|source| StudyError::Write { path: path.to_owned(), source })
}

/// A result as indented JSON with a final line break.
///
/// # Errors
/// [`StudyError::Json`] when a value cannot be written as JSON.
pub fn to_json(path: &Path, result: &impl Serialize) -> Result<String, StudyError> {
    let mut text = serde_json::to_string_pretty(result)
        .map_err(|source| StudyError::Json { path: path.to_owned(), source })?;
    text.push('\n');
    Ok(text)
}

/// Whether a file begins as JSON does.
///
/// # Errors
/// [`StudyError::Read`] when it cannot be read.
pub fn is_json(path: &Path) -> Result<bool, StudyError> {
    let mut first = [0];
    let read = std::fs::File::open(path).and_then(|mut file| file.read(&mut first));
    Ok(read.map_err(|source| StudyError::Read { path: path.to_owned(), source })? == 1 && first == *b"{")
}

/// Reads a result written by [`to_json`].
///
/// # Errors
/// [`StudyError::Read`] when the file cannot be read, [`StudyError::Json`] when it is not such a result.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, StudyError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| StudyError::Read { path: path.to_owned(), source })?;
    serde_json::from_str(&text).map_err(|source| StudyError::Json { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A written file is complete, replaces its predecessor, and leaves nothing beside it.
    #[test]
    fn a_file_is_replaced_in_one_act() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.json");
        write_text(&path, "old").unwrap();
        write_text(&path, "new").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    /// A missing folder is one clear line that says what would mend it.
    #[test]
    fn a_missing_folder_is_named() {
        let error = write_text(Path::new("no-such-folder/result.json"), "x").unwrap_err().to_string();
        assert!(error.starts_with("no-such-folder/result.json: cannot be written"), "{error}");
        assert!(!error.contains('\n') && error.contains("choose a folder"), "{error}");
    }
}
