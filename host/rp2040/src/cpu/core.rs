//! The core: its state, and one step of it.

use super::bus::{Bus, BusFault};
use super::fault::{Executed, FaultCause, FaultReport, Trap};
use super::nvic::exception::{self, IRQ0};
use super::registers::{PC, Registers};
use super::system::System;
use super::systick::Clock;

/// What the core is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Executing instructions.
    Running,
    /// Asleep in WFE.
    WaitingForEvent,
    /// Asleep in WFI, or after the last exception with SLEEPONEXIT.
    WaitingForInterrupt,
    /// A fault occurred where no HardFault can be taken.
    Lockup,
}

/// The processor core.
#[derive(Clone, Debug)]
pub struct Core {
    pub(super) registers: Registers,
    pub(super) system: System,
    pub(super) activity: Activity,
    /// Where the load or store that is faulting went.
    pub(super) fault_address: Option<u32>,
    pub(super) fault: Option<FaultReport>,
}

impl Default for Core {
    fn default() -> Self {
        Self::new()
    }
}

impl Core {
    /// A core that was not reset yet: registers zero, running from address 0.
    pub const fn new() -> Self {
        Self {
            registers: Registers::new(),
            system: System::new(),
            activity: Activity::Running,
            fault_address: None,
            fault: None,
        }
    }

    /// TakeReset(): everything to its reset value, then stack pointer and start address from the
    /// vector table. That is at 0 in hardware; another address stands for a boot loader that has
    /// set VTOR and gone on from there.
    pub fn reset<B: Bus>(&mut self, bus: &mut B, vector_table: u32) {
        *self = Self::new();
        self.system.vector_table = vector_table;
        let vectors = [
            bus.read32(vector_table),
            bus.read32(vector_table.wrapping_add(4)),
        ];
        if let [Ok(stack), Ok(start)] = vectors {
            self.registers.set_msp(stack);
            self.registers.thumb = start & 1 != 0;
            self.registers.branch_to(start);
        } else {
            let cause = FaultCause::VectorRead;
            self.fault = Some(FaultReport {
                cause,
                instruction: 0,
                address: None,
            });
            self.activity = Activity::Lockup;
        }
    }

    /// Executes one instruction, or takes one exception; returns the cycles that took, which SysTick
    /// has counted. 0 if the core sleeps on, is locked up, or waits for a
    /// [reset that it asked for](Self::take_reset_request).
    #[inline]
    pub fn step<B: Bus>(&mut self, bus: &mut B) -> u32 {
        if self.sleeping() {
            return 0;
        }
        self.step_awake(bus)
    }

    /// [`step`](Self::step) of a core that is not [`sleeping`](Self::sleeping). When the core falls
    /// asleep it takes one more step of no cycles to notice.
    #[inline(never)]
    pub(crate) fn step_awake<B: Bus>(&mut self, bus: &mut B) -> u32 {
        debug_assert!(!self.sleeping());
        if self.system.attention
            && let Some(cycles) = self.attend(bus)
        {
            self.system.tick(Clock::Processor, u64::from(cycles));
            return cycles;
        }
        let cycles = if self.registers.thumb {
            self.step_plain(bus)
        } else {
            let cause = FaultCause::NotThumb;
            self.trap(bus, self.registers.next, Trap::Fault(cause))
        };
        self.system.tick(Clock::Processor, u64::from(cycles));
        cycles
    }

    /// Whether [`step_plain`](Self::step_plain) is all there is to a step, which whatever ends it
    /// shows by [attention](Self::has_attention).
    pub(crate) fn is_plain(&self) -> bool {
        self.registers.thumb && self.system.systick.clock() != Some(Clock::Processor)
    }

    /// Whether there is something to see to before the next instruction.
    #[inline(always)]
    pub(crate) fn has_attention(&self) -> bool {
        self.system.attention
    }

