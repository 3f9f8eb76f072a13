//! Single-cycle I/O (RP2040 datasheet 2.3.1): pins, spinlocks, divider, interpolators, mailbox.
//!
//! There is one core only: core 1 stays in its boot ROM, reads nothing from the mailbox and takes no
//! spinlock.

mod divider;
mod interpolator;

use divider::Divider;
use interpolator::{Interpolator, Kind};

use crate::peripheral::Cycles;

const CPUID: u32 = 0x000;
const GPIO_IN: u32 = 0x004;
const GPIO_HI_IN: u32 = 0x008;
const GPIO_OUT: u32 = 0x010;
const GPIO_OE_XOR: u32 = 0x02c;
const GPIO_HI_OUT: u32 = 0x030;
const GPIO_HI_OE_XOR: u32 = 0x04c;
const FIFO_ST: u32 = 0x050;
const FIFO_WR: u32 = 0x054;
const FIFO_RD: u32 = 0x058;
const SPINLOCK_ST: u32 = 0x05c;
const DIVIDER: u32 = 0x060;
const DIVIDER_CSR: u32 = 0x078;
const INTERP0: u32 = 0x080;
const INTERP0_LAST: u32 = 0x0bc;
const INTERP1: u32 = 0x0c0;
const INTERP1_LAST: u32 = 0x0fc;
const SPINLOCK0: u32 = 0x100;
const SPINLOCK31: u32 = 0x17c;

/// The pins of bank 0.
const PINS: u32 = 0x3fff_ffff;
/// The six pins of the flash.
const QSPI_PINS: u32 = 0x3f;
/// Words that the mailbox to core 1 takes.
const FIFO_DEPTH: u32 = 8;
/// FIFO_ST.
const FIFO_READY: u32 = 1 << 1;
const FIFO_WRITTEN_WHEN_FULL: u32 = 1 << 2;
const FIFO_READ_WHEN_EMPTY: u32 = 1 << 3;

/// Output levels and output enables of a bank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// The levels, a bit a pin.
    pub level: u32,
    /// Which pins are driven.
    pub enable: u32,
}

impl Outputs {
    /// Eight registers: value, set, clear, xor of levels and enables.
    fn write(&mut self, register: u32, value: u32, pins: u32) {
        let outputs = if register < 4 {
            &mut self.level
        } else {
            &mut self.enable
        };
        *outputs = pins
            & match register & 3 {
                0 => value,
                1 => *outputs | value,
                2 => *outputs & !value,
                _ => *outputs ^ value,
            };
    }

    fn read(&self, register: u32) -> u32 {
        match register {
            0 => self.level,
            4 => self.enable,
            _ => 0,
        }
    }
}

/// The registers. It has no atomic aliases.
#[derive(Clone, Debug)]
pub struct Sio {
    outputs: Outputs,
    qspi: Outputs,
    spinlocks: u32,
    sent: u32,
    fifo_errors: u32,
    divider: Divider,
    interpolators: [Interpolator; 2],
}

impl Sio {
    /// After a reset: no pin driven, all spinlocks free.
    pub fn new() -> Self {
        Self {
            outputs: Outputs::default(),
            qspi: Outputs::default(),
            spinlocks: 0,
            sent: 0,
            fifo_errors: 0,
            divider: Divider::default(),
            interpolators: [Kind::Blending, Kind::Clamping].map(Interpolator::new),
        }
    }

    /// What is driven to the pins of bank 0 that have SIO as their function.
    pub const fn outputs(&self) -> Outputs {
        self.outputs
    }

    /// The interrupt line of core 0 (2.3.1.4): errors of the mailbox.
    pub const fn line(&self) -> bool {
        self.fifo_errors != 0
    }

    /// Whether this register tells the levels of the pins, which the bus knows.
    pub const fn reads_pins(offset: u32) -> bool {
        offset == GPIO_IN
    }

    /// Whether writing this register can change what pins are driven to, or an interrupt line.
    #[inline(always)]
    pub const fn is_seen_outside(offset: u32) -> bool {
        offset >= GPIO_OUT && offset <= FIFO_RD
    }

