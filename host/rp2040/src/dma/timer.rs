//! The pacing timers (RP2040 datasheet 2.5.5.1).

use crate::peripheral::Cycles;

/// A timer that asks for X transfers every Y cycles, evenly, one a cycle at most.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timer {
    x: u16,
    y: u16,
    /// What is left of Y after the last request, in steps of X.
    phase: u64,
    since: Cycles,
}

impl Timer {
    /// X in the high half and Y in the low half.
    pub fn fraction(&self) -> u32 {
        u32::from(self.x) << 16 | u32::from(self.y)
    }

    /// Sets both, and begins anew.
    pub fn set(&mut self, fraction: u32, now: Cycles) {
        *self = Self {
            x: (fraction >> 16) as u16,
            y: fraction as u16,
            phase: 0,
            since: now,
        };
    }

    fn runs(&self) -> bool {
        self.x != 0 && self.y != 0
    }

    /// When it asks next; `None` if never.
    pub fn next_request(&self) -> Option<Cycles> {
        let left = u64::from(self.y).saturating_sub(self.phase);
        self.runs()
            .then(|| self.since + left.div_ceil(u64::from(self.x)).max(1))
    }

    /// How often it has asked since it was advanced last.
    pub fn advance(&mut self, now: Cycles) -> u64 {
        let elapsed = now.saturating_sub(self.since);
        self.since = self.since.max(now);
        if !self.runs() {
            return 0;
        }
        let (x, y) = (u64::from(self.x.min(self.y)), u64::from(self.y));
        let steps = self.phase + x * elapsed;
        self.phase = steps % y;
        steps / y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_come_at_the_rate_set() {
        let mut timer = Timer::default();
        assert_eq!(timer.next_request(), None);
        timer.set(3 << 16 | 1_000, 500);
        assert_eq!(timer.next_request(), Some(500 + 334));
        assert_eq!(timer.advance(500 + 333), 0);
        assert_eq!(timer.advance(500 + 334), 1);
        assert_eq!(timer.next_request(), Some(500 + 667));
        assert_eq!(timer.advance(500 + 1_000_000), 2_999);
    }

    #[test]
    fn there_is_one_request_a_cycle_at_most() {
        let mut timer = Timer::default();
        timer.set(9 << 16 | 2, 0);
        assert_eq!(timer.next_request(), Some(1));
        assert_eq!(timer.advance(100), 100);
        timer.set(9 << 16, 100);
        assert_eq!((timer.advance(200), timer.next_request()), (0, None));
    }
}
