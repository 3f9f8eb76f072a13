//! Everything that is said between rover and host: the contract, and nothing else.
//!
//! All types of the wire stand in this file, beside the quantities of [`crate::units`] and
//! [`crate::time`], and [`Sample`] and [`StepRecord`], which are the controller's own input and
//! output. The core uses these very types: what the supervisor refuses with is what the host
//! reads. The schema hash is computed from this file's text
//! without comments and white space, so any change here, even of an order, gives another hash;
//! then [`PROTOCOL_VERSION`] must go up too (a test insists).
//!
//! postcard writes enums as their position, so **variants are only ever appended**, and the
//! position of [`Report::Hello`] and [`Command::Hello`] stays 0.
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

use crate::controller::StepRecord;
use crate::sensing::Sample;
use crate::time::Instant;
use crate::units::{Microdegrees, Micrometres};

/// Bytes of knowledge in one chunk: with its header it fits three USB packets of 64 bytes.
pub const CHUNK_BYTES: usize = 128;
/// Longest name of a board or of a firmware version, in bytes.
pub const NAME_BYTES: usize = 24;
/// Longest text kept over a reset, in bytes.
pub const TEXT_BYTES: usize = 96;
/// Most points of a range sensor's calibration curve.
pub const CURVE_POINTS: usize = 12;

/// What the host asks for.
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
    /// Says that the host still drives; at least twice a second in [`Mode::Host`].
    Heartbeat,
    /// Allows the motors to run, if everything is well.
    Arm,
    /// Stops the motors and forbids them; acknowledges a standing fault.
    Disarm,
    /// Chooses who moves the rover.
    SetMode(Mode),
    /// Chooses what is to be learned or done.
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
    /// Forgets everything and begins with untrained knowledge; refused while armed.
    NewKnowledge,
}

/// What the rover says.
///
/// A place in a queue of reports has the size of the largest, an [`ActionRecord`]: there is no
/// heap to put it on.
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
    /// When this was so.
    pub time: Instant,
    /// What the supervisor allows.
    pub state: State,
    /// Whether wheel commands reach the motors at this moment.
    pub motors_enabled: bool,
    /// What is being done.
    pub task: Task,
    /// The direction to follow.
    pub direction: Microdegrees,
    /// Action cycles since the reset.
    pub steps: u32,
    /// Median ADC counts: front left, front right, left, right.
    #[cfg_attr(feature = "schema", schemars(inner(range(max = 4_095))))]
    pub counts: [u16; 4],
    /// What these channels' curves make of them.
    pub distances: [Micrometres; 4],
    /// Where the rover points, counter-clockwise in the compass's frame, its offset added; `None`
    /// if the compass cannot be believed.
    pub heading: Option<Microdegrees>,
    /// Health of the range sensors: front left, front right, left, right.
    pub ranges: [ChannelHealth; 4],
    /// Health of the compass.
    pub compass: CompassHealth,
    /// How often each fault has been counted since the reset.
    pub counters: Counters,
}

/// One action cycle: all that the core saw, thought, did and learned.
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
    /// What the controller made of it: percept, corners, pattern, action, and what it learned
    /// from the cycle before.
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

/// A fault at the moment it was counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FaultReport {
    /// When.
    pub time: Instant,
    /// Which.
    pub fault: Fault,
    /// How often since the reset, this time included.
    pub count: u32,
}

/// A part of the knowledge's bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Chunk {
    /// Length of the whole knowledge in bytes.
    pub total: u32,
    /// Checksum of the whole knowledge, see [`fingerprint`](super::transfer::fingerprint).
    pub fingerprint: u32,
    /// Where this part starts.
    pub offset: u32,
    /// This part's bytes.
    #[cfg_attr(feature = "schema", schemars(with = "[u8]", length(max = 128)))]
    pub data: Vec<u8, CHUNK_BYTES>,
}

/// What the supervisor allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum State {
    /// The motors are off until somebody arms.
    Disarmed,
    /// Armed, but nobody drives: the motors are off.
    Armed,
    /// The motors follow the mode's wheel commands.
    Driving(Mode),
    /// The motors are off until somebody disarms, which acknowledges the fault, and arms anew.
    Faulted(Fault),
}

/// Who moves the rover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Mode {
    /// Nobody.
    Idle,
    /// The controller, which also learns.
    Learn,
    /// The controller with what it knows, frozen.
    Run,
    /// The host, by [`Command::Drive`] and heartbeats.
    Host,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Task {
    /// Follow the direction that was set.
    FollowDirection,
    /// Follow a direction that is redrawn at random (IV-A).
    FollowChangingDirection,
    /// Aim at a target, for robots that sense one (III).
    AimAtTarget,
}

/// Why the rover last started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ResetReason {
    /// The supply came up, or its voltage had dropped.
    PowerOn,
    /// The RUN pin was pulled low.
    RunPin,
    /// A task fell silent and the watchdog was no longer fed.
    Watchdog,
    /// The program panicked; see [`Report::LastWords`].
    Panic,
    /// The processor took a hard fault; see [`Report::LastWords`].
    HardFault,
    /// The debugger or the program asked for it.
    Requested,
}