    /// Executes one instruction and nothing else, for the loop in which a machine spends its time.
    #[inline(always)]
    pub(crate) fn step_plain<B: Bus>(&mut self, bus: &mut B) -> u32 {
        let address = self.registers.next;
        match self.execute_at(bus, address) {
            Ok(cycles) => cycles,
            Err(trap) => self.trap(bus, address, trap),
        }
    }

    #[inline(always)]
    fn execute_at<B: Bus>(&mut self, bus: &mut B, address: u32) -> Executed {
        let op = bus
            .fetch(address)
            .map_err(|BusFault| Trap::Fault(FaultCause::Fetch))?;
        self.registers.r[PC] = address.wrapping_add(4);
        self.registers.next = address.wrapping_add(2);
        self.execute(bus, op)
    }

    pub(super) fn sleep(&mut self, activity: Activity) {
        self.activity = activity;
        self.system.attention = true;
    }

    /// Lets cycles pass in which the core does nothing: it sleeps, or waits for the bus.
    pub fn idle(&mut self, cycles: u64) {
        self.system.tick(Clock::Processor, cycles);
    }

    /// Lets SysTick count ticks of the external reference clock, if it is set to.
    pub fn tick_reference(&mut self, ticks: u64) {
        self.system.tick(Clock::Reference, ticks);
    }

    /// Cycles until SysTick makes its exception pending; `None` if it does not by itself.
    pub fn cycles_to_systick(&self) -> Option<u64> {
        self.ticks_to_systick(Clock::Processor)
    }

    /// Ticks of the reference clock until SysTick makes its exception pending; `None` if it does
    /// not by itself.
    pub fn reference_ticks_to_systick(&self) -> Option<u64> {
        self.ticks_to_systick(Clock::Reference)
    }

    fn ticks_to_systick(&self, clock: Clock) -> Option<u64> {
        let systick = &self.system.systick;
        let counts = systick.clock() == Some(clock) && systick.interrupts();
        counts
            .then(|| systick.ticks_to_zero())
            .flatten()
            .map(u64::from)
    }

    /// Sets the levels of the 32 interrupt inputs.
    pub fn set_interrupt_lines(&mut self, levels: u32) {
        self.system.set_interrupt_lines(levels);
    }

    /// Makes an exception pending, as an edge on its input does.
    ///
    /// # Panics
    /// There are exceptions 2 to 47 only.
    pub fn pend(&mut self, number: u32) {
        assert!(
            (exception::NMI..IRQ0 + 32).contains(&number),
            "no exception {number}"
        );
        self.system.pend(number);
    }

    /// Sets the event register, as SEV on another core does.
    pub fn set_event(&mut self) {
        self.system.set_event();
    }

    /// What the core is doing.
    pub fn activity(&self) -> Activity {
        self.activity
    }

    /// Whether the core sleeps (or is locked up) and nothing that could wake it has happened since
    /// its last step.
    #[inline]
    pub fn sleeping(&self) -> bool {
        self.activity != Activity::Running && !self.system.attention
    }

    /// Whether sleep is deep sleep (SCR.SLEEPDEEP).
    pub fn sleep_deep(&self) -> bool {
        self.system.sleep_deep()
    }

    /// Whether SYSRESETREQ was written since this was last asked.
    pub fn take_reset_request(&mut self) -> bool {
        std::mem::take(&mut self.system.reset_requested)
    }

    /// The last fault, if any.
    pub fn fault(&self) -> Option<FaultReport> {
        self.fault
    }

    /// The vector table's address, VTOR.
    pub fn vector_table(&self) -> u32 {
        self.system.vector_table
    }

    /// Address of the next instruction.
    #[inline]
    pub fn pc(&self) -> u32 {
        self.registers.next
    }

    /// The registers.
    pub fn registers(&self) -> &Registers {
        &self.registers
    }

    /// The registers, for a debugger or boot loader to change.
    pub fn registers_mut(&mut self) -> &mut Registers {
        self.system.attention = true;
        &mut self.registers
    }
}
