//! Chooses the board by the features, and tells the linker where the root's `memory.x` is.

use std::env;
use std::path::Path;

/// The board without a feature of its own.
const DEFAULT_BOARD: &str = "rp2040_four_adc";
/// Features that are no boards.
const OTHER_FEATURES: [&str; 3] = ["default", "defmt", "gp2y0a21"];

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../memory.x");
    choose_board();
    // On a host there is nothing to link: `cargo check --workspace` gets this far.
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    println!("cargo:rustc-link-search={}", root.display());
    for script in ["link.x", "link-rp.x"] {
        println!("cargo:rustc-link-arg-bins=-T{script}");
    }
    // Do not pad the file so that its sections can be mapped page by page.
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}

/// Writes which of the crate `rover-boards`' modules is the board.
fn choose_board() {
    let features = env::vars().filter_map(|(name, _)| {
        let feature = name.strip_prefix("CARGO_FEATURE_")?;
        Some(feature.to_lowercase())
    });
    let boards: Vec<String> = features
        .filter(|feature| !OTHER_FEATURES.contains(&feature.as_str()))
        .collect();
    let board = match boards.as_slice() {
        [] => DEFAULT_BOARD,
        [board] => board,
        _ => panic!("choose one board of the features {boards:?}"),
    };
    let out = env::var("OUT_DIR").expect("cargo sets it");
    let text = format!("pub use rover_boards::{board}::BOARD;\n");
    std::fs::write(Path::new(&out).join("board.rs"), text).expect("the output is writable");
}
