//! SysTick, the 24-bit system timer (B3.3).

/// Enable bit of SYST_CSR.
const ENABLE: u32 = 1;
/// SYST_CSR: reaching zero makes the exception pending.
const TICKINT: u32 = 1 << 1;
/// SYST_CSR: the processor clock is counted, not the external reference.
const CLKSOURCE: u32 = 1 << 2;
/// SYST_CSR: zero was reached since it was last read.
const COUNTFLAG: u32 = 1 << 16;
/// The counter has 24 bits.
const COUNTER_MASK: u32 = 0x00ff_ffff;

/// What the counter counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Cycles of the core.
    Processor,
    /// Ticks of the external reference clock; on the RP2040 1 us.
    Reference,
}

/// The timer.
#[derive(Clone, Debug)]
pub(super) struct SysTick {
    /// ENABLE, TICKINT and CLKSOURCE of SYST_CSR.
    control: u32,
    reload: u32,
    current: u32,
    count_flag: bool,
}

impl SysTick {
    /// Stopped.
    pub const fn new() -> Self {
        Self {
            control: 0,
            reload: 0,
            current: 0,
            count_flag: false,
        }
    }

    /// What is being counted, if anything is.
    #[inline(always)]
    pub fn clock(&self) -> Option<Clock> {
        if self.control & ENABLE == 0 {
            return None;
        }
        Some(if self.control & CLKSOURCE == 0 {
            Clock::Reference
        } else {
            Clock::Processor
        })
    }

    /// Ticks until zero is next reached, which happens every RELOAD + 1 ticks; `None` if never.
    pub fn ticks_to_zero(&self) -> Option<u32> {
        match (self.current, self.reload) {
            (0, 0) => None,
            (0, reload) => Some(reload + 1),
            (current, _) => Some(current),
        }
    }

    /// Whether reaching zero makes the exception pending.
    pub fn interrupts(&self) -> bool {
        self.control & TICKINT != 0
    }

    /// Counts `ticks` down; returns whether the exception becomes pending.
    #[inline(always)]
    pub fn count(&mut self, ticks: u64) -> bool {
        if ticks < u64::from(self.current) {
            self.current -= ticks as u32;
            return false;
        }
        self.count_past_zero(ticks)
    }

    #[inline(never)]
    fn count_past_zero(&mut self, ticks: u64) -> bool {
        let Some(to_zero) = self.ticks_to_zero().map(u64::from) else {
            return false;
        };
        let period = u64::from(self.reload) + 1;
        if ticks < to_zero {
            // At zero before: the first tick reloads.
            self.current = ((to_zero - ticks) % period) as u32;
            return false;
        }
        let past = (ticks - to_zero) % period;
        self.current = if past == 0 { 0 } else { (period - past) as u32 };
        self.count_flag = true;
        self.interrupts()
    }

    /// Reads SYST_CSR, which clears COUNTFLAG.
    pub fn read_control(&mut self) -> u32 {
        let flag = std::mem::take(&mut self.count_flag);
        self.control | if flag { COUNTFLAG } else { 0 }
    }

    /// Writes SYST_CSR.
    pub fn write_control(&mut self, value: u32) {
        self.control = value & (ENABLE | TICKINT | CLKSOURCE);
    }

    /// Reads SYST_RVR.
    pub fn reload(&self) -> u32 {
        self.reload
    }

    /// Writes SYST_RVR.
    pub fn write_reload(&mut self, value: u32) {
        self.reload = value & COUNTER_MASK;
    }

    /// Reads SYST_CVR.
    pub fn current(&self) -> u32 {
        self.current
    }

    /// Writes SYST_CVR: whatever is written, it and COUNTFLAG become zero.
    pub fn clear_current(&mut self) {
        self.current = 0;
        self.count_flag = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn running(reload: u32) -> SysTick {
        let mut timer = SysTick::new();
        timer.write_reload(reload);
        timer.write_control(ENABLE | TICKINT | CLKSOURCE);
        timer
    }

    #[test]
    fn zero_comes_every_reload_plus_one_ticks() {
        let mut timer = running(9);
        let zeros: Vec<u64> = (1..=40).filter(|_| timer.count(1)).collect();
        assert_eq!(zeros, [10, 20, 30, 40]);
        assert_eq!(timer.read_control() >> 16, 1);
        assert_eq!(timer.read_control() >> 16, 0);
    }

    #[test]
    fn a_reload_of_zero_stops_it_at_the_next_zero() {
        let mut timer = running(5);
        assert!(!timer.count(1));
        timer.write_reload(0);
        assert!(timer.count(5));
        assert!(!timer.count(1_000));
        assert_eq!(timer.current(), 0);
    }

    proptest! {
        #[test]
        fn many_ticks_at_once_are_as_many_single_ones(
            reload in 0u32..40, before in 0u64..100, ticks in 0u64..200,
        ) {
            let mut at_once = running(reload);
            at_once.count(before);
            let mut singly = at_once.clone();
            let pended = at_once.count(ticks);
            let pended_singly = (0..ticks).fold(false, |any, _| singly.count(1) | any);
            prop_assert_eq!(pended, pended_singly);
            prop_assert_eq!(at_once.current(), singly.current());
            prop_assert_eq!(at_once.read_control(), singly.read_control());
        }
    }
}
