//! The rover without its hardware: observations and commands in, wheel commands and reports out.
//!
//! ```text
//!              at rest for SETTLE, then
//!   resting ─────────────────────────────► acting: sense, learn, perceive, choose; turn, advance
//!      ▲                                      │
//!      └────────── the move ended ────────────┘  one ActionRecord
//! ```
//!
//! [`Rover::step`] is called every [`PERIOD`], [`Rover::handle`] for every command. What may move
//! is not decided here: the [supervisor](crate::supervisor) is asked through [`Supervision`], told
//! what happened, and has the last word over the wheels.
//!
//! A **session** lasts from the moment the controller begins to drive until it stops. It begins
//! with an event that names the seed and the knowledge it starts from, and every interruption of
//! the learning is visible in the reports ([`EventKind::Direction`], and outcomes for which
//! [`interrupts`] holds): together with the action records this replays to the same bits.

mod command;
mod cycle;
mod knowledge;
mod staging;

pub use command::Identity;
pub use knowledge::Save;
pub use staging::{MOST_BYTES, Staging};

use crate::action::motor_map::{MotorWeights, PaperRule};
use crate::calibration::Calibrations;
use crate::controller::{Controller, StepRecord};
use crate::knowledge::Knowledge;
use crate::learning;
use crate::motion::{Motion, WheelCommand};
use crate::parameters::Coefficients;
use crate::random::Generator;
use crate::sensing::Sample;
use crate::sensing::ir::curve::RangeCurve;
use crate::sensing::ir::{AdcCount, CHANNELS, IrReading};
use crate::supervisor::{Input, Supervisor};
use crate::time::{Duration, Instant};
use crate::units::{Microdegrees, Micrometres};
use crate::wire::message::{
    ChannelHealth, CompassHealth, Counters, Event, EventKind, FaultReport, Mode, Outcome, Refusal,
    Report, ResetReason, State, Task,
};

/// How often [`Rover::step`] is to be called: as often as the compass is read.
pub const PERIOD: Duration = Duration::from_millis(20);

/// How long the wheels rest before the next sample: three periods of the range sensors (38 ms +-
/// 10) and of the compass's average, so that nothing of the move is left in either.
pub const SETTLE: Duration = Duration::from_millis(150);

/// Chance, as a fraction of 2^32, that the direction to follow is redrawn before an action: 2 %,
/// some fifty actions in one direction. (IV-C says "changed at random" and no more.)
const CHANGE: u32 = (u32::MAX / 100) * 2;

/// Streams of the session's seed beside the controller's.
const DIRECTION_STREAM: u64 = 2;
const NEXT_SEED_STREAM: u64 = 3;

/// What is sensed at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observation {
    /// When the range sensors were sampled.
    pub time: Instant,
    /// The range sensors.
    pub ir: IrReading,
    /// Where the rover points, if the compass can be believed.
    pub heading: Option<Microdegrees>,
    /// Whether it can.
    pub compass: CompassHealth,
}

impl Observation {
    /// Before anything was sensed.
    pub const NOTHING: Self = Self {
        time: Instant(0),
        ir: IrReading {
            counts: [AdcCount::ZERO; CHANNELS],
            distances: [Micrometres(0); CHANNELS],
            health: [ChannelHealth::Unknown; CHANNELS],
        },
        heading: None,
        compass: CompassHealth::Unknown,
    };
}

/// What the supervisor says at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Its state.
    pub state: State,
    /// Whether the motors may run.
    pub motors_enabled: bool,
    /// How often each fault was counted.
    pub counters: Counters,
    /// Why the board last started.
    pub reset: ResetReason,
}

/// The supervisor, wherever it is kept and whoever else tells it things at the same time.
pub trait Supervision {
    /// Tells what happened now.
    ///
    /// # Errors
    /// What was asked for is refused, and why.
    fn handle(&mut self, input: Input) -> Result<(), Refusal>;

    /// What it says now.
    fn view(&mut self) -> View;

    /// The next fault to report.
    fn take_fault(&mut self) -> Option<FaultReport>;
}

/// A supervisor at hand, at this time.
impl Supervision for (Instant, &mut Supervisor) {
    fn handle(&mut self, input: Input) -> Result<(), Refusal> {
        self.1.handle(self.0, input)
    }

