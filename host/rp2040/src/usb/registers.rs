//! Offsets and bits of the controller's registers (RP2040 datasheet 4.1.4), as far as a device is
//! concerned: what only the controller's host mode looks at is storage here.

/// Address that the device answers to.
pub(super) const ADDR_ENDP: u32 = 0x00;
/// First and last of the addresses of interrupt endpoints; host mode only.
pub(super) const ADDR_ENDP1: u32 = 0x04;
pub(super) const ADDR_ENDP15: u32 = 0x3c;
/// Main control.
pub(super) const MAIN_CTRL: u32 = 0x40;
/// Last frame number seen.
pub(super) const SOF_RD: u32 = 0x48;
/// Control of the serial interface engine.
pub(super) const SIE_CTRL: u32 = 0x4c;
/// Status of the serial interface engine.
pub(super) const SIE_STATUS: u32 = 0x50;
/// Interrupt endpoints to poll; host mode only.
pub(super) const INT_EP_CTRL: u32 = 0x54;
/// Buffers that are done.
pub(super) const BUFF_STATUS: u32 = 0x58;
/// Which of two buffers is done.
pub(super) const BUFF_CPU_SHOULD_HANDLE: u32 = 0x5c;
/// Endpoints whose buffers are being revoked.
pub(super) const EP_ABORT: u32 = 0x60;
/// Endpoints whose buffers may be touched.
pub(super) const EP_ABORT_DONE: u32 = 0x64;
/// Lets the STALL bits of endpoint 0 take effect.
pub(super) const EP_STALL_ARM: u32 = 0x68;
/// How often to poll; host mode only.
pub(super) const NAK_POLL: u32 = 0x6c;
/// Endpoints that have sent NAK or STALL and were to tell so.
pub(super) const EP_STATUS_STALL_NAK: u32 = 0x70;
/// Where the controller is connected to.
pub(super) const USB_MUXING: u32 = 0x74;
/// Power signals and what replaces them.
pub(super) const USB_PWR: u32 = 0x78;
/// The transceiver, by hand.
pub(super) const USBPHY_DIRECT: u32 = 0x7c;
pub(super) const USBPHY_DIRECT_OVERRIDE: u32 = 0x80;
pub(super) const USBPHY_TRIM: u32 = 0x84;
/// Interrupts: raw, enabled, forced, and what is left of them.
pub(super) const INTR: u32 = 0x8c;
pub(super) const INTE: u32 = 0x90;
pub(super) const INTF: u32 = 0x94;
pub(super) const INTS: u32 = 0x98;

/// The bits of a register that are storage; 0 for those that are not.
pub(super) const fn stored(offset: u32) -> u32 {
    match offset {
        ADDR_ENDP => 0x000f_007f,
        ADDR_ENDP1..=ADDR_ENDP15 => 0x060f_007f,
        MAIN_CTRL => 0x8000_0003,
        // Without the bits that clear themselves: transactions and resets of host mode, and RESUME.
        SIE_CTRL => 0xff07_8f4e,
        INT_EP_CTRL => 0xfffe,
        EP_ABORT => u32::MAX,
        EP_STALL_ARM => 0b11,
        NAK_POLL => 0x03ff_03ff,
        USB_MUXING => 0xf,
        USB_PWR => 0x3f,
        USBPHY_DIRECT => 0x0000_ff77,
        USBPHY_DIRECT_OVERRIDE => 0x0000_9fff,
        USBPHY_TRIM => 0x1f1f,
        INTE | INTF => 0x000f_ffff,
        _ => 0,
    }
}

/// What a register holds after a reset.
pub(super) const fn initial(offset: u32) -> u32 {
    match offset {
        NAK_POLL => 0x0010_0010,
        USBPHY_TRIM => 0x1f1f,
        _ => 0,
    }
}

/// MAIN_CTRL: enables the controller.
pub(super) const CONTROLLER_EN: u32 = 1 << 0;
/// MAIN_CTRL: host mode.
pub(super) const HOST_NDEVICE: u32 = 1 << 1;

/// SIE_CTRL: pull-up on D+, which tells the host that a full-speed device is there.
pub(super) const PULLUP_EN: u32 = 1 << 16;
/// SIE_CTRL: tell of every NAK on endpoint 0.
pub(super) const EP0_INT_NAK: u32 = 1 << 27;
/// SIE_CTRL: tell of every second buffer on endpoint 0.
pub(super) const EP0_INT_2BUF: u32 = 1 << 28;
/// SIE_CTRL: tell of every buffer on endpoint 0.
pub(super) const EP0_INT_1BUF: u32 = 1 << 29;
/// SIE_CTRL: two buffers on endpoint 0.
pub(super) const EP0_DOUBLE_BUF: u32 = 1 << 30;
/// SIE_CTRL: tell of every STALL on endpoint 0.
pub(super) const EP0_INT_STALL: u32 = 1 << 31;

/// SIE_STATUS.
pub(super) const VBUS_DETECTED: u32 = 1 << 0;
pub(super) const LINE_STATE_SHIFT: u32 = 2;
pub(super) const SUSPENDED: u32 = 1 << 4;
pub(super) const RESUME: u32 = 1 << 11;
pub(super) const CONNECTED: u32 = 1 << 16;
pub(super) const SETUP_REC: u32 = 1 << 17;
pub(super) const TRANS_COMPLETE: u32 = 1 << 18;
pub(super) const BUS_RESET: u32 = 1 << 19;
pub(super) const CRC_ERROR: u32 = 1 << 24;
pub(super) const BIT_STUFF_ERROR: u32 = 1 << 25;
pub(super) const RX_OVERFLOW: u32 = 1 << 26;
pub(super) const RX_TIMEOUT: u32 = 1 << 27;
pub(super) const STALL_REC: u32 = 1 << 29;
pub(super) const ACK_REC: u32 = 1 << 30;
pub(super) const DATA_SEQ_ERROR: u32 = 1 << 31;

/// USB_MUXING: connects the controller to the transceiver on the chip.
pub(super) const TO_PHY: u32 = 1 << 0;

/// USB_PWR: what takes the place of the VBUS signal, and whether it does.
pub(super) const VBUS_DETECT: u32 = 1 << 2;
pub(super) const VBUS_DETECT_OVERRIDE_EN: u32 = 1 << 3;

/// Interrupts that are no copy of a bit of SIE_STATUS.
pub(super) const INT_BUFF_STATUS: u32 = 1 << 4;
pub(super) const INT_DEV_CONN_DIS: u32 = 1 << 13;
pub(super) const INT_DEV_SOF: u32 = 1 << 17;
pub(super) const INT_ABORT_DONE: u32 = 1 << 18;
pub(super) const INT_EP_STALL_NAK: u32 = 1 << 19;

/// The interrupts that are copies of bits of SIE_STATUS, with these bits.
pub(super) const INT_OF_STATUS: [(u32, u32); 12] = [
    (1 << 3, TRANS_COMPLETE),
    (1 << 5, DATA_SEQ_ERROR),
    (1 << 6, RX_TIMEOUT),
    (1 << 7, RX_OVERFLOW),
    (1 << 8, BIT_STUFF_ERROR),
    (1 << 9, CRC_ERROR),
    (1 << 10, STALL_REC),
    (1 << 11, VBUS_DETECTED),
    (1 << 12, BUS_RESET),
    (1 << 14, SUSPENDED),
    (1 << 15, RESUME),
    (1 << 16, SETUP_REC),
];
