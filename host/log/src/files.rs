//! Writing files so that nothing half-written is left behind.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// A file or folder could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {}", said(error))]
pub struct WriteError {
    /// Which.
    pub path: String,
    /// Why not.
    pub error: std::io::Error,
}

/// The error and what to do about it.
fn said(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::AlreadyExists => {
            "cannot be written: it is there already; choose another name".into()
        }
        _ => format!("cannot be written: {error}; choose another place"),
    }
}

impl WriteError {
    /// An error about `path`.
    pub fn new(path: &Path, error: std::io::Error) -> Self {
        Self {
            path: path.display().to_string(),
            error,
        }
    }
}

/// Makes sure that `folder` exists and can be written to, before long work is begun.
///
/// # Errors
/// If it cannot.
pub fn writable_folder(folder: &Path) -> Result<(), WriteError> {
    let try_it = || {
        if folder.is_file() {
            return Err(ErrorKind::NotADirectory.into());
        }
        fs::create_dir_all(folder)?;
        let probe = partial(&folder.join("probe"));
        File::create(&probe)?;
        fs::remove_file(&probe)
    };
    try_it().map_err(|error| WriteError::new(folder, error))
}

/// Writes `bytes` to `path` by way of a file beside it, so that `path` holds either its old
/// contents or all of the new.
///
/// # Errors
/// If it cannot be written; the file beside it is removed.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    Replacement::new(path)?.complete(bytes)
}

/// A file that takes its place only when it is complete, and is removed if it never is.
#[derive(Debug)]
pub struct Replacement {
    file: Option<File>,
    partial: PathBuf,
    path: PathBuf,
}

impl Replacement {
    /// Begins a file that replaces `path` when it is complete.
    ///
    /// # Errors
    /// If nothing can be written beside `path`.
    pub fn new(path: &Path) -> Result<Self, WriteError> {
        let partial = partial(path);
        let file = File::create(&partial).map_err(|error| WriteError::new(path, error))?;
        Ok(Self {
            file: Some(file),
            partial,
            path: path.to_owned(),
        })
    }

    /// The file to write to.
    pub fn file(&mut self) -> &mut File {
        self.file
            .as_mut()
            .expect("only commit, which consumes the value, takes the file")
    }

    /// Writes these bytes and puts the file in its place.
    ///
    /// # Errors
    /// As [`commit`](Self::commit).
    pub fn complete(mut self, bytes: &[u8]) -> Result<(), WriteError> {
        let written = self.file().write_all(bytes);
        written.map_err(|error| WriteError::new(&self.path, error))?;
        self.commit()
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If it cannot be completed or put there.
    pub fn commit(mut self) -> Result<(), WriteError> {
        let file = self.file.take();
        let commit = || {
            file.map_or(Ok(()), |file| file.sync_all())?;
            fs::rename(&self.partial, &self.path)
        };
        commit().map_err(|error| WriteError::new(&self.path, error))
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        // After a commit there is nothing left under this name.
        let _ = fs::remove_file(&self.partial);
    }
}

/// A name beside `path`, always the same, so that what a killed run leaves behind is replaced by the
/// next.
fn partial(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".partial");
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn a_file_appears_only_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut file = Replacement::new(&path).unwrap();
        file.file().write_all(b"half").unwrap();
        assert!(!path.exists());
        drop(file);
        assert_eq!(names(folder.path()), [""; 0]);
        write_whole(&path, b"whole").unwrap();
        assert_eq!(names(folder.path()), ["a"]);
    }

    #[test]
    fn a_folder_that_is_a_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        fs::write(&file, "").unwrap();
        let error = writable_folder(&file).unwrap_err().to_string();
        assert!(error.contains("cannot be written"), "{error}");
    }
}