    fn view(&mut self) -> View {
        self.1.poll(self.0);
        View {
            state: self.1.state(),
            motors_enabled: self.1.motors_enabled(),
            counters: *self.1.counters(),
            reset: self.1.reset_reason(),
        }
    }

    fn take_fault(&mut self) -> Option<FaultReport> {
        self.1.take_fault()
    }
}

/// Whether what followed a move that ended so says nothing about the action: something else than
/// the action decided where the rover ended up. Then nothing is learned from it.
pub const fn interrupts(outcome: Outcome) -> bool {
    match outcome {
        Outcome::Completed | Outcome::Obstacle | Outcome::NoProgress => false,
        Outcome::TurnTimeout | Outcome::CompassLost | Outcome::Late | Outcome::Stopped => true,
    }
}

/// All of a rover that can be computed.
pub struct Rover<'k> {
    coefficients: &'k Coefficients,
    controller: Controller<'k, PaperRule>,
    staging: &'k mut Staging,
    motion: Motion,
    calibrations: Calibrations,
    identity: Identity,
    /// Whether the knowledge can be used.
    valid: bool,
    /// The seed of this session, or of the next while nobody drives.
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
    conversation: command::Conversation,
    saving: knowledge::Saving,
    reported: Reported,
}

/// What was last reported, to report changes.
struct Reported {
    state: State,
    ranges: [ChannelHealth; CHANNELS],
    compass: CompassHealth,
}

enum Activity {
    /// No move; the next may begin at this time.
    Resting { until: Instant },
    /// The move of an action.
    Acting(Cycle),
    /// A move that the host asked for.
    Driven,
}

/// An action cycle whose move is under way.
struct Cycle {
    observation: Observation,
    sample: Sample,
    step: StepRecord,
}

impl<'k> Rover<'k> {
    /// A rover at rest, with empty knowledge: [load](Self::load) some, or [begin](Self::begin).
    /// `curve` and `motion` hold until they are calibrated.
    pub fn new(
        coefficients: &'k Coefficients,
        knowledge: &'k mut Knowledge<MotorWeights>,
        staging: &'k mut Staging,
        (curve, motion): (RangeCurve, Motion),
        identity: Identity,
        seed: u64,
    ) -> Self {
        let rng = Generator::new(seed);
        let mode = learning::Mode::Run;
        Self {
            coefficients,
            controller: Controller::new(coefficients, PaperRule, knowledge, rng, mode),
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
            conversation: command::Conversation::Closed,
            saving: knowledge::Saving::default(),
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

    /// One control period: looks at what is sensed, moves on, and gives the wheels' command, which
    /// the supervisor's gate still has to let pass.
    pub fn step(
        &mut self,
        now: Instant,
        seen: &Observation,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) -> WheelCommand {
        let view = watch.view();
        let mode = match view.state {
            State::Driving(mode) => mode,
            _ => Mode::Idle,
        };
        if mode != self.mode {
            // Out of idleness only a host can have begun a move, which is to go on.
            if self.mode != Mode::Idle {
                self.stop(now, watch, report);
            }
            self.change_mode(now, mode, report);
        }
        if !view.motors_enabled {
            self.stop(now, watch, report);
        }
        let command = match self.mode {
            Mode::Learn | Mode::Run => self.drive(now, seen, view.motors_enabled, watch, report),
            Mode::Host => self.carry_out(now, seen, watch, report),
            Mode::Idle => WheelCommand::STOP,
        };
        self.report_changes(now, seen, watch, report);
        command
    }

    /// Reports what changed since the last step, and faults.
    fn report_changes(
        &mut self,
        now: Instant,
        seen: &Observation,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) {
        let mut tell = |kind| report(Report::Event(Event { time: now, kind }));
        let state = watch.view().state;
        if state != self.reported.state {
            self.reported.state = state;
            tell(EventKind::State(state));
        }
        let channels = (0..).zip(seen.ir.health).zip(&mut self.reported.ranges);
        for ((channel, health), before) in channels {
            if health != *before {
                *before = health;
                tell(EventKind::Range { channel, health });
            }
        }
        if seen.compass != self.reported.compass {
            self.reported.compass = seen.compass;
            tell(EventKind::Compass(seen.compass));
        }
        // One a step: a report that finds its queue full is a fault again.
        if let Some(fault) = watch.take_fault() {
            report(Report::Fault(fault));
        }
    }
}

#[cfg(test)]
mod tests;
