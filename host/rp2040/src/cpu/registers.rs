//! The registers of the programmers' model: R0 to R15 with two stack pointers, APSR, IPSR, EPSR,
//! PRIMASK and CONTROL (architecture manual, section B1.4).

/// Number of the stack pointer in use.
pub const SP: usize = 13;
/// Number of the link register.
pub const LR: usize = 14;
/// Number of the program counter.
pub const PC: usize = 15;

/// The condition flags, APSR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Negative.
    pub n: bool,
    /// Zero.
    pub z: bool,
    /// Carry, or no borrow.
    pub c: bool,
    /// Signed overflow.
    pub v: bool,
}

impl Flags {
    /// From bits 31 to 28 of a program status register.
    #[inline(always)]
    pub const fn from_psr(psr: u32) -> Self {
        Self {
            n: psr >> 31 & 1 != 0,
            z: psr >> 30 & 1 != 0,
            c: psr >> 29 & 1 != 0,
            v: psr >> 28 & 1 != 0,
        }
    }

    /// As bits 31 to 28 of a program status register.
    #[inline(always)]
    pub const fn to_psr(self) -> u32 {
        (self.n as u32) << 31
            | (self.z as u32) << 30
            | (self.c as u32) << 29
            | (self.v as u32) << 28
    }

    #[inline(always)]
    pub(super) fn set_nz(&mut self, result: u32) {
        self.n = result >> 31 != 0;
        self.z = result == 0;
    }
}

/// The registers of the core.
#[derive(Clone, Debug)]
pub struct Registers {
    /// R0 to R12, the stack pointer in use, LR, and what R15 reads as in the instruction under
    /// execution: its address + 4.
    pub(super) r: [u32; 16],
    /// The stack pointer not in use.
    pub(super) other_sp: u32,
    /// Address of the next instruction.
    pub(super) next: u32,
    pub(super) flags: Flags,
    /// EPSR.T. There is only Thumb state: an instruction without it faults.
    pub(super) thumb: bool,
    /// IPSR: the number of the exception being handled, 0 in Thread mode.
    pub(super) ipsr: u32,
    pub(super) primask: bool,
    /// CONTROL.nPRIV: Thread mode is unprivileged.
    pub(super) unprivileged: bool,
    /// CONTROL.SPSEL: Thread mode uses the process stack.
    pub(super) process_stack: bool,
}

impl Registers {
    /// All zero but the link register, in Thumb state, Thread mode, privileged.
    pub(super) const fn new() -> Self {
        let mut r = [0; 16];
        r[LR] = u32::MAX;
        Self {
            r,
            other_sp: 0,
            next: 0,
            flags: Flags {
                n: false,
                z: false,
                c: false,
                v: false,
            },
            thumb: true,
            ipsr: 0,
            primask: false,
            unprivileged: false,
            process_stack: false,
        }
    }

    /// R0 to R14; 15 gives the address of the next instruction.
    ///
    /// # Panics
    /// There are registers 0 to 15 only.
    pub const fn get(&self, number: usize) -> u32 {
        if number == PC {
            self.next
        } else {
            self.r[number]
        }
    }

    /// Sets R0 to R14 (stack pointers are multiples of 4), or with 15 the address of the next
    /// instruction (even).
    ///
    /// # Panics
    /// There are registers 0 to 15 only.
    pub const fn set(&mut self, number: usize, value: u32) {
        match number {
            PC => self.next = value & !1,
            SP => self.r[SP] = value & !3,
            _ => self.r[number] = value,
        }
    }

    /// The condition flags.
    pub const fn flags(&self) -> Flags {
        self.flags
    }

    /// Sets the condition flags.
    pub const fn set_flags(&mut self, flags: Flags) {
        self.flags = flags;
    }

    /// XPSR: APSR, IPSR and EPSR in one word.
    pub const fn xpsr(&self) -> u32 {
        self.flags.to_psr() | (self.thumb as u32) << 24 | self.ipsr
    }

    /// The number of the exception being handled, 0 in Thread mode.
    pub const fn ipsr(&self) -> u32 {
        self.ipsr
    }

    /// Whether the core is in Handler mode.
    #[inline(always)]
    pub const fn handler_mode(&self) -> bool {
        self.ipsr != 0
    }

