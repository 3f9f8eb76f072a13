//! The System Control Space, 0xE000E000 to 0xE000EFFF: SysTick, NVIC and System Control Block as
//! memory (B3.2 to B3.4).
//!
//! Words only, privileged only; addresses without a register read as zero and ignore writes. The
//! memory protection unit and the debug registers are not there.

use super::nvic::Nvic;
use super::nvic::exception::{IRQ0, NMI, PENDSV, SVCALL, SYSTICK};
use super::systick::{Clock, SysTick};

const SYST_CSR: u32 = 0xe000_e010;
const SYST_RVR: u32 = 0xe000_e014;
const SYST_CVR: u32 = 0xe000_e018;
const NVIC_ISER: u32 = 0xe000_e100;
const NVIC_ICER: u32 = 0xe000_e180;
const NVIC_ISPR: u32 = 0xe000_e200;
const NVIC_ICPR: u32 = 0xe000_e280;
const NVIC_IPR0: u32 = 0xe000_e400;
const NVIC_IPR7: u32 = 0xe000_e41c;
const CPUID: u32 = 0xe000_ed00;
const ICSR: u32 = 0xe000_ed04;
const VTOR: u32 = 0xe000_ed08;
const AIRCR: u32 = 0xe000_ed0c;
const SCR: u32 = 0xe000_ed10;
const CCR: u32 = 0xe000_ed14;
const SHPR2: u32 = 0xe000_ed1c;
const SHPR3: u32 = 0xe000_ed20;
const SHCSR: u32 = 0xe000_ed24;

/// CPUID: ARM, Cortex-M0+ r0p1, ARMv6-M.
const CORTEX_M0_PLUS_R0P1: u32 = 0x410c_c601;
/// CCR: STKALIGN and UNALIGN_TRP, both fixed at 1.
const CONFIGURATION: u32 = 1 << 9 | 1 << 3;
/// VTOR: tables are aligned to 256 bytes.
const VTOR_MASK: u32 = !0xff;
/// AIRCR: what VECTKEY reads as.
const VECTKEYSTAT: u32 = 0xfa05 << 16;
/// AIRCR: what VECTKEY must be written as.
const VECTKEY: u32 = 0x05fa;
const SYSRESETREQ: u32 = 1 << 2;
const SLEEPONEXIT: u32 = 1 << 1;
const SLEEPDEEP: u32 = 1 << 2;
const SEVONPEND: u32 = 1 << 4;
/// SHCSR: the supervisor call is pending.
const SVCALLPENDED: u32 = 1 << 15;

/// Bits of ICSR.
mod icsr {
    pub const NMIPENDSET: u32 = 1 << 31;
    pub const PENDSVSET: u32 = 1 << 28;
    pub const PENDSVCLR: u32 = 1 << 27;
    pub const PENDSTSET: u32 = 1 << 26;
    pub const PENDSTCLR: u32 = 1 << 25;
    pub const ISRPENDING: u32 = 1 << 22;
    pub const VECTPENDING_SHIFT: u32 = 12;
}

#[inline(always)]
pub(super) const fn is_system_control_space(address: u32) -> bool {
    address >> 12 == 0xe000e
}

/// The registers of the System Control Space, and the event register.
#[derive(Clone, Debug)]
pub(super) struct System {
    pub nvic: Nvic,
    pub systick: SysTick,
    pub vector_table: u32,
    /// SLEEPONEXIT, SLEEPDEEP and SEVONPEND of SCR.
    sleep_control: u32,
    /// The event register, for WFE.
    pub event: bool,
    /// SYSRESETREQ was written.
    pub reset_requested: bool,
    /// Something changed that may make the core take an exception or wake: before the next
    /// instruction it looks.
    pub attention: bool,
}

impl System {
    pub const fn new() -> Self {
        Self {
            nvic: Nvic::new(),
            systick: SysTick::new(),
            vector_table: 0,
            sleep_control: 0,
            event: false,
            reset_requested: false,
            attention: false,
        }
    }

    pub fn sleep_on_exit(&self) -> bool {
        self.sleep_control & SLEEPONEXIT != 0
    }

    pub fn sleep_deep(&self) -> bool {
        self.sleep_control & SLEEPDEEP != 0
    }

    pub fn set_event(&mut self) {
        self.event = true;
        self.attention = true;
    }

    /// Makes an exception pending.
    pub fn pend(&mut self, number: u32) {
        let changed = self.nvic.pend(1 << number);
        self.note_pending(changed);
    }

    pub fn set_interrupt_lines(&mut self, levels: u32) {
        let changed = self.nvic.set_lines(levels);
        self.note_pending(changed);
    }

    pub fn deactivate(&mut self, number: u32) {
        let changed = self.nvic.deactivate(number);
        self.note_pending(changed);
        self.attention = true;
    }

