//! The messages between rover and host.
//!
//! They are made of the values in [`crate::contract`], the quantities in [`crate::units`] and
//! [`crate::time`], and the controller's input and output, [`Sample`] and [`StepRecord`]. The
//! schema hash covers the text of this file and of `contract.rs` without comments and white space:
//! any change, even of an order, changes it, and [`PROTOCOL_VERSION`] must go up too (a test
//! insists).
//!
//! postcard encodes a variant as its position: **variants are only appended**, and
//! [`Report::Hello`] and [`Command::Hello`] stay at position 0.
//!
//! | host to rover ([`Command`]) | the rover answers [`Report::Ack`] and |
//! |---|---|
//! | `Hello` | `Hello`; nothing else is served before it |
//! | `Ping`, `Heartbeat` | nothing more |
//! | `Arm`, `Disarm`, `SetMode`, `SetTask`, `SetDirection`, `SetSeed`, `Calibrate` | nothing more |
//! | `Drive` | a `MoveEnded` event when the move is over |
//! | `ReadStatus` | `Status` |
//! | `PullKnowledge` | `Knowledge` with the chunk at that offset |
//! | `PushKnowledge` | a `KnowledgeStored` event after the last chunk |
//! | `StoreKnowledge` | a `KnowledgeStored` event |
//! | `NewKnowledge` | nothing more |
//!
//! [`PROTOCOL_VERSION`]: super::PROTOCOL_VERSION

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use crate::contract::{
    Calibration, ChannelHealth, CompassHealth, Counters, FaultReport, Mode, Outcome, Refusal,
    ResetReason, State, TEXT_BYTES, Task,
};
use crate::controller::StepRecord;
use crate::sensing::Sample;
use crate::time::Instant;
use crate::units::{Microdegrees, Micrometres};

/// Bytes of knowledge in one chunk: with its header it fits three USB packets of 64 bytes.
pub const CHUNK_BYTES: usize = 128;
/// Longest name of a board or of a firmware version, in bytes.
pub const NAME_BYTES: usize = 24;

/// A message from the host.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Command {
    /// Opens the conversation.
    Hello {
        /// The host's [`SCHEMA_HASH`](super::SCHEMA_HASH).
        schema: u32,
    },
    /// Asks for an acknowledgement only.
    Ping,
    /// The host's heartbeat; at least twice a second in [`Mode::Host`].
    Heartbeat,
    /// Allows the motors to run, if everything is well.
    Arm,
    /// Stops the motors and forbids them; acknowledges a standing fault.
    Disarm,
    /// Selects who moves the rover.
    SetMode(Mode),
    /// Selects the task.
    SetTask(Task),
    /// The direction to follow, counter-clockwise in the compass's frame.
    SetDirection(Microdegrees),
    /// One move in [`Mode::Host`]: turn, then advance.
    Drive {
        /// Turn on the spot, positive to the left.
        turn: Microdegrees,
        /// Advance after the turn.
        advance: Micrometres,
    },
    /// Seeds the generator of the learning noise and of new phases.
    SetSeed(u64),
    /// Replaces a calibration; refused while armed.
    Calibrate(Calibration),
    /// Asks for the rover's state.
    ReadStatus,
    /// Asks for the chunk of knowledge that starts at this byte; refused while driving, since
    /// learning changes it between the chunks.
    PullKnowledge {
        /// First byte wanted, from the start of the knowledge.
        offset: u32,
    },
    /// Hands over a chunk of knowledge, in order from offset 0; refused while armed.
    PushKnowledge(Chunk),
    /// Writes what was learned to the flash; refused while armed.
    StoreKnowledge,
    /// Starts with untrained knowledge; refused while armed.
    NewKnowledge,
}

/// A message from the rover.
///
/// A slot in a queue of reports has the size of the largest, an [`ActionRecord`]: there is no heap.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Report {
    /// Opens the conversation, and follows every reset.
    Hello(Hello),
    /// The answer to one command.
    Ack(Ack),
    /// The rover's state, when asked for.
    Status(Status),
    /// One complete action cycle.
    Action(ActionRecord),
    /// Something happened.
    Event(Event),
    /// Something went wrong.
    Fault(FaultReport),
    /// A chunk of the rover's knowledge, when asked for.
    Knowledge(Chunk),
    /// What a panic or hard fault left behind before the last reset.
    #[cfg_attr(feature = "schema", schemars(with = "str"))]
    LastWords(String<TEXT_BYTES>),
}

