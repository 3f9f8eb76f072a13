//! Why a command was not carried out, or a connection not made.

use rover_shared::contract::Refusal;
use rover_shared::wire::Mismatch;

use crate::port::PortError;
use crate::refusal::explain;

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
    /// Nothing there answers as a rover does.
    #[error(
        "{0}: nothing there answers as a rover does: check that its firmware runs, and that \
         --port names the rover"
    )]
    NoAnswer(String),
    /// The rover did not answer this command.
    #[error("the rover did not answer to `{0}` in time: check the cable, or reset the rover")]
    Silent(String),
    /// The rover refused.
    #[error("the rover refused `{command}`: {}", explain(*.refusal))]
    Refused {
        /// The command.
        command: String,
        /// Why.
        refusal: Refusal,
    },
    /// Knowledge could not be transferred whole.
    #[error("the rover's knowledge could not be transferred: {0}: try again")]
    Transfer(&'static str),
}
