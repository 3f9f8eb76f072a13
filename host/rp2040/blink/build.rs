//! Tells the linker where the root's `memory.x` is.

use std::path::Path;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../../../memory.x");
    // On a host there is nothing to link: `cargo check --workspace` gets this far.
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    println!("cargo:rustc-link-search={}", root.display());
    for script in ["link.x", "link-rp.x"] {
        println!("cargo:rustc-link-arg-bins=-T{script}");
    }
    // Do not pad the file so that its sections can be mapped page by page.
    println!("cargo:rustc-link-arg-bins=--nmagic");
}