/// Who the rover is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Hello {
    /// The rover's [`SCHEMA_HASH`](super::SCHEMA_HASH).
    pub schema: u32,
    /// The board the firmware was built for.
    #[cfg_attr(feature = "schema", schemars(with = "str"))]
    pub board: String<NAME_BYTES>,
    /// The firmware's version.
    #[cfg_attr(feature = "schema", schemars(with = "str"))]
    pub firmware: String<NAME_BYTES>,
    /// Why the rover last started.
    pub reset: ResetReason,
    /// The generator's seed.
    pub seed: u64,
    /// Fingerprint of the knowledge in use, as [`Chunk::fingerprint`]; `None` if there is none or
    /// it is damaged.
    pub knowledge: Option<u32>,
}

/// The answer to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Ack {
    /// The sequence number of the command's frame.
    pub sequence: u16,
    /// Done, or why not.
    pub result: Result<(), Refusal>,
}

/// The rover's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Status {
    /// When this was the state.
    pub time: Instant,
    /// What the supervisor allows.
    pub state: State,
    /// Whether wheel commands reach the motors at this moment.
    pub motors_enabled: bool,
    /// The task.
    pub task: Task,
    /// The direction to follow.
    pub direction: Microdegrees,
    /// Action cycles since the reset.
    pub steps: u32,
    /// Median ADC counts: front left, front right, left, right.
    #[cfg_attr(feature = "schema", schemars(inner(range(max = 4_095))))]
    pub counts: [u16; 4],
    /// The distances by these channels' curves.
    pub distances: [Micrometres; 4],
    /// The rover's heading, counter-clockwise in the compass's frame, its offset added; `None` if
    /// the compass is not good.
    pub heading: Option<Microdegrees>,
    /// Health of the range sensors: front left, front right, left, right.
    pub ranges: [ChannelHealth; 4],
    /// Health of the compass.
    pub compass: CompassHealth,
    /// How often each fault has been counted since the reset.
    pub counters: Counters,
}

/// One complete action cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ActionRecord {
    /// When the sample was taken.
    pub time: Instant,
    /// Median ADC counts: front left, front right, left, right.
    #[cfg_attr(feature = "schema", schemars(inner(range(max = 4_095))))]
    pub counts: [u16; 4],
    /// Health of these channels.
    pub ranges: [ChannelHealth; 4],
    /// Health of the compass.
    pub compass: CompassHealth,
    /// The sample in physical units.
    pub sample: Sample,
    /// The controller's record: percept, corners, pattern, action, and what it learned from the
    /// cycle before.
    pub step: StepRecord,
    /// How this cycle's move ended.
    pub outcome: Outcome,
    /// How often each fault has been counted since the reset.
    pub counters: Counters,
}

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Event {
    /// When.
    pub time: Instant,
    /// What.
    pub kind: EventKind,
}

/// The kinds of [`Event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum EventKind {
    /// The supervisor changed its state.
    State(State),
    /// A move that the host asked for is over.
    MoveEnded(Outcome),
    /// The direction to follow was redrawn.
    Direction(Microdegrees),
    /// Knowledge is in the flash, whole.
    KnowledgeStored {
        /// Its fingerprint, as [`Chunk::fingerprint`].
        fingerprint: u32,
    },
    /// A range sensor's health changed.
    Range {
        /// 0 to 3 for front left, front right, left, right.
        #[cfg_attr(feature = "schema", schemars(range(max = 3)))]
        channel: u8,
        /// The health from now on.
        health: ChannelHealth,
    },
    /// The compass's health changed.
    Compass(CompassHealth),
    /// The controller begins to drive: what is needed to replay the actions that follow.
    Session {
        /// Learning or not.
        mode: Mode,
        /// What its generator starts from.
        seed: u64,
        /// Fingerprint of the knowledge it starts from, as [`Chunk::fingerprint`].
        knowledge: u32,
    },
}

/// A part of the knowledge's bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Chunk {
    /// Length of the whole knowledge in bytes.
    pub total: u32,
    /// Checksum of the whole knowledge, see [`fingerprint`](crate::checksum::fingerprint).
    pub fingerprint: u32,
    /// Where this part starts.
    pub offset: u32,
    /// This part's bytes.
    #[cfg_attr(feature = "schema", schemars(with = "[u8]", length(max = 128)))]
    pub data: Vec<u8, CHUNK_BYTES>,
}
