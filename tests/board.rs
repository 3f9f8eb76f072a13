//! The unmodified firmware on the emulated board.

use std::sync::LazyLock;

use rover_host::board::Machine;
use rover_host::board::elf::Image;
use rover_host::board::peripheral::{CYCLES_PER_MICROSECOND, Cycles};

#[path = "support/thumb.rs"]
mod thumb;

const MS: Cycles = 1_000 * CYCLES_PER_MICROSECOND;

/// The firmware as it is flashed.
static FIRMWARE: LazyLock<Image> = LazyLock::new(|| {
    let path = thumb::build("rover-firmware", "firmware");
    let file = std::fs::read(path).expect("the firmware was built");
    Image::parse(&file).expect("the firmware is an ELF file")
});

fn board() -> Machine {
    Machine::new(&FIRMWARE, 1).expect("the firmware fits into the flash")
}

#[test]
fn the_firmware_comes_up_and_feeds_the_watchdog() {
    let mut board = board();
    let start = std::time::Instant::now();
    for ms in 1..=5_000 {
        board.run_until(ms * MS);
    }
    println!(
        "{:?} load {:?} {} pc {:08x} incidents {:?} unmodelled {:?} boot {:?} stack {:?}",
        start.elapsed(),
        board.load(),
        board.load().share(),
        board.core().pc(),
        board.incidents(),
        board.unmodelled(),
        board.boot(),
        board.stack_high_water(),
    );
    assert_eq!(board.incidents().count(), 0, "{:?}", board.incidents());
}
