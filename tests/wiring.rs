//! The wiring table of `firmware/README.md`, the pins in `firmware/src/board.rs` and the linker script
//! say the same.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::collections::BTreeMap;

const BOARD: &str = include_str!("../firmware/src/board.rs");
const README: &str = include_str!("../firmware/README.md");
const STORE: &str = include_str!("../firmware/src/store.rs");
const MEMORY: &str = include_str!("../memory.x");

/// GPIO by signal.
type Pins = BTreeMap<String, u8>;

/// Both boards' pins by the source: `let signal = ... p.PIN_n ...;`, with the `cfg` in the line before.
fn in_source() -> [Pins; 2] {
    let mut boards = [Pins::new(), Pins::new()];
    let mut condition = [true, true];
    for line in BOARD.lines().map(str::trim) {
        if let Some((before, after)) = line.split_once("p.PIN_") {
            let signal = before.strip_prefix("let ").unwrap();
            let signal = signal.split(' ').next().unwrap();
            let digits = after.split(|c: char| !c.is_ascii_digit()).next().unwrap();
            for (board, holds) in boards.iter_mut().zip(condition) {
                if holds {
                    let before = board.insert(signal.into(), digits.parse().unwrap());
                    assert_eq!(before, None, "{signal} is named once");
                }
            }
        }
        condition = match line {
            "#[cfg(feature = \"pico\")]" => [false, true],
            "#[cfg(not(feature = \"pico\"))]" => [true, false],
            _ => [true, true],
        };
    }
    boards
}

/// Both boards' pins by the table: `| signal | GPIO | GPIO, Pico | ...`.
fn in_table() -> [Pins; 2] {
    let mut boards = [Pins::new(), Pins::new()];
    for line in README.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        for (board, cell) in boards.iter_mut().zip([cells[2], cells[3]]) {
            if cell != "-" {
                board.insert(cells[1].trim_matches('`').into(), cell.parse().unwrap());
            }
        }
    }
    boards
}

#[test]
fn table_and_source_name_the_same_pins() {
    assert_eq!(in_source(), in_table());
    let [four, three] = in_table();
    assert_eq!((four.len(), three.len()), (12, 12));
}

#[test]
fn no_pin_has_two_signals() {
    for board in in_source() {
        let mut pins: Vec<_> = board.values().collect();
        pins.sort();
        pins.dedup();
        assert_eq!(pins.len(), board.len(), "{board:?}");
    }
}

/// The converter gives its channels in the order of their pins, whatever order is asked for.
#[test]
fn range_sensors_are_in_the_order_of_their_pins() {
    for board in in_source() {
        let order = ["front_left", "front_right", "left", "right"];
        let pins: Vec<_> = order.iter().filter_map(|name| board.get(*name)).collect();
        assert!(pins.is_sorted() && pins.iter().all(|pin| (26..=29).contains(*pin)));
    }
}

/// Where a fault handler takes the pins from.
#[test]
fn the_pins_that_a_fault_switches_off_are_the_motors() {
    for board in in_source() {
        let named = format!(
            "const MOTOR_PWM_PINS: [usize; 2] = [{}, {}];",
            board["left_pwm"], board["right_pwm"]
        );
        assert!(BOARD.contains(&named), "{named}");
        // Channels A and B of one slice: stopped by one register.
        let slice = board["left_pwm"] / 2 % 8;
        assert_eq!(slice, board["right_pwm"] / 2 % 8);
        assert!(BOARD.contains(&format!("const MOTOR_SLICE: usize = {slice};")));
    }
}

fn number(text: &str, before: &str, after: &str) -> u32 {
    let rest = text.split_once(before).unwrap().1;
    rest.split_once(after).unwrap().0.trim().parse().unwrap()
}

#[test]
fn the_slots_fit_into_the_flash_that_is_set_aside() {
    let knowledge = number(STORE, "KNOWLEDGE_SECTORS: u32 =", ";");
    let calibrations = number(STORE, "CALIBRATION_SECTORS: u32 =", ";");
    let storage = MEMORY.split_once("STORAGE :").unwrap().1;
    let kilobytes = number(storage, "LENGTH =", "K");
    assert!(2 * (knowledge + calibrations) * 4 <= kilobytes);
    assert!(MEMORY.contains("LENGTH = 2048K - 128K - 0x100") && kilobytes == 128);
    assert!(README.contains(&format!("Two slots of {} KB for knowledge", 4 * knowledge)));
}
