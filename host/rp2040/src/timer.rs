//! The timer: 64 bits of microseconds and four alarms (RP2040 datasheet 4.6).

use super::peripheral::{Cycles, Peripheral, Write};
use super::watchdog::Tick;

const TIMEHW: u32 = 0x00;
const TIMELW: u32 = 0x04;
const TIMEHR: u32 = 0x08;
const TIMELR: u32 = 0x0c;
const ALARM0: u32 = 0x10;
const ALARM3: u32 = 0x1c;
const ARMED: u32 = 0x20;
const TIMERAWH: u32 = 0x24;
const TIMERAWL: u32 = 0x28;
const DBGPAUSE: u32 = 0x2c;
const PAUSE: u32 = 0x30;
const INTR: u32 = 0x34;
const INTE: u32 = 0x38;
const INTF: u32 = 0x3c;
const INTS: u32 = 0x40;

/// Number of alarms, each with an interrupt line.
pub const ALARMS: usize = 4;
const ALARM_BITS: u32 = 0xf;
/// DBGPAUSE after a reset.
const DBGPAUSE_AT_RESET: u32 = 7;

/// The registers.
#[derive(Clone, Debug)]
pub struct Timer {
    /// The count at `since`.
    count: u64,
    since: Cycles,
    tick: Tick,
    paused: bool,
    /// TIMELW, until TIMEHW is written.
    low_to_write: u32,
    /// TIMEHR, as of the last read of TIMELR.
    high_latched: u32,
    alarms: [u32; ALARMS],
    /// The count at which each alarm fires, while it is armed.
    due: [Option<u64>; ALARMS],
    debug_pause: u32,
    raised: u32,
    enabled: u32,
    forced: u32,
}

impl Timer {
    /// At zero at this moment, counting this tick.
    pub const fn new(tick: Tick, now: Cycles) -> Self {
        Self {
            count: 0,
            since: now,
            tick,
            paused: false,
            low_to_write: 0,
            high_latched: 0,
            alarms: [0; ALARMS],
            due: [None; ALARMS],
            debug_pause: DBGPAUSE_AT_RESET,
            raised: 0,
            enabled: 0,
            forced: 0,
        }
    }

    /// Microseconds, if the tick is set up for that.
    pub fn count(&self, now: Cycles) -> u64 {
        // A program may set the count to anything.
        let ticks = self.running_tick().ticks_in(now - self.since);
        self.count.wrapping_add(ticks)
    }

    /// Counts another tick from now on.
    pub fn set_tick(&mut self, tick: Tick, now: Cycles) {
        if tick != self.tick {
            self.settle(now);
            self.tick = tick;
        }
    }

    /// The interrupt lines, a bit an alarm.
    pub fn lines(&self) -> u32 {
        self.raised & self.enabled | self.forced
    }

    fn running_tick(&self) -> Tick {
        if self.paused {
            Tick::STOPPED
        } else {
            self.tick
        }
    }

    fn settle(&mut self, now: Cycles) {
        self.count = self.count(now);
        self.since = now;
    }

    /// Arms an alarm: it fires when the low word of the count is next equal to it.
    fn arm(&mut self, alarm: usize, value: u32, now: Cycles) {
        let count = self.count(now);
        let left = value.wrapping_sub(count as u32);
        self.alarms[alarm] = value;
        self.due[alarm] = Some(count.wrapping_add(u64::from(left)));
    }

    /// The alarms' moments follow the count when that is set.
    fn set_count(&mut self, count: u64, now: Cycles) {
        self.count = count;
        self.since = now;
        for alarm in 0..ALARMS {
            if self.due[alarm].is_some() {
                self.arm(alarm, self.alarms[alarm], now);
            }
        }
    }

    fn armed(&self) -> u32 {
        (0..ALARMS)
            .filter(|&alarm| self.due[alarm].is_some())
            .map(|alarm| 1 << alarm)
            .sum()
    }
}

impl Peripheral for Timer {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        match offset {
            TIMEHR => self.high_latched,
            TIMELR => {
                let count = self.count(now);
                self.high_latched = (count >> 32) as u32;
                count as u32
            }
            ALARM0..=ALARM3 => self.alarms[(offset - ALARM0) as usize / 4],
            ARMED => self.armed(),
            TIMERAWH => (self.count(now) >> 32) as u32,
            TIMERAWL => self.count(now) as u32,
            DBGPAUSE => self.debug_pause,
            PAUSE => u32::from(self.paused),
            INTR => self.raised,
            INTE => self.enabled,
            INTF => self.forced,
            INTS => self.lines(),
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        match offset {
            TIMEHW => {
                let high = u64::from(write.onto(0)) << 32;
                self.set_count(high | u64::from(self.low_to_write), now);
            }
            TIMELW => self.low_to_write = write.onto(0),
            ALARM0..=ALARM3 => {
                let alarm = (offset - ALARM0) as usize / 4;
                self.arm(alarm, write.onto(self.alarms[alarm]), now);
            }
            // Written 1 to disarm; a write through the alias that clears has no other effect.
            ARMED => {
                for (alarm, due) in self.due.iter_mut().enumerate() {
                    if write.value >> alarm & 1 != 0 {
                        *due = None;
                    }
                }
            }
            DBGPAUSE => self.debug_pause = write.onto(self.debug_pause) & 7,
            PAUSE => {
                self.settle(now);
                self.paused = write.onto(u32::from(self.paused)) & 1 != 0;
            }
            // Written 1 to clear.
            INTR => self.raised &= !write.value,
            INTE => self.enabled = write.onto(self.enabled) & ALARM_BITS,
            INTF => self.forced = write.onto(self.forced) & ALARM_BITS,
            _ => {}
        }
    }

