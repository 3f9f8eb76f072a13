//! The values that rover, host and core share: states, modes, outcomes, health, faults, refusals,
//! calibrations.
//!
//! The core uses these types itself: what the supervisor refuses with is what the host reads. They
//! travel inside the messages of [`crate::wire::message`], so the rules given there hold here: this
//! file's text is part of the schema hash, and variants are only appended.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::time::Instant;
use crate::units::{Microdegrees, Micrometres};

/// Longest text kept over a reset, in bytes.
pub const TEXT_BYTES: usize = 96;
/// Most points of a range sensor's calibration curve.
pub const CURVE_POINTS: usize = 12;

/// What the supervisor allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum State {
    /// The motors are off until armed.
    Disarmed,
    /// Armed but idle: the motors are off.
    Armed,
    /// The motors follow the mode's wheel commands.
    Driving(Mode),
    /// The motors are off until disarmed, which acknowledges the fault, and armed again.
    Faulted(Fault),
}

/// Who moves the rover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Mode {
    /// None.
    Idle,
    /// The controller, which also learns.
    Learn,
    /// The controller with what it knows, frozen.
    Run,
    /// The host, by [`Command::Drive`](crate::wire::message::Command::Drive) and heartbeats.
    Host,
}

/// The task.
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
    /// The program panicked; see [`Report::LastWords`](crate::wire::message::Report::LastWords).
    Panic,
    /// The processor took a hard fault; see
    /// [`Report::LastWords`](crate::wire::message::Report::LastWords).
    HardFault,
    /// Requested by the debugger or the program.
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
    /// The wheels were driven without progress.
    NoProgress,
    /// The turn did not come to rest at its end in time.
    TurnTimeout,
    /// There was no heading from the compass.
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
    /// Too few samples since the reset.
    Unknown,
    /// Fit for use.
    Good,
    /// At the lower rail: cable open (with the pull-down resistor), or shorted to ground.
    Open,
    /// At the upper rail: shorted to the supply.
    Shorted,
    /// The counts do not change although the rover moves.
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
    /// It answers with bearings that cannot be true.
    Implausible,
}

/// The faults, in the order of [`Counters`].
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

/// Why a command was refused.
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
    /// Distance at these counts.
    pub distance: Micrometres,
}
