//! Files that commands read.

use std::path::{Path, PathBuf};

use rover_shared::parameters::Parameters;
use rover_simulator::parameters::overlay;

use super::output::Failure;

/// A file's bytes.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path)
        .map_err(|error| Failure::of(path.display(), format_args!("cannot be read: {error}")))
}

/// The bytes of the files of one log.
pub fn read_all(paths: &[PathBuf]) -> Result<Vec<Vec<u8>>, Failure> {
    paths.iter().map(|path| read(path)).collect()
}

/// Paths for people, with `between` between them.
pub fn listed(paths: &[PathBuf], between: &str) -> String {
    let paths: Vec<_> = paths
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    paths.join(between)
}

/// Reads a file of parameters; what it leaves out is as in `preset`.
pub fn read_parameters(path: Option<&Path>, preset: Parameters) -> Result<Parameters, Failure> {
    let Some(path) = path else {
        return Ok(preset);
    };
    let text = String::from_utf8(read(path)?);
    let text = text.map_err(|error| Failure::of(path.display(), error.utf8_error()))?;
    overlay(preset, &text).map_err(|error| Failure::of(path.display(), error))
}
