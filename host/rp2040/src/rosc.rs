//! The ring oscillator (RP2040 datasheet 2.17), for its random bit.
//!
//! The bits come from a generator seeded from outside: the same seed gives the same run.

use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg32;

use super::peripheral::{Cycles, Peripheral, Write};

const CTRL: u32 = 0x00;
const DIV: u32 = 0x10;
const STATUS: u32 = 0x18;
const RANDOMBIT: u32 = 0x1c;
const COUNT: u32 = 0x20;
/// Registers that hold what is written.
const HELD: usize = 6;

/// CTRL after a reset: enabled by default, lowest range.
const CTRL_AT_RESET: u32 = 0xaa0;
/// DIV after a reset: 16.
const DIV_AT_RESET: u32 = 0xab0;
/// STATUS: STABLE, DIV_RUNNING and ENABLED.
const RUNNING: u32 = 1 << 31 | 1 << 16 | 1 << 12;

/// The registers, and what makes the random bits.
#[derive(Clone, Debug)]
pub struct Rosc {
    held: [u32; HELD],
    noise: Pcg32,
}

impl Rosc {
    /// Running, with bits from this seed.
    pub fn new(seed: u64) -> Self {
        let mut held = [0; HELD];
        held[CTRL as usize / 4] = CTRL_AT_RESET;
        held[DIV as usize / 4] = DIV_AT_RESET;
        Self {
            held,
            noise: Pcg32::seed_from_u64(seed),
        }
    }
}

impl Peripheral for Rosc {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            STATUS => RUNNING,
            RANDOMBIT => self.noise.next_u32() >> 31,
            COUNT => 0,
            _ => self.held.get(offset as usize / 4).copied().unwrap_or(0),
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        if let Some(register) = self.held.get_mut(offset as usize / 4) {
            *register = write.onto(*register);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(seed: u64) -> Vec<u32> {
        let mut rosc = Rosc::new(seed);
        (0..4_096).map(|_| rosc.read(RANDOMBIT, 0)).collect()
    }

    #[test]
    fn the_seed_decides_the_bits() {
        assert_eq!(bits(1), bits(1));
        assert_ne!(bits(1), bits(2));
        let ones: u32 = bits(1).iter().sum();
        assert!((1_900..2_200).contains(&ones), "{ones}");
    }

    #[test]
    fn it_runs() {
        let mut rosc = Rosc::new(0);
        assert_eq!(rosc.read(STATUS, 0), RUNNING);
        rosc.write(DIV, Write::plain(0xaa1), 0);
        assert_eq!(rosc.read(DIV, 0), 0xaa1);
        rosc.write(STATUS, Write::plain(0), 0);
        assert_eq!(rosc.read(STATUS, 0), RUNNING);
    }
}
