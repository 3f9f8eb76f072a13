//! What a bad cable does to bytes.

use rand_core::Rng as _;
use rand_pcg::Pcg32;

/// Most bytes of one burst.
const BURST: u32 = 40;
/// Of so many frames one loses its end.
const TRUNCATED_OF: u32 = 3;

/// What makes random bytes and cuts frames short.
#[derive(Clone, Debug)]
pub struct Garbler {
    rng: Pcg32,
    /// The frame under way loses the rest of its bytes, its end included.
    truncating: bool,
}

impl Garbler {
    /// One that is drawn from `seed`.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self {
            rng: Pcg32::new(seed, stream),
            truncating: false,
        }
    }

    fn below(&mut self, limit: u32) -> u32 {
        ((u64::from(self.rng.next_u32()) * u64::from(limit)) >> 32) as u32
    }

    /// A burst of random bytes, zeros (which end frames) among them.
    pub fn burst(&mut self) -> Vec<u8> {
        let length = 1 + self.below(BURST);
        (0..length)
            .map(|_| match self.below(8) {
                0 => 0,
                _ => self.rng.next_u32() as u8,
            })
            .collect()
    }

    /// Cuts the ends off some of the frames in `bytes`, which continue those of the last call.
    pub fn truncate(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut kept = Vec::with_capacity(bytes.len());
        for byte in bytes {
            if !self.truncating {
                kept.push(*byte);
            }
            if *byte == 0 {
                // The frame that follows: cut within its first bytes, or not at all.
                self.truncating = false;
            } else if !self.truncating && self.below(TRUNCATED_OF * 16) == 0 {
                self.truncating = true;
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bursts_are_short_and_end_frames_at_times() {
        let mut garbler = Garbler::new(1, 1);
        let bursts: Vec<_> = (0..1_000).map(|_| garbler.burst()).collect();
        assert!(bursts.iter().all(|burst| (1..=40).contains(&burst.len())));
        let all: Vec<u8> = bursts.concat();
        let zeros = all.iter().filter(|byte| **byte == 0).count();
        assert!(zeros * 16 > all.len() && zeros * 4 < all.len());
    }

    #[test]
    fn some_frames_lose_their_ends_and_others_none() {
        let mut garbler = Garbler::new(1, 1);
        let frame = [1, 2, 3, 4, 5, 6, 7, 8, 9, 0];
        let kept = garbler.truncate(&frame.repeat(1_000));
        let whole = kept.split(|byte| *byte == 0).filter(|f| *f == &frame[..9]);
        let whole = whole.count();
        assert!((500..950).contains(&whole), "{whole} whole frames");
        assert!(kept.len() < 10_000);
    }
}
