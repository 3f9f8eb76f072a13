//! The watchdog, and the tick that it and the timer count (RP2040 datasheet 4.7).
//!
//! Erratum RP2040-E1: the counter goes down by two each tick. A reset by the watchdog, too, stops it
//! (its real block is left running, and stopped by the boot ROM); REASON and the scratch registers
//! keep their values.

use super::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Peripheral, Write};

const CTRL: u32 = 0x00;
const LOAD: u32 = 0x04;
const REASON: u32 = 0x08;
const SCRATCH0: u32 = 0x0c;
const SCRATCH7: u32 = 0x28;
const TICK: u32 = 0x2c;

/// CTRL: triggers at once.
const TRIGGER: u32 = 1 << 31;
const ENABLE: u32 = 1 << 30;
/// CTRL: pause while a debugger halts a core; here is none.
const PAUSE: u32 = 7 << 24;
/// CTRL and LOAD: the counter.
const COUNTER: u32 = 0x00ff_ffff;
/// REASON.
const BY_TIMER: u32 = 1;
const BY_FORCE: u32 = 1 << 1;
/// TICK: CYCLES, ENABLE, RUNNING.
const TICK_CYCLES: u32 = 0x1ff;
const TICK_ENABLE: u32 = 1 << 9;
const TICK_RUNNING: u32 = 1 << 10;
/// What the counter goes down by (RP2040-E1).
const STEP: u32 = 2;
/// The reference clock, which the tick generator divides.
const REFERENCE_MEGAHERTZ: Cycles = 12;

/// How fast the tick is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// Periods of the 12 MHz reference clock that a tick takes; 0 if there is none.
    reference_cycles: Cycles,
}

impl Tick {
    /// No ticks.
    pub const STOPPED: Self = Self {
        reference_cycles: 0,
    };
    /// A tick each microsecond, from the crystal of 12 MHz.
    #[cfg(test)]
    pub const MICROSECOND: Self = Self {
        reference_cycles: REFERENCE_MEGAHERTZ,
    };

    /// Whole ticks in a time.
    #[inline]
    pub const fn ticks_in(self, time: Cycles) -> u64 {
        match self.reference_cycles {
            0 => 0,
            REFERENCE_MEGAHERTZ => time / CYCLES_PER_MICROSECOND,
            cycles => time * REFERENCE_MEGAHERTZ / (CYCLES_PER_MICROSECOND * cycles),
        }
    }

    /// The time until that many ticks are over; `None` if they never are.
    pub const fn time_of(self, ticks: u64) -> Option<Cycles> {
        if self.reference_cycles == 0 {
            return None;
        }
        let periods = ticks.saturating_mul(self.reference_cycles);
        Some(
            periods
                .saturating_mul(CYCLES_PER_MICROSECOND)
                .div_ceil(REFERENCE_MEGAHERTZ),
        )
    }
}

/// The registers.
#[derive(Clone, Debug)]
pub struct Watchdog {
    /// ENABLE and the pause bits of CTRL.
    ctrl: u32,
    /// The counter at `since`.
    counter: u32,
    since: Cycles,
    reason: u32,
    scratch: [u32; 8],
    tick: u32,
    fired: bool,
}

impl Watchdog {
    /// After a reset of the whole chip.
    pub const fn new() -> Self {
        Self {
            ctrl: PAUSE,
            counter: 0,
            since: 0,
            reason: 0,
            scratch: [0; 8],
            tick: TICK_ENABLE,
            fired: false,
        }
    }

    /// What a reset by the watchdog leaves: its reason and the scratch registers.
    pub fn restart(&mut self) {
        *self = Self {
            reason: self.reason,
            scratch: self.scratch,
            ..Self::new()
        };
    }

    /// The tick that is set up.
    pub const fn tick(&self) -> Tick {
        let enabled = self.tick & TICK_ENABLE != 0;
        Tick {
            reference_cycles: if enabled {
                (self.tick & TICK_CYCLES) as Cycles
            } else {
                0
            },
        }
    }

    /// Whether it wants the reset now; the reason is set.
    pub fn take_fired(&mut self) -> bool {
        std::mem::take(&mut self.fired)
    }

    const fn enabled(&self) -> bool {
        self.ctrl & ENABLE != 0
    }

    fn counter(&self, now: Cycles) -> u32 {
        if !self.enabled() {
            return self.counter;
        }
        let ticks = self.tick().ticks_in(now - self.since);
        let down = u64::from(STEP).saturating_mul(ticks);
        u64::from(self.counter).saturating_sub(down) as u32
    }

