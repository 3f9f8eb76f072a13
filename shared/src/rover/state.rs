//! The parts of a rover's state.

use super::observation::Observation;
use crate::contract::{ChannelHealth, CompassHealth, State};
use crate::controller::StepRecord;
use crate::sensing::Sample;
use crate::sensing::ir::CHANNELS;
use crate::time::Instant;

/// Who a rover is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The board's name, at most [`NAME_BYTES`](crate::wire::message::NAME_BYTES) long.
    pub board: &'static str,
    /// The firmware's version, at most [`NAME_BYTES`](crate::wire::message::NAME_BYTES) long.
    pub firmware: &'static str,
}

/// State of the conversation with the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Conversation {
    /// No hello yet.
    Closed,
    /// Both sides were built from the same contract.
    Open,
    /// They were not.
    Mismatch,
}

/// What the rover does.
pub(super) enum Activity {
    /// No move; the next may begin at this time.
    Resting { until: Instant },
    /// The move of an action.
    Acting(Cycle),
    /// A move commanded by the host.
    Driven,
}

/// An action cycle whose move is under way.
pub(super) struct Cycle {
    pub(super) observation: Observation,
    pub(super) sample: Sample,
    pub(super) step: StepRecord,
}

/// What was last reported, to report changes.
pub(super) struct Reported {
    pub(super) state: State,
    pub(super) ranges: [ChannelHealth; CHANNELS],
    pub(super) compass: CompassHealth,
}

/// What is to be written to the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Save {
    /// [`Rover::knowledge_bytes`](super::Rover::knowledge_bytes).
    Knowledge,
    /// [`Rover::calibrations`](super::Rover::calibrations).
    Calibrations,
}

/// What is to be saved, and what is being saved.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Saving {
    /// The knowledge has changed by learning since it was last saved.
    pub(super) knowledge: bool,
    /// The calibrations have changed since they were last saved.
    pub(super) calibrations: bool,
    /// Permission to write was given: a write is under way, or to begin.
    pub(super) granted: Option<Save>,
}
