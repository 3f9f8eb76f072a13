//! What is wired to which pin, board by board: data for the firmware, which takes its pins by it,
//! and for the emulator, which wires its vehicle by it.
//!
//! To add a board, copy a file beside this one and change it, and add its name to `[features]` in
//! `firmware/Cargo.toml`: `cargo fw --features NAME` builds for it. A description that the RP2040 or
//! the firmware cannot follow does not compile ([`Board::check`]). The table in
//! `firmware/README.md` is for people; `tests/wiring.rs` compares it with this.
//!
//! ```
//! let names: Vec<_> = rover_boards::ALL.iter().map(|board| board.name()).collect();
//! assert!(names.contains(&"raspberry-pi-pico"));
//! ```
#![no_std]
#![forbid(unsafe_code)]

use core::ffi::CStr;

include!(concat!(env!("OUT_DIR"), "/boards.rs"));

/// The number of a GPIO, 0 to 29.
pub type Pin = u8;

/// A board, and what is connected to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// Its name: by this the rover introduces itself, `picotool info` shows it (`pico_board`), and
    /// the emulator finds the description that belongs to an image. Zero-terminated for `picotool`.
    pub name: &'static CStr,
    /// The left side's half of the motor driver.
    pub left: Motor,
    /// The right side's half of the motor driver.
    pub right: Motor,
    /// The compass's bus.
    pub compass: Bus,
    /// The range sensors, `None` where one is not fitted: ahead (on the left of two), ahead on the
    /// right, left, right.
    pub ranges: [Option<Pin>; 4],
    /// A plain light, on while its pin is high.
    pub led: Option<Pin>,
    /// Size of the flash in bytes.
    pub flash_bytes: usize,
}

/// One side's motors behind a bridge with PWM and two direction inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motor {
    /// High for the share of the time that the motor is driven.
    pub pwm: Pin,
    /// High to go forwards.
    pub forward: Pin,
    /// High to go backwards.
    pub reverse: Pin,
}

/// An I2C bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bus {
    /// Data.
    pub sda: Pin,
    /// Clock.
    pub scl: Pin,
}

impl Motor {
    /// The PWM slice (0 to 7) that drives its PWM pin (RP2040 data sheet, 4.5.2).
    pub const fn slice(self) -> u8 {
        self.pwm / 2 % 8
    }
}

impl Bus {
    /// The controller, 0 or 1, whose pins these can be (RP2040 data sheet, 2.19.2).
    pub const fn controller(self) -> u8 {
        self.sda / 2 % 2
    }
}

/// The pins that the ADC can read (RP2040 data sheet, 4.9.1).
const ADC: [Pin; 4] = [26, 27, 28, 29];

impl Board {
    /// The ADC channel, 0 to 3, of a pin that it can read.
    pub const fn adc_channel(pin: Pin) -> usize {
        (pin - ADC[0]) as usize
    }

