//! Counts of the analogue-to-digital converter and their medians.

/// Channels in the order of all arrays of four.
pub const CHANNELS: usize = 4;

/// One conversion of the RP2040's ADC: 0 to 4095 counts for 0 to 3.3 V.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct AdcCount(u16);

impl AdcCount {
    /// Largest value of the 12 bit converter.
    pub const MAX: u16 = 4095;
    /// No voltage.
    pub const ZERO: Self = Self(0);

    /// A conversion's result; `None` if its error bit or an impossible bit is set.
    pub const fn new(raw: u16) -> Option<Self> {
        if raw > Self::MAX {
            None
        } else {
            Some(Self(raw))
        }
    }

    /// The number of counts.
    pub const fn get(self) -> u16 {
        self.0
    }
}

/// The median of each channel over an odd number `N` of sweeps of the converter.
///
/// The RP2040's ADC has spikes of its differential nonlinearity at the codes 512, 1536, 2560 and
/// 3584 (erratum RP2040-E11), and the sensors draw current in bursts that show on their output;
/// a median drops such outliers, a mean would not. Five sweeps are enough.
///
/// `None` if a conversion failed.
pub fn medians<const N: usize>(sweeps: &[[u16; CHANNELS]; N]) -> Option<[AdcCount; CHANNELS]> {
    const { assert!(N % 2 == 1, "an even number has no median") };
    let mut medians = [AdcCount(0); CHANNELS];
    for (channel, median) in medians.iter_mut().enumerate() {
        let mut column = [AdcCount(0); N];
        for (place, sweep) in column.iter_mut().zip(sweeps) {
            *place = AdcCount::new(sweep[channel])?;
        }
        column.sort_unstable();
        *median = column[N / 2];
    }
    Some(medians)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn counts(raw: [u16; 4]) -> [AdcCount; 4] {
        raw.map(|c| AdcCount::new(c).expect("12 bits"))
    }

    #[test]
    fn a_spike_does_not_pass_the_median() {
        let sweeps = [
            [500, 9, 1, 0],
            [512, 7, 2, 0],
            [499, 8, 3, 0],
            [501, 5, 4, 0],
            [4095, 6, 5, 0],
        ];
        assert_eq!(medians(&sweeps), Some(counts([501, 7, 3, 0])));
        let failed = [[500, 9, 1, 0x8000]];
        assert_eq!(medians(&failed), None);
    }

    proptest! {
        #[test]
        fn the_median_has_as_many_below_as_above(column in any::<[u16; 7]>()) {
            let sweeps = column.map(|c| [c & AdcCount::MAX; 4]);
            let median = medians(&sweeps).unwrap()[2].get();
            prop_assert!(sweeps.iter().filter(|s| s[2] <= median).count() >= 4);
            prop_assert!(sweeps.iter().filter(|s| s[2] >= median).count() >= 4);
        }
    }
}
