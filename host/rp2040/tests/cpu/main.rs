//! The Cortex-M0+ core: single instructions against vectors, and the system level by programs.

mod exceptions;
mod faults;
mod fixture;
mod instructions;
mod sleep;
mod system_registers;
mod vectors;

/// 20,000 vectors of all encodings.
#[test]
fn committed_sample_of_vectors() {
    assert_eq!(vectors::check(include_bytes!("vectors.bin")), 20_000);
}

/// The file that the environment variable `CPU_VECTORS` names; `make_vectors.py` says how it is
/// made, and how this test is run.
#[test]
#[ignore = "needs a file of vectors"]
fn full_set_of_vectors() {
    let path = std::env::var("CPU_VECTORS").expect("CPU_VECTORS names a file");
    let file = std::fs::read(path).expect("CPU_VECTORS can be read");
    println!("{} vectors agree", vectors::check(&file));
}
