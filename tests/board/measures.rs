//! What is measured of the firmware.

use emulated_rp2040::defmt::Log;
use emulated_rp2040::elf::Image;
use rover_emulator::profile::Profile;
use rover_shared::contract::Mode;
use rover_shared::wire::message::Command;

use crate::rig::{Bench, FIRMWARE, MS};
use crate::thumb;

#[test]
fn action_cycles_are_measured() {
    let mut bench = Bench::connected(1);
    bench.run(500);
    let profile = Profile::start(&mut bench.machine, &FIRMWARE).expect("the firmware's functions");
    assert_eq!(bench.command(&Command::Arm), Ok(()));
    assert_eq!(bench.command(&Command::SetMode(Mode::Run)), Ok(()));
    bench.run(1_000);
    let cycles = profile.cycles(&bench.machine);
    let first = cycles.first().expect("an action");
    println!("{cycles:?}");
    assert!(first.steps > 10);
    assert!(first.perception < first.whole);
    assert!(first.whole < 20 * MS, "longer than a control period");
}

#[test]
fn log_lines_are_decoded() {
    let path = thumb::build("rover-firmware", "firmware", "defmt");
    let file = std::fs::read(path).expect("the firmware was built");
    let image = Image::parse(&file).expect("the firmware is an ELF file");
    let mut log = Log::new(&file, &image)
        .expect("a table of lines")
        .expect("the firmware logs");
    let mut bench = Bench::with(&image, 1);
    let mut lines = Vec::new();
    for _ in 0..400 {
        bench.run(1);
        lines.extend(log.lines(&mut bench.machine));
    }
    assert!(
        lines.iter().any(|line| line.contains("started, reason 0")),
        "{lines:?}"
    );
    assert_eq!(log.malformed(), 0);
}
