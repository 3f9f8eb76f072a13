//! The only source of randomness: a seeded generator that is passed in, so that a log replays from
//! its seed to the same bits.

use rand_core::Rng as _;
use rand_pcg::Pcg32;

/// Fraction bits of [`Generator::normal`].
pub const NORMAL_FRACTION_BITS: u32 = 20;

/// Condenses noise with little entropy per byte into a seed: FNV-1a over all of it, then
/// splitmix64's finisher, so that seeds of similar noise differ in half their bits.
pub fn condensed(noise: impl IntoIterator<Item = u8>) -> u64 {
    let fnv = noise
        .into_iter()
        .fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3)
        });
    let mixed = (fnv ^ (fnv >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ (mixed >> 31)
}

/// A PCG32 generator with the distributions used here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Generator(Pcg32);

impl Generator {
    /// The stream the controller draws from. The simulator uses others, so that a controller which
    /// draws more or less often meets the same arenas.
    pub const CONTROLLER_STREAM: u64 = 1;

    /// The generator that a controller with this seed uses.
    pub fn new(seed: u64) -> Self {
        Self::with_stream(seed, Self::CONTROLLER_STREAM)
    }

    /// A generator on a stream of its own: different streams of one seed are different sequences.
    pub fn with_stream(seed: u64, stream: u64) -> Self {
        Self(Pcg32::new(seed, stream))
    }

    /// A whole number, uniform in [-amplitude, amplitude]. Amplitudes above 2^30 count as 2^30.
    ///
    /// Multiply-and-shift without rejection, which would be an unbounded loop: no value is more
    /// likely than another by more than the share span / 2^32, 1 % for phases of +-20 degrees.
    pub fn symmetric(&mut self, amplitude: u32) -> i32 {
        let amplitude = amplitude.min(1 << 30);
        let span = 2 * u64::from(amplitude) + 1;
        let offset = ((u64::from(self.0.next_u32()) * span) >> 32) as u32;
        offset as i32 - amplitude as i32
    }

    /// A normal deviate of mean 0 and variance 1 in Q20, always within +-6.
    ///
    /// The sum of twelve uniforms (Irwin-Hall): integers only, so equal on every machine; its
    /// tails are thinner than the normal's beyond about 3, which search noise does not need.
    pub fn normal(&mut self) -> i32 {
        let sum: u32 = (0..12)
            .map(|_| self.0.next_u32() >> (32 - NORMAL_FRACTION_BITS))
            .sum();
        // Each term is on average half a unit below its real value: 12 of them, 6 units.
        sum as i32 + 6 - (6 << NORMAL_FRACTION_BITS)
    }

    /// Returns the next 32 bits.
    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symmetric_covers_its_range_evenly() {
        let mut rng = Generator::new(7);
        let mut counts = [0u32; 7];
        for _ in 0..70_000 {
            counts[(rng.symmetric(3) + 3) as usize] += 1;
        }
        assert!(
            counts.iter().all(|n| n.abs_diff(10_000) < 500),
            "{counts:?}"
        );
        assert_eq!(rng.symmetric(0), 0);
    }

    #[test]
    fn normal_has_mean_zero_and_variance_one() {
        let mut rng = Generator::new(8);
        let draws: std::vec::Vec<f64> = (0..100_000)
            .map(|_| f64::from(rng.normal()) / (1 << 20) as f64)
            .collect();
        let mean = draws.iter().sum::<f64>() / 1e5;
        let variance = draws.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 1e5;
        let beyond_two = draws.iter().filter(|x| x.abs() > 2.0).count() as f64 / 1e5;
        assert!(
            mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02,
            "{mean} {variance}"
        );
        assert!((beyond_two - 0.0455).abs() < 0.004, "{beyond_two}");
    }

    #[test]
    fn one_bit_of_noise_changes_half_the_seed() {
        let mut noise = [0x55; 256];
        let first = condensed(noise);
        for i in 0..256 {
            noise[i] ^= 1;
            let changed = (condensed(noise) ^ first).count_ones();
            noise[i] ^= 1;
            assert!((12..=52).contains(&changed), "byte {i}: {changed} bits");
        }
    }

    #[test]
    fn streams_of_one_seed_differ_and_repeat() {
        let draw = |stream| Generator::with_stream(3, stream).bits();
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
    }
}
