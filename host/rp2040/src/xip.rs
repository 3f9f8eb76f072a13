//! The flash cache's control registers (RP2040 datasheet 2.6.3.6).
//!
//! There is no cache: what is fetched from the flash comes at once, and the counters of hits and
//! accesses stand at zero. Streaming is missing.

use super::peripheral::{Cycles, Peripheral, Write};

const CTRL: u32 = 0x00;
const STAT: u32 = 0x08;
const STREAM_ADDR: u32 = 0x14;

/// CTRL after a reset: enabled, bad writes are errors.
const CTRL_AT_RESET: u32 = 3;
const CTRL_WRITABLE: u32 = 0xb;
/// STAT: flushed, FIFO empty.
const READY: u32 = 3;

/// The registers.
#[derive(Clone, Debug)]
pub struct XipControl {
    ctrl: u32,
    stream_address: u32,
}

impl XipControl {
    /// After a reset.
    pub const fn new() -> Self {
        Self {
            ctrl: CTRL_AT_RESET,
            stream_address: 0,
        }
    }
}

impl Peripheral for XipControl {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            CTRL => self.ctrl,
            STAT => READY,
            STREAM_ADDR => self.stream_address,
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        match offset {
            CTRL => self.ctrl = write.onto(self.ctrl) & CTRL_WRITABLE,
            STREAM_ADDR => self.stream_address = write.onto(self.stream_address) & !3,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_always_flushed() {
        let mut xip = XipControl::new();
        assert_eq!(xip.read(CTRL, 0), 3);
        xip.write(CTRL, Write::plain(!0), 0);
        assert_eq!(xip.read(CTRL, 0), 0xb);
        assert_eq!((xip.read(STAT, 0), xip.read(0x18, 0)), (3, 0));
    }
}