    /// Fixes the count, before what determines it changes.
    fn settle(&mut self, now: Cycles) {
        self.counter = self.counter(now);
        self.since = now;
    }

    fn fire(&mut self, reason: u32) {
        self.reason = reason;
        self.ctrl &= !ENABLE;
        self.fired = true;
    }
}

impl Peripheral for Watchdog {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        match offset {
            CTRL => self.ctrl | self.counter(now),
            REASON => self.reason,
            SCRATCH0..=SCRATCH7 => self.scratch[(offset - SCRATCH0) as usize / 4],
            TICK if self.tick & TICK_ENABLE != 0 => self.tick | TICK_RUNNING,
            TICK => self.tick,
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        match offset {
            CTRL => {
                self.settle(now);
                let value = write.onto(self.ctrl);
                self.ctrl = value & (ENABLE | PAUSE);
                if value & TRIGGER != 0 {
                    self.fire(BY_FORCE);
                }
            }
            LOAD => {
                self.counter = write.onto(0) & COUNTER;
                self.since = now;
            }
            SCRATCH0..=SCRATCH7 => {
                let scratch = &mut self.scratch[(offset - SCRATCH0) as usize / 4];
                *scratch = write.onto(*scratch);
            }
            TICK => {
                self.settle(now);
                self.tick = write.onto(self.tick) & (TICK_ENABLE | TICK_CYCLES);
            }
            _ => {}
        }
    }

    fn next_event(&self) -> Option<Cycles> {
        if !self.enabled() {
            return None;
        }
        let ticks = self.counter.div_ceil(STEP);
        Some(self.since + self.tick().time_of(u64::from(ticks))?)
    }

    fn advance(&mut self, now: Cycles) {
        if self.next_event().is_some_and(|at| at <= now) {
            self.fire(BY_TIMER);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Started with this load, 12 reference cycles a tick.
    fn started(load: u32) -> Watchdog {
        let mut watchdog = Watchdog::new();
        watchdog.write(TICK, Write::plain(TICK_ENABLE | 12), 0);
        watchdog.write(LOAD, Write::plain(load), 0);
        watchdog.write(CTRL, Write::plain(ENABLE), 0);
        watchdog
    }

    #[test]
    fn it_counts_two_a_microsecond() {
        let mut watchdog = started(2_000);
        assert_eq!(watchdog.read(CTRL, 100 * 125) & COUNTER, 1_800);
        assert_eq!(watchdog.next_event(), Some(1_000 * 125));
        watchdog.advance(1_000 * 125 - 1);
        assert!(!watchdog.take_fired());
        watchdog.advance(1_000 * 125);
        assert!(watchdog.take_fired());
        assert!(!watchdog.take_fired());
        assert_eq!(watchdog.read(REASON, 0), BY_TIMER);
        assert_eq!(watchdog.next_event(), None);
    }

    #[test]
    fn feeding_puts_it_off() {
        let mut watchdog = started(2_000);
        watchdog.write(LOAD, Write::plain(2_000), 900 * 125);
        assert_eq!(watchdog.next_event(), Some(1_900 * 125));
        watchdog.write(CTRL, Write::plain(0), 1_000 * 125);
        assert_eq!(watchdog.next_event(), None);
        assert_eq!(watchdog.read(CTRL, 9_999 * 125) & COUNTER, 1_800, "paused");
    }

    #[test]
    fn it_can_be_forced_and_keeps_its_scratch_registers() {
        let mut watchdog = started(2_000);
        watchdog.write(SCRATCH7, Write::plain(0xdead_beef), 0);
        watchdog.write(CTRL, Write::plain(TRIGGER), 5);
        assert!(watchdog.take_fired());
        watchdog.restart();
        assert_eq!(watchdog.read(REASON, 5), BY_FORCE);
        assert_eq!(watchdog.read(SCRATCH7, 5), 0xdead_beef);
        assert_eq!(watchdog.read(CTRL, 5), PAUSE);
    }

    #[test]
    fn ticks_have_the_length_set() {
        let quick = Tick {
            reference_cycles: 6,
        };
        assert_eq!(quick.ticks_in(125), 2);
        assert_eq!(quick.time_of(1), Some(63));
        assert_eq!(quick.ticks_in(63), 1);
        assert_eq!(quick.ticks_in(62), 0);
        assert_eq!(Tick::STOPPED.time_of(1), None);
        assert_eq!(Tick::MICROSECOND.time_of(3), Some(375));
    }
}
