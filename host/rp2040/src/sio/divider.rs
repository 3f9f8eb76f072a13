//! The integer divider (RP2040 datasheet 2.3.1.5): 8 cycles, signed and unsigned.

use crate::peripheral::Cycles;

/// Cycles that a division takes.
const LATENCY: Cycles = 8;
/// CSR.
const READY: u32 = 1;
const DIRTY: u32 = 1 << 1;

/// Its registers. Results are there at once; only READY waits for the 8 cycles.
#[derive(Clone, Debug, Default)]
pub(super) struct Divider {
    dividend: u32,
    divisor: u32,
    quotient: u32,
    remainder: u32,
    ready_at: Cycles,
    dirty: bool,
}

impl Divider {
    /// Reads the register at this offset from DIV_UDIVIDEND.
    pub fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        match offset {
            0x00 | 0x08 => self.dividend,
            0x04 | 0x0c => self.divisor,
            0x10 => {
                self.dirty = false;
                self.quotient
            }
            0x14 => self.remainder,
            _ => {
                let ready = if self.ready_at <= now { READY } else { 0 };
                ready | if self.dirty { DIRTY } else { 0 }
            }
        }
    }

    /// Writes the register at this offset. Writing an operand starts a division.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) {
        let signed = offset & 0x08 != 0;
        match offset {
            0x00 | 0x08 => self.dividend = value,
            0x04 | 0x0c => self.divisor = value,
            0x10 => self.quotient = value,
            0x14 => self.remainder = value,
            _ => return,
        }
        self.dirty = true;
        if offset < 0x10 {
            self.divide(signed);
            self.ready_at = now + LATENCY;
        }
    }

    fn divide(&mut self, signed: bool) {
        (self.quotient, self.remainder) = if signed {
            let (dividend, divisor) = (self.dividend as i32, self.divisor as i32);
            let (quotient, remainder) = match divisor {
                0 if dividend < 0 => (1, dividend),
                0 => (-1, dividend),
                _ => (
                    dividend.wrapping_div(divisor),
                    dividend.wrapping_rem(divisor),
                ),
            };
            (quotient as u32, remainder as u32)
        } else {
            let quotient = self.dividend.checked_div(self.divisor);
            let remainder = self.dividend.checked_rem(self.divisor);
            (
                quotient.unwrap_or(u32::MAX),
                remainder.unwrap_or(self.dividend),
            )
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quotient and remainder, by the register pair at this offset.
    fn divide(pair: u32, dividend: i64, divisor: i64) -> (u32, u32) {
        let mut divider = Divider::default();
        divider.write(pair, dividend as u32, 0);
        divider.write(pair + 4, divisor as u32, 1);
        let remainder = divider.read(0x14, 9);
        (divider.read(0x10, 9), remainder)
    }

    #[test]
    fn it_divides_signed_and_unsigned() {
        assert_eq!(divide(0, 0xffff_ffff, 10), (429_496_729, 5));
        assert_eq!(divide(0, 7, 0), (u32::MAX, 7));
        assert_eq!(divide(8, -7, 2), (-3i32 as u32, -1i32 as u32));
        assert_eq!(divide(8, 7, -2), (-3i32 as u32, 1));
        assert_eq!(divide(8, 7, 0), (u32::MAX, 7));
        assert_eq!(divide(8, -7, 0), (1, -7i32 as u32));
        assert_eq!(divide(8, i64::from(i32::MIN), -1), (1 << 31, 0));
    }

    #[test]
    fn it_says_when_it_is_ready_and_dirty() {
        let mut divider = Divider::default();
        assert_eq!(divider.read(0x18, 0), READY);
        divider.write(0x04, 3, 100);
        assert_eq!(divider.read(0x18, 107), DIRTY);
        assert_eq!(divider.read(0x18, 108), DIRTY | READY);
        divider.read(0x10, 108);
        assert_eq!(divider.read(0x18, 108), READY);
        divider.write(0x10, 5, 110);
        divider.write(0x14, 6, 110);
        assert_eq!((divider.read(0x14, 110), divider.read(0x10, 110)), (6, 5));
    }
}
