//! The counters of the faults.

use crate::contract::{Counters, Fault};

impl Fault {
    /// Number of faults.
    pub const COUNT: usize = Self::FlashFailed as usize + 1;

    /// All faults, in the order of [`Counters`].
    pub const ALL: [Self; Self::COUNT] = [
        Self::ControlSilent,
        Self::TaskSilent,
        Self::Blocked,
        Self::RangeSensor,
        Self::Compass,
        Self::NoProgress,
        Self::Stuck,
        Self::HostLate,
        Self::HostLost,
        Self::ArmRefused,
        Self::FlashWhileArmed,
        Self::BadFrame,
        Self::Unsettled,
        Self::QueueFull,
        Self::TurnTimeout,
        Self::LateStep,
        Self::BusRecovered,
        Self::AdcError,
        Self::ClockStepped,
        Self::FlashFailed,
    ];
}

impl Counters {
    /// Returns how often a fault was counted.
    pub const fn of(&self, fault: Fault) -> u32 {
        self.0[fault as usize]
    }

    /// Counts a fault `times` times; stops at the largest value.
    pub(super) fn count(&mut self, fault: Fault, times: u32) {
        let counter = &mut self.0[fault as usize];
        *counter = counter.saturating_add(times);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_its_own_counter() {
        let mut counters = Counters::default();
        for (i, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(fault as usize, i);
            counters.count(fault, i as u32);
            counters.count(fault, 1);
        }
        for (i, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(counters.of(fault), i as u32 + 1);
        }
        counters.count(Fault::QueueFull, u32::MAX);
        assert_eq!(counters.of(Fault::QueueFull), u32::MAX);
    }
}
