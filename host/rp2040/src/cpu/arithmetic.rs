//! The shared pseudocode functions of the architecture manual, section A2.2.

/// AddWithCarry(): the sum, the carry out, and whether the signed sum overflowed.
#[inline(always)]
pub(super) fn add_with_carry(x: u32, y: u32, carry_in: bool) -> (u32, bool, bool) {
    let unsigned_sum = u64::from(x) + u64::from(y) + u64::from(carry_in);
    let result = unsigned_sum as u32;
    let carry_out = unsigned_sum >> 32 != 0;
    let overflow = ((x ^ result) & (y ^ result)) >> 31 != 0;
    (result, carry_out, overflow)
}

/// LSL_C() for shifts of 0 to 255; a shift by 0 keeps the carry.
#[inline(always)]
pub(super) fn lsl_c(x: u32, shift: u32, carry_in: bool) -> (u32, bool) {
    match shift {
        0 => (x, carry_in),
        1..=31 => (x << shift, x >> (32 - shift) & 1 != 0),
        32 => (0, x & 1 != 0),
        _ => (0, false),
    }
}

/// LSR_C() for shifts of 0 to 255; a shift by 0 keeps the carry.
#[inline(always)]
pub(super) fn lsr_c(x: u32, shift: u32, carry_in: bool) -> (u32, bool) {
    match shift {
        0 => (x, carry_in),
        1..=31 => (x >> shift, x >> (shift - 1) & 1 != 0),
        32 => (0, x >> 31 != 0),
        _ => (0, false),
    }
}

/// ASR_C() for shifts of 0 to 255; a shift by 0 keeps the carry.
#[inline(always)]
pub(super) fn asr_c(x: u32, shift: u32, carry_in: bool) -> (u32, bool) {
    match shift {
        0 => (x, carry_in),
        1..=31 => (((x as i32) >> shift) as u32, x >> (shift - 1) & 1 != 0),
        _ => (((x as i32) >> 31) as u32, x >> 31 != 0),
    }
}

/// ROR_C() for shifts of 0 to 255; a shift by 0 keeps the carry, one by 32 only sets it.
#[inline(always)]
pub(super) fn ror_c(x: u32, shift: u32, carry_in: bool) -> (u32, bool) {
    if shift == 0 {
        return (x, carry_in);
    }
    let result = x.rotate_right(shift % 32);
    (result, result >> 31 != 0)
}

/// SignExtend() of the lowest `bits` bits.
#[inline(always)]
pub(super) const fn sign_extend(x: u32, bits: u32) -> u32 {
    (((x << (32 - bits)) as i32) >> (32 - bits)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subtraction_by_addition_sets_carry_for_no_borrow() {
        assert_eq!(add_with_carry(5, !5, true), (0, true, false));
        assert_eq!(add_with_carry(5, !6, true), (u32::MAX, false, false));
        assert_eq!(
            add_with_carry(0x8000_0000, !1, true),
            (0x7fff_ffff, true, true)
        );
        assert_eq!(
            add_with_carry(u32::MAX, u32::MAX, true),
            (u32::MAX, true, false)
        );
        assert_eq!(
            add_with_carry(0x7fff_ffff, 0, true),
            (0x8000_0000, false, true)
        );
    }

    #[test]
    fn shifts_by_the_register_width_and_beyond() {
        let x = 0x8000_0001;
        assert_eq!(lsl_c(x, 32, false), (0, true));
        assert_eq!(lsl_c(x, 33, true), (0, false));
        assert_eq!(lsr_c(x, 32, false), (0, true));
        assert_eq!(lsr_c(x, 255, true), (0, false));
        assert_eq!(asr_c(x, 32, false), (u32::MAX, true));
        assert_eq!(asr_c(x, 200, false), (u32::MAX, true));
        assert_eq!(ror_c(x, 32, false), (x, true));
        assert_eq!(ror_c(x, 33, false), (0xc000_0000, true));
        for shift in [lsl_c, lsr_c, asr_c, ror_c] {
            assert_eq!(shift(x, 0, true), (x, true));
            assert_eq!(shift(x, 0, false), (x, false));
        }
    }

    #[test]
    fn sign_extension() {
        assert_eq!(sign_extend(0x80, 8), 0xffff_ff80);
        assert_eq!(sign_extend(0x7f, 8), 0x7f);
        assert_eq!(sign_extend(0x8000, 16), 0xffff_8000);
    }
}
