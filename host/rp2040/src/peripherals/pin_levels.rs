//! The levels on the pins of bank 0: what the chip drives, and what it reads.

use super::blocks::Peripherals;
use crate::gpio::Function;
use crate::i2c::Lines;
use crate::peripheral::Cycles;
use crate::pins::Output;

impl Peripherals {
    /// What the pin is driven to.
    pub fn output(&self, pin: usize) -> Output {
        let sio = self.sio.outputs();
        let (signal, enabled) = match self.io_bank0.function(pin) {
            Function::Sio => {
                let level = sio.level >> pin & 1 != 0;
                (Output::Level(level), sio.enable >> pin & 1 != 0)
            }
            Function::Pwm => (Output::Pulses(self.pwm.output(pin)), true),
            // I2C is a bus of its own, and not seen pin by pin.
            Function::I2c | Function::Other => (Output::Level(false), false),
        };
        let enabled = self.io_bank0.enable_override(pin).apply(enabled);
        if !enabled || !self.pads.output_enabled(pin) {
            return Output::Floating;
        }
        signal.overridden(self.io_bank0.output_override(pin))
    }

    /// Brings the pins' levels, interrupts and I2C buses up to date, after something changed what is
    /// on them.
    ///
    /// Pulses are read as low: an event for each of their edges would cost time, and hardly any
    /// program reads back its own PWM.
    pub(crate) fn pins_changed(&mut self, now: Cycles) {
        let mut outside = self.outside;
        for number in 0..self.i2c.len() {
            let Some(wires) = self.i2c_pins[number] else {
                continue;
            };
            let is_i2c = |pin| self.io_bank0.function(pin) == Function::I2c;
            let connected = wires.into_iter().all(is_i2c);
            let [data, clock] = wires.map(|pin| self.output(pin) != Output::Level(false));
            let i2c = &mut self.i2c[number];
            i2c.set_connected(connected);
            i2c.pins(Lines { clock, data }, now);
            let lines = i2c.lines();
            for (pin, level) in wires.into_iter().zip([lines.data, lines.clock]) {
                outside[pin] = Some(level);
            }
        }
        let mut levels = 0;
        for (pin, outside) in outside.into_iter().enumerate() {
            let level = match self.output(pin) {
                Output::Floating => outside,
                Output::Level(level) => Some(level),
                Output::Pulses(_) => Some(false),
            };
            levels |= u32::from(self.pads.input(pin, level)) << pin;
        }
        self.io_bank0.set_levels(levels);
    }
}
