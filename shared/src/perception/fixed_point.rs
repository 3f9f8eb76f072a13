//! Fixed-point products and quotients that round to the nearest, ties away from zero.

/// v k / 2^SHIFT, rounded to the nearest, ties away from zero.
///
/// Ties away from zero make this odd in v, so that mirrored and negated states stay exactly
/// mirrored and negated.
///
/// Requires k <= 2^(32 - SPLIT) - 2^(SHIFT - SPLIT - 1), SPLIT <= SHIFT and |v k| < 2^(31 + SPLIT),
/// so that the halves of the product, split at bit SPLIT of v, fit the 32 bits to which the
/// Cortex-M0+ multiplies.
#[inline(always)]
pub(super) fn scale<const SPLIT: u32, const SHIFT: u32>(v: i32, k: u32) -> i32 {
    if cfg!(target_pointer_width = "64") {
        scale_wide::<SHIFT>(v, k)
    } else {
        scale_split::<SPLIT, SHIFT>(v, k)
    }
}

/// [`scale`] for machines that multiply to 64 bits.
#[inline(always)]
fn scale_wide<const SHIFT: u32>(v: i32, k: u32) -> i32 {
    let v = i64::from(v);
    ((v * i64::from(k) + (1 << (SHIFT - 1)) + (v >> 63)) >> SHIFT) as i32
}

/// [`scale`] for machines that multiply to 32 bits.
#[inline(always)]
fn scale_split<const SPLIT: u32, const SHIFT: u32>(v: i32, k: u32) -> i32 {
    const { assert!(SPLIT <= SHIFT && SHIFT < 32) }
    let half = 1u32 << (SHIFT - 1);
    let negative = v as u32 >> 31;
    let low = (v as u32 & ((1 << SPLIT) - 1)) * k + half - negative;
    ((v >> SPLIT) * k as i32 + (low >> SPLIT) as i32) >> (SHIFT - SPLIT)
}

/// v / 2^shift for 0 < shift < 31, rounded to the nearest, ties away from zero.
#[inline(always)]
pub(super) fn halved(v: i32, shift: u32) -> i32 {
    (v + (1 << (shift - 1)) + (v >> 31)) >> shift
}

/// v k / 2^shift, rounded. Only for set-up: 64-bit products are slow on the board.
pub(super) fn product(v: i64, k: i64, shift: u32) -> i64 {
    rounded(v * k, shift)
}

/// v / 2^shift, rounded to the nearest, ties away from zero.
pub(super) fn rounded(v: i64, shift: u32) -> i64 {
    (v + (1 << (shift - 1)) + (v >> 63)) >> shift
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn products_round_alike_on_all_machines(
            v in -(1 << 29)..1i32 << 29,
            k in 0u32..65_536,
            wide in 0u32..131_040,
        ) {
            prop_assert_eq!(scale_split::<16, 16>(v, k), scale_wide::<16>(v, k));
            prop_assert_eq!(scale_split::<15, 19>(v, wide), scale_wide::<19>(v, wide));
            prop_assert_eq!(scale_split::<15, 21>(v, wide), scale_wide::<21>(v, wide));
        }

        #[test]
        fn products_are_rounded_and_odd(v in -(1 << 29)..1i32 << 29, k in 0u32..65_536) {
            let product = scale::<16, 16>(v, k);
            prop_assert_eq!(scale::<16, 16>(-v, k), -product);
            let exact = i64::from(v) * i64::from(k);
            prop_assert!((i64::from(product) << 16).abs_diff(exact) <= 1 << 15);
        }

        #[test]
        fn halving_is_odd(v in -(1 << 30)..1i32 << 30, shift in 1u32..8) {
            prop_assert_eq!(halved(-v, shift), -halved(v, shift));
            prop_assert!((i64::from(halved(v, shift)) << shift).abs_diff(v.into()) <= 1 << (shift - 1));
        }
    }
}
