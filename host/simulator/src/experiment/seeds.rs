//! What is drawn from one seed.

use rand_pcg::Pcg32;

/// Generator streams of one seed, one for each use, so that what one use draws does not shift
/// another's: all controllers meet the same arenas. (The controller's own stream is
/// [`rover_shared::random::Generator::CONTROLLER_STREAM`].)
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// The arenas of learning trials.
    Learning = 2,
    /// The arenas of test trials.
    Testing = 3,
    /// When the direction to follow changes, and to what.
    Directions = 4,
    /// What a controller under test draws.
    Examined = 5,
}

/// The seed of the k-th of many uses of `seed`. Seeds of neighbouring sessions are neighbours;
/// what they count through must not overlap.
pub fn numbered(seed: u64, k: u64) -> u64 {
    let bytes = seed.to_le_bytes().into_iter().chain(k.to_le_bytes());
    rover_shared::random::condensed(bytes)
}

/// The generator of one use of a seed.
pub fn generator(seed: u64, stream: Stream) -> Pcg32 {
    Pcg32::new(seed, stream as u64)
}