    /// Reads the register at this offset; GPIO_IN is read from the pins.
    pub fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        match offset {
            SPINLOCK0..=SPINLOCK31 => {
                let lock = 1 << ((offset - SPINLOCK0) / 4);
                let claimed = if self.spinlocks & lock == 0 { lock } else { 0 };
                self.spinlocks |= lock;
                claimed
            }
            DIVIDER..=DIVIDER_CSR => self.divider.read(offset - DIVIDER, now),
            INTERP0..=INTERP0_LAST => self.interpolators[0].read(offset - INTERP0),
            INTERP1..=INTERP1_LAST => self.interpolators[1].read(offset - INTERP1),
            // Core 0; and pins that only the flash uses.
            CPUID | GPIO_HI_IN => 0,
            GPIO_OUT..=GPIO_OE_XOR => self.outputs.read((offset - GPIO_OUT) / 4),
            GPIO_HI_OUT..=GPIO_HI_OE_XOR => self.qspi.read((offset - GPIO_HI_OUT) / 4),
            FIFO_ST => {
                let ready = self.sent < FIFO_DEPTH;
                self.fifo_errors | if ready { FIFO_READY } else { 0 }
            }
            FIFO_RD => {
                self.fifo_errors |= FIFO_READ_WHEN_EMPTY;
                0
            }
            SPINLOCK_ST => self.spinlocks,
            _ => 0,
        }
    }

    /// Writes the register at this offset.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) {
        match offset {
            SPINLOCK0..=SPINLOCK31 => self.spinlocks &= !(1 << ((offset - SPINLOCK0) / 4)),
            DIVIDER..=DIVIDER_CSR => self.divider.write(offset - DIVIDER, value, now),
            INTERP0..=INTERP0_LAST => self.interpolators[0].write(offset - INTERP0, value),
            INTERP1..=INTERP1_LAST => self.interpolators[1].write(offset - INTERP1, value),
            GPIO_OUT..=GPIO_OE_XOR => self.outputs.write((offset - GPIO_OUT) / 4, value, PINS),
            GPIO_HI_OUT..=GPIO_HI_OE_XOR => {
                self.qspi
                    .write((offset - GPIO_HI_OUT) / 4, value, QSPI_PINS);
            }
            // Written 1 to clear.
            FIFO_ST => self.fifo_errors &= !value,
            FIFO_WR if self.sent < FIFO_DEPTH => self.sent += 1,
            FIFO_WR => self.fifo_errors |= FIFO_WRITTEN_WHEN_FULL,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_set_cleared_and_toggled() {
        let mut sio = Sio::new();
        for (offset, value, out) in [
            (0x10, 0xffff_ff0f, 0x3fff_ff0f),
            (0x18, 0x3fff_ff00, 0x0f),
            (0x14, 0x30, 0x3f),
            (0x1c, 0x3c, 0x03),
        ] {
            sio.write(offset, value, 0);
            assert_eq!(sio.read(GPIO_OUT, 0), out);
        }
        sio.write(0x24, 0x80, 0);
        assert_eq!(
            sio.outputs(),
            Outputs {
                level: 0x03,
                enable: 0x80
            }
        );
        assert_eq!(sio.read(0x20, 0), 0x80);
        assert_eq!(sio.read(0x14, 0), 0, "only written");
    }

    #[test]
    fn a_spinlock_is_claimed_by_reading_and_freed_by_writing() {
        let mut sio = Sio::new();
        assert_eq!(sio.read(SPINLOCK31, 0), 1 << 31);
        assert_eq!(sio.read(SPINLOCK31, 0), 0);
        assert_eq!(sio.read(SPINLOCK_ST, 0), 1 << 31);
        sio.write(SPINLOCK31, 1, 0);
        assert_eq!(sio.read(SPINLOCK31, 0), 1 << 31);
    }

    #[test]
    fn nobody_reads_the_mailbox() {
        let mut sio = Sio::new();
        for _ in 0..FIFO_DEPTH {
            assert_eq!(sio.read(FIFO_ST, 0), FIFO_READY);
            sio.write(FIFO_WR, 0, 0);
        }
        assert_eq!(sio.read(FIFO_ST, 0), 0);
        assert!(!sio.line());
        sio.write(FIFO_WR, 0, 0);
        assert_eq!(sio.read(FIFO_RD, 0), 0);
        assert!(sio.line());
        assert_eq!(sio.read(FIFO_ST, 0), 0b1100);
        sio.write(FIFO_ST, 0b1100, 0);
        assert!(!sio.line());
    }

    #[test]
    fn divider_and_interpolators_are_in_their_places() {
        let mut sio = Sio::new();
        sio.write(0x060, 17, 0);
        sio.write(0x064, 5, 0);
        assert_eq!((sio.read(0x074, 9), sio.read(0x070, 9)), (2, 3));
        for interpolator in [INTERP0, INTERP1] {
            sio.write(interpolator + 8, 42, 0);
            assert_eq!(sio.read(interpolator + 8, 0), 42);
        }
        assert_eq!(sio.read(CPUID, 0), 0);
    }
}
