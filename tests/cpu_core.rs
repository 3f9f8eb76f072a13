//! The Cortex-M0+ core: single instructions against vectors, and the system level by programs.

#[path = "cpu/exceptions.rs"]
mod exceptions;
#[path = "cpu/faults.rs"]
mod faults;
#[path = "cpu/fixture.rs"]
mod fixture;
#[path = "cpu/instructions.rs"]
mod instructions;
#[path = "cpu/sleep.rs"]
mod sleep;
#[path = "cpu/system_registers.rs"]
mod system_registers;
#[path = "cpu/vectors.rs"]
mod vectors;

/// 20,000 vectors of all encodings.
#[test]
fn committed_sample_of_vectors() {
    assert_eq!(vectors::check(include_bytes!("vectors/cpu.bin")), 20_000);
}

/// The file that the environment variable `CPU_VECTORS` names; `make_cpu_vectors.py` says how it is
/// made, and how this test is run.
#[test]
#[ignore = "needs a file of vectors"]
fn full_set_of_vectors() {
    let path = std::env::var("CPU_VECTORS").expect("CPU_VECTORS names a file");
    let file = std::fs::read(path).expect("CPU_VECTORS can be read");
    println!("{} vectors agree", vectors::check(&file));
}
