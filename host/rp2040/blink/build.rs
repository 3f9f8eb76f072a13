//! Tells the linker where `memory.x` is.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    // On a host there is nothing to link: `cargo check --workspace` gets this far.
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    println!("cargo:rustc-link-search={}", env!("CARGO_MANIFEST_DIR"));
    for script in ["link.x", "link-rp.x"] {
        println!("cargo:rustc-link-arg-bins=-T{script}");
    }
    // Do not pad the file so that its sections can be mapped page by page.
    println!("cargo:rustc-link-arg-bins=--nmagic");
}
