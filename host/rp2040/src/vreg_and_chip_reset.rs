//! Voltage regulator, brown-out detector and the chip-level reset's reason (RP2040 datasheet 2.10
//! to 2.12).

use super::peripheral::{Cycles, Peripheral, Write};

const VREG: u32 = 0x00;
const BOD: u32 = 0x04;
const CHIP_RESET: u32 = 0x08;

/// VREG: regulated, read only.
const ROK: u32 = 1 << 12;
/// VREG: VSEL, HIZ and EN.
const VREG_WRITABLE: u32 = 0xf3;
/// VREG after a reset: 1.10 V, enabled.
const VREG_AT_RESET: u32 = 0xb1;
const BOD_WRITABLE: u32 = 0xf1;
/// BOD after a reset: 0.860 V, enabled.
const BOD_AT_RESET: u32 = 0x91;
/// CHIP_RESET: for a debugger that recovers a chip; written 1 to clear.
const PSM_RESTART_FLAG: u32 = 1 << 24;

/// What reset the whole chip (2.12).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChipReset {
    /// The supply came, or fell too low (power-on reset, brown-out detection).
    Power,
    /// The RUN pin.
    RunPin,
}

/// The registers.
#[derive(Clone, Debug)]
pub struct VregAndChipReset {
    vreg: u32,
    bod: u32,
    reason: u32,
}

impl VregAndChipReset {
    /// After a reset of the whole chip. Other resets leave this block alone.
    pub const fn new(reset: ChipReset) -> Self {
        Self {
            vreg: VREG_AT_RESET,
            bod: BOD_AT_RESET,
            reason: match reset {
                ChipReset::Power => 1 << 8,
                ChipReset::RunPin => 1 << 16,
            },
        }
    }
}

impl Peripheral for VregAndChipReset {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            VREG => self.vreg | ROK,
            BOD => self.bod,
            CHIP_RESET => self.reason,
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        match offset {
            VREG => self.vreg = write.onto(self.vreg) & VREG_WRITABLE,
            BOD => self.bod = write.onto(self.bod) & BOD_WRITABLE,
            CHIP_RESET => self.reason &= !(write.onto(0) & PSM_RESTART_FLAG),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reason_is_told() {
        let mut power = VregAndChipReset::new(ChipReset::Power);
        assert_eq!(power.read(CHIP_RESET, 0), 1 << 8);
        power.write(CHIP_RESET, Write::plain(!0), 0);
        assert_eq!(power.read(CHIP_RESET, 0), 1 << 8, "read only");
        let mut run = VregAndChipReset::new(ChipReset::RunPin);
        assert_eq!(run.read(CHIP_RESET, 0), 1 << 16);
    }

    #[test]
    fn the_regulator_regulates() {
        let mut vreg = VregAndChipReset::new(ChipReset::Power);
        assert_eq!(vreg.read(VREG, 0), 0x10b1);
        vreg.write(VREG, Write::plain(0xf1), 0);
        assert_eq!(vreg.read(VREG, 0), 0x10f1);
        assert_eq!(vreg.read(BOD, 0), 0x91);
    }
}
