//! Data processing: shift, add, subtract, move, compare (A5.2.1), the register forms (A5.2.2), the
//! special forms for high registers (A5.2.3), and the extensions and reversals (A5.2.5).
//!
//! None of them can fault. Those that may write the PC take two cycles if they do, the others one.

use super::arithmetic::{add_with_carry, asr_c, lsl_c, lsr_c, ror_c, sign_extend};
use super::decode::{high_register, immediate, register};
use super::fault::{Executed, SINGLE_CYCLE, TAKEN_BRANCH};
use super::registers::{PC, Registers, SP};

type Shift = fn(u32, u32, bool) -> (u32, bool);

impl Registers {
    /// Shifts Rm by an immediate into Rd; sets N, Z and C.
    #[inline(always)]
    fn shift_immediate(&mut self, op: u16, shift: Shift, amount: u32) -> Executed {
        let (d, m) = (register(op, 0), register(op, 3));
        let (result, carry) = shift(self.r[m], amount, self.flags.c);
        self.r[d] = result;
        self.flags.set_nz(result);
        self.flags.c = carry;
        SINGLE_CYCLE
    }

    /// LSL (immediate) T1: `LSLS Rd, Rm, #imm5`. With imm5 = 0 it is MOV (register) T2,
    /// `MOVS Rd, Rm`, which keeps C.
    #[inline(always)]
    pub(super) fn lsl_immediate_t1(&mut self, op: u16) -> Executed {
        self.shift_immediate(op, lsl_c, immediate(op, 6, 5))
    }

    /// LSR (immediate) T1: `LSRS Rd, Rm, #imm5`; imm5 = 0 means 32.
    #[inline(always)]
    pub(super) fn lsr_immediate_t1(&mut self, op: u16) -> Executed {
        self.shift_immediate(op, lsr_c, one_to_32(op))
    }

    /// ASR (immediate) T1: `ASRS Rd, Rm, #imm5`; imm5 = 0 means 32.
    #[inline(always)]
    pub(super) fn asr_immediate_t1(&mut self, op: u16) -> Executed {
        self.shift_immediate(op, asr_c, one_to_32(op))
    }

    /// AddWithCarry() with all flags set.
    #[inline(always)]
    fn add_setting_flags(&mut self, x: u32, y: u32, carry_in: bool) -> u32 {
        let (result, carry, overflow) = add_with_carry(x, y, carry_in);
        self.flags.set_nz(result);
        self.flags.c = carry;
        self.flags.v = overflow;
        result
    }

    /// ADD (register) T1: `ADDS Rd, Rn, Rm`.
    #[inline(always)]
    pub(super) fn add_register_t1(&mut self, op: u16) -> Executed {
        let (d, n, m) = (register(op, 0), register(op, 3), register(op, 6));
        self.r[d] = self.add_setting_flags(self.r[n], self.r[m], false);
        SINGLE_CYCLE
    }

    /// SUB (register) T1: `SUBS Rd, Rn, Rm`.
    #[inline(always)]
    pub(super) fn sub_register_t1(&mut self, op: u16) -> Executed {
        let (d, n, m) = (register(op, 0), register(op, 3), register(op, 6));
        self.r[d] = self.add_setting_flags(self.r[n], !self.r[m], true);
        SINGLE_CYCLE
    }

    /// ADD (immediate) T1: `ADDS Rd, Rn, #imm3`.
    #[inline(always)]
    pub(super) fn add_immediate_t1(&mut self, op: u16) -> Executed {
        let (d, n) = (register(op, 0), register(op, 3));
        self.r[d] = self.add_setting_flags(self.r[n], immediate(op, 6, 3), false);
        SINGLE_CYCLE
    }

    /// SUB (immediate) T1: `SUBS Rd, Rn, #imm3`.
    #[inline(always)]
    pub(super) fn sub_immediate_t1(&mut self, op: u16) -> Executed {
        let (d, n) = (register(op, 0), register(op, 3));
        self.r[d] = self.add_setting_flags(self.r[n], !immediate(op, 6, 3), true);
        SINGLE_CYCLE
    }

    /// MOV (immediate) T1: `MOVS Rd, #imm8`.
    #[inline(always)]
    pub(super) fn mov_immediate_t1(&mut self, op: u16) -> Executed {
        let value = immediate(op, 0, 8);
        self.r[register(op, 8)] = value;
        self.flags.set_nz(value);
        SINGLE_CYCLE
    }

    /// CMP (immediate) T1: `CMP Rn, #imm8`.
    #[inline(always)]
    pub(super) fn cmp_immediate_t1(&mut self, op: u16) -> Executed {
        self.add_setting_flags(self.r[register(op, 8)], !immediate(op, 0, 8), true);
        SINGLE_CYCLE
    }

    /// ADD (immediate) T2: `ADDS Rdn, #imm8`.
    #[inline(always)]
    pub(super) fn add_immediate_t2(&mut self, op: u16) -> Executed {
        let dn = register(op, 8);
        self.r[dn] = self.add_setting_flags(self.r[dn], immediate(op, 0, 8), false);
        SINGLE_CYCLE
    }

