//! The files that make up an arena, read by the caller: this crate has no file system.

use std::io;
use std::path::Path;

use super::error::ArenaError;

/// Reads files by their paths.
pub(super) struct Files<'a>(pub(super) &'a mut dyn FnMut(&Path) -> io::Result<Vec<u8>>);

impl Files<'_> {
    pub(super) fn bytes(&mut self, path: &Path) -> Result<Vec<u8>, ArenaError> {
        (self.0)(path).map_err(|source| ArenaError::read(path, source))
    }

    pub(super) fn text(&mut self, path: &Path) -> Result<String, ArenaError> {
        String::from_utf8(self.bytes(path)?).map_err(|_| {
            let problem = "stream did not contain valid UTF-8";
            let source = io::Error::new(io::ErrorKind::InvalidData, problem);
            ArenaError::read(path, source)
        })
    }
}
