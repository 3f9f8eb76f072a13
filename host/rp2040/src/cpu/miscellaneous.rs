//! Instructions that concern the system: special registers, barriers, hints, CPS, SVC, BKPT, UDF
//! (A5.2.5, A5.3.1, B4.2).

use super::bus::Bus;
use super::core::{Activity, Core};
use super::decode::immediate;
use super::fault::{Executed, FaultCause, SINGLE_CYCLE, Trap};
use super::registers::{Flags, Registers};

/// MRS, MSR and the barriers take three cycles.
const THREE_CYCLES: Executed = Ok(3);
/// WFE and WFI take two, sleep aside.
const WAIT: Executed = Ok(2);
/// An encoding that is not allocated.
pub(super) const UNDEFINED: Executed = Err(Trap::Fault(FaultCause::Undefined));

/// The special registers by their number SYSm.
mod sysm {
    pub const MSP: u32 = 8;
    pub const PSP: u32 = 9;
    pub const PRIMASK: u32 = 16;
    pub const CONTROL: u32 = 20;
}

impl Core {
    /// MRS T1: `MRS Rd, spec_reg`. Unprivileged code reads zero, but for APSR and CONTROL.
    pub(super) fn mrs_t1(&mut self, second: u16) -> Executed {
        let registers = &mut self.registers;
        let privileged = registers.privileged();
        let value = match immediate(second, 0, 8) {
            // EPSR reads as zero.
            xpsr @ (0..=3 | 5..=7) => xpsr_parts(registers, xpsr),
            sysm::MSP if privileged => registers.msp(),
            sysm::PSP if privileged => registers.psp(),
            sysm::PRIMASK => u32::from(privileged && registers.primask),
            sysm::CONTROL => registers.control(),
            sysm::MSP | sysm::PSP => 0,
            _ => return UNDEFINED,
        };
        registers.write(usize::from(second >> 8 & 15), value);
        THREE_CYCLES
    }

    /// MSR (register) T1: `MSR spec_reg, Rn`. Unprivileged code changes APSR only.
    pub(super) fn msr_register_t1(&mut self, first: u16, second: u16) -> Executed {
        let value = self.registers.r[usize::from(first & 15)];
        let privileged = self.registers.privileged();
        match immediate(second, 0, 8) {
            0..=3 => self.registers.flags = Flags::from_psr(value),
            5..=7 => {}
            sysm::MSP | sysm::PSP | sysm::PRIMASK | sysm::CONTROL if !privileged => {}
            sysm::MSP => self.registers.set_msp(value),
            sysm::PSP => self.registers.set_psp(value),
            sysm::PRIMASK => self.write_primask(value & 1 != 0),
            sysm::CONTROL => self.registers.set_control(value),
            _ => return UNDEFINED,
        }
        THREE_CYCLES
    }

    /// CPS T1: `CPSIE i`, `CPSID i`; nothing in unprivileged code.
    pub(super) fn cps_t1(&mut self, op: u16) -> Executed {
        // Other values of bits 3 to 0 are UNPREDICTABLE: there is nothing but PRIMASK to change.
        if op & 0b10_1111 != 0b10_0010 {
            return UNDEFINED;
        }
        if self.registers.privileged() {
            self.write_primask(op >> 4 & 1 != 0);
        }
        SINGLE_CYCLE
    }

    fn write_primask(&mut self, masked: bool) {
        self.registers.primask = masked;
        self.system.attention = true;
    }

    /// DSB, DMB, ISB T1: the core does everything in order, so they only take time.
    pub(super) fn barrier_t1(&mut self) -> Executed {
        THREE_CYCLES
    }

    /// Hints (A5.2.5): NOP, YIELD, WFE, WFI, SEV T1; those not allocated do nothing.
    pub(super) fn hint<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        if op & 0b1111 != 0 {
            return UNDEFINED; // IT, in other profiles.
        }
        match op >> 4 & 0b1111 {
            0b0010 => self.wfe_t1(),
            0b0011 => self.wfi_t1(),
            0b0100 => {
                self.system.set_event();
                bus.send_event();
                SINGLE_CYCLE
            }
            _ => SINGLE_CYCLE,
        }
    }

    /// WFE T1: uses up an event, or sleeps until there is one.
    fn wfe_t1(&mut self) -> Executed {
        if self.system.event {
            self.system.event = false;
        } else {
            self.sleep(Activity::WaitingForEvent);
        }
        WAIT
    }

    /// WFI T1: sleeps until there is an exception to take, or one that only PRIMASK masks.
    fn wfi_t1(&mut self) -> Executed {
        self.sleep(Activity::WaitingForInterrupt);
        WAIT
    }

    /// BKPT T1: `BKPT #imm8`.
    pub(super) fn bkpt_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let handled = bus.breakpoint(op as u8, &mut self.registers);
        if handled {
            SINGLE_CYCLE
        } else {
            Err(Trap::Fault(FaultCause::Breakpoint))
        }
    }

    /// SVC T1: `SVC #imm8`.
    pub(super) fn svc_t1(&mut self) -> Executed {
        Err(Trap::SupervisorCall)
    }
}

/// The parts of XPSR that SYSm 0 to 7 name: IPSR by bit 0, no APSR by bit 2.
fn xpsr_parts(registers: &Registers, sysm: u32) -> u32 {
    let ipsr = if sysm & 1 != 0 { registers.ipsr } else { 0 };
    let apsr = if sysm & 4 == 0 {
        registers.flags.to_psr()
    } else {
        0
    };
    ipsr | apsr
}
