//! The power-on state machine (RP2040 datasheet 2.13): the order in which the chip comes out of
//! reset, and what the watchdog sends through it again.

use super::peripheral::{Cycles, Peripheral, Write};

const FRCE_ON: u32 = 0x0;
const FRCE_OFF: u32 = 0x4;
const WDSEL: u32 = 0x8;
const DONE: u32 = 0xc;

/// One bit a stage, in their order; the first two are the oscillators.
pub mod stage {
    /// Clock generators.
    pub const CLOCKS: u32 = 1 << 2;
    /// The subsystem resets.
    pub const RESETS: u32 = 1 << 3;
    /// The flash interface.
    pub const XIP: u32 = 1 << 12;
    /// Single-cycle I/O.
    pub const SIO: u32 = 1 << 14;
    /// Core 0.
    pub const PROC0: u32 = 1 << 15;
    /// All there are.
    pub const ALL: u32 = 0x1_ffff;
}

/// Stages of the machine.
const STAGES: u32 = 17;

/// The registers.
#[derive(Clone, Debug, Default)]
pub struct Psm {
    force_on: u32,
    force_off: u32,
    watchdog: u32,
    /// Which stages went off since this was last asked.
    fallen: u32,
}

impl Psm {
    /// Everything on.
    pub const fn new() -> Self {
        Self {
            force_on: 0,
            force_off: 0,
            watchdog: 0,
            fallen: 0,
        }
    }

    /// A stage is off if it is forced off, or if the one before is off and it is not forced on.
    const fn on(&self) -> u32 {
        let (mut on, mut stage) = (0, 0);
        let mut before = true;
        while stage < STAGES {
            let bit = 1 << stage;
            before = self.force_off & bit == 0 && (before || self.force_on & bit != 0);
            if before {
                on |= bit;
            }
            stage += 1;
        }
        on
    }

    /// Which stages the watchdog restarts: those selected, and all behind the first of them.
    pub const fn restarted_by_watchdog(&self) -> u32 {
        if self.watchdog == 0 {
            return 0;
        }
        stage::ALL & (u32::MAX << self.watchdog.trailing_zeros())
    }

    /// Which stages went off since this was last asked.
    pub fn take_fallen(&mut self) -> u32 {
        std::mem::take(&mut self.fallen)
    }
}

impl Peripheral for Psm {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            FRCE_ON => self.force_on,
            FRCE_OFF => self.force_off,
            WDSEL => self.watchdog,
            DONE => self.on(),
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        let before = self.on();
        let register = match offset {
            FRCE_ON => &mut self.force_on,
            FRCE_OFF => &mut self.force_off,
            WDSEL => &mut self.watchdog,
            _ => return,
        };
        *register = write.onto(*register) & stage::ALL;
        self.fallen |= before & !self.on();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROC1: u32 = 1 << 16;

    #[test]
    fn a_forced_stage_takes_the_later_ones_with_it_unless_they_are_held() {
        let mut psm = Psm::new();
        assert_eq!(psm.read(DONE, 0), stage::ALL);
        // As embassy-rp resets SIO without resetting the core that does it.
        psm.write(FRCE_ON, Write::plain(stage::PROC0), 0);
        psm.write(FRCE_OFF, Write::plain(stage::SIO | PROC1), 0);
        assert_eq!(psm.read(DONE, 0), stage::ALL & !stage::SIO & !PROC1);
        assert_eq!(psm.take_fallen(), stage::SIO | PROC1);
        psm.write(FRCE_OFF, Write::plain(0), 0);
        psm.write(FRCE_ON, Write::plain(0), 0);
        assert_eq!(psm.read(DONE, 0), stage::ALL);
        assert_eq!(psm.take_fallen(), 0);
        psm.write(FRCE_OFF, Write::plain(stage::SIO), 0);
        assert_eq!(psm.take_fallen(), stage::SIO | stage::PROC0 | PROC1);
    }

    #[test]
    fn the_watchdog_restarts_from_the_first_stage_selected() {
        let mut psm = Psm::new();
        assert_eq!(psm.restarted_by_watchdog(), 0);
        psm.write(WDSEL, Write::plain(0x1_fffc), 0);
        assert_eq!(psm.restarted_by_watchdog(), 0x1_fffc);
        psm.write(WDSEL, Write::plain(stage::SIO), 0);
        assert_eq!(
            psm.restarted_by_watchdog(),
            stage::SIO | stage::PROC0 | PROC1
        );
    }
}
