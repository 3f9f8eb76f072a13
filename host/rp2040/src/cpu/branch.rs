//! Branches (A5.2.3, A5.2.6, A5.3.1).

use super::arithmetic::sign_extend;
use super::bus::Bus;
use super::core::Core;
use super::decode::immediate;
use super::fault::{Executed, SINGLE_CYCLE, TAKEN_BRANCH};
use super::registers::{Flags, LR, PC};

/// BL takes a cycle more than other branches.
const BRANCH_WITH_LINK: Executed = Ok(3);

impl Core {
    /// BXWritePC(): in Handler mode an EXC_RETURN value returns from the exception, elsewhere bit 0
    /// is the new instruction set state. Returns the cycles of the branch.
    #[inline(always)]
    pub(super) fn bx_write_pc<B: Bus>(&mut self, bus: &mut B, address: u32) -> Executed {
        if address >> 28 == 0xf && self.registers.handler_mode() {
            return self.exception_return(bus, address);
        }
        self.interwork(address);
        TAKEN_BRANCH
    }

    /// Branches; bit 0 is the new instruction set state. In any but Thumb state the next instruction
    /// is a fault.
    #[inline(always)]
    fn interwork(&mut self, address: u32) {
        self.registers.branch_to(address);
        if address & 1 == 0 {
            self.registers.thumb = false;
            self.system.attention = true;
        }
    }

    /// BX T1: `BX Rm`.
    #[inline(always)]
    pub(super) fn bx_t1<B: Bus>(&mut self, bus: &mut B, op: u16) -> Executed {
        self.bx_write_pc(bus, self.registers.r[usize::from(op >> 3 & 15)])
    }

    /// BLX (register) T1: `BLX Rm`; LR gets the address of the next instruction.
    #[inline(always)]
    pub(super) fn blx_register_t1(&mut self, op: u16) -> Executed {
        let target = self.registers.r[usize::from(op >> 3 & 15)];
        self.registers.r[LR] = self.registers.next | 1;
        self.interwork(target);
        TAKEN_BRANCH
    }

    #[inline(always)]
    fn branch_by(&mut self, offset: u32) {
        self.registers
            .branch_to(self.registers.r[PC].wrapping_add(offset));
    }

    /// B T1: `B<c> label`, +-256 bytes.
    #[inline(always)]
    pub(super) fn b_t1(&mut self, op: u16) -> Executed {
        if !condition_passed(immediate(op, 8, 4), self.registers.flags) {
            return SINGLE_CYCLE;
        }
        self.branch_by(sign_extend(immediate(op, 0, 8) << 1, 9));
        TAKEN_BRANCH
    }

    /// B T2: `B label`, +-2 KB.
    #[inline(always)]
    pub(super) fn b_t2(&mut self, op: u16) -> Executed {
        self.branch_by(sign_extend(immediate(op, 0, 11) << 1, 12));
        TAKEN_BRANCH
    }

    /// BL T1: `BL label`, +-16 MB. (The J bits are inverted by the sign, as the range of the first
    /// Thumb's BL demands.)
    pub(super) fn bl_t1(&mut self, first: u16, second: u16) -> Executed {
        let sign = immediate(first, 10, 1);
        let i1 = !(immediate(second, 13, 1) ^ sign) & 1;
        let i2 = !(immediate(second, 11, 1) ^ sign) & 1;
        let high = sign << 24 | i1 << 23 | i2 << 22 | immediate(first, 0, 10) << 12;
        let offset = sign_extend(high | immediate(second, 0, 11) << 1, 25);
        self.registers.r[LR] = self.registers.next | 1;
        self.branch_by(offset);
        BRANCH_WITH_LINK
    }
}

/// ConditionPassed() for conditions 0b0000 to 0b1101 (A6.3).
#[inline(always)]
fn condition_passed(condition: u32, flags: Flags) -> bool {
    let Flags { n, z, c, v } = flags;
    let result = match condition >> 1 {
        0b000 => z,        // EQ, NE
        0b001 => c,        // CS, CC
        0b010 => n,        // MI, PL
        0b011 => v,        // VS, VC
        0b100 => c && !z,  // HI, LS
        0b101 => n == v,   // GE, LT
        _ => n == v && !z, // GT, LE
    };
    result != (condition & 1 != 0)
}
