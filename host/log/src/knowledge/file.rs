//! Knowledge files: `rover_shared::knowledge` bytes as they are, one file a robot.

use std::path::Path;

use rover_shared::knowledge::KnowledgeError;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::parameters::{Coefficients, Parameters};

use crate::files;
use rover_simulator::experiment::Known;

/// Why a knowledge file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// It cannot be read at all.
    #[error("{path}: cannot be read: {error}")]
    Io {
        /// The file.
        path: String,
        /// Why not.
        error: std::io::Error,
    },
    /// It is not knowledge.
    #[error("{path}: {error}")]
    Knowledge {
        /// The file.
        path: String,
        /// What is wrong with it.
        error: KnowledgeError,
    },
    /// It was learned with parameters that cannot be used.
    #[error("{path}: {error}")]
    Parameters {
        /// The file.
        path: String,
        /// What is wrong with them.
        error: rover_shared::range_check::ParameterError,
    },
}

/// Knowledge ready to be used.
#[derive(Debug)]
pub struct Loaded {
    /// What was learned.
    pub known: Box<Known>,
    /// The parameters it was learned with, and what follows from them.
    pub coefficients: Coefficients,
}

/// Knowledge and its parameters from their form as bytes.
///
/// # Errors
/// If the bytes are not knowledge.
pub fn from_bytes(bytes: &[u8]) -> Result<(Box<Known>, Parameters), KnowledgeError> {
    let mut known = Box::new(Known::default());
    let parameters = known.read::<PaperRule>(bytes)?;
    Ok((known, parameters))
}

/// Knowledge in its form as bytes.
pub fn to_bytes(known: &Known, parameters: &Parameters) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(known.size());
    let written = known.write::<PaperRule, std::convert::Infallible>(parameters, |part| {
        bytes.extend_from_slice(part);
        Ok(())
    });
    match written {
        Ok(()) => bytes,
        Err(never) => match never {},
    }
}

/// Reads a knowledge file.
///
/// # Errors
/// [`FileError`], which names the file.
pub fn load(path: &Path) -> Result<Loaded, FileError> {
    let name = || path.display().to_string();
    let bytes = std::fs::read(path).map_err(|error| FileError::Io {
        path: name(),
        error,
    })?;
    let (known, parameters) = from_bytes(&bytes).map_err(|error| FileError::Knowledge {
        path: name(),
        error,
    })?;
    let coefficients = Coefficients::new(&parameters).map_err(|error| FileError::Parameters {
        path: name(),
        error,
    })?;
    Ok(Loaded {
        known,
        coefficients,
    })
}

/// Writes a knowledge file, whole or not at all.
///
/// # Errors
/// If it cannot be written.
pub fn save(path: &Path, known: &Known, parameters: &Parameters) -> Result<(), files::WriteError> {
    files::write_whole(path, &to_bytes(known, parameters))
}
