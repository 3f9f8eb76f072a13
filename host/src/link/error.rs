//! Why a command was not carried out, or a connection not made.

use rover_shared::wire::Mismatch;
use rover_shared::wire::message::{Command, Refusal};

use super::{PortError, explain};

/// Why a command was not carried out, or a connection not made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The port failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The rover speaks, but not our protocol.
    #[error("{port}: {mismatch}")]
    Mismatch {
        /// The port.
        port: String,
        /// What differs.
        mismatch: Mismatch,
    },
    /// Nothing that answers like a rover is there.
    #[error(
        "{0}: nothing there answers as a rover does: check that its firmware runs, and that \
         --port names the rover"
    )]
    NoAnswer(String),
    /// The rover did not answer a command.
    #[error("the rover did not answer to `{0}` in time: check the cable, or reset the rover")]
    Silent(&'static str),
    /// The rover refused.
    #[error("the rover refused to {command}: {}", explain(*.refusal))]
    Refused {
        /// The command, as a verb.
        command: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// What came of a transfer is not what was sent.
    #[error("the rover's knowledge could not be transferred: {0}: try again")]
    Transfer(&'static str),
}

/// A command as a verb, for sentences.
pub fn name_of(command: &Command) -> &'static str {
    match command {
        Command::Hello { .. } => "be introduced",
        Command::Ping => "answer",
        Command::Heartbeat => "take a heartbeat",
        Command::Arm => "arm",
        Command::Disarm => "disarm",
        Command::SetMode(_) => "change its mode",
        Command::SetTask(_) => "change its task",
        Command::SetDirection(_) => "change its direction",
        Command::Drive { .. } => "move",
        Command::SetSeed(_) => "change its seed",
        Command::Calibrate(_) => "be calibrated",
        Command::ReadStatus => "tell its state",
        Command::PullKnowledge { .. } => "hand out its knowledge",
        Command::PushKnowledge(_) => "take knowledge",
        Command::StoreKnowledge => "store its knowledge",
        Command::NewKnowledge => "forget its knowledge",
    }
}
