//! Exception entry and return (B1.5.6 to B1.5.8), faults and lockup (B1.5.13 to B1.5.15).
//!
//! An entry or return is one step. So an exception that arrives during the stacking for another is
//! taken right after it, before the first instruction of the other's handler, by an entry of its
//! own: a late arrival in effect, but with two frames on the stack where the hardware makes one.
//! Only the HardFault that stacking itself causes replaces the exception in its frame. A return
//! with an exception pending goes straight to that one, as the hardware does (tail-chaining).

use super::bus::{Bus, BusFault};
use super::core::{Activity, Core};
use super::fault::{Executed, FaultCause, FaultReport, Trap};
use super::nvic::exception::{HARD_FAULT, NMI, SVCALL};
use super::registers::{Flags, LR, Registers, SP};

/// Cycles from the end of an instruction to the first of the handler, by the Technical Reference
/// Manual's interrupt latency without wait states.
const ENTRY_CYCLES: u32 = 15;
/// Not in the manual: a branch (2) and what a POP of as many words with PC takes (3 + 8).
const RETURN_CYCLES: u32 = 13;
/// Not in the manual: what remains of return and entry without their 16 transfers (13 + 15 - 16).
const TAIL_CHAIN_CYCLES: u32 = 12;

/// Bytes of a stack frame: R0 to R3, R12, LR, return address, XPSR.
const FRAME_SIZE: u32 = 0x20;
/// Bit of the stacked XPSR: the frame was aligned to 8 bytes by 4 more.
const FRAME_ALIGN_SHIFT: u32 = 9;
/// IPSR in an XPSR.
const IPSR_MASK: u32 = 0x3f;
/// Where the program counter stands in lockup.
const LOCKUP_ADDRESS: u32 = 0xffff_fffe;

/// The values that return from an exception.
mod exc_return {
    /// To Handler mode.
    pub const HANDLER: u32 = 0xffff_fff1;
    /// To Thread mode, frame on the main stack.
    pub const THREAD_MAIN: u32 = 0xffff_fff9;
    /// To Thread mode, frame on the process stack.
    pub const THREAD_PROCESS: u32 = 0xffff_fffd;
}

impl Core {
    /// ExecutionPriority(): that of the active exceptions, at least 0 under PRIMASK.
    pub(super) fn execution_priority(&self) -> i32 {
        let active = self.system.nvic.active_priority();
        if self.registers.primask {
            active.min(0)
        } else {
            active
        }
    }

    /// Before an instruction: wakes the core if it is time, and takes the exception that is due.
    /// Returns the cycles if there is no instruction to be executed in this step.
    #[inline(never)]
    pub(super) fn attend<B: Bus>(&mut self, bus: &mut B) -> Option<u32> {
        // It goes no further until its owner has seen what it asked for.
        if self.system.reset_requested {
            return Some(0);
        }
        self.system.attention = false;
        let pending = self.system.nvic.highest_pending();
        let due = pending.filter(|&(_, priority)| priority < self.execution_priority());
        let awake = match self.activity {
            Activity::Running => true,
            Activity::WaitingForEvent => due.is_some() || std::mem::take(&mut self.system.event),
            // PRIMASK does not keep an exception from waking the core, only from being taken.
            Activity::WaitingForInterrupt => {
                pending.is_some_and(|(_, priority)| priority < self.system.nvic.active_priority())
            }
            Activity::Lockup => due.is_some(),
        };
        if !awake {
            return Some(0);
        }
        self.activity = Activity::Running;
        let (number, _) = due?;
        Some(self.exception_entry(bus, number, self.registers.next))
    }

    /// What an instruction at `instruction` that did not complete leads to; returns the cycles.
    #[cold]
    pub(super) fn trap<B: Bus>(&mut self, bus: &mut B, instruction: u32, trap: Trap) -> u32 {
        let priority = self.execution_priority();
        let cause = match trap {
            Trap::SupervisorCall if self.system.nvic.priority(SVCALL) < priority => {
                return 1 + self.exception_entry(bus, SVCALL, self.registers.next);
            }
            Trap::SupervisorCall => FaultCause::SupervisorCall,
            Trap::Fault(cause) => cause,
        };
        let address = self.fault_address.take();
        self.fault = Some(FaultReport {
            cause,
            instruction,
            address,
        });
        if self.system.nvic.priority(HARD_FAULT) < priority {
            1 + self.exception_entry(bus, HARD_FAULT, instruction)
        } else {
            self.lock_up();
            1
        }
    }

    /// ExceptionEntry(); returns its cycles.
    fn exception_entry<B: Bus>(&mut self, bus: &mut B, number: u32, return_address: u32) -> u32 {
        let stacked = self.push_stack(bus, return_address);
        if stacked.is_ok() {
            self.exception_taken(bus, number);
            return ENTRY_CYCLES;
        }
        self.report_derived(FaultCause::Stacking);
        let hard_fault_active = self.system.nvic.is_active(HARD_FAULT);
        match number {
            HARD_FAULT => self.lock_up_in(number),
            NMI if hard_fault_active => self.lock_up_in(number),
            // The HardFault waits for the more urgent NMI.
            NMI => {
                self.system.pend(HARD_FAULT);
                self.exception_taken(bus, NMI);
            }
            // The exception waits for the more urgent HardFault.
            _ => {
                self.system.pend(number);
                self.exception_taken(bus, HARD_FAULT);
            }
        }
        ENTRY_CYCLES
    }