    /// SUB (immediate) T2: `SUBS Rdn, #imm8`.
    #[inline(always)]
    pub(super) fn sub_immediate_t2(&mut self, op: u16) -> Executed {
        let dn = register(op, 8);
        self.r[dn] = self.add_setting_flags(self.r[dn], !immediate(op, 0, 8), true);
        SINGLE_CYCLE
    }

    /// Rdn = f(Rdn, Rm); sets N and Z.
    #[inline(always)]
    fn combine(&mut self, op: u16, f: impl Fn(u32, u32) -> u32) -> Executed {
        let (dn, m) = (register(op, 0), register(op, 3));
        self.r[dn] = f(self.r[dn], self.r[m]);
        self.flags.set_nz(self.r[dn]);
        SINGLE_CYCLE
    }

    /// AND (register) T1: `ANDS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn and_register_t1(&mut self, op: u16) -> Executed {
        self.combine(op, |n, m| n & m)
    }

    /// EOR (register) T1: `EORS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn eor_register_t1(&mut self, op: u16) -> Executed {
        self.combine(op, |n, m| n ^ m)
    }

    /// ORR (register) T1: `ORRS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn orr_register_t1(&mut self, op: u16) -> Executed {
        self.combine(op, |n, m| n | m)
    }

    /// MUL T1: `MULS Rdm, Rn, Rdm`, by the single-cycle multiplier.
    #[inline(always)]
    pub(super) fn mul_t1(&mut self, op: u16) -> Executed {
        self.combine(op, u32::wrapping_mul)
    }

    /// BIC (register) T1: `BICS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn bic_register_t1(&mut self, op: u16) -> Executed {
        self.combine(op, |n, m| n & !m)
    }

    /// MVN (register) T1: `MVNS Rd, Rm`.
    #[inline(always)]
    pub(super) fn mvn_register_t1(&mut self, op: u16) -> Executed {
        self.combine(op, |_, m| !m)
    }

    /// Rdn shifted by the low byte of Rm; sets N, Z and C.
    #[inline(always)]
    fn shift_register(&mut self, op: u16, shift: Shift) -> Executed {
        let (dn, m) = (register(op, 0), register(op, 3));
        let (result, carry) = shift(self.r[dn], self.r[m] & 0xff, self.flags.c);
        self.r[dn] = result;
        self.flags.set_nz(result);
        self.flags.c = carry;
        SINGLE_CYCLE
    }

    /// LSL (register) T1: `LSLS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn lsl_register_t1(&mut self, op: u16) -> Executed {
        self.shift_register(op, lsl_c)
    }

    /// LSR (register) T1: `LSRS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn lsr_register_t1(&mut self, op: u16) -> Executed {
        self.shift_register(op, lsr_c)
    }

    /// ASR (register) T1: `ASRS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn asr_register_t1(&mut self, op: u16) -> Executed {
        self.shift_register(op, asr_c)
    }

    /// ROR (register) T1: `RORS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn ror_register_t1(&mut self, op: u16) -> Executed {
        self.shift_register(op, ror_c)
    }

    /// ADC (register) T1: `ADCS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn adc_register_t1(&mut self, op: u16) -> Executed {
        let (dn, m) = (register(op, 0), register(op, 3));
        self.r[dn] = self.add_setting_flags(self.r[dn], self.r[m], self.flags.c);
        SINGLE_CYCLE
    }

    /// SBC (register) T1: `SBCS Rdn, Rm`.
    #[inline(always)]
    pub(super) fn sbc_register_t1(&mut self, op: u16) -> Executed {
        let (dn, m) = (register(op, 0), register(op, 3));
        self.r[dn] = self.add_setting_flags(self.r[dn], !self.r[m], self.flags.c);
        SINGLE_CYCLE
    }

    /// RSB (immediate) T1: `RSBS Rd, Rn, #0`.
    #[inline(always)]
    pub(super) fn rsb_immediate_t1(&mut self, op: u16) -> Executed {
        let (d, n) = (register(op, 0), register(op, 3));
        self.r[d] = self.add_setting_flags(!self.r[n], 0, true);
        SINGLE_CYCLE
    }

    /// TST (register) T1: `TST Rn, Rm`.
    #[inline(always)]
    pub(super) fn tst_register_t1(&mut self, op: u16) -> Executed {
        self.flags
            .set_nz(self.r[register(op, 0)] & self.r[register(op, 3)]);
        SINGLE_CYCLE
    }

    /// CMP (register) T1: `CMP Rn, Rm`.
    #[inline(always)]
    pub(super) fn cmp_register_t1(&mut self, op: u16) -> Executed {
        self.add_setting_flags(self.r[register(op, 0)], !self.r[register(op, 3)], true);
        SINGLE_CYCLE
    }

    /// CMN (register) T1: `CMN Rn, Rm`.
    #[inline(always)]
    pub(super) fn cmn_register_t1(&mut self, op: u16) -> Executed {
        self.add_setting_flags(self.r[register(op, 0)], self.r[register(op, 3)], false);
        SINGLE_CYCLE
    }

    /// CMP (register) T2: `CMP Rn, Rm` with a high register.
    #[inline(always)]
    pub(super) fn cmp_register_t2(&mut self, op: u16) -> Executed {
        let (n, m) = (high_register(op), usize::from(op >> 3 & 15));
        self.add_setting_flags(self.r[n], !self.r[m], true);
        SINGLE_CYCLE
    }

    /// ALUWritePC() or a register write.
    #[inline(always)]
    fn write_any(&mut self, d: usize, value: u32) -> Executed {
        if d == PC {
            self.branch_to(value);
            return TAKEN_BRANCH;
        }
        self.write(d, value);
        SINGLE_CYCLE
    }

    /// ADD (register) T2: `ADD Rdn, Rm`, any registers; also ADD (SP plus register) T1 and T2.
    #[inline(always)]
    pub(super) fn add_register_t2(&mut self, op: u16) -> Executed {
        let (dn, m) = (high_register(op), usize::from(op >> 3 & 15));
        self.write_any(dn, self.r[dn].wrapping_add(self.r[m]))
    }

    /// MOV (register) T1: `MOV Rd, Rm`, any registers; no flags.
    #[inline(always)]
    pub(super) fn mov_register_t1(&mut self, op: u16) -> Executed {
        self.write_any(high_register(op), self.r[usize::from(op >> 3 & 15)])
    }

    /// ADR T1: `ADR Rd, label`.
    #[inline(always)]
    pub(super) fn adr_t1(&mut self, op: u16) -> Executed {
        let base = self.r[PC] & !3;
        self.r[register(op, 8)] = base.wrapping_add(immediate(op, 0, 8) << 2);
        SINGLE_CYCLE
    }

    /// ADD (SP plus immediate) T1: `ADD Rd, SP, #imm8 * 4`.
    #[inline(always)]
    pub(super) fn add_sp_immediate_t1(&mut self, op: u16) -> Executed {
        self.r[register(op, 8)] = self.r[SP].wrapping_add(immediate(op, 0, 8) << 2);
        SINGLE_CYCLE
    }

    /// ADD (SP plus immediate) T2: `ADD SP, SP, #imm7 * 4`.
    #[inline(always)]
    pub(super) fn add_sp_immediate_t2(&mut self, op: u16) -> Executed {
        self.r[SP] = self.r[SP].wrapping_add(immediate(op, 0, 7) << 2);
        SINGLE_CYCLE
    }

    /// SUB (SP minus immediate) T1: `SUB SP, SP, #imm7 * 4`.
    #[inline(always)]
    pub(super) fn sub_sp_immediate_t1(&mut self, op: u16) -> Executed {
        self.r[SP] = self.r[SP].wrapping_sub(immediate(op, 0, 7) << 2);
        SINGLE_CYCLE
    }

    /// Rd = f(Rm); no flags.
    #[inline(always)]
    fn convert(&mut self, op: u16, f: impl Fn(u32) -> u32) -> Executed {
        self.r[register(op, 0)] = f(self.r[register(op, 3)]);
        SINGLE_CYCLE
    }

    /// SXTH T1: `SXTH Rd, Rm`.
    #[inline(always)]
    pub(super) fn sxth_t1(&mut self, op: u16) -> Executed {
        self.convert(op, |m| sign_extend(m, 16))
    }

    /// SXTB T1: `SXTB Rd, Rm`.
    #[inline(always)]
    pub(super) fn sxtb_t1(&mut self, op: u16) -> Executed {
        self.convert(op, |m| sign_extend(m, 8))
    }

    /// UXTH T1: `UXTH Rd, Rm`.
    #[inline(always)]
    pub(super) fn uxth_t1(&mut self, op: u16) -> Executed {
        self.convert(op, |m| m & 0xffff)
    }

    /// UXTB T1: `UXTB Rd, Rm`.
    #[inline(always)]
    pub(super) fn uxtb_t1(&mut self, op: u16) -> Executed {
        self.convert(op, |m| m & 0xff)
    }

    /// REV T1: `REV Rd, Rm`, the bytes of the word reversed.
    #[inline(always)]
    pub(super) fn rev_t1(&mut self, op: u16) -> Executed {
        self.convert(op, u32::swap_bytes)
    }

    /// REV16 T1: `REV16 Rd, Rm`, the bytes of each halfword reversed.
    #[inline(always)]
    pub(super) fn rev16_t1(&mut self, op: u16) -> Executed {
        self.convert(op, |m| m.swap_bytes().rotate_right(16))
    }

    /// REVSH T1: `REVSH Rd, Rm`, the bytes of the low halfword reversed, then sign-extended.
    #[inline(always)]
    pub(super) fn revsh_t1(&mut self, op: u16) -> Executed {
        self.convert(op, |m| sign_extend(u32::from((m as u16).swap_bytes()), 16))
    }
}

/// DecodeImmShift() of a right shift.
#[inline(always)]
fn one_to_32(op: u16) -> u32 {
    match immediate(op, 6, 5) {
        0 => 32,
        amount => amount,
    }
}
