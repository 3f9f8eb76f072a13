//! Raspberry Pi Pico: GPIO 29 is not brought out, so there is one range sensor ahead.

use crate::{Board, Bus, Motor};

/// The board.
pub const BOARD: Board = Board {
    name: c"raspberry-pi-pico",
    left: Motor {
        pwm: 0,
        forward: 2,
        reverse: 3,
    },
    right: Motor {
        pwm: 1,
        forward: 4,
        reverse: 5,
    },
    compass: Bus { sda: 6, scl: 7 },
    ranges: [Some(26), None, Some(27), Some(28)],
    led: Some(25),
    flash_bytes: 2 * 1024 * 1024,
};
