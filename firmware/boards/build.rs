//! Lists the boards: every file in `src` but `lib.rs`.

use std::env::var;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=src");
    let source = Path::new(&var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("src");
    let files = fs::read_dir(source).expect("the boards' directory is readable");
    let mut files: Vec<_> = files.map(|file| file.expect("readable").path()).collect();
    files.sort();
    let (mut text, mut all) = (String::new(), String::new());
    for file in files {
        let name = file.file_stem().and_then(|name| name.to_str());
        let name = name.expect("a board's file has a plain name");
        if name != "lib" {
            let checked = format!("const _: () = {name}::BOARD.check();");
            writeln!(text, "#[path = {file:?}]\npub mod {name};\n{checked}").expect("memory");
            write!(all, "&{name}::BOARD, ").expect("memory");
        }
    }
    let list = format!("/// All boards.\npub const ALL: &[&Board] = &[{all}];\n");
    let out = var("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("boards.rs"), text + &list).expect("the output is writable");
}
