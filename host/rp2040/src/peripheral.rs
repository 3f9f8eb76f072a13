//! What a peripheral is to the bus: registers, and moments at which something happens by itself.
//!
//! All peripherals live in the time of the system clock. The bus hands it over with each access, so
//! that a peripheral need not be advanced while it is not accessed; what must happen at a certain
//! time (an alarm, the end of a conversion) it names by [`Peripheral::next_event`], and the machine
//! calls [`Peripheral::advance`] when that time has come. Interrupt lines, requests to the DMA
//! controller and pins are each peripheral's own functions, since no two have the same.

/// Cycles of the system clock since power-up.
pub type Cycles = u64;

/// The system clock at 125 MHz, as the SDKs set it up. The machine runs at it from power-up on,
/// whatever the program sets.
pub const CYCLES_PER_MICROSECOND: Cycles = 125;

/// Which of its four aliases a register was written through (RP2040 datasheet 2.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alias {
    /// Normal access, at +0x0000.
    Plain,
    /// Atomic XOR, at +0x1000.
    Xor,
    /// Atomic bitmask set, at +0x2000.
    Set,
    /// Atomic bitmask clear, at +0x3000.
    Clear,
}

impl Alias {
    /// The alias that an address within a peripheral of the APB or AHB-Lite selects.
    pub const fn of(address: u32) -> Self {
        match (address >> 12) & 3 {
            0 => Self::Plain,
            1 => Self::Xor,
            2 => Self::Set,
            _ => Self::Clear,
        }
    }
}

/// A word written to a register. Writes of bytes and halfwords arrive here as words, repeated over
/// the width of the bus (datasheet 2.1.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Write {
    /// What was written.
    pub value: u32,
    /// Through which alias.
    pub alias: Alias,
}

impl Write {
    /// A normal write.
    pub const fn plain(value: u32) -> Self {
        Self {
            value,
            alias: Alias::Plain,
        }
    }

    /// What a register that held `old` holds afterwards.
    pub const fn onto(self, old: u32) -> u32 {
        match self.alias {
            Alias::Plain => self.value,
            Alias::Xor => old ^ self.value,
            Alias::Set => old | self.value,
            Alias::Clear => old & !self.value,
        }
    }
}

/// These bits if something is so, and none otherwise.
pub const fn flag(set: bool, bits: u32) -> u32 {
    if set { bits } else { 0 }
}

/// A block of registers on the bus.
pub trait Peripheral {
    /// Reads the register at this offset, with whatever reading does to it. Offsets are multiples
    /// of 4 below 0x1000; those without a register read 0.
    fn read(&mut self, offset: u32, now: Cycles) -> u32;

    /// Writes the register at this offset; those without one ignore it.
    fn write(&mut self, offset: u32, write: Write, now: Cycles);

    /// When something will happen by itself; `None` if nothing will.
    fn next_event(&self) -> Option<Cycles> {
        None
    }

    /// Does what is due by now.
    fn advance(&mut self, _now: Cycles) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_aliases_change_bits_as_the_data_sheet_says() {
        let write = |address| {
            Write {
                value: 0b0110,
                alias: Alias::of(address),
            }
            .onto(0b1100)
        };
        assert_eq!(write(0x4005_4000), 0b0110);
        assert_eq!(write(0x4005_5000), 0b1010);
        assert_eq!(write(0x4005_6000), 0b1110);
        assert_eq!(write(0x4005_7000), 0b1000);
    }
}
