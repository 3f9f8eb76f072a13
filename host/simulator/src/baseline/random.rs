//! Chance: what any other controller has to beat.

use rand_core::Rng as _;
use rand_pcg::Pcg32;
use rover_shared::units::Microdegrees;

use super::driver::{Driver, Observation};

/// Turns by a uniformly random angle within +-20 degrees, the range from which the paper draws the
/// actions that nothing has been learned about yet (III-A).
#[derive(Clone, Debug)]
pub struct Random {
    rng: Pcg32,
}

/// Largest turn.
const AMPLITUDE: Microdegrees = Microdegrees::from_degrees(20);

impl Random {
    /// A driver whose turns follow from `seed`.
    pub fn new(seed: u64) -> Self {
        Self {
            rng: Pcg32::new(seed, 0x72616e646f6d),
        }
    }
}

impl Driver for Random {
    fn act(&mut self, _seen: &Observation) -> Microdegrees {
        let span = 2 * u64::from(AMPLITUDE.0.unsigned_abs()) + 1;
        let draw = (u64::from(self.rng.next_u32()) * span) >> 32;
        Microdegrees(draw as i32 - AMPLITUDE.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_fill_their_range_evenly_and_follow_from_the_seed() {
        let seen = Observation::example([0; 3], 0.0);
        let draw = |seed| {
            let mut driver = Random::new(seed);
            (0..8000).map(|_| driver.act(&seen).0).collect::<Vec<_>>()
        };
        let turns = draw(1);
        let mut counts = [0; 8];
        for turn in &turns {
            assert!(turn.abs() <= AMPLITUDE.0);
            counts[((turn + AMPLITUDE.0) / 5_000_001) as usize] += 1;
        }
        assert!(counts.iter().all(|n| (850..1150).contains(n)), "{counts:?}");
        assert_eq!(turns, draw(1));
        assert_ne!(turns, draw(2));
    }
}
