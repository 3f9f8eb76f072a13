//! Whatever resets the board: it comes up with its motors off, and says why.

use emulated_rp2040::cpu::PC;
use emulated_rp2040::incident::Kind;
use emulated_rp2040::peripheral::Cycles;
use rover_shared::contract::{Mode, ResetReason};
use rover_shared::wire::message::Command;

use crate::rig::{Bench, FIRMWARE, MS};

/// Within which a silent loop resets the board.
const PROMISE: Cycles = 1_000 * MS;
/// How long to wait for what resets the board, to tell late from never.
const SILENCE: u64 = 2_200;

/// A bench whose rover is driving.
fn driving() -> Bench {
    let mut bench = Bench::connected(1);
    bench.run(500);
    bench.keep_alive();
    bench.run(250);
    for command in [
        Command::Arm,
        Command::SetMode(Mode::Host),
        Command::Drive {
            turn: rover_shared::units::Microdegrees(0),
            advance: rover_shared::units::Micrometres(70_000),
        },
    ] {
        assert_eq!(bench.command(&command), Ok(()));
    }
    bench.run(100);
    assert!(!bench.motors_off());
    bench
}

/// Runs until the incident with this number; gives how long that took, and how long the motors ran.
fn until_incident(bench: &mut Bench, number: usize) -> (Kind, Cycles, Cycles) {
    let start = bench.machine.now();
    let mut driven = start;
    while bench.machine.now() < start + SILENCE * MS {
        bench.run(1);
        if let Some(incident) = bench.machine.incidents().first().get(number) {
            assert!(bench.motors_off());
            return (incident.kind, incident.at - start, driven - start);
        }
        if !bench.motors_off() {
            driven = bench.machine.now();
        }
    }
    panic!("nothing happened: {:?}", bench.machine.incidents());
}

/// What the host hears when it finds the board again.
fn reason(bench: &mut Bench) -> ResetReason {
    for _ in 0..1_500 {
        bench.run(1);
        assert!(bench.motors_off());
    }
    bench.connect();
    bench.hello().reset
}

#[test]
fn a_task_that_hangs_ends_in_a_watchdog_reset() {
    let mut bench = driving();
    while !bench.machine.hang() {
        bench.run(1);
    }
    let (kind, after, driven) = until_incident(&mut bench, 0);
    assert_eq!(kind, Kind::Watchdog { fault: None });
    assert!(driven <= 210 * MS, "motors ran {} ms", driven / MS);
    assert!(after <= PROMISE, "reset after {} ms", after / MS);
    assert_eq!(reason(&mut bench), ResetReason::Watchdog);
    assert_eq!(bench.last_words(), None);
}

#[test]
fn a_core_that_stands_still_ends_in_a_watchdog_reset() {
    let mut bench = driving();
    bench.machine.stall(5_000 * MS);
    let (kind, after, _) = until_incident(&mut bench, 0);
    assert_eq!(kind, Kind::Watchdog { fault: None });
    assert!(after <= PROMISE, "reset after {} ms", after / MS);
}

#[test]
fn a_hard_faults_text_survives_the_reset() {
    let mut bench = driving();
    bench
        .machine
        .core_mut()
        .registers_mut()
        .set(PC, 0x3000_0000);
    let (kind, at_fault, driven) = until_incident(&mut bench, 0);
    assert!(matches!(kind, Kind::HardFault(_)), "{kind:?}");
    // The core may be asleep until the next control period.
    assert!(at_fault <= 21 * MS && driven <= 21 * MS);
    let reset = bench.machine.incidents().first()[1].kind;
    assert!(
        matches!(reset, Kind::Watchdog { fault: Some(_) }),
        "{reset:?}"
    );
    assert_eq!(reason(&mut bench), ResetReason::HardFault);
    let words = bench.last_words().expect("last words");
    assert!(words.starts_with("hard fault at 0x30000000"), "{words}");
}

#[test]
fn a_panics_text_survives_the_reset() {
    /// In the stack's last bytes, which nothing reaches.
    const LOCATION: u32 = 0x2000_0100;
    let mut bench = driving();
    let mut panics = FIRMWARE.symbols();
    let (_, panic) = panics
        .find(|(name, _)| name.contains("panic_const_div_by_zero"))
        .expect("the firmware divides somewhere");
    // A `core::panic::Location`: file, line, column.
    let location = [LOCATION + 16, 9, 42, 7].map(u32::to_le_bytes).concat();
    for (address, bytes) in [(LOCATION, &location[..]), (LOCATION + 16, b"orange.rs")] {
        bench.machine.write_ram(address, bytes).expect("in RAM");
    }
    let registers = bench.machine.core_mut().registers_mut();
    registers.set(0, LOCATION);
    registers.set(PC, panic.address);
    let (kind, ..) = until_incident(&mut bench, 0);
    assert_eq!(kind, Kind::Watchdog { fault: None });
    assert_eq!(reason(&mut bench), ResetReason::Panic);
    assert_eq!(bench.last_words(), Some("panicked at orange.rs:42"));
}

#[test]
fn other_resets_are_told_apart() {
    let mut bench = driving();
    bench.machine.brown_out();
    assert!(bench.motors_off());
    assert_eq!(reason(&mut bench), ResetReason::PowerOn);
    bench.machine.pulse_run_pin();
    assert_eq!(reason(&mut bench), ResetReason::RunPin);
    bench.machine.power_off();
    bench.run(100);
    assert!(!bench.machine.powered() && bench.motors_off());
    bench.machine.power_on();
    assert_eq!(reason(&mut bench), ResetReason::PowerOn);
    let kinds: Vec<Kind> = bench
        .machine
        .incidents()
        .first()
        .iter()
        .map(|incident| incident.kind)
        .collect();
    assert_eq!(kinds, [Kind::BrownOut, Kind::RunPin, Kind::PowerLost]);
}
