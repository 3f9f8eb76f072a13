//! The levels on the pins of bank 0: what the chip drives, and what it reads.

use super::blocks::Peripherals;
use crate::gpio::{Function, PINS};
use crate::i2c::Lines;
use crate::peripheral::Cycles;
use crate::pins::Output;

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
    pub(crate) fn pins_changed(&mut self, now: Cycles) {
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
