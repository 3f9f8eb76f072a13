//! Learning and testing in the simulator.
//!
//! | file | holds |
//! |---|---|
//! | `trial` | one robot in one arena until it arrives or gives up: [`run_trial`] |
//! | `pilot` | who steers: the [`Pilot`] trait, and the [`Turing`] pilot |
//! | `session` | learning from nothing over many trials: [`learn`] |
//! | `exam` | a frozen controller in arenas it has never met: [`examine_knowledge`] |
//! | `history` | how the staircases changed while learning: [`History`] |
//! | `measures` | directedness (8), means and confidence intervals |

mod baseline_pilot;
mod exam;
mod history;
mod measures;
mod pilot;
mod session;
mod trial;

pub use baseline_pilot::{BaselinePilot, teach};
pub use exam::{Exam, ExamResult, examine, examine_knowledge};
pub use history::{History, Staircases};
pub use measures::{Estimate, directedness, mean, proportion};
pub use pilot::{Event, Known, Pilot, TaskKind, Turing, Witness};
pub use session::{LearnedSession, SessionPlan, learn};
pub use trial::{Conduct, Directions, Ending, FreeHeading, Trial, run_trial};

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
