//! Offsets of the registers (RP2040 datasheet 2.5.7), and the numbers of requests.

/// Channels.
pub const CHANNELS: usize = 12;
/// Its interrupt lines, DMA_IRQ_0 and DMA_IRQ_1.
pub const IRQS: [u32; 2] = [11, 12];

/// What paces a channel: the numbers of TREQ_SEL (2.5.3.1), which are also the places of their bits
/// in sets of requests.
pub mod treq {
    /// The first PWM slice's counter wrapped; the other slices follow.
    pub const PWM_WRAP0: u32 = 24;
    /// The transmit FIFO of I2C0.
    pub const I2C0_TX: u32 = 32;
    /// The receive FIFO of I2C0.
    pub const I2C0_RX: u32 = 33;
    /// The transmit FIFO of I2C1.
    pub const I2C1_TX: u32 = 34;
    /// The receive FIFO of I2C1.
    pub const I2C1_RX: u32 = 35;
    /// The FIFO of the analogue-to-digital converter.
    pub const ADC: u32 = 36;
    /// The first pacing timer; the others follow.
    pub const TIMER0: u32 = 59;
    /// Always.
    pub const PERMANENT: u32 = 63;
}

pub const CHANNEL_STRIDE: u32 = 0x40;
pub const CHANNELS_END: u32 = CHANNELS as u32 * CHANNEL_STRIDE;
pub const INTR: u32 = 0x400;
pub const INTE0: u32 = 0x404;
pub const INTF0: u32 = 0x408;
pub const INTS0: u32 = 0x40c;
pub const INTE1: u32 = 0x414;
pub const INTF1: u32 = 0x418;
pub const INTS1: u32 = 0x41c;
pub const TIMER0: u32 = 0x420;
pub const TIMER3: u32 = 0x42c;
pub const MULTI_CHAN_TRIGGER: u32 = 0x430;
pub const SNIFF_CTRL: u32 = 0x434;
pub const SNIFF_DATA: u32 = 0x438;
pub const CHAN_ABORT: u32 = 0x444;
pub const N_CHANNELS: u32 = 0x448;
pub const DEBUG: u32 = 0x800;
pub const DEBUG_END: u32 = DEBUG + CHANNELS_END;
