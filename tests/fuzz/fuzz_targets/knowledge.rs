//! Knowledge files: `cargo +nightly fuzz run --fuzz-dir tests/fuzz knowledge`.
#![no_main]

#[path = "../entry_points/mod.rs"]
#[allow(dead_code, reason = "each target enters at one point")]
mod entry_points;

libfuzzer_sys::fuzz_target!(|input: &[u8]| entry_points::knowledge(input));
