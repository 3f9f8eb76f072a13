//! The rover without its hardware: observations and commands in, wheel commands and reports out.
//!
//! ```text
//!              at rest for SETTLE, then
//!   resting ─────────────────────────────► acting: sense, learn, perceive, choose; turn, advance
//!      ▲                                      │
//!      └────────── the move ended ────────────┘  one ActionRecord
//! ```
//!
//! [`Rover::step`] is called every [`PERIOD`], [`Rover::handle`] for every command. Whether the
//! motors may run is decided by the [supervisor](crate::supervisor), which is asked and informed
//! through [`Supervision`] and gates the wheels' command.
//!
//! A **session** lasts from the moment the controller begins to drive until it stops. It begins
//! with an event that names its seed and the knowledge it starts from, and every interruption of
//! the learning is visible in the reports
//! ([`EventKind::Direction`](crate::wire::message::EventKind::Direction), and outcomes for which
//! [`interrupts`] holds): together with the action records this replays to the same bits.

mod command;
mod cycle;
mod knowledge;
mod observation;
mod rule;
mod staging;
mod state;
mod supervision;

pub use observation::Observation;
pub use rule::{RoverKnowledge, Rule};
pub use staging::{MOST_BYTES, Staging};
pub use state::{Identity, Save};
pub use supervision::{Supervision, View};

use crate::calibration::Calibrations;
use crate::contract::{ChannelHealth, CompassHealth, Mode, Outcome, State, Task};
use crate::controller::Controller;
use crate::learning;
use crate::motion::Motion;
use crate::parameters::Coefficients;
use crate::random::Generator;
use crate::sensing::ir::CHANNELS;
use crate::sensing::ir::curve::RangeCurve;
use crate::time::{Duration, Instant};
use crate::units::Microdegrees;
use state::{Activity, Conversation, Reported, Saving};

/// How often [`Rover::step`] is to be called: the compass's period.
pub const PERIOD: Duration = Duration::from_millis(20);

/// How long the wheels rest before the next sample: three periods of the range sensors (38 ms +-
/// 10) and of the compass's average, so that neither still contains readings of the move.
pub const SETTLE: Duration = Duration::from_millis(150);

/// Streams of the session's seed beside the controller's.
const DIRECTION_STREAM: u64 = 2;
const NEXT_SEED_STREAM: u64 = 3;

/// Whether a move's end hides what the action led to, because something else decided where the
/// rover ended up. Then nothing is learned from it.
pub const fn interrupts(outcome: Outcome) -> bool {
    match outcome {
        Outcome::Completed | Outcome::Obstacle | Outcome::NoProgress => false,
        Outcome::TurnTimeout | Outcome::CompassLost | Outcome::Late | Outcome::Stopped => true,
    }
}

/// All of a rover that can be computed.
pub struct Rover<'k> {
    coefficients: &'k Coefficients,
    controller: Controller<'k, Rule>,
    staging: &'k mut Staging,
    motion: Motion,
    calibrations: Calibrations,
    identity: Identity,
    /// Whether the knowledge can be used.
    valid: bool,
    /// The seed of this session, or of the next one between sessions.
    seed: u64,
    /// The seed was set since the last session began.
    chosen: bool,
    /// Draws directions.
    chance: Generator,
    task: Task,
    direction: Microdegrees,
    /// The direction was changed since the last sample.
    redirected: bool,
    /// Who drove at the last step.
    mode: Mode,
    activity: Activity,
    /// Action cycles since the start.
    steps: u32,
    conversation: Conversation,
    saving: Saving,
    reported: Reported,
}

impl<'k> Rover<'k> {
    /// A rover at rest, with empty knowledge: [load](Self::load) some, or [begin](Self::begin).
    /// `curve` and `motion` hold until they are calibrated.
    pub fn new(
        coefficients: &'k Coefficients,
        knowledge: &'k mut RoverKnowledge,
        staging: &'k mut Staging,
        (curve, motion): (RangeCurve, Motion),
        identity: Identity,
        seed: u64,
    ) -> Self {
        let rng = Generator::new(seed);
        let mode = learning::Mode::Run;
        Self {
            coefficients,
            controller: Controller::new(coefficients, Rule::default(), knowledge, rng, mode),
            staging,
            calibrations: Calibrations::new(curve, *motion.parameters()),
            motion,
            identity,
            valid: false,
            seed,
            chosen: false,
            chance: Generator::with_stream(seed, DIRECTION_STREAM),
            task: Task::FollowDirection,
            direction: Microdegrees(0),
            redirected: false,
            mode: Mode::Idle,
            activity: Activity::Resting { until: Instant(0) },
            steps: 0,
            conversation: Conversation::Closed,
            saving: Saving::default(),
            reported: Reported {
                state: State::Disarmed,
                ranges: [ChannelHealth::Unknown; CHANNELS],
                compass: CompassHealth::Unknown,
            },
        }
    }

    /// The calibrations in force.
    pub fn calibrations(&self) -> &Calibrations {
        &self.calibrations
    }
}

#[cfg(test)]
mod tests;