    /// Its name.
    pub const fn name(&self) -> &'static str {
        match self.name.to_str() {
            Ok(name) => name,
            Err(_) => panic!("a board's name is not UTF-8"),
        }
    }

    /// All signals with their pins, `None` for what the board does not have.
    pub const fn signals(&self) -> [(&'static CStr, Option<Pin>); 13] {
        let [front_left, front_right, left, right] = self.ranges;
        [
            (c"left_pwm", Some(self.left.pwm)),
            (c"right_pwm", Some(self.right.pwm)),
            (c"left_forward", Some(self.left.forward)),
            (c"left_reverse", Some(self.left.reverse)),
            (c"right_forward", Some(self.right.forward)),
            (c"right_reverse", Some(self.right.reverse)),
            (c"sda", Some(self.compass.sda)),
            (c"scl", Some(self.compass.scl)),
            (c"front_left", front_left),
            (c"front_right", front_right),
            (c"left", left),
            (c"right", right),
            (c"led", self.led),
        ]
    }

    /// Checked for every board while this crate is compiled.
    ///
    /// # Panics
    /// The RP2040 or the firmware cannot follow the description.
    pub const fn check(&self) {
        self.name();
        let signals = self.signals();
        let mut used = 0u32;
        let mut i = 0;
        while i < signals.len() {
            if let Some(pin) = signals[i].1 {
                assert!(pin <= 29, "the RP2040 has GPIO 0 to 29");
                assert!(used >> pin & 1 == 0, "a pin has two signals");
                used |= 1 << pin;
            }
            i += 1;
        }
        assert!(
            self.left.slice() == self.right.slice(),
            "both PWM pins must be of one slice: one register stops both sides"
        );
        assert!(
            self.left.pwm.is_multiple_of(2) && !self.right.pwm.is_multiple_of(2),
            "the left PWM pin must be channel A (even), the right one channel B (odd)"
        );
        assert!(
            self.compass.sda % 4 == 2 && self.compass.scl % 4 == 3,
            "the compass must be on pins of I2C1: SDA on 2, 6, 10, ..., SCL on 3, 7, 11, ..."
        );
        let [front_left, _, left, right] = self.ranges;
        assert!(
            front_left.is_some() && left.is_some() && right.is_some(),
            "only the sensor on the front right may be missing"
        );
        let mut next = ADC[0];
        let mut i = 0;
        while i < self.ranges.len() {
            if let Some(pin) = self.ranges[i] {
                assert!(
                    next <= pin && pin <= ADC[3],
                    "range sensors must be on GPIO 26 to 29, in ascending order"
                );
                next = pin + 1;
            }
            i += 1;
        }
        assert!(
            self.flash_bytes >= 2 * 1024 * 1024,
            "memory.x keeps knowledge at the end of the first 2 MB of the flash"
        );
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    #[test]
    fn boards_have_names_of_their_own() {
        let mut names: Vec<_> = ALL.iter().map(|board| board.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), ALL.len());
    }

    /// What `check` says to a board that was spoilt.
    fn refused(spoil: impl FnOnce(&mut Board)) -> &'static str {
        let mut board = pico::BOARD;
        spoil(&mut board);
        let panic = std::panic::catch_unwind(|| board.check()).expect_err("a wrong board");
        panic.downcast_ref::<&str>().expect("a plain text")
    }

    #[test]
    fn wrong_descriptions_are_refused() {
        let no_pin = refused(|board| board.led = Some(30));
        assert_eq!(no_pin, "the RP2040 has GPIO 0 to 29");
        let twice = refused(|board| board.led = board.ranges[0]);
        assert_eq!(twice, "a pin has two signals");
        let slices = refused(|board| board.right.pwm = 9);
        assert!(slices.contains("one slice"));
        let swapped = refused(|board| core::mem::swap(&mut board.left.pwm, &mut board.right.pwm));
        assert!(swapped.contains("channel A"));
        let other_controller = refused(|board| board.compass = Bus { sda: 8, scl: 9 });
        assert!(other_controller.contains("I2C1"));
        let swapped =
            refused(|board| core::mem::swap(&mut board.compass.sda, &mut board.compass.scl));
        assert!(swapped.contains("I2C1"));
        let blind = refused(|board| board.ranges[2] = None);
        assert!(blind.contains("missing"));
        let digital = refused(|board| board.ranges[3] = Some(22));
        assert!(digital.contains("26 to 29"));
        let order = refused(|board| board.ranges.swap(2, 3));
        assert!(order.contains("ascending"));
        let small = refused(|board| board.flash_bytes /= 2);
        assert!(small.contains("2 MB"));
    }

    #[test]
    fn pwm_slices_are_the_data_sheets() {
        let slice = |pwm| {
            Motor {
                pwm,
                ..pico::BOARD.left
            }
            .slice()
        };
        assert_eq!([0, 1, 15, 16, 29].map(slice), [0, 0, 7, 0, 6]);
    }
}
