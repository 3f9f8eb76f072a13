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
    let path = std::env::var_os("FW")
        .map(std::path::PathBuf::from)
        .unwrap_or_else(|| thumb::build("rover-firmware", "firmware"));
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
    let secs: u64 = std::env::var("SECS")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(5);
    let now = board.now();
    if std::env::var_os("PLUG").is_some() {
        board.usb_mut().plug(now);
        board.usb_mut().set_dtr(true, now);
    }
    let mut bytes = 0;
    for ms in 1..=secs * 1000 {
        board.run_until(ms * MS);
        let now = board.now();
        bytes += board.usb_mut().receive(now).len();
    }
    let wall = start.elapsed();
    println!(
        "{wall:?} x{:.0} load {:?} {:.4} {:.1} Mcycles/s busy pc {:08x} incidents {:?} unmodelled {:x?} boot {:?} stack {:?} usb {:?} {bytes} {:?}",
        secs as f64 / wall.as_secs_f64(),
        board.load(),
        board.load().share(),
        board.load().busy as f64 / wall.as_secs_f64() / 1e6,
        board.core().pc(),
        board.incidents(),
        board.unmodelled(),
        board.boot(),
        board.stack_high_water(),
        board.usb().state(),
        board.usb().counters(),
    );
}
