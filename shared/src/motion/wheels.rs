//! The command to the motors.

use serde::{Deserialize, Serialize};

/// Duties of the two sides, in per mille of full, forwards positive; never beyond 1000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct WheelCommand {
    left: i16,
    right: i16,
}

impl WheelCommand {
    /// Full duty.
    pub const FULL: i16 = 1_000;
    /// Both sides stopped.
    pub const STOP: Self = Self { left: 0, right: 0 };

    /// A command, clamped to full duty.
    pub fn new(left: i32, right: i32) -> Self {
        let clamp = |duty: i32| duty.clamp(-i32::from(Self::FULL), i32::from(Self::FULL)) as i16;
        Self {
            left: clamp(left),
            right: clamp(right),
        }
    }

    /// Duty of the left side, -1000 to 1000.
    pub const fn left(self) -> i16 {
        self.left
    }

    /// Duty of the right side, -1000 to 1000.
    pub const fn right(self) -> i16 {
        self.right
    }

    /// Whether any wheel is driven.
    pub const fn drives(self) -> bool {
        self.left != 0 || self.right != 0
    }
}
