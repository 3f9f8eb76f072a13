//! What is on the pins of bank 0: what the chip drives them to, and what it reads from them.

use super::gpio::Override;

pub use super::gpio::PINS;

/// What the chip drives a pin to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Nothing: it is an input, or was never set up.
    Floating,
    /// A level.
    Level(bool),
    /// Pulses.
    Pulses(Pulses),
}

/// A signal that is high for a share of each period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulses {
    /// Counts of a period that it is high; as many as a period has, or 0, if it does not change.
    pub high: u32,
    /// Counts of a period; not 0.
    pub period: u32,
}

impl Pulses {
    /// The share of the time that it is high, 0 to 1.
    pub fn duty(self) -> f64 {
        f64::from(self.high) / f64::from(self.period)
    }

    const fn inverted(self) -> Self {
        Self {
            high: self.period.saturating_sub(self.high),
            period: self.period,
        }
    }
}

impl Output {
    /// The share of the time that the pin is high, 0 to 1; 0 if it floats.
    pub fn duty(self) -> f64 {
        match self {
            Self::Floating | Self::Level(false) => 0.0,
            Self::Level(true) => 1.0,
            Self::Pulses(pulses) => pulses.duty(),
        }
    }

    pub(super) fn overridden(self, by: Override) -> Self {
        match (by, self) {
            (Override::None, output) => output,
            (Override::Low, _) => Self::Level(false),
            (Override::High, _) => Self::Level(true),
            (Override::Invert, Self::Level(level)) => Self::Level(!level),
            (Override::Invert, Self::Pulses(pulses)) => Self::Pulses(pulses.inverted()),
            (Override::Invert, Self::Floating) => Self::Floating,
        }
    }
}
