//! Offsets and bits of the registers (RP2040 datasheet 4.3.17).

/// The interrupt lines of both controllers, I2C0_IRQ and I2C1_IRQ.
pub const IRQS: [u32; 2] = [23, 24];
/// Entries of each FIFO.
pub const FIFO_DEPTH: usize = 16;

pub const DATA_CMD: u32 = 0x10;
pub const INTR_STAT: u32 = 0x2c;
pub const RAW_INTR_STAT: u32 = 0x34;
pub const CLR_INTR: u32 = 0x40;
pub const CLR_RX_UNDER: u32 = 0x44;
pub const CLR_RX_OVER: u32 = 0x48;
pub const CLR_TX_OVER: u32 = 0x4c;
pub const CLR_TX_ABRT: u32 = 0x54;
pub const CLR_ACTIVITY: u32 = 0x5c;
pub const CLR_STOP_DET: u32 = 0x60;
pub const CLR_START_DET: u32 = 0x64;
pub const ENABLE: u32 = 0x6c;
pub const STATUS: u32 = 0x70;
pub const TXFLR: u32 = 0x74;
pub const RXFLR: u32 = 0x78;
pub const TX_ABRT_SOURCE: u32 = 0x80;
pub const ENABLE_STATUS: u32 = 0x9c;
pub const COMP_VERSION: u32 = 0xf8;
pub const COMP_TYPE: u32 = 0xfc;

/// Bits of the interrupt registers. RD_REQ (5), RX_DONE (7), GEN_CALL (11) and RESTART_DET (12) are
/// a slave's and never set.
pub mod interrupt {
    pub const RX_UNDER: u32 = 1 << 0;
    pub const RX_OVER: u32 = 1 << 1;
    pub const RX_FULL: u32 = 1 << 2;
    pub const TX_OVER: u32 = 1 << 3;
    pub const TX_EMPTY: u32 = 1 << 4;
    pub const TX_ABRT: u32 = 1 << 6;
    pub const ACTIVITY: u32 = 1 << 8;
    pub const STOP_DET: u32 = 1 << 9;
    pub const START_DET: u32 = 1 << 10;
}

/// Bits of IC_ENABLE.
pub mod enable {
    pub const ENABLE: u32 = 1 << 0;
    pub const ABORT: u32 = 1 << 1;
    pub const TX_CMD_BLOCK: u32 = 1 << 2;
}

/// Bits of IC_STATUS.
pub mod status {
    pub const ACTIVITY: u32 = 1 << 0;
    pub const TFNF: u32 = 1 << 1;
    pub const TFE: u32 = 1 << 2;
    pub const RFNE: u32 = 1 << 3;
    pub const RFF: u32 = 1 << 4;
    pub const MST_ACTIVITY: u32 = 1 << 5;
}

/// Bits of IC_TX_ABRT_SOURCE that a master sets.
pub mod abort {
    pub const ADDR_NOACK_7B: u32 = 1 << 0;
    pub const ADDR1_NOACK_10B: u32 = 1 << 1;
    pub const TXDATA_NOACK: u32 = 1 << 3;
    pub const GCALL_NOACK: u32 = 1 << 4;
    pub const GCALL_READ: u32 = 1 << 5;
    pub const RD_NORSTRT_10B: u32 = 1 << 10;
    pub const MASTER_DIS: u32 = 1 << 11;
    pub const LOST: u32 = 1 << 12;
    pub const USER_ABRT: u32 = 1 << 16;
    /// TX_FLUSH_CNT, entries of the transmit FIFO that were lost.
    pub const FLUSHED_SHIFT: u32 = 23;
}
