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
const INTR_MASK: u32 = 0x30;
const RX_TL: u32 = 0x38;
const TX_TL: u32 = 0x3c;
const SDA_HOLD: u32 = 0x7c;
const SLV_DATA_NACK_ONLY: u32 = 0x84;
const DMA_CR: u32 = 0x88;
const DMA_TDLR: u32 = 0x8c;
const DMA_RDLR: u32 = 0x90;
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

/// The registers.
#[derive(Clone, Debug)]
pub struct Settings {
    con: u32,
    tar: u32,
    sar: u32,
    ss_scl_hcnt: u32,
    ss_scl_lcnt: u32,
    fs_scl_hcnt: u32,
    fs_scl_lcnt: u32,
    /// IC_INTR_MASK.
    pub intr_mask: u32,
    /// IC_RX_TL.
    pub rx_tl: u32,
    /// IC_TX_TL.
    pub tx_tl: u32,
    sda_hold: u32,
    slv_data_nack_only: u32,
    dma_cr: u32,
    /// IC_DMA_TDLR.
    pub dma_tdlr: u32,
    /// IC_DMA_RDLR.
    pub dma_rdlr: u32,
    sda_setup: u32,
    ack_general_call: u32,
    fs_spklen: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            con: 0x65,
            tar: 0x55,
            sar: 0x55,
            ss_scl_hcnt: 0x28,
            ss_scl_lcnt: 0x2f,
            fs_scl_hcnt: 0x06,
            fs_scl_lcnt: 0x0d,
            intr_mask: 0x8ff,
            rx_tl: 0,
            tx_tl: 0,
            sda_hold: 1,
            slv_data_nack_only: 0,
            dma_cr: 0,
            dma_tdlr: 0,
            dma_rdlr: 0,
            sda_setup: 0x64,
            ack_general_call: 1,
            fs_spklen: 7,
        }
    }
}

impl Settings {
    /// Whether IC_CON has this bit.
    pub fn has(&self, bit: u32) -> bool {
        self.con & bit != 0
    }

    /// A register, the bits that it has, and whether it can be written while the controller is
    /// enabled.
    fn register(&mut self, offset: u32) -> Option<(&mut u32, u32, bool)> {
        Some(match offset {
            CON => (&mut self.con, 0x3ff, false),
            TAR => (&mut self.tar, 0xfff, false),
            SAR => (&mut self.sar, 0x3ff, false),
            SS_SCL_HCNT => (&mut self.ss_scl_hcnt, 0xffff, false),
            SS_SCL_LCNT => (&mut self.ss_scl_lcnt, 0xffff, false),
            FS_SCL_HCNT => (&mut self.fs_scl_hcnt, 0xffff, false),
            FS_SCL_LCNT => (&mut self.fs_scl_lcnt, 0xffff, false),
            INTR_MASK => (&mut self.intr_mask, 0x1fff, true),
            RX_TL => (&mut self.rx_tl, 0xff, true),
            TX_TL => (&mut self.tx_tl, 0xff, true),
            SDA_HOLD => (&mut self.sda_hold, 0xff_ffff, false),
            SLV_DATA_NACK_ONLY => (&mut self.slv_data_nack_only, 1, false),
            DMA_CR => (&mut self.dma_cr, 3, true),
            DMA_TDLR => (&mut self.dma_tdlr, 0xf, true),
            DMA_RDLR => (&mut self.dma_rdlr, 0xf, true),
            SDA_SETUP => (&mut self.sda_setup, 0xff, false),
            ACK_GENERAL_CALL => (&mut self.ack_general_call, 1, true),
            FS_SPKLEN => (&mut self.fs_spklen, 0xff, false),
            _ => return None,
        })
    }

    /// Reads a register; 0 if there is none.
    pub fn read(&mut self, offset: u32) -> u32 {
        self.register(offset).map_or(0, |(register, ..)| *register)
    }

    /// Writes a register, if it can be written in this state of the controller.
    pub fn write(&mut self, offset: u32, write: Write, enabled: bool) {
        match self.register(offset) {
            Some((register, mask, at_any_time)) if at_any_time || !enabled => {
                *register = write.onto(*register) & mask;
            }
            _ => return,
        }
        match offset {
            CON if !matches!(self.speed(), con::STANDARD | con::FAST) => {
                self.con = self.con & !con::SPEED | con::FAST << con::SPEED_SHIFT;
            }
            RX_TL => self.rx_tl = self.rx_tl.min(FIFO_DEPTH as u32 - 1),
            TX_TL => self.tx_tl = self.tx_tl.min(FIFO_DEPTH as u32 - 1),
            SS_SCL_HCNT => self.ss_scl_hcnt = self.ss_scl_hcnt.max(LEAST_HIGH),
            FS_SCL_HCNT => self.fs_scl_hcnt = self.fs_scl_hcnt.max(LEAST_HIGH),
            SS_SCL_LCNT => self.ss_scl_lcnt = self.ss_scl_lcnt.max(LEAST_LOW),
            FS_SCL_LCNT => self.fs_scl_lcnt = self.fs_scl_lcnt.max(LEAST_LOW),
            FS_SPKLEN => self.fs_spklen = self.fs_spklen.max(1),
            _ => {}
        }
    }

    fn speed(&self) -> u32 {
        (self.con & con::SPEED) >> con::SPEED_SHIFT
    }

    /// How long SCL is high in a period.
    pub fn high(&self) -> Cycles {
        let count = match self.speed() {
            con::STANDARD => self.ss_scl_hcnt,
            _ => self.fs_scl_hcnt,
        };
        Cycles::from(count + self.fs_spklen + HIGH_OVERHEAD)
    }

    /// How long SCL is low in a period.
    pub fn low(&self) -> Cycles {
        let count = match self.speed() {
            con::STANDARD => self.ss_scl_lcnt,
            _ => self.fs_scl_lcnt,
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
            (self.tar & mask) as u16
        }
    }

    /// Whether the target is the general call address.
    pub fn calls_all(&self) -> bool {
        self.tar & tar::SPECIAL != 0 && self.tar & tar::GC_OR_START == 0
    }

    /// Whether the transmit FIFO is to ask for transfers.
    pub fn dma_transmits(&self) -> bool {
        self.dma_cr & dma_cr::TDMAE != 0
    }

    /// Whether the receive FIFO is to ask for transfers.
    pub fn dma_receives(&self) -> bool {
        self.dma_cr & dma_cr::RDMAE != 0
    }
}
