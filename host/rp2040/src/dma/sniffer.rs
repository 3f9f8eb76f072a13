//! The sniffer, which calculates checksums of what one channel moves (RP2040 datasheet 2.5.5.2).
//!
//! Of transfers wider than a byte the lowest byte counts first. That is how CRCs of bytes in memory
//! come out the same whatever the width; the datasheet does not say so.

use super::transfer::{Size, Transfer};

const EN: u32 = 1 << 0;
const DMACH_SHIFT: u32 = 1;
const CALC_SHIFT: u32 = 5;
const BSWAP: u32 = 1 << 9;
const OUT_REV: u32 = 1 << 10;
const OUT_INV: u32 = 1 << 11;
const STORED: u32 = 0xfff;

/// Values of CALC.
mod calc {
    pub const CRC32: u32 = 0x0;
    pub const CRC32_REVERSED: u32 = 0x1;
    pub const CRC16: u32 = 0x2;
    pub const CRC16_REVERSED: u32 = 0x3;
    pub const EVEN: u32 = 0xe;
    pub const SUM: u32 = 0xf;
}

/// The polynomial of IEEE 802.3.
const CRC32_POLYNOMIAL: u32 = 0x04c1_1db7;
/// The polynomial of CRC-16-CCITT, at the top of a word.
const CRC16_POLYNOMIAL: u32 = 0x1021 << 16;

/// SNIFF_CTRL and SNIFF_DATA.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sniffer {
    control: u32,
    data: u32,
}

impl Sniffer {
    pub fn control(&self) -> u32 {
        self.control
    }

    pub fn set_control(&mut self, control: u32) {
        self.control = control & STORED;
    }

    pub fn seed(&mut self, data: u32) {
        self.data = data;
    }

    /// SNIFF_DATA as it is read.
    pub fn result(&self) -> u32 {
        let reversed = self.control & OUT_REV != 0;
        let data = if reversed {
            self.data.reverse_bits()
        } else {
            self.data
        };
        if self.control & OUT_INV != 0 {
            !data
        } else {
            data
        }
    }

    /// A transfer was made, of a channel that may (SNIFF_EN) be sniffed.
    pub fn observe(&mut self, transfer: &Transfer, may_be: bool, read: u32) {
        let observed = self.control >> DMACH_SHIFT & 0xf;
        if !may_be || self.control & EN == 0 || observed as usize != transfer.channel {
            return;
        }
        let mut data = transfer.swapped(read);
        if self.control & BSWAP != 0 {
            data = transfer.size.reversed(data);
        }
        self.data = match self.control >> CALC_SHIFT & 0xf {
            calc::CRC32 => crc(self.data, CRC32_POLYNOMIAL, data, transfer.size, false),
            calc::CRC32_REVERSED => crc(self.data, CRC32_POLYNOMIAL, data, transfer.size, true),
            calc::CRC16 => crc16(self.data, data, transfer.size, false),
            calc::CRC16_REVERSED => crc16(self.data, data, transfer.size, true),
            calc::EVEN => self.data ^ data.count_ones() & 1,
            calc::SUM => self.data.wrapping_add(data),
            _ => self.data,
        };
    }
}

fn crc(state: u32, polynomial: u32, data: u32, size: Size, reversed: bool) -> u32 {
    let bytes = data.to_le_bytes().into_iter().take(size.bytes() as usize);
    bytes.fold(state, |state, byte| {
        let byte = if reversed { byte.reverse_bits() } else { byte };
        (0..8).fold(state ^ u32::from(byte) << 24, |state, _| {
            let carry = if state >> 31 == 0 { 0 } else { polynomial };
            state << 1 ^ carry
        })
    })
}

/// The low half of the register is the state.
fn crc16(state: u32, data: u32, size: Size, reversed: bool) -> u32 {
    crc(state << 16, CRC16_POLYNOMIAL, data, size, reversed) >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transfer(size: Size) -> Transfer {
        Transfer {
            channel: 5,
            from: 0,
            to: 0,
            size,
            byte_swap: false,
        }
    }

    /// The checksum of this text, moved in parts of this size.
    fn sniffed(calc: u32, seed: u32, size: Size, output: u32, text: &[u8]) -> u32 {
        let mut sniffer = Sniffer::default();
        sniffer.set_control(EN | 5 << DMACH_SHIFT | calc << CALC_SHIFT | output);
        sniffer.seed(seed);
        for part in text.chunks(size.bytes() as usize) {
            let mut word = [0; 4];
            word[..part.len()].copy_from_slice(part);
            sniffer.observe(&transfer(size), true, u32::from_le_bytes(word));
        }
        sniffer.result()
    }

    #[test]
    fn checksums_have_their_published_check_values() {
        let reversed = OUT_REV | OUT_INV;
        for (calc, seed, output, result) in [
            (calc::CRC32_REVERSED, !0, reversed, 0xcbf4_3926), // CRC-32/ISO-HDLC
            (calc::CRC32, !0, OUT_INV, 0xfc89_1918),           // CRC-32/BZIP2
            (calc::CRC16, 0, 0, 0x31c3),                       // CRC-16/XMODEM
            // CRC-16/KERMIT comes out in the upper half when reversed.
            (calc::CRC16_REVERSED, 0, OUT_REV, 0x2189 << 16),
            (calc::SUM, 1, 0, 478),
            (calc::EVEN, 0, 0, 1),
        ] {
            let sniffed = sniffed(calc, seed, Size::Byte, output, b"123456789");
            assert_eq!(sniffed, result, "{calc}");
        }
    }

    #[test]
    fn the_width_of_the_transfers_does_not_matter() {
        for size in [Size::Byte, Size::Halfword, Size::Word] {
            let output = OUT_REV | OUT_INV;
            let crc = sniffed(calc::CRC32_REVERSED, !0, size, output, b"12345678");
            assert_eq!(crc, 0x9ae0_daaf, "{size:?}");
        }
    }

    #[test]
    fn only_the_channel_set_is_sniffed() {
        let mut sniffer = Sniffer::default();
        sniffer.set_control(EN | 5 << DMACH_SHIFT | calc::SUM << CALC_SHIFT);
        let mut transfer = transfer(Size::Word);
        transfer.channel = 4;
        sniffer.observe(&transfer, true, 7);
        transfer.channel = 5;
        sniffer.observe(&transfer, false, 7);
        assert_eq!(sniffer.result(), 0);
        sniffer.observe(&transfer, true, 0x0102_0304);
        assert_eq!(sniffer.result(), 0x0102_0304);
        sniffer.set_control(sniffer.control() | BSWAP);
        sniffer.observe(&transfer, true, 0x0102_0304);
        assert_eq!(sniffer.result(), 0x0505_0505);
    }
}
