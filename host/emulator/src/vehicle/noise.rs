//! Chance that does not depend on when anybody looks: a number for each moment, drawn by hashing.

/// One of the things that chance decides about a vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub(super) enum Use {
    /// How a range sensor differs from its data sheet.
    SensorSpread = 1,
    /// How long a range sensor's measurement takes.
    SensorPeriod,
    /// What a measurement of a range sensor errs by.
    SensorNoise,
    /// What a conversion of a range sensor's voltage errs by.
    Ripple,
    /// What a bearing errs by.
    Compass,
    /// What a compass that sends garbage sends.
    Garbage,
    /// How much a side's wheels slip.
    Slip,
}

/// The chance of one use, of one of several like parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise(u64);

impl Noise {
    /// The chance of part number `part`.
    pub(super) fn new(seed: u64, of: Use, part: usize) -> Self {
        Self(mixed(
            mixed(seed).wrapping_add((of as u64) << 32 | part as u64),
        ))
    }

    /// 64 bits that belong to moment `when`.
    pub(super) fn bits(self, when: u64) -> u64 {
        mixed(self.0.wrapping_add(when.wrapping_mul(GOLDEN)))
    }

    /// Uniform in [-1, 1).
    pub(super) fn uniform(self, when: u64) -> f64 {
        part(self.bits(when), 0, 32) / 2_147_483_648.0 - 1.0
    }

    /// Near to normal, of mean 0 and variance 1, always within +-3.5: the sum of four uniforms.
    pub(super) fn normal(self, when: u64) -> f64 {
        let bits = self.bits(when);
        let sum: f64 = (0..4).map(|i| part(bits, 16 * i, 16)).sum();
        // A uniform of width 1 has the variance 1/12.
        (sum / 65_536.0 - 2.0 + 2.0 / 65_536.0) * 3f64.sqrt()
    }
}

/// 2^64 over the golden ratio: multiples of it lie evenly.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// `width` bits from bit `at`, as a number.
fn part(bits: u64, at: u32, width: u32) -> f64 {
    ((bits >> at) & ((1 << width) - 1)) as f64
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014): every bit of the input changes half of
/// the output's.
fn mixed(bits: u64) -> u64 {
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_have_the_moments_they_are_named_for() {
        let noise = Noise::new(1, Use::Compass, 0);
        let moments = |draw: &dyn Fn(u64) -> f64| {
            let draws: Vec<f64> = (0..100_000).map(draw).collect();
            let mean = draws.iter().sum::<f64>() / 1e5;
            let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 1e5;
            let next: f64 = draws.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 1e5;
            (mean, variance, next)
        };
        let (mean, variance, next) = moments(&|i| noise.normal(i));
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02 && next.abs() < 0.02);
        let (mean, variance, next) = moments(&|i| noise.uniform(i));
        assert!(mean.abs() < 0.01 && (variance - 1.0 / 3.0).abs() < 0.01 && next.abs() < 0.02);
    }

    #[test]
    fn parts_uses_and_seeds_have_chances_of_their_own() {
        let first = Noise::new(1, Use::Ripple, 0).bits(5);
        assert_eq!(first, Noise::new(1, Use::Ripple, 0).bits(5));
        for other in [
            Noise::new(2, Use::Ripple, 0).bits(5),
            Noise::new(1, Use::Ripple, 1).bits(5),
            Noise::new(1, Use::Slip, 0).bits(5),
            Noise::new(1, Use::Ripple, 0).bits(6),
        ] {
            assert!((16..=48).contains(&(first ^ other).count_ones()));
        }
    }
}
