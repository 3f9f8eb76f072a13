//! Registers of an I2C controller that stay as they are written (RP2040 datasheet 4.3.17).

use super::registers::FIFO_DEPTH;
use crate::peripheral::{Cycles, Write};

const CON: u32 = 0x00;
const TAR: u32 = 0x04;
const SAR: u32 = 0x08;
const SS_SCL_HCNT: u32 = 0x14;
const SS_SCL_LCNT: u32 = 0x18;
const FS_SCL_HCNT: u32 = 0x1c;
const FS_SCL_LCNT: u32 = 0x20;
pub const INTR_MASK: u32 = 0x30;
pub const RX_TL: u32 = 0x38;
pub const TX_TL: u32 = 0x3c;
const SDA_HOLD: u32 = 0x7c;
const SLV_DATA_NACK_ONLY: u32 = 0x84;
const DMA_CR: u32 = 0x88;
pub const DMA_TDLR: u32 = 0x8c;
pub const DMA_RDLR: u32 = 0x90;
const SDA_SETUP: u32 = 0x94;
const ACK_GENERAL_CALL: u32 = 0x98;
const FS_SPKLEN: u32 = 0xa0;

/// Bits of IC_CON.
pub mod con {
    pub const MASTER_MODE: u32 = 1 << 0;
    pub const SPEED_SHIFT: u32 = 1;
    pub const SPEED: u32 = 3 << SPEED_SHIFT;
    pub const STANDARD: u32 = 1;
    pub const FAST: u32 = 2;
    pub const TEN_BIT_MASTER: u32 = 1 << 4;
    pub const RESTART_EN: u32 = 1 << 5;
    pub const TX_EMPTY_CTRL: u32 = 1 << 8;
    pub const RX_FIFO_FULL_HLD_CTRL: u32 = 1 << 9;
}

/// Bits of IC_TAR.
mod tar {
    pub const ADDRESS: u32 = 0x3ff;
    pub const GC_OR_START: u32 = 1 << 10;
    pub const SPECIAL: u32 = 1 << 11;
}

/// Bits of IC_DMA_CR.
mod dma_cr {
    pub const RDMAE: u32 = 1 << 0;
    pub const TDMAE: u32 = 1 << 1;
}

/// The least that HCNT and LCNT may be: hardware raises what is less.
const LEAST_HIGH: u32 = 6;
const LEAST_LOW: u32 = 8;
/// The counts of a period that hardware adds to HCNT and SPKLEN, and to LCNT (4.3.14.1).
const HIGH_OVERHEAD: u32 = 7;
const LOW_OVERHEAD: u32 = 1;

/// What a register holds after a reset, the bits that it has, and whether it can be written while
/// the controller is enabled.
const fn shape(offset: u32) -> (u32, u32, bool) {
    match offset {
        CON => (0x65, 0x3ff, false),
        TAR => (0x55, 0xfff, false),
        SAR => (0x55, 0x3ff, false),
        SS_SCL_HCNT => (0x28, 0xffff, false),
        SS_SCL_LCNT => (0x2f, 0xffff, false),
        FS_SCL_HCNT => (0x06, 0xffff, false),
        FS_SCL_LCNT => (0x0d, 0xffff, false),
        INTR_MASK => (0x8ff, 0x1fff, true),
        RX_TL | TX_TL => (0, 0xff, true),
        SDA_HOLD => (1, 0xff_ffff, false),
        SLV_DATA_NACK_ONLY => (0, 1, false),
        DMA_CR => (0, 3, true),
        DMA_TDLR | DMA_RDLR => (0, 0xf, true),
        SDA_SETUP => (0x64, 0xff, false),
        ACK_GENERAL_CALL => (1, 1, true),
        FS_SPKLEN => (7, 0xff, false),
        _ => (0, 0, false),
    }
}

/// The registers.
#[derive(Clone, Debug)]
pub struct Settings {
    registers: [u32; FS_SPKLEN as usize / 4 + 1],
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            registers: std::array::from_fn(|i| shape(4 * i as u32).0),
        }
    }
}

impl Settings {
    /// Whether IC_CON has this bit.
    pub fn has(&self, bit: u32) -> bool {
        self.read(CON) & bit != 0
    }

    /// Reads a register; 0 if there is none.
    #[inline]
    pub fn read(&self, offset: u32) -> u32 {
        let register = self.registers.get(offset as usize / 4);
        register.copied().unwrap_or(0)
    }

    /// Writes a register, if it can be written in this state of the controller.
    pub fn write(&mut self, offset: u32, write: Write, enabled: bool) {
        let (_, mask, at_any_time) = shape(offset);
        if mask == 0 || enabled && !at_any_time {
            return;
        }
        let register = &mut self.registers[offset as usize / 4];
        let value = write.onto(*register) & mask;
        *register = match offset {
            CON if !matches!(speed(value), con::STANDARD | con::FAST) => {
                value & !con::SPEED | con::FAST << con::SPEED_SHIFT
            }
            RX_TL | TX_TL => value.min(FIFO_DEPTH as u32 - 1),
            SS_SCL_HCNT | FS_SCL_HCNT => value.max(LEAST_HIGH),
            SS_SCL_LCNT | FS_SCL_LCNT => value.max(LEAST_LOW),
            FS_SPKLEN => value.max(1),
            _ => value,
        };
    }

    /// How long SCL is high in a period.
    pub fn high(&self) -> Cycles {
        let count = match speed(self.read(CON)) {
            con::STANDARD => self.read(SS_SCL_HCNT),
            _ => self.read(FS_SCL_HCNT),
        };
        Cycles::from(count + self.read(FS_SPKLEN) + HIGH_OVERHEAD)
    }

    /// How long SCL is low in a period.
    pub fn low(&self) -> Cycles {
        let count = match speed(self.read(CON)) {
            con::STANDARD => self.read(SS_SCL_LCNT),
            _ => self.read(FS_SCL_LCNT),
        };
        Cycles::from(count + LOW_OVERHEAD)
    }

    /// The target address.
    pub fn address(&self) -> u16 {
        let ten_bits = self.has(con::TEN_BIT_MASTER);
        let mask = if ten_bits { tar::ADDRESS } else { 0x7f };
        if self.calls_all() {
            0
        } else {
            (self.read(TAR) & mask) as u16
        }
    }

    /// Whether the target is the general call address.
    pub fn calls_all(&self) -> bool {
        self.read(TAR) & tar::SPECIAL != 0 && self.read(TAR) & tar::GC_OR_START == 0
    }

    /// Whether the transmit FIFO is to ask for transfers.
    pub fn dma_transmits(&self) -> bool {
        self.read(DMA_CR) & dma_cr::TDMAE != 0
    }

    /// Whether the receive FIFO is to ask for transfers.
    pub fn dma_receives(&self) -> bool {
        self.read(DMA_CR) & dma_cr::RDMAE != 0
    }
}

const fn speed(con: u32) -> u32 {
    (con & con::SPEED) >> con::SPEED_SHIFT
}
