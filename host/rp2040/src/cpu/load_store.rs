//! Loads and stores, single (A5.2.4) and multiple (LDM, STM, POP, PUSH).
//!
//! An access that faults leaves every register as it was. A multiple transfer is one step: the
//! hardware abandons it for an interrupt and starts it again later, which comes to the same, apart
//! from repeated accesses.

use super::arithmetic::sign_extend;
use super::bus::{Bus, BusFault};
use super::core::Core;
use super::decode::{immediate, register};
use super::fault::{Executed, FaultCause, Trap};
use super::registers::{LR, PC, SP};
use super::system::is_system_control_space;

impl Core {
    #[cold]
    fn data_fault(&mut self, cause: FaultCause, address: u32) -> Trap {
        self.fault_address = Some(address);
        Trap::Fault(cause)
    }

    #[inline(always)]
    fn check_alignment(&mut self, address: u32, size: u32) -> Result<(), Trap> {
        if address & (size - 1) != 0 {
            return Err(self.data_fault(FaultCause::Unaligned, address));
        }
        Ok(())
    }

    /// The System Control Space takes words only, from privileged code only.
    #[cold]
    fn check_system_access(&mut self, address: u32, size: u32) -> Result<(), Trap> {
        if size != 4 || !self.registers.privileged() {
            return Err(self.data_fault(FaultCause::Bus, address));
        }
        Ok(())
    }

    #[inline(always)]
    fn load_word<B: Bus>(&mut self, bus: &mut B, address: u32) -> Result<u32, Trap> {
        self.check_alignment(address, 4)?;
        if is_system_control_space(address) {
            self.check_system_access(address, 4)?;
            return Ok(self.system.read(address, self.registers.ipsr));
        }
        bus.read32(address)
            .map_err(|BusFault| self.data_fault(FaultCause::Bus, address))
    }

    #[inline(always)]
    fn load_halfword<B: Bus>(&mut self, bus: &mut B, address: u32) -> Result<u32, Trap> {
        self.check_alignment(address, 2)?;
        if is_system_control_space(address) {
            self.check_system_access(address, 2)?;
        }
        let value = bus.read16(address);
        value
            .map(u32::from)
            .map_err(|BusFault| self.data_fault(FaultCause::Bus, address))
    }

    #[inline(always)]
    fn load_byte<B: Bus>(&mut self, bus: &mut B, address: u32) -> Result<u32, Trap> {
        if is_system_control_space(address) {
            self.check_system_access(address, 1)?;
        }
        let value = bus.read8(address);
        value
            .map(u32::from)
            .map_err(|BusFault| self.data_fault(FaultCause::Bus, address))
    }

    #[inline(always)]
    fn store_word<B: Bus>(&mut self, bus: &mut B, address: u32, value: u32) -> Result<(), Trap> {
        self.check_alignment(address, 4)?;
        if is_system_control_space(address) {
            self.check_system_access(address, 4)?;
            self.system.write(address, value);
            return Ok(());
        }
        bus.write32(address, value)
            .map_err(|BusFault| self.data_fault(FaultCause::Bus, address))
    }

