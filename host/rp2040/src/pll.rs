//! A phase-locked loop (RP2040 datasheet 2.18): locked as soon as it is powered.

use super::peripheral::{Cycles, Peripheral, Write};

const CS: u32 = 0x00;
const PWR: u32 = 0x04;
const FBDIV_INT: u32 = 0x08;
const PRIM: u32 = 0x0c;

/// CS: LOCK is read only; BYPASS and REFDIV can be set.
const LOCK: u32 = 1 << 31;
const CS_WRITABLE: u32 = 1 << 8 | 0x3f;
/// PWR: power down of the oscillator and of the whole loop.
const VCOPD: u32 = 1 << 5;
const PD: u32 = 1;
const PWR_WRITABLE: u32 = VCOPD | 1 << 3 | 1 << 2 | PD;
const PRIM_WRITABLE: u32 = 0x7 << 16 | 0x7 << 12;

/// The registers.
#[derive(Clone, Debug)]
pub struct Pll {
    cs: u32,
    pwr: u32,
    fbdiv: u32,
    prim: u32,
}

impl Pll {
    /// Powered down.
    pub const fn new() -> Self {
        Self {
            cs: 1,
            pwr: PWR_WRITABLE,
            fbdiv: 0,
            prim: PRIM_WRITABLE,
        }
    }
}

impl Peripheral for Pll {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        let locked = self.pwr & (VCOPD | PD) == 0 && self.fbdiv != 0;
        match offset {
            CS if locked => self.cs | LOCK,
            CS => self.cs,
            PWR => self.pwr,
            FBDIV_INT => self.fbdiv,
            PRIM => self.prim,
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        let (register, writable) = match offset {
            CS => (&mut self.cs, CS_WRITABLE),
            PWR => (&mut self.pwr, PWR_WRITABLE),
            FBDIV_INT => (&mut self.fbdiv, 0xfff),
            PRIM => (&mut self.prim, PRIM_WRITABLE),
            _ => return,
        };
        *register = write.onto(*register) & writable;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peripheral::Alias;

    #[test]
    fn it_locks_when_powered_with_a_divisor() {
        let mut pll = Pll::new();
        assert_eq!(pll.read(CS, 0), 1);
        pll.write(FBDIV_INT, Write::plain(125), 0);
        assert_eq!(pll.read(CS, 0) & LOCK, 0);
        let power_up = Write {
            value: VCOPD | PD,
            alias: Alias::Clear,
        };
        pll.write(PWR, power_up, 0);
        assert_eq!(pll.read(CS, 0), LOCK | 1);
        assert_eq!(pll.read(PWR, 0), 0xc);
    }

    #[test]
    fn it_starts_with_the_data_sheets_values() {
        let mut pll = Pll::new();
        let values = [CS, PWR, FBDIV_INT, PRIM].map(|offset| pll.read(offset, 0));
        assert_eq!(values, [1, 0x2d, 0, 0x77000]);
    }
}