    /// With SEVONPEND whatever becomes pending is an event.
    fn note_pending(&mut self, changed: bool) {
        if changed {
            self.attention = true;
            self.event |= self.sleep_control & SEVONPEND != 0;
        }
    }

    /// Lets `ticks` of a clock pass for SysTick, if it counts that clock.
    #[inline(always)]
    pub fn tick(&mut self, clock: Clock, ticks: u64) {
        if self.systick.clock() == Some(clock) && self.systick.count(ticks) {
            self.pend(SYSTICK);
        }
    }

    /// Reads a register; IPSR is the core's.
    pub fn read(&mut self, address: u32, ipsr: u32) -> u32 {
        match address {
            SYST_CSR => self.systick.read_control(),
            SYST_RVR => self.systick.reload(),
            SYST_CVR => self.systick.current(),
            NVIC_ISER | NVIC_ICER => self.nvic.enabled_interrupts(),
            NVIC_ISPR | NVIC_ICPR => self.nvic.pending_interrupts(),
            NVIC_IPR0..=NVIC_IPR7 => self.read_priorities(IRQ0 + (address - NVIC_IPR0)),
            CPUID => CORTEX_M0_PLUS_R0P1,
            ICSR => self.read_icsr(ipsr),
            VTOR => self.vector_table,
            AIRCR => VECTKEYSTAT,
            SCR => self.sleep_control,
            CCR => CONFIGURATION,
            SHPR2 => self.read_priorities(SVCALL - 3),
            SHPR3 => self.read_priorities(SYSTICK - 3),
            SHCSR if self.nvic.is_pending(SVCALL) => SVCALLPENDED,
            _ => 0,
        }
    }

    fn read_icsr(&self, ipsr: u32) -> u32 {
        let flag = |number, bit| if self.nvic.is_pending(number) { bit } else { 0 };
        let interrupts = self.nvic.pending_interrupts() != 0;
        let next = self.nvic.highest_pending().map_or(0, |(number, _)| number);
        flag(NMI, icsr::NMIPENDSET)
            | flag(PENDSV, icsr::PENDSVSET)
            | flag(SYSTICK, icsr::PENDSTSET)
            | if interrupts { icsr::ISRPENDING } else { 0 }
            | next << icsr::VECTPENDING_SHIFT
            | ipsr
    }

    /// Writes a register.
    pub fn write(&mut self, address: u32, value: u32) {
        match address {
            SYST_CSR => self.systick.write_control(value),
            SYST_RVR => self.systick.write_reload(value),
            SYST_CVR => self.systick.clear_current(),
            NVIC_ISER => self.nvic.enable_interrupts(value),
            NVIC_ICER => self.nvic.disable_interrupts(value),
            NVIC_ISPR => {
                let changed = self.nvic.pend(u64::from(value) << IRQ0);
                self.note_pending(changed);
            }
            NVIC_ICPR => self.nvic.unpend(u64::from(value) << IRQ0),
            NVIC_IPR0..=NVIC_IPR7 => self.write_priorities(IRQ0 + (address - NVIC_IPR0), value),
            ICSR => self.write_icsr(value),
            VTOR => self.vector_table = value & VTOR_MASK,
            AIRCR => self.reset_requested |= value >> 16 == VECTKEY && value & SYSRESETREQ != 0,
            SCR => self.sleep_control = value & (SLEEPONEXIT | SLEEPDEEP | SEVONPEND),
            SHPR2 => self.nvic.set_priority_byte(SVCALL, value.to_le_bytes()[3]),
            SHPR3 => {
                let [.., pendsv, systick] = value.to_le_bytes();
                self.nvic.set_priority_byte(PENDSV, pendsv);
                self.nvic.set_priority_byte(SYSTICK, systick);
            }
            _ => {}
        }
        self.attention = true;
    }

    fn write_icsr(&mut self, value: u32) {
        for (number, set, clear) in [
            (NMI, icsr::NMIPENDSET, 0),
            (PENDSV, icsr::PENDSVSET, icsr::PENDSVCLR),
            (SYSTICK, icsr::PENDSTSET, icsr::PENDSTCLR),
        ] {
            if value & set != 0 {
                self.pend(number);
            } else if value & clear != 0 {
                self.nvic.unpend(1 << number);
            }
        }
    }

    /// The priorities of four exceptions from `first`, a byte each.
    fn read_priorities(&self, first: u32) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|i| {
            self.nvic.priority_byte(first + i as u32)
        }))
    }

    fn write_priorities(&mut self, first: u32, value: u32) {
        for (number, byte) in (first..).zip(value.to_le_bytes()) {
            self.nvic.set_priority_byte(number, byte);
        }
    }
}
