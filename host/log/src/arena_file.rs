//! Arenas by their names, or from their files.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use rover_simulator::arena::{ArenaError, ArenaSource};

/// A built-in arena by its name, or that of a file.
///
/// # Errors
/// If there is no such arena, or the file is not a valid one.
pub fn load(spec: &str) -> Result<ArenaSource, ArenaError> {
    ArenaSource::named(spec).map_or_else(|| load_file(Path::new(spec)), Ok)
}

/// The arena of a file: TOML, or a `map_server` map.
///
/// # Errors
/// If the file is not a valid one.
pub fn load_file(path: &Path) -> Result<ArenaSource, ArenaError> {
    ArenaSource::read(path, &mut read)
}

/// Reads no more than an arena can use: a map may name a device that never ends.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = File::open(path)?;
    file.take(ArenaSource::LARGEST_FILE)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn an_image_without_end_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.yaml");
        let yaml = "image: /dev/zero\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n\
            occupied_thresh: 0.65\nfree_thresh: 0.196\n";
        std::fs::write(&path, yaml).unwrap();
        let error = load_file(&path).unwrap_err().to_string();
        assert!(
            error.contains("/dev/zero") && error.contains("PGM"),
            "{error}"
        );
    }
}