    fn next_event(&self) -> Option<Cycles> {
        let first = self.due.iter().flatten().min()?;
        let ticks = first.saturating_sub(self.count);
        let time = self.running_tick().time_of(ticks)?;
        Some(self.since.saturating_add(time))
    }

    fn advance(&mut self, now: Cycles) {
        let count = self.count(now);
        for (alarm, due) in self.due.iter_mut().enumerate() {
            if due.is_some_and(|due| due <= count) {
                *due = None;
                self.raised |= 1 << alarm;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peripheral::Alias;

    const US: Cycles = 125;

    fn timer() -> Timer {
        Timer::new(Tick::MICROSECOND, 0)
    }

    #[test]
    fn reading_the_low_word_latches_the_high_one() {
        let mut timer = timer();
        timer.write(TIMELW, Write::plain(0xffff_fffe), 0);
        timer.write(TIMEHW, Write::plain(6), 0);
        assert_eq!(timer.read(TIMELR, US), 0xffff_ffff);
        assert_eq!(timer.read(TIMERAWH, 2 * US), 7);
        assert_eq!(timer.read(TIMEHR, 2 * US), 6);
        assert_eq!(timer.read(TIMELR, 2 * US), 0);
        assert_eq!(timer.read(TIMEHR, 2 * US), 7);
    }

    #[test]
    fn an_alarm_fires_once_at_its_time() {
        let mut timer = timer();
        timer.write(INTE, Write::plain(0b0010), 0);
        timer.write(ALARM0 + 4, Write::plain(100), 30 * US + 7);
        assert_eq!(timer.read(ARMED, 0), 0b0010);
        assert_eq!(timer.next_event(), Some(100 * US));
        timer.advance(100 * US - 1);
        assert_eq!(timer.lines(), 0);
        timer.advance(100 * US);
        assert_eq!((timer.lines(), timer.read(ARMED, 0)), (0b0010, 0));
        assert_eq!(timer.next_event(), None);
        timer.write(INTR, Write::plain(0b0010), 101 * US);
        assert_eq!(timer.lines(), 0);
    }

    #[test]
    fn an_alarm_that_is_past_waits_for_the_low_word_to_come_round() {
        let mut timer = timer();
        timer.write(ALARM0, Write::plain(9), 10 * US);
        assert_eq!(timer.next_event(), Some(((1 << 32) + 9) * US));
        timer.write(ARMED, Write::plain(1), 10 * US);
        assert_eq!(timer.next_event(), None);
    }

    #[test]
    fn interrupts_can_be_forced_and_masked() {
        let mut timer = timer();
        let set = Write {
            value: 0b1000,
            alias: Alias::Set,
        };
        timer.write(INTF, set, 0);
        assert_eq!(timer.read(INTS, 0), 0b1000);
        timer.write(INTF, Write::plain(0), 0);
        timer.write(ALARM0 + 8, Write::plain(1), 0);
        timer.advance(US);
        assert_eq!((timer.read(INTR, 0), timer.read(INTS, 0)), (0b0100, 0));
        timer.write(INTE, set, 0);
        timer.write(INTE, Write::plain(0b0100), 0);
        assert_eq!(timer.read(INTS, 0), 0b0100);
    }

    #[test]
    fn it_pauses_and_stands_without_a_tick() {
        let mut timer = timer();
        timer.write(ALARM0, Write::plain(20), 0);
        timer.write(PAUSE, Write::plain(1), 10 * US);
        assert_eq!(timer.next_event(), None);
        assert_eq!(timer.count(50 * US), 10);
        timer.write(PAUSE, Write::plain(0), 50 * US);
        assert_eq!(timer.next_event(), Some(60 * US));
        timer.set_tick(Tick::STOPPED, 55 * US);
        assert_eq!(timer.count(90 * US), 15);
        timer.set_tick(Tick::MICROSECOND, 90 * US);
        assert_eq!(timer.count(91 * US), 16);
    }
}
