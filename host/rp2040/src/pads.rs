//! PADS_BANK0: pulls, input enable and output disable of the pins (RP2040 datasheet 2.19.6.3).

use super::gpio::PINS;
use super::peripheral::{Cycles, Peripheral, Write};

const VOLTAGE_SELECT: u32 = 0x00;
const GPIO0: u32 = 0x04;
const SWCLK: u32 = 0x7c;
const SWD: u32 = 0x80;

/// Bits of a pad.
mod pad {
    pub const OD: u32 = 1 << 7;
    pub const IE: u32 = 1 << 6;
    pub const PUE: u32 = 1 << 3;
    pub const ALL: u32 = 0xff;
    /// After a reset: input enabled, pulled down.
    pub const RESET: u32 = 0x56;
}

/// The registers.
#[derive(Clone, Debug)]
pub struct Pads {
    voltage: u32,
    pads: [u32; PINS],
    debug: [u32; 2],
}

impl Pads {
    /// After a reset.
    pub const fn new() -> Self {
        Self {
            voltage: 0,
            pads: [pad::RESET; PINS],
            debug: [0xda, 0x5a],
        }
    }

    /// Whether the pin may be driven (OD is not set).
    pub fn output_enabled(&self, pin: usize) -> bool {
        self.pads[pin] & pad::OD == 0
    }

    /// What the chip reads of a pin that is at this level outside, or left alone.
    pub fn input(&self, pin: usize, outside: Option<bool>) -> bool {
        let pad = self.pads[pin];
        // Both pulls together keep the level, which is not modelled: it counts as pulled up.
        pad & pad::IE != 0 && outside.unwrap_or(pad & pad::PUE != 0)
    }

    fn register(&mut self, offset: u32) -> Option<(&mut u32, u32)> {
        match offset {
            VOLTAGE_SELECT => Some((&mut self.voltage, 1)),
            SWCLK | SWD => Some((&mut self.debug[(offset - SWCLK) as usize / 4], pad::ALL)),
            _ => {
                let pin = offset.checked_sub(GPIO0)? as usize / 4;
                Some((self.pads.get_mut(pin)?, pad::ALL))
            }
        }
    }
}

impl Peripheral for Pads {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        self.register(offset).map_or(0, |(register, _)| *register)
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        if let Some((register, writable)) = self.register(offset) {
            *register = write.onto(*register) & writable;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_left_alone_follows_its_pull() {
        let mut pads = Pads::new();
        assert_eq!(pads.read(GPIO0 + 4 * 6, 0), pad::RESET);
        assert!(!pads.input(6, None));
        assert!(pads.input(6, Some(true)));
        pads.write(GPIO0 + 4 * 6, Write::plain(pad::IE | pad::PUE), 0);
        assert!(pads.input(6, None));
        pads.write(GPIO0 + 4 * 6, Write::plain(pad::PUE), 0);
        assert!(!pads.input(6, Some(true)), "no input buffer");
        assert_eq!(pads.read(SWCLK, 0), 0xda);
    }

    #[test]
    fn a_pads_output_can_be_disabled() {
        let mut pads = Pads::new();
        assert!(pads.output_enabled(0));
        pads.write(GPIO0, Write::plain(pad::OD), 0);
        assert!(!pads.output_enabled(0) && pads.output_enabled(1));
    }
}