    fn report_derived(&mut self, cause: FaultCause) {
        let instruction = self.registers.next;
        self.fault = Some(FaultReport {
            cause,
            instruction,
            address: None,
        });
    }

    /// PushStack(): makes the frame and sets LR.
    fn push_stack<B: Bus>(&mut self, bus: &mut B, return_address: u32) -> Result<(), BusFault> {
        let Registers { r, .. } = &self.registers;
        let aligned_by_4 = r[SP] >> 2 & 1;
        let xpsr = self.registers.xpsr() | aligned_by_4 << FRAME_ALIGN_SHIFT;
        let words = [r[0], r[1], r[2], r[3], r[12], r[LR], return_address, xpsr];
        let frame = r[SP].wrapping_sub(FRAME_SIZE) & !4;
        let value = match (self.registers.handler_mode(), self.registers.process_stack) {
            (true, _) => exc_return::HANDLER,
            (false, false) => exc_return::THREAD_MAIN,
            (false, true) => exc_return::THREAD_PROCESS,
        };
        self.registers.r[SP] = frame;
        self.registers.r[LR] = value;
        for (i, word) in (0..).zip(words) {
            bus.write32(frame.wrapping_add(4 * i), word)?;
        }
        Ok(())
    }

    /// ExceptionTaken(): from the stacked state to the first instruction of the handler.
    fn exception_taken<B: Bus>(&mut self, bus: &mut B, number: u32) {
        let Ok(vector) = bus.read32(self.system.vector_table.wrapping_add(4 * number)) else {
            self.report_derived(FaultCause::VectorRead);
            if matches!(number, NMI | HARD_FAULT) {
                self.lock_up_in(number);
            } else {
                self.system.pend(number);
                self.exception_taken(bus, HARD_FAULT);
            }
            return;
        };
        self.enter_handler(number);
        self.registers.thumb = vector & 1 != 0;
        self.registers.branch_to(vector);
    }

    fn enter_handler(&mut self, number: u32) {
        self.registers.change_mode(number, false);
        self.system.nvic.activate(number);
        self.system.set_event();
    }

    /// Lockup at the priority of an exception that could not be entered.
    fn lock_up_in(&mut self, number: u32) {
        self.enter_handler(number);
        self.lock_up();
    }

    /// Nothing is left but reset, or an NMI if the core is not at its priority.
    fn lock_up(&mut self) {
        self.activity = Activity::Lockup;
        self.registers.next = LOCKUP_ADDRESS;
        self.system.attention = true;
    }

    /// ExceptionReturn(); returns its cycles. What the manual calls UNPREDICTABLE is a fault here.
    #[inline(never)]
    pub(super) fn exception_return<B: Bus>(&mut self, bus: &mut B, value: u32) -> Executed {
        let returning = self.registers.ipsr;
        let nested = self.system.nvic.active_count() > 1;
        let right_kind = match value {
            exc_return::HANDLER => nested,
            exc_return::THREAD_MAIN | exc_return::THREAD_PROCESS => !nested,
            _ => false,
        };
        if !right_kind || !self.system.nvic.is_active(returning) {
            return Err(Trap::Fault(FaultCause::ExceptionReturn));
        }
        self.system.deactivate(returning);
        let priority = self.execution_priority();
        let pending = self.system.nvic.highest_pending();
        if let Some((next, _)) = pending.filter(|&(_, urgency)| urgency < priority) {
            self.registers.r[LR] = value;
            self.exception_taken(bus, next);
            return Ok(TAIL_CHAIN_CYCLES);
        }
        if let Err(cause) = self.pop_stack(bus, value) {
            self.report_derived(cause);
            if priority <= self.system.nvic.priority(HARD_FAULT) {
                self.lock_up_in(HARD_FAULT);
            } else {
                self.registers.r[LR] = value;
                self.exception_taken(bus, HARD_FAULT);
            }
            return Ok(TAIL_CHAIN_CYCLES);
        }
        self.system.set_event();
        if !self.registers.handler_mode() && self.system.sleep_on_exit() {
            self.sleep(Activity::WaitingForInterrupt);
        }
        Ok(RETURN_CYCLES)
    }

    /// PopStack(): takes the frame back, all of it or, after a fault, nothing.
    fn pop_stack<B: Bus>(&mut self, bus: &mut B, value: u32) -> Result<(), FaultCause> {
        let process = value == exc_return::THREAD_PROCESS;
        let frame = if process {
            self.registers.psp()
        } else {
            self.registers.msp()
        };
        let mut words = [0; 8];
        for (i, word) in (0..).zip(&mut words) {
            let address = frame.wrapping_add(4 * i);
            *word = bus
                .read32(address)
                .map_err(|BusFault| FaultCause::Unstacking)?;
        }
        let [r0, r1, r2, r3, r12, lr, return_address, xpsr] = words;
        let to_handler = value == exc_return::HANDLER;
        if to_handler != (xpsr & IPSR_MASK != 0) {
            return Err(FaultCause::ExceptionReturn);
        }
        let registers = &mut self.registers;
        registers.change_mode(xpsr & IPSR_MASK, process);
        registers.r[..4].copy_from_slice(&[r0, r1, r2, r3]);
        registers.r[12] = r12;
        registers.r[LR] = lr;
        let realign = (xpsr >> FRAME_ALIGN_SHIFT & 1) << 2;
        registers.r[SP] = frame.wrapping_add(FRAME_SIZE) | realign;
        registers.flags = Flags::from_psr(xpsr);
        registers.thumb = xpsr >> 24 & 1 != 0;
        registers.branch_to(return_address);
        Ok(())
    }
}
