//! Draws that several modules make.

use rand_core::Rng as _;
use rand_pcg::Pcg32;
use rover_shared::units::Microdegrees;

/// Uniform in [low, high).
pub fn uniform(rng: &mut Pcg32, low: f64, high: f64) -> f64 {
    low + (high - low) * (f64::from(rng.next_u32()) / 4_294_967_296.0)
}

/// A direction, all equally likely.
pub fn direction(rng: &mut Pcg32) -> Microdegrees {
    let turn = 2 * i64::from(Microdegrees::HALF_TURN.0);
    Microdegrees::wrapped((i64::from(rng.next_u32()) * turn) >> 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_go_all_round() {
        let mut rng = Pcg32::new(5, 5);
        let mut quarters = [0; 4];
        for _ in 0..4000 {
            let direction = direction(&mut rng).0;
            quarters[((direction + 180_000_000 - 1) / 90_000_000) as usize] += 1;
        }
        assert!(
            quarters.iter().all(|n| (850..1150).contains(n)),
            "{quarters:?}"
        );
    }
}
