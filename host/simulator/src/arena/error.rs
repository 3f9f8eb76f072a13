//! Everything that can be wrong with an arena.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why an arena could not be loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArenaError {
    /// Neither the name of a built-in arena nor a file of a known kind.
    #[error(
        "no arena `{0}`: expected paper, harder, free, rover or rover-5m, or a file that ends in \
         .toml, .yaml or .yml"
    )]
    Unknown(String),
    /// The file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is read but a line of it is not as expected.
    #[error("{}, line {line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// The file as a whole is not as expected.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what was expected.
        problem: String,
    },
}

impl ArenaError {
    pub(super) fn read(path: &Path, source: std::io::Error) -> Self {
        let path = path.to_path_buf();
        Self::Read { path, source }
    }

    pub(super) fn line(path: &Path, line: usize, problem: impl Into<String>) -> Self {
        Self::Line {
            path: path.to_path_buf(),
            line,
            problem: problem.into(),
        }
    }

    pub(super) fn file(path: &Path, problem: impl Into<String>) -> Self {
        Self::File {
            path: path.to_path_buf(),
            problem: problem.into(),
        }
    }
}
