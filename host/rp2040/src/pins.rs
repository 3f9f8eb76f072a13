//! What is on the pins of bank 0: what the chip drives them to, and what it reads from them.

use super::gpio::{Function, Override, PINS};
use super::i2c::Lines;
use super::peripheral::Cycles;
use super::peripherals::Peripherals;

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
    /// The share of the time that the pin is high: 0 if it floats, for the board's resistors pull it
    /// down.
    pub fn duty(self) -> f64 {
        match self {
            Self::Floating | Self::Level(false) => 0.0,
            Self::Level(true) => 1.0,
            Self::Pulses(pulses) => pulses.duty(),
        }
    }

    fn overridden(self, by: Override) -> Self {
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

impl Peripherals {
    /// What the pin is driven to.
    ///
    /// # Panics
    /// There are pins 0 to 29 only.
    pub fn output(&self, pin: usize) -> Output {
        let sio = self.sio.outputs();
        let (signal, enabled) = match self.io_bank0.function(pin) {
            Function::Sio => {
                let level = sio.level >> pin & 1 != 0;
                (Output::Level(level), sio.enable >> pin & 1 != 0)
            }
            Function::Pwm => (self.pwm_output(pin), true),
            // I2C is a bus of its own, and not seen pin by pin.
            Function::I2c | Function::Other => (Output::Level(false), false),
        };
        let enabled = self.io_bank0.enable_override(pin).apply(enabled);
        if !enabled || !self.pads.output_enabled(pin) {
            return Output::Floating;
        }
        signal.overridden(self.io_bank0.output_override(pin))
    }

    /// Tells the pins' interrupts, after something changed what is on them.
    ///
    /// Pulses are taken to be low: nobody reads back the pins of the motors, and interrupts 20,000
    /// times a second would cost time.
    pub(super) fn pins_changed(&mut self, now: Cycles) {
        let mut outside = self.outside;
        for number in 0..self.i2c_pins.len() {
            let Some([data, clock]) = self.i2c_pins[number] else {
                continue;
            };
            let released = |output| output != Output::Level(false);
            let driven = Lines {
                clock: released(self.output(clock)),
                data: released(self.output(data)),
            };
            let i2c = if number == 0 {
                &mut self.i2c0
            } else {
                &mut self.i2c1
            };
            i2c.pins(driven, now);
            outside[data] = Some(i2c.lines().data);
            outside[clock] = Some(i2c.lines().clock);
        }
        let mut levels = 0;
        for pin in 0..PINS {
            let outside = match self.output(pin) {
                Output::Floating => outside[pin],
                Output::Level(level) => Some(level),
                Output::Pulses(_) => Some(false),
            };
            levels |= u32::from(self.pads.input(pin, outside)) << pin;
        }
        self.io_bank0.set_levels(levels);
    }
}
