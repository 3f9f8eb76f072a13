//! Executes the instruction that an encoding stands for.

use super::bus::{Bus, BusFault};
use super::core::Core;
use super::decode::{Encoding as I, decode, immediate};
use super::fault::{Executed, FaultCause, Trap};
use super::miscellaneous::UNDEFINED;

impl Core {
    /// Executes the instruction that begins with the halfword `op`; returns its cycles.
    #[inline(always)]
    pub(super) fn execute<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        let r = &mut self.registers;
        match decode(op) {
            I::LslImmediateT1 => r.lsl_immediate_t1(op),
            I::LsrImmediateT1 => r.lsr_immediate_t1(op),
            I::AsrImmediateT1 => r.asr_immediate_t1(op),
            I::AddRegisterT1 => r.add_register_t1(op),
            I::SubRegisterT1 => r.sub_register_t1(op),
            I::AddImmediateT1 => r.add_immediate_t1(op),
            I::SubImmediateT1 => r.sub_immediate_t1(op),
            I::MovImmediateT1 => r.mov_immediate_t1(op),
            I::CmpImmediateT1 => r.cmp_immediate_t1(op),
            I::AddImmediateT2 => r.add_immediate_t2(op),
            I::SubImmediateT2 => r.sub_immediate_t2(op),
            I::AndRegisterT1 => r.and_register_t1(op),
            I::EorRegisterT1 => r.eor_register_t1(op),
            I::LslRegisterT1 => r.lsl_register_t1(op),
            I::LsrRegisterT1 => r.lsr_register_t1(op),
            I::AsrRegisterT1 => r.asr_register_t1(op),
            I::AdcRegisterT1 => r.adc_register_t1(op),
            I::SbcRegisterT1 => r.sbc_register_t1(op),
            I::RorRegisterT1 => r.ror_register_t1(op),
            I::TstRegisterT1 => r.tst_register_t1(op),
            I::RsbImmediateT1 => r.rsb_immediate_t1(op),
            I::CmpRegisterT1 => r.cmp_register_t1(op),
            I::CmnRegisterT1 => r.cmn_register_t1(op),
            I::OrrRegisterT1 => r.orr_register_t1(op),
            I::MulT1 => r.mul_t1(op),
            I::BicRegisterT1 => r.bic_register_t1(op),
            I::MvnRegisterT1 => r.mvn_register_t1(op),
            I::AddRegisterT2 => r.add_register_t2(op),
            I::CmpRegisterT2 => r.cmp_register_t2(op),
            I::MovRegisterT1 => r.mov_register_t1(op),
            I::BxT1 => self.bx_t1(bus, op),
            I::BlxRegisterT1 => self.blx_register_t1(op),
            I::LdrLiteralT1 => self.ldr_literal_t1(bus, op),
            I::StrRegisterT1 => self.str_register_t1(bus, op),
            I::StrhRegisterT1 => self.strh_register_t1(bus, op),
            I::StrbRegisterT1 => self.strb_register_t1(bus, op),
            I::LdrsbRegisterT1 => self.ldrsb_register_t1(bus, op),
            I::LdrRegisterT1 => self.ldr_register_t1(bus, op),
            I::LdrhRegisterT1 => self.ldrh_register_t1(bus, op),
            I::LdrbRegisterT1 => self.ldrb_register_t1(bus, op),
            I::LdrshRegisterT1 => self.ldrsh_register_t1(bus, op),
            I::StrImmediateT1 => self.str_immediate_t1(bus, op),
            I::LdrImmediateT1 => self.ldr_immediate_t1(bus, op),
            I::StrbImmediateT1 => self.strb_immediate_t1(bus, op),
            I::LdrbImmediateT1 => self.ldrb_immediate_t1(bus, op),
            I::StrhImmediateT1 => self.strh_immediate_t1(bus, op),
            I::LdrhImmediateT1 => self.ldrh_immediate_t1(bus, op),
            I::StrImmediateT2 => self.str_immediate_t2(bus, op),
            I::LdrImmediateT2 => self.ldr_immediate_t2(bus, op),
            I::AdrT1 => r.adr_t1(op),
            I::AddSpImmediateT1 => r.add_sp_immediate_t1(op),
            I::AddSpImmediateT2 => r.add_sp_immediate_t2(op),
            I::SubSpImmediateT1 => r.sub_sp_immediate_t1(op),
            I::SxthT1 => r.sxth_t1(op),
            I::SxtbT1 => r.sxtb_t1(op),
            I::UxthT1 => r.uxth_t1(op),
            I::UxtbT1 => r.uxtb_t1(op),
            I::PushT1 => self.push_t1(bus, op),
            I::CpsT1 => self.cps_t1(op),
            I::RevT1 => r.rev_t1(op),
            I::Rev16T1 => r.rev16_t1(op),
            I::RevshT1 => r.revsh_t1(op),
            I::PopT1 => self.pop_t1(bus, op),
            I::BkptT1 => self.bkpt_t1(bus, op),
            I::Hint => self.hint(bus, op),
            I::StmT1 => self.stm_t1(bus, op),
            I::LdmT1 => self.ldm_t1(bus, op),
            I::BT1 => self.b_t1(op),
            I::SvcT1 => self.svc_t1(),
            I::BT2 => self.b_t2(op),
            I::Wide => self.execute_32_bit(bus, op),
            I::Undefined => UNDEFINED,
        }
    }

    /// Executes the 32-bit instruction that begins with `first` (A5.3): branch and miscellaneous
    /// control is all there is. 0xF7F0 to 0xF7FF before 0xA000 to 0xAFFF is UDF T2.
    #[inline(never)]
    #[allow(clippy::unusual_byte_groupings)]
    fn execute_32_bit<B: Bus>(&mut self, bus: &mut B, first: u16) -> Executed {
        let address = self.registers.next;
        let second = bus
            .fetch(address)
            .map_err(|BusFault| Trap::Fault(FaultCause::Fetch))?;
        self.registers.next = address.wrapping_add(2);
        if immediate(first, 11, 5) != 0b11110 || immediate(second, 15, 1) != 1 {
            return UNDEFINED;
        }
        match (immediate(first, 4, 7), immediate(second, 12, 3)) {
            (_, 0b101 | 0b111) => self.bl_t1(first, second),
            (0b011100_0..=0b011100_1, 0b000 | 0b010) => self.msr_register_t1(first, second),
            (0b0111011, 0b000 | 0b010) if matches!(second >> 4 & 15, 4..=6) => self.barrier_t1(),
            (0b011111_0..=0b011111_1, 0b000 | 0b010) => self.mrs_t1(second),
            _ => UNDEFINED,
        }
    }
}
