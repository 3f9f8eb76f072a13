//! Boards that bring out all four ADC pins, and GPIO 0 to 7: Waveshare RP2040-Zero, Pimoroni Tiny
//! 2040. Neither has a plain light.

use crate::{Board, Bus, Motor};

/// The board.
pub const BOARD: Board = Board {
    name: c"rp2040-four-adc",
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
    ranges: [Some(26), Some(27), Some(28), Some(29)],
    led: None,
    // The smaller one of the two.
    flash_bytes: 2 * 1024 * 1024,
};
