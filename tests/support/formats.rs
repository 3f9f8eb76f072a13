//! Files in formats that were written once; see `tests/data/formats/README.md`.

use std::io::Read;
use std::path::Path;

/// Simulations' logs.
pub const SIMULATIONS: [&str; 2] = ["target.mcap", "direction.mcap"];
/// Recordings, each with all its files.
pub const RECORDINGS: [&[&str]; 2] = [&["drive.mcap.lz4"], &["parts.mcap.lz4", "parts-2.mcap.lz4"]];

/// The contents of one of the files, unpacked.
pub fn contents(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats");
    let bytes = std::fs::read(folder.join(name)).unwrap();
    if !name.ends_with(".lz4") {
        return bytes;
    }
    let mut contents = Vec::new();
    let mut decoder = lz4_flex::frame::FrameDecoder::new(&*bytes);
    decoder.read_to_end(&mut contents).unwrap();
    contents
}

/// The logs: of each the contents of its files.
pub fn logs() -> Vec<Vec<Vec<u8>>> {
    let simulations = SIMULATIONS.iter().map(|name| vec![contents(name)]);
    let files = |names: &&[&str]| names.iter().map(|name| contents(name)).collect();
    simulations.chain(RECORDINGS.iter().map(files)).collect()
}
