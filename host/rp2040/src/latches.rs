//! Registers that hold what is written to them, and do nothing else here.
//!
//! That is all there is to see of pads that are not looked at, priorities on a bus with one user,
//! and power switches of memories.

use super::peripheral::{Cycles, Peripheral, Write};

/// A register.
#[derive(Clone, Copy, Debug)]
pub struct Latch {
    /// Where it is.
    pub offset: u32,
    /// What it holds after a reset.
    pub reset: u32,
    /// Which bits can be written.
    pub writable: u32,
}

/// SYSCFG (RP2040 datasheet 2.21): interrupt masks of the NMI and synchronisers of inputs, which
/// have no effect here.
pub const SYSCFG: &[Latch] = &[
    latch(0x00, 0, !0),
    latch(0x04, 0, !0),
    latch(0x08, 0x1000_0000, 0xff00_0000),
    latch(0x0c, 0, 0x3fff_ffff),
    latch(0x10, 0, 0x3f),
    latch(0x14, 0x66, 0xee),
    latch(0x18, 0, 0xff),
];

/// IO_QSPI (2.19.6.2): the pins of the flash, which nothing but the flash uses.
pub const IO_QSPI: &[Latch] = &[
    latch(0x04, 0x1f, 0x3003_331f),
    latch(0x0c, 0x1f, 0x3003_331f),
    latch(0x14, 0x1f, 0x3003_331f),
    latch(0x1c, 0x1f, 0x3003_331f),
    latch(0x24, 0x1f, 0x3003_331f),
    latch(0x2c, 0x1f, 0x3003_331f),
];

/// PADS_QSPI (2.19.6.4): their electrical properties.
pub const PADS_QSPI: &[Latch] = &[
    latch(0x00, 0, 1),
    latch(0x04, 0x56, 0xff),
    latch(0x08, 0x52, 0xff),
    latch(0x0c, 0x52, 0xff),
    latch(0x10, 0x52, 0xff),
    latch(0x14, 0x52, 0xff),
    latch(0x18, 0x5a, 0xff),
];

/// BUSCTRL (2.1.5): priorities on the bus, which has one user at a time, and counters, which stand.
pub const BUSCTRL: &[Latch] = &[
    latch(0x00, 0, 0x1111),
    latch(0x04, 1, 0),
    latch(0x0c, 0x1f, 0x1f),
    latch(0x14, 0x1f, 0x1f),
    latch(0x1c, 0x1f, 0x1f),
    latch(0x24, 0x1f, 0x1f),
];

/// TBMAN (2.22): silicon, not a simulation.
pub const TBMAN: &[Latch] = &[latch(0x00, 1, 0)];

const fn latch(offset: u32, reset: u32, writable: u32) -> Latch {
    Latch {
        offset,
        reset,
        writable,
    }
}

/// A block of such registers.
#[derive(Clone, Debug)]
pub struct Latches {
    latches: &'static [Latch],
    values: Vec<u32>,
}

impl Latches {
    /// The registers after a reset.
    pub fn new(latches: &'static [Latch]) -> Self {
        let values = latches.iter().map(|latch| latch.reset).collect();
        Self { latches, values }
    }

    /// Back to the reset values.
    pub fn reset(&mut self) {
        *self = Self::new(self.latches);
    }

    fn find(&self, offset: u32) -> Option<usize> {
        self.latches.iter().position(|latch| latch.offset == offset)
    }
}

impl Peripheral for Latches {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        self.find(offset).map_or(0, |at| self.values[at])
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        if let Some(at) = self.find(offset) {
            let (old, writable) = (self.values[at], self.latches[at].writable);
            self.values[at] = old & !writable | write.onto(old) & writable;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_writable_bits_change_until_a_reset() {
        let mut pads = Latches::new(PADS_QSPI);
        assert_eq!(pads.read(0x04, 0), 0x56);
        pads.write(0x04, Write::plain(0xffff_ff01), 0);
        assert_eq!(pads.read(0x04, 0), 0x01);
        pads.write(0x40, Write::plain(7), 0);
        assert_eq!(pads.read(0x40, 0), 0);
        pads.reset();
        assert_eq!(pads.read(0x04, 0), 0x56);
    }

    #[test]
    fn the_chip_knows_that_it_is_silicon() {
        let mut tbman = Latches::new(TBMAN);
        tbman.write(0, Write::plain(2), 0);
        assert_eq!(tbman.read(0, 0), 1);
    }
}