    /// Whether code has access to everything: in Handler mode, or if CONTROL.nPRIV is 0.
    #[inline(always)]
    pub const fn privileged(&self) -> bool {
        !self.unprivileged || self.handler_mode()
    }

    /// Whether R13 is the process stack pointer at present.
    pub const fn uses_process_stack(&self) -> bool {
        self.process_stack && !self.handler_mode()
    }

    /// The main stack pointer.
    pub const fn msp(&self) -> u32 {
        if self.uses_process_stack() {
            self.other_sp
        } else {
            self.r[SP]
        }
    }

    /// The process stack pointer.
    pub const fn psp(&self) -> u32 {
        if self.uses_process_stack() {
            self.r[SP]
        } else {
            self.other_sp
        }
    }

    /// Sets the main stack pointer, to a multiple of 4.
    pub const fn set_msp(&mut self, value: u32) {
        let bank = if self.uses_process_stack() {
            &mut self.other_sp
        } else {
            &mut self.r[SP]
        };
        *bank = value & !3;
    }

    /// Sets the process stack pointer, to a multiple of 4.
    pub const fn set_psp(&mut self, value: u32) {
        let bank = if self.uses_process_stack() {
            &mut self.r[SP]
        } else {
            &mut self.other_sp
        };
        *bank = value & !3;
    }

    /// PRIMASK.
    pub const fn primask(&self) -> bool {
        self.primask
    }

    /// Sets PRIMASK.
    pub const fn set_primask(&mut self, masked: bool) {
        self.primask = masked;
    }

    /// CONTROL: nPRIV in bit 0, SPSEL in bit 1.
    pub const fn control(&self) -> u32 {
        self.unprivileged as u32 | (self.process_stack as u32) << 1
    }

    /// Sets CONTROL as MSR does: SPSEL does not change in Handler mode.
    pub const fn set_control(&mut self, value: u32) {
        self.unprivileged = value & 1 != 0;
        if !self.handler_mode() {
            self.change_mode(0, value & 2 != 0);
        }
    }

    /// Changes to Handler mode for an exception, or to Thread mode for 0, with SPSEL as given;
    /// R13 becomes the stack pointer that goes with it.
    pub(super) const fn change_mode(&mut self, ipsr: u32, process_stack: bool) {
        let before = self.uses_process_stack();
        self.ipsr = ipsr;
        self.process_stack = process_stack;
        if before != self.uses_process_stack() {
            let other = self.other_sp;
            self.other_sp = self.r[SP];
            self.r[SP] = other;
        }
    }

    /// BranchTo().
    #[inline(always)]
    pub(super) const fn branch_to(&mut self, address: u32) {
        self.next = address & !1;
    }

    /// Writes R0 to R14 where an instruction may name SP, whose low two bits are always 0.
    #[inline(always)]
    pub(super) const fn write(&mut self, number: usize, value: u32) {
        let mask = if number == SP { !3 } else { !0 };
        self.r[number & 15] = value & mask;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_mode_sees_its_own_stack_pointer() {
        let mut registers = Registers::new();
        registers.set_msp(0x103);
        registers.set_psp(0x207);
        assert_eq!(
            (registers.get(SP), registers.msp(), registers.psp()),
            (0x100, 0x100, 0x204)
        );
        registers.set_control(2);
        assert_eq!(
            (registers.get(SP), registers.msp(), registers.psp()),
            (0x204, 0x100, 0x204)
        );
        registers.change_mode(11, false);
        assert_eq!((registers.get(SP), registers.control()), (0x100, 0));
        registers.set_control(3);
        assert_eq!(
            registers.control(),
            1,
            "SPSEL cannot be set in Handler mode"
        );
        registers.change_mode(0, true);
        assert_eq!((registers.get(SP), registers.control()), (0x204, 3));
        registers.set_msp(0x110);
        registers.set_psp(0x210);
        assert_eq!((registers.msp(), registers.psp()), (0x110, 0x210));
    }

    #[test]
    fn flags_keep_their_places() {
        for psr in 0..16 {
            assert_eq!(Flags::from_psr(psr << 28).to_psr(), psr << 28);
        }
        assert!(Flags::from_psr(1 << 31).n && Flags::from_psr(1 << 28).v);
        assert!(Flags::from_psr(1 << 30).z && Flags::from_psr(1 << 29).c);
    }
}
