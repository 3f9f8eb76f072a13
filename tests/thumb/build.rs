//! Links for the bare machine: everything in RAM.

fn main() {
    println!("cargo:rerun-if-changed=bare.x");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        println!(
            "cargo:rustc-link-arg-bins=-T{}/bare.x",
            env!("CARGO_MANIFEST_DIR")
        );
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
}
