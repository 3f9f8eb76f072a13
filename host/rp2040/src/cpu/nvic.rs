//! The state of all exceptions: pending, enabled, active, priority (B1.5.4, B3.4).

/// Exception numbers (B1.5.2).
pub mod exception {
    /// The non-maskable interrupt, priority -2.
    pub const NMI: u32 = 2;
    /// HardFault, priority -1.
    pub const HARD_FAULT: u32 = 3;
    /// The supervisor call.
    pub const SVCALL: u32 = 11;
    /// The pendable service request.
    pub const PENDSV: u32 = 14;
    /// The system timer.
    pub const SYSTICK: u32 = 15;
    /// External interrupt 0; 31 follow.
    pub const IRQ0: u32 = 16;
}

use exception::{HARD_FAULT, IRQ0, NMI, PENDSV, SVCALL, SYSTICK};

/// Exceptions that are always enabled.
const SYSTEM: u64 = 1 << NMI | 1 << HARD_FAULT | 1 << SVCALL | 1 << PENDSV | 1 << SYSTICK;
/// ARMv6-M implements the two most significant bits of a priority: 0, 64, 128 and 192.
const PRIORITY_MASK: u8 = 0b1100_0000;
/// The execution priority of Thread mode: below every exception.
pub(super) const LOWEST_PRIORITY: i32 = 256;

/// Bits are numbered by exception.
#[derive(Clone, Debug)]
pub(super) struct Nvic {
    pending: u64,
    enabled: u64,
    active: u64,
    /// Of exceptions 11 and up; 64 entries, so that any IPSR indexes them.
    priority: [u8; 64],
    /// The levels of the 32 interrupt inputs.
    lines: u32,
}

impl Nvic {
    pub const fn new() -> Self {
        Self {
            pending: 0,
            enabled: SYSTEM,
            active: 0,
            priority: [0; 64],
            lines: 0,
        }
    }

    /// The smaller, the more urgent.
    pub fn priority(&self, number: u32) -> i32 {
        match number {
            NMI => -2,
            HARD_FAULT => -1,
            _ => i32::from(self.priority[number as usize & 63]),
        }
    }

    /// The byte of the priority register of exception `number`.
    pub fn priority_byte(&self, number: u32) -> u8 {
        self.priority[number as usize & 63]
    }

    pub fn set_priority_byte(&mut self, number: u32, value: u8) {
        self.priority[number as usize & 63] = value & PRIORITY_MASK;
    }

    /// The most urgent of these exceptions, the lowest number first among equals.
    fn most_urgent(&self, mut set: u64) -> Option<(u32, i32)> {
        let mut best: Option<(u32, i32)> = None;
        while set != 0 {
            let number = set.trailing_zeros();
            set &= set - 1;
            let priority = self.priority(number);
            if best.is_none_or(|(_, least)| priority < least) {
                best = Some((number, priority));
            }
        }
        best
    }

    /// The pending and enabled exception to be taken first, and its priority.
    pub fn highest_pending(&self) -> Option<(u32, i32)> {
        self.most_urgent(self.pending & self.enabled)
    }

    /// The priority that the active exceptions give the code running.
    pub fn active_priority(&self) -> i32 {
        self.most_urgent(self.active)
            .map_or(LOWEST_PRIORITY, |(_, priority)| priority)
    }

    pub fn is_pending(&self, number: u32) -> bool {
        self.pending >> number & 1 != 0
    }

    pub fn is_active(&self, number: u32) -> bool {
        self.active >> (number & 63) & 1 != 0
    }

    pub fn active_count(&self) -> u32 {
        self.active.count_ones()
    }

    /// Makes these exceptions pending; returns whether any was not so before.
    pub fn pend(&mut self, set: u64) -> bool {
        let new = set & !self.pending;
        self.pending |= set;
        new != 0
    }

    /// Interrupts whose line is high stay pending.
    pub fn unpend(&mut self, set: u64) {
        self.pending = self.pending & !set | self.asserted();
    }

    /// Interrupts whose line is high and that are not being handled.
    fn asserted(&self) -> u64 {
        u64::from(self.lines) << IRQ0 & !self.active
    }

    /// Changes the levels of the interrupt inputs; returns whether anything became pending: a line
    /// that rises, or that is high while its interrupt is not being handled.
    pub fn set_lines(&mut self, levels: u32) -> bool {
        let rising = u64::from(levels & !self.lines) << IRQ0;
        self.lines = levels;
        self.pend(rising | self.asserted())
    }

    /// The exception is handled from now on.
    pub fn activate(&mut self, number: u32) {
        self.pending &= !(1 << number);
        self.active |= 1 << number;
    }

    /// The exception has been handled; returns whether a line that is still high makes it pending
    /// again.
    pub fn deactivate(&mut self, number: u32) -> bool {
        self.active &= !(1 << number);
        self.pend(self.asserted())
    }

    pub fn enabled_interrupts(&self) -> u32 {
        (self.enabled >> IRQ0) as u32
    }

    pub fn pending_interrupts(&self) -> u32 {
        (self.pending >> IRQ0) as u32
    }

    pub fn enable_interrupts(&mut self, set: u32) {
        self.enabled |= u64::from(set) << IRQ0;
    }

    pub fn disable_interrupts(&mut self, set: u32) {
        self.enabled &= !(u64::from(set) << IRQ0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_priorities_go_by_number() {
        let mut nvic = Nvic::new();
        nvic.enable_interrupts(!0);
        nvic.set_priority_byte(IRQ0 + 7, 64);
        nvic.set_priority_byte(IRQ0 + 9, 64);
        nvic.set_priority_byte(IRQ0 + 3, 128);
        assert!(nvic.pend(1 << (IRQ0 + 9) | 1 << (IRQ0 + 7) | 1 << (IRQ0 + 3)));
        assert_eq!(nvic.highest_pending(), Some((IRQ0 + 7, 64)));
        nvic.pend(1 << HARD_FAULT);
        assert_eq!(nvic.highest_pending(), Some((HARD_FAULT, -1)));
        nvic.pend(1 << NMI);
        assert_eq!(nvic.highest_pending(), Some((NMI, -2)));
    }

    #[test]
    fn a_high_line_pends_again_after_its_handler_and_cannot_be_cleared() {
        let mut nvic = Nvic::new();
        assert!(nvic.set_lines(1 << 4));
        nvic.unpend(1 << (IRQ0 + 4));
        assert!(nvic.is_pending(IRQ0 + 4), "the level still asks");
        nvic.activate(IRQ0 + 4);
        assert!(!nvic.set_lines(1 << 4), "no edge while active");
        assert!(!nvic.is_pending(IRQ0 + 4));
        assert!(nvic.deactivate(IRQ0 + 4));
        assert!(nvic.is_pending(IRQ0 + 4));
        nvic.activate(IRQ0 + 4);
        nvic.set_lines(0);
        assert!(nvic.set_lines(1 << 4), "an edge while active is remembered");
        nvic.set_lines(0);
        nvic.unpend(1 << (IRQ0 + 4));
        assert!(!nvic.deactivate(IRQ0 + 4));
    }
}