/// How a move ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Outcome {
    /// Turned and advanced as asked.
    Completed,
    /// Stopped at the hard-stop distance from an obstacle, or before a blind range sensor.
    Obstacle,
    /// The wheels were driven and nothing changed.
    NoProgress,
    /// The turn did not come to rest at its end in time.
    TurnTimeout,
    /// The compass gave no heading.
    CompassLost,
    /// The control loop came so late that its knowledge of the move was stale.
    Late,
    /// Stopped from outside.
    Stopped,
}

/// Health of a range sensor's channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ChannelHealth {
    /// Too few samples since the reset to tell.
    Unknown,
    /// Fit for use.
    Good,
    /// At the lower rail: cable open (with the pull-down resistor), or shorted to ground.
    Open,
    /// At the upper rail: shorted to the supply.
    Shorted,
    /// Not one count of change for long while moving.
    Frozen,
    /// No samples any more.
    Silent,
    /// This board has no such sensor.
    NotFitted,
}

/// Health of the compass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum CompassHealth {
    /// No bearing since the reset.
    Unknown,
    /// Fit for use.
    Good,
    /// The bus or the compass does not answer.
    Silent,
    /// It answers with what cannot be true.
    Implausible,
}

/// Everything that is counted, in the order of [`Counters`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Fault {
    /// The control loop was silent for 200 ms.
    ControlSilent,
    /// A task was silent for so long that the watchdog is left to reset the board.
    TaskSilent,
    /// A move was stopped by an obstacle at the hard-stop distance.
    Blocked,
    /// A range sensor's channel was unfit for use.
    RangeSensor,
    /// The compass was silent or implausible.
    Compass,
    /// A move made no progress.
    NoProgress,
    /// Three moves in a row made no progress.
    Stuck,
    /// The driving host's heartbeat was late (0.5 s).
    HostLate,
    /// The driving host's heartbeat was lost (2 s).
    HostLost,
    /// Arming was refused.
    ArmRefused,
    /// A write to the flash was refused, for the rover was armed.
    FlashWhileArmed,
    /// A frame was dropped.
    BadFrame,
    /// A percept did not settle at the step cap; the safe action was taken.
    Unsettled,
    /// A report was dropped, for the telemetry queue was full.
    QueueFull,
    /// A turn did not end in time.
    TurnTimeout,
    /// A move was stopped for a late control loop.
    LateStep,
    /// The I2C bus had to be freed.
    BusRecovered,
    /// An ADC conversion failed.
    AdcError,
    /// Time went backwards.
    ClockStepped,
    /// A write to the flash failed, or the flash is worn out; what it held before is in force.
    FlashFailed,
}

/// How often each [`Fault`] has been counted since the reset; they stop at the largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Counters(pub [u32; 20]);

/// Why a command was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Refusal {
    /// No `Hello` was exchanged yet.
    NoHello,
    /// Rover and host were built from different contracts.
    SchemaMismatch,
    /// This needs an armed rover.
    NotArmed,
    /// This needs a disarmed rover.
    Armed,
    /// A fault stands: disarm to acknowledge it.
    Fault(Fault),
    /// There is no valid knowledge.
    KnowledgeInvalid,
    /// A range sensor is unfit for use.
    RangeSensor {
        /// 0 to 3 for front left, front right, left, right.
        #[cfg_attr(feature = "schema", schemars(range(max = 3)))]
        channel: u8,
        /// What is wrong with it.
        health: ChannelHealth,
    },
    /// The compass is unfit for use.
    Compass(CompassHealth),
    /// The control loop does not run.
    ControlSilent,
    /// The flash is being written.
    FlashBusy,
    /// Host-driven mode needs heartbeats.
    NoHeartbeat,
    /// This needs [`Mode::Host`].
    NotHostDriven,
    /// A move is under way.
    MoveUnderWay,
    /// A value lies outside its range.
    OutOfRange,
    /// The calibration is not a falling curve.
    BadCalibration,
    /// The chunk does not continue the transfer: start again at offset 0.
    ChunkOutOfOrder,
    /// The knowledge is longer than there is room for.
    TooLong,
    /// The knowledge is damaged: its checksum does not match.
    BadChecksum,
    /// The knowledge is of another version, or does not hold what it should.
    BadKnowledge,
    /// This rover cannot do that.
    Unsupported,
}

/// A calibration.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Calibration {
    /// The curve of one range sensor.
    Range {
        /// 0 to 3 for front left, front right, left, right.
        #[cfg_attr(feature = "schema", schemars(range(max = 3)))]
        channel: u8,
        /// Counts rising, distances falling.
        #[cfg_attr(feature = "schema", schemars(with = "[CurvePoint]", length(max = 12)))]
        points: Vec<CurvePoint, CURVE_POINTS>,
    },
    /// How the compass is mounted.
    Compass {
        /// Added to the compass's counter-clockwise heading.
        offset: Microdegrees,
    },
    /// How fast the rover goes.
    Speed {
        /// Duty of a straight advance, per mille.
        duty: u16,
        /// Speed at that duty, micrometres a second.
        speed: Micrometres,
        /// Duty at which the wheels just begin to turn, per mille.
        dead_band: u16,
    },
}

/// A point of a range sensor's curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CurvePoint {
    /// ADC counts, 0 to 4095.
    pub counts: u16,
    /// Distance at which the sensor gives them.
    pub distance: Micrometres,
}