    #[inline(always)]
    fn store_halfword<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        value: u32,
    ) -> Result<(), Trap> {
        self.check_alignment(address, 2)?;
        if is_system_control_space(address) {
            self.check_system_access(address, 2)?;
        }
        let written = bus.write16(address, value as u16);
        written.map_err(|BusFault| self.data_fault(FaultCause::Bus, address))
    }

    #[inline(always)]
    fn store_byte<B: Bus>(&mut self, bus: &mut B, address: u32, value: u32) -> Result<(), Trap> {
        if is_system_control_space(address) {
            self.check_system_access(address, 1)?;
        }
        let written = bus.write8(address, value as u8);
        written.map_err(|BusFault| self.data_fault(FaultCause::Bus, address))
    }

    /// Rn + imm5 * scale.
    #[inline(always)]
    fn immediate_offset(&self, op: u16, scale: u32) -> u32 {
        self.registers.r[register(op, 3)].wrapping_add(immediate(op, 6, 5) * scale)
    }

    /// Rn + Rm.
    #[inline(always)]
    fn register_offset(&self, op: u16) -> u32 {
        self.registers.r[register(op, 3)].wrapping_add(self.registers.r[register(op, 6)])
    }

    /// SP + imm8 * 4.
    #[inline(always)]
    fn stack_offset(&self, op: u16) -> u32 {
        self.registers.r[SP].wrapping_add(immediate(op, 0, 8) << 2)
    }

    /// Rt, in bits 2 to 0.
    #[inline(always)]
    fn rt(&self, op: u16) -> u32 {
        self.registers.r[register(op, 0)]
    }

    #[inline(always)]
    fn set_rt(&mut self, op: u16, value: u32) {
        self.registers.r[register(op, 0)] = value;
    }

    /// LDR (literal) T1: `LDR Rt, [PC, #imm8 * 4]`.
    #[inline(always)]
    pub(super) fn ldr_literal_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let base = self.registers.r[PC] & !3;
        let address = base.wrapping_add(immediate(op, 0, 8) << 2);
        self.registers.r[register(op, 8)] = self.load_word(bus, address)?;
        Ok(bus.access_cycles(address))
    }

    /// LDR (immediate) T1: `LDR Rt, [Rn, #imm5 * 4]`.
    #[inline(always)]
    pub(super) fn ldr_immediate_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.immediate_offset(op, 4);
        let value = self.load_word(bus, address)?;
        self.set_rt(op, value);
        Ok(bus.access_cycles(address))
    }

    /// LDR (immediate) T2: `LDR Rt, [SP, #imm8 * 4]`.
    #[inline(always)]
    pub(super) fn ldr_immediate_t2<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.stack_offset(op);
        self.registers.r[register(op, 8)] = self.load_word(bus, address)?;
        Ok(bus.access_cycles(address))
    }

    /// LDR (register) T1: `LDR Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn ldr_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        let value = self.load_word(bus, address)?;
        self.set_rt(op, value);
        Ok(bus.access_cycles(address))
    }

    /// LDRH (immediate) T1: `LDRH Rt, [Rn, #imm5 * 2]`.
    #[inline(always)]
    pub(super) fn ldrh_immediate_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.immediate_offset(op, 2);
        let value = self.load_halfword(bus, address)?;
        self.set_rt(op, value);
        Ok(bus.access_cycles(address))
    }

    /// LDRH (register) T1: `LDRH Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn ldrh_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        let value = self.load_halfword(bus, address)?;
        self.set_rt(op, value);
        Ok(bus.access_cycles(address))
    }

    /// LDRSH (register) T1: `LDRSH Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn ldrsh_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        let value = self.load_halfword(bus, address)?;
        self.set_rt(op, sign_extend(value, 16));
        Ok(bus.access_cycles(address))
    }

    /// LDRB (immediate) T1: `LDRB Rt, [Rn, #imm5]`.
    #[inline(always)]
    pub(super) fn ldrb_immediate_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.immediate_offset(op, 1);
        let value = self.load_byte(bus, address)?;
        self.set_rt(op, value);
        Ok(bus.access_cycles(address))
    }

    /// LDRB (register) T1: `LDRB Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn ldrb_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        let value = self.load_byte(bus, address)?;
        self.set_rt(op, value);
        Ok(bus.access_cycles(address))
    }

    /// LDRSB (register) T1: `LDRSB Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn ldrsb_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        let value = self.load_byte(bus, address)?;
        self.set_rt(op, sign_extend(value, 8));
        Ok(bus.access_cycles(address))
    }

    /// STR (immediate) T1: `STR Rt, [Rn, #imm5 * 4]`.
    #[inline(always)]
    pub(super) fn str_immediate_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.immediate_offset(op, 4);
        self.store_word(bus, address, self.rt(op))?;
        Ok(bus.access_cycles(address))
    }

    /// STR (immediate) T2: `STR Rt, [SP, #imm8 * 4]`.
    #[inline(always)]
    pub(super) fn str_immediate_t2<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.stack_offset(op);
        self.store_word(bus, address, self.registers.r[register(op, 8)])?;
        Ok(bus.access_cycles(address))
    }

    /// STR (register) T1: `STR Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn str_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        self.store_word(bus, address, self.rt(op))?;
        Ok(bus.access_cycles(address))
    }

    /// STRH (immediate) T1: `STRH Rt, [Rn, #imm5 * 2]`.
    #[inline(always)]
    pub(super) fn strh_immediate_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.immediate_offset(op, 2);
        self.store_halfword(bus, address, self.rt(op))?;
        Ok(bus.access_cycles(address))
    }

    /// STRH (register) T1: `STRH Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn strh_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        self.store_halfword(bus, address, self.rt(op))?;
        Ok(bus.access_cycles(address))
    }

    /// STRB (immediate) T1: `STRB Rt, [Rn, #imm5]`.
    #[inline(always)]
    pub(super) fn strb_immediate_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.immediate_offset(op, 1);
        self.store_byte(bus, address, self.rt(op))?;
        Ok(bus.access_cycles(address))
    }

    /// STRB (register) T1: `STRB Rt, [Rn, Rm]`.
    #[inline(always)]
    pub(super) fn strb_register_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let address = self.register_offset(op);
        self.store_byte(bus, address, self.rt(op))?;
        Ok(bus.access_cycles(address))
    }

    /// LDM T1: `LDM Rn!, {registers}`, without the `!` if Rn is among them. 1 + N cycles.
    #[inline(always)]
    pub(super) fn ldm_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let (n, list) = (register(op, 8), op as u8);
        let start = self.registers.r[n];
        self.check_alignment(start, 4)?;
        let end = self.load_low_registers(bus, start, list)?;
        if list >> n & 1 == 0 {
            self.registers.r[n] = end;
        }
        Ok(multiple_cycles(bus, start, list.count_ones()))
    }

    /// STM T1: `STM Rn!, {registers}`. 1 + N cycles.
    #[inline(always)]
    pub(super) fn stm_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let (n, list) = (register(op, 8), op as u8);
        let start = self.registers.r[n];
        self.check_alignment(start, 4)?;
        self.registers.r[n] = self.store_low_registers(bus, start, list)?;
        Ok(multiple_cycles(bus, start, list.count_ones()))
    }

    /// PUSH T1: `PUSH {low registers, LR}`. 1 + N cycles.
    #[inline(always)]
    pub(super) fn push_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let count = (op & 0x1ff).count_ones();
        let start = self.registers.r[SP].wrapping_sub(4 * count);
        let end = self.store_low_registers(bus, start, op as u8)?;
        if op >> 8 & 1 != 0 {
            self.store_word(bus, end, self.registers.r[LR])?;
        }
        self.registers.r[SP] = start;
        Ok(multiple_cycles(bus, start, count))
    }

    /// POP T1: `POP {low registers, PC}`. 1 + N cycles, and those of the branch if PC is among
    /// them: 3 + N.
    #[inline(always)]
    pub(super) fn pop_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let (start, count) = (self.registers.r[SP], (op & 0x1ff).count_ones());
        let cycles = multiple_cycles(bus, start, count);
        if op >> 8 & 1 == 0 {
            self.registers.r[SP] = self.load_low_registers(bus, start, op as u8)?;
            return Ok(cycles);
        }
        // First, so that a fault here leaves the other registers as they were.
        let target = self.load_word(bus, start.wrapping_add(4 * (count - 1)))?;
        self.registers.r[SP] = self
            .load_low_registers(bus, start, op as u8)?
            .wrapping_add(4);
        Ok(cycles + self.bx_write_pc(bus, target)?)
    }

    /// Loads ascending registers from ascending words, all or none; returns the address behind them.
    #[inline(always)]
    fn load_low_registers<B: Bus>(
        &mut self,
        bus: &mut B,
        start: u32,
        list: u8,
    ) -> Result<u32, Trap> {
        let mut values = [0; 8];
        let mut address = start;
        for (i, value) in values.iter_mut().enumerate() {
            if list >> i & 1 != 0 {
                *value = self.load_word(bus, address)?;
                address = address.wrapping_add(4);
            }
        }
        for (i, value) in values.into_iter().enumerate() {
            if list >> i & 1 != 0 {
                self.registers.r[i] = value;
            }
        }
        Ok(address)
    }

    /// Stores ascending registers to ascending words; returns the address behind them.
    #[inline(always)]
    fn store_low_registers<B: Bus>(
        &mut self,
        bus: &mut B,
        start: u32,
        list: u8,
    ) -> Result<u32, Trap> {
        let mut address = start;
        for i in 0..8 {
            if list >> i & 1 != 0 {
                self.store_word(bus, address, self.registers.r[i])?;
                address = address.wrapping_add(4);
            }
        }
        Ok(address)
    }
}

/// 1 + N, at two cycles an access: all words are taken to lie on the port of the first.
#[inline(always)]
fn multiple_cycles<B: Bus>(bus: &B, start: u32, count: u32) -> u32 {
    1 + count * (bus.access_cycles(start) - 1)
}
