//! The core calculates the same on the board's processor as on the host: `thumb/` is built for
//! thumbv6m, run on the emulator's bare machine, and its checksums compared with those of the same
//! code here.

use emulated_rp2040::bare::{Bare, Exit};
use emulated_rp2040::elf::Image;

#[path = "thumb/src/groups.rs"]
mod groups;
#[path = "support/thumb.rs"]
mod thumb;

const PACKAGE: &str = "rover-thumb-vectors";
/// Ten times what it takes.
const CYCLE_LIMIT: u64 = 2_000_000_000;

/// One line a group.
#[derive(Default)]
struct Lines(Vec<String>);

impl groups::Report for Lines {
    fn group(&mut self, name: &str, checksum: u32) {
        self.0.push(format!("{name} {checksum:08x}"));
    }
}

#[test]
fn board_and_host_calculate_the_same() {
    let file = std::fs::read(thumb::build(PACKAGE, "release", "")).expect("the program was built");
    let image = Image::parse(&file).expect("the program is an ELF file");
    let vectors = image
        .symbol("__vector_table")
        .expect("the program has a vector table");
    let mut machine = Bare::new();
    machine
        .load(&image)
        .expect("the program fits into the machine");
    machine.reset(vectors.address);
    let exit = machine
        .run(CYCLE_LIMIT)
        .expect("the program ends by itself");
    let output = String::from_utf8_lossy(machine.output());
    println!("{output}({} cycles in all)", machine.cycles());
    assert_eq!(exit, Exit::SUCCESS, "{output}");
    let mut here = Lines::default();
    groups::run(&mut here);
    let mut there: Vec<&str> = output.lines().collect();
    let cycles = there.pop().unwrap_or_default();
    assert!(cycles.starts_with("cycles of"), "{output}");
    assert_eq!(
        there, here.0,
        "on the board's processor (left) and here (right)"
    );
}
