//! The unmodified firmware on the emulated board.

#[path = "board/flash.rs"]
mod flash;
#[path = "board/measures.rs"]
mod measures;
#[path = "board/resets.rs"]
mod resets;
#[path = "board/rig.rs"]
mod rig;
#[path = "board/sensors.rs"]
mod sensors;
#[path = "support/thumb.rs"]
mod thumb;
#[path = "board/usb.rs"]
mod usb;

use emulated_rp2040::bus::Boot;
use emulated_rp2040::usb::State;
use rig::{Bench, MS};
use rover_shared::contract::{Mode, Outcome, ResetReason};
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::{Command, EventKind, Report};

#[test]
fn the_firmware_comes_up_with_its_motors_off_and_feeds_the_watchdog() {
    let mut bench = Bench::new(1);
    for _ in 0..3_000 {
        bench.run(1);
        assert!(bench.motors().iter().all(|duty| *duty == 0.0));
    }
    let machine = &bench.machine;
    assert_eq!(machine.boot(), Boot::Started);
    assert_eq!(machine.incidents().first(), [], "the watchdog bites in 1 s");
    assert_eq!(machine.unmodelled(), None);
    assert_eq!(machine.usb().state(), State::Unplugged);
    assert!(machine.load().idle > machine.load().busy);
    let stack = machine.stack_high_water().expect("the stack's symbols");
    assert!((500..20_000).contains(&stack), "{stack} bytes of stack");
}

#[test]
fn it_says_hello_when_the_port_is_opened() {
    let bench = Bench::connected(1);
    let hello = bench.hello();
    assert_eq!(hello.board, "rp2040-four-adc");
    assert_eq!(hello.reset, ResetReason::PowerOn);
    assert!(hello.knowledge.is_some(), "a new board begins untrained");
    let description = bench.machine.usb().description().expect("configured");
    println!("{description:?}");
    assert_eq!(Bench::connected(1).hello().seed, hello.seed);
    assert_ne!(Bench::connected(2).hello().seed, hello.seed);
}

#[test]
fn it_drives_when_told_to_and_stops_when_told_to() {
    let mut bench = Bench::connected(1);
    let drive = Command::Drive {
        turn: Microdegrees(0),
        advance: Micrometres(70_000),
    };
    bench.run(500);
    assert!(bench.command(&drive).is_err(), "not armed");
    assert_eq!(bench.command(&Command::Arm), Ok(()));
    bench.keep_alive();
    bench.run(400);
    assert_eq!(bench.command(&Command::SetMode(Mode::Host)), Ok(()));
    assert!(bench.motors_off());
    assert_eq!(bench.command(&drive), Ok(()));
    bench.run(100);
    let motors = bench.motors();
    assert!(motors[0] > 0.1 && motors[1] > 0.1, "{motors:?}");
    assert_eq!(motors[2..], [1.0, 0.0, 1.0, 0.0], "both sides forward");
    assert_eq!(bench.command(&Command::Disarm), Ok(()));
    assert!(bench.motors_off());
    bench.run(100);

    assert_eq!(bench.command(&Command::Arm), Ok(()));
    assert_eq!(bench.command(&Command::SetMode(Mode::Host)), Ok(()));
    assert_eq!(bench.command(&drive), Ok(()));
    let ended = bench.wait(3_000, |report| {
        matches!(report, Report::Event(event) if event.kind == EventKind::MoveEnded(Outcome::Completed))
    });
    assert!(ended.is_some(), "{:?}", bench.reports);
    bench.run(20);
    assert!(bench.motors_off());
}

#[test]
fn a_run_is_repeatable() {
    let run = || {
        let mut bench = Bench::connected(3);
        bench.run(1_000);
        let machine = &bench.machine;
        (
            machine.now(),
            machine.load(),
            machine.core().pc(),
            bench.reports.clone(),
        )
    };
    assert_eq!(run(), run());
    assert!(run().0 >= 1_000 * MS);
}
