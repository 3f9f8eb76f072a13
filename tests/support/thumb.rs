//! Builds programs for the board's processor, for tests that run them on the emulator.

use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "thumbv6m-none-eabi";

/// Builds a package of the workspace with these features, and gives the program's path.
///
/// # Panics
/// With what to do about it, if that fails.
pub fn build(package: &str, profile: &str, features: &str) -> PathBuf {
    install_target();
    // Not the target folder that the command which runs this test may have locked.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("thumb{features}"));
    run(
        Command::new(env!("CARGO"))
            .args(["build", "--package", package, "--profile", profile])
            .args(["--features", features])
            .args(["--target", TARGET, "--target-dir"])
            .arg(&folder),
        "it is built by this test, which needs the crates that Cargo.lock names",
    );
    folder.join(TARGET).join(profile).join(package)
}

fn install_target() {
    let libraries = run(
        Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]),
        "the compiler has to be on the path",
    );
    if !Path::new(libraries.trim()).exists() {
        run(
            Command::new("rustup").args(["target", "add", TARGET]),
            "install the standard library for the board with `rustup target add \
             thumbv6m-none-eabi`, or your distribution's package of it, and run the test again",
        );
    }
}

/// Runs a command in the workspace; gives what it printed.
fn run(command: &mut Command, advice: &str) -> String {
    let output = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap_or_else(|error| panic!("{command:?} cannot be started ({error}): {advice}"));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{command:?} failed: {advice}\n{errors}"
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}
