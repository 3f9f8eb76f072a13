//! The crystal oscillator (RP2040 datasheet 2.16), 12 MHz.

use super::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Peripheral, Write};

const CTRL: u32 = 0x00;
const STATUS: u32 = 0x04;
const DORMANT: u32 = 0x08;
const STARTUP: u32 = 0x0c;
const COUNT: u32 = 0x1c;

/// CTRL: ENABLE, bits 23 to 12, and what switches the oscillator on.
const ENABLE_SHIFT: u32 = 12;
const ENABLE: u32 = 0xfab;
/// STATUS.
const STABLE: u32 = 1 << 31;
const ENABLED: u32 = 1 << 12;
/// DORMANT after a reset: awake.
const WAKE: u32 = 0x7761_6b65;
/// STARTUP: units of 256 periods, bits 13 to 0.
const DELAY_MASK: u32 = 0x3fff;
const DELAY_UNIT: Cycles = 256;
/// STARTUP after a reset.
const DELAY_AT_RESET: u32 = 0xc4;
/// The crystal.
const MEGAHERTZ: Cycles = 12;

/// The registers.
#[derive(Clone, Debug)]
pub struct Xosc {
    ctrl: u32,
    startup: u32,
    dormant: u32,
    count: u32,
    stable_at: Option<Cycles>,
}

impl Xosc {
    /// Switched off.
    pub const fn new() -> Self {
        Self {
            ctrl: 0,
            startup: DELAY_AT_RESET,
            dormant: WAKE,
            count: 0,
            stable_at: None,
        }
    }

    /// When a read of STATUS that waits for STABLE may go on, if the oscillator was switched on.
    ///
    /// Programs poll for it, some 128 ms long. The machine does not step them through that: it lets
    /// the core wait at the first read, which comes to the same.
    pub fn wait_at_status(&self, offset: u32, now: Cycles) -> Option<Cycles> {
        self.stable_at.filter(|at| offset == STATUS && *at > now)
    }

    fn start_or_stop(&mut self, now: Cycles) {
        let enabled = self.ctrl >> ENABLE_SHIFT & 0xfff == ENABLE;
        let delay = Cycles::from(self.startup & DELAY_MASK) * DELAY_UNIT;
        let stable_at = now + delay * CYCLES_PER_MICROSECOND / MEGAHERTZ;
        self.stable_at = enabled.then(|| self.stable_at.unwrap_or(stable_at));
    }
}

impl Peripheral for Xosc {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        match offset {
            CTRL => self.ctrl,
            STATUS => match self.stable_at {
                Some(at) if at <= now => STABLE | ENABLED,
                Some(_) => ENABLED,
                None => 0,
            },
            DORMANT => self.dormant,
            STARTUP => self.startup,
            COUNT => self.count,
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        match offset {
            CTRL => {
                self.ctrl = write.onto(self.ctrl);
                self.start_or_stop(now);
            }
            STARTUP => self.startup = write.onto(self.startup),
            // Falling asleep with all clocks stopped is not modelled.
            DORMANT => self.dormant = write.onto(self.dormant),
            COUNT => self.count = write.onto(self.count) & 0xff,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_stable_after_the_delay_set() {
        let mut xosc = Xosc::new();
        assert_eq!(xosc.read(STATUS, 0), 0);
        xosc.write(STARTUP, Write::plain(47), 0);
        xosc.write(CTRL, Write::plain(ENABLE << ENABLE_SHIFT | 0xaa0), 1_000);
        // 47 * 256 / 12 MHz = 1002.67 us
        let stable = 1_000 + 125_333;
        assert_eq!(xosc.read(STATUS, stable - 1), ENABLED);
        assert_eq!(xosc.wait_at_status(STATUS, stable - 1), Some(stable));
        assert_eq!(xosc.wait_at_status(CTRL, stable - 1), None);
        assert_eq!(xosc.wait_at_status(STATUS, stable), None);
        assert_eq!(xosc.read(STATUS, stable), ENABLED | STABLE);
        xosc.write(CTRL, Write::plain(0xd1e << ENABLE_SHIFT), stable + 9);
        assert_eq!(xosc.read(STATUS, stable + 9), 0);
    }
}
