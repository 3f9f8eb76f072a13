//! SYSINFO: which chip this is (RP2040 datasheet 2.20).

use super::peripheral::{Cycles, Peripheral, Write};

/// CHIP_ID of revision B2: REVISION 2, PART 2, MANUFACTURER 0x927.
const CHIP_ID: u32 = 2 << 28 | 2 << 12 | 0x927;
/// PLATFORM: an ASIC, no FPGA.
const PLATFORM: u32 = 1 << 1;

/// The registers, none of which can be written.
#[derive(Clone, Copy, Debug)]
pub struct SysInfo;

impl Peripheral for SysInfo {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            0x00 => CHIP_ID,
            0x04 => PLATFORM,
            _ => 0,
        }
    }

    fn write(&mut self, _offset: u32, _write: Write, _now: Cycles) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_an_rp2040_b2() {
        SysInfo.write(0, Write::plain(0), 0);
        assert_eq!(SysInfo.read(0, 0), 0x2000_2927);
        assert_eq!(SysInfo.read(4, 0), 2);
    }
}
