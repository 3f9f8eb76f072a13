//! One move: turn on the spot under the compass's feedback, then advance (IV-A: the action's
//! phase and module).
//!
//! A state machine without a clock or a motor: [`Motion::start`] begins a move, [`Motion::step`] is
//! called at every control period with what is sensed and returns the wheels' command and, at the
//! end, how the move went.
//!
//! ```text
//!          start            within tolerance, settled          way done
//!  idle ──────────► turning ─────────────────────────► advancing ──────► idle, Completed
//!                      │ no compass, no progress,         │ obstacle, no compass,
//!                      │ time-out, late step              │ no progress, late step
//!                      ▼                                  ▼
//!                     idle, with the reason; whatever it is, the command is STOP
//! ```
//!
//! There are no wheel encoders: the advance is timed by a calibrated speed. A move that an
//! obstacle cuts short keeps its turn and counts as blocked, as in the simulated arena. Turning
//! is never stopped by an obstacle, for it is the way out.

mod parameters;
mod progress;
mod wheels;

pub use parameters::{ParameterError, Parameters};
pub use wheels::WheelCommand;

use crate::contract::Outcome;
use crate::sensing::ir::Ranges;
use crate::time::{Duration, Instant};
use crate::units::{Microdegrees, Micrometres};
use progress::Progress;

/// Longest advance of one move.
pub const LONGEST_ADVANCE: Micrometres = Micrometres::from_cm(100);

/// The senses that a move depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Senses {
    /// The rover's heading; `None` if the compass is not good.
    pub heading: Option<Microdegrees>,
    /// Free distances to stop by: unclipped, 0 for a sensor that is not good.
    pub clearance: Ranges,
}

/// An event of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionEvent {
    /// The turn is done, the advance begins.
    Turned,
    /// The move is over.
    Ended(Move),
}

/// How a move went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Move {
    /// How it ended.
    pub outcome: Outcome,
    /// Heading error left, by the last bearing; 0 if there was none.
    pub heading_error: Microdegrees,
    /// How far the rover should have advanced by its calibrated speed.
    pub advanced: Micrometres,
    /// Whether the rover is known to have moved: its heading or a range changed. An advance with
    /// nothing in view may be completed on wheels that spin.
    pub proven: bool,
}

/// Why a move was not started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartError {
    /// A move is under way.
    UnderWay,
    /// A turn beyond half a circle, or an advance beyond [`LONGEST_ADVANCE`].
    OutOfRange,
}

/// The state machine of moves.
#[derive(Clone, Debug)]
pub struct Motion {
    parameters: Parameters,
    phase: Phase,
    progress: Progress,
    /// Time and command of the last step of this move.
    last: Option<(Instant, WheelCommand)>,
}

#[derive(Clone, Copy, Debug)]
enum Phase {
    Idle,
    /// Waiting for the first heading.
    Starting {
        turn: Microdegrees,
        advance: Micrometres,
    },
    Turning(Turn),
    Advancing(Advance),
}

#[derive(Clone, Copy, Debug)]
struct Turn {
    target: Microdegrees,
    began: Instant,
    /// Since when the heading lies within the tolerance.
    settled: Option<Instant>,
    advance: Micrometres,
}

#[derive(Clone, Copy, Debug)]
struct Advance {
    target: Microdegrees,
    /// Way to go, in micrometre-microseconds a second, that is picometres.
    remaining: u64,
    asked: u64,
    /// Duty in millionths of a per mille, so that short control periods are not rounded away.
    duty: u32,
}

/// Picometres in a micrometre, and millionths in one.
const MILLION: u32 = 1_000_000;

impl Motion {
    /// A rover at rest.
    ///
    /// # Errors
    /// Parameters that do not fit together.
    pub const fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        match parameters.check() {
            Ok(()) => Ok(Self {
                parameters,
                phase: Phase::Idle,
                progress: Progress::new(),
                last: None,
            }),
            Err(error) => Err(error),
        }
    }

    /// The parameters in use.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Replaces the calibrated speed: `speed` a second at `duty`, nothing up to `dead_band`, both
    /// of these per mille of full duty.
    ///
    /// # Errors
    /// Numbers that do not fit together: a dead band that is not below the duty, a duty above 1000,
    /// a speed below 1 cm/s or above 1 m/s; then nothing is changed.
    pub fn calibrate_speed(
        &mut self,
        duty: u16,
        speed: Micrometres,
        dead_band: u16,
    ) -> Result<(), ParameterError> {
        let new = Parameters {
            cruise: duty,
            cruise_speed: speed,
            dead_band,
            ..self.parameters
        };
        new.check()?;
        self.parameters = new;
        Ok(())
    }

    /// Whether a move is under way.
    pub const fn under_way(&self) -> bool {
        !matches!(self.phase, Phase::Idle)
    }

    /// Begins a move with the next step: a turn by `turn` (positive to the left) from the
    /// heading found then, and an advance.
    ///
    /// # Errors
    /// See [`StartError`]; the move under way continues.
    pub fn start(&mut self, turn: Microdegrees, advance: Micrometres) -> Result<(), StartError> {
        if self.under_way() {
            return Err(StartError::UnderWay);
        }
        let half = Microdegrees::HALF_TURN.0.unsigned_abs();
        if turn.0.unsigned_abs() > half || advance > LONGEST_ADVANCE {
            return Err(StartError::OutOfRange);
        }
        self.phase = Phase::Starting { turn, advance };
        self.progress.begin_move();
        self.last = None;
        Ok(())
    }

    /// Ends the move under way, if any; the caller must command STOP from now on.
    pub fn stop(&mut self) -> Option<Move> {
        self.under_way().then(|| self.end(Outcome::Stopped, None))
    }

    /// Advances by one control period; to be called every 10 to 50 ms, moving or not.
    pub fn step(&mut self, now: Instant, senses: Senses) -> (WheelCommand, Option<MotionEvent>) {
        let (command, event) = match self.advance_state(now, senses) {
            Ok(step) => step,
            Err(outcome) => {
                let ended = self.end(outcome, senses.heading);
                (WheelCommand::STOP, Some(MotionEvent::Ended(ended)))
            }
        };
        self.last = self.under_way().then_some((now, command));
        (command, event)
    }

    /// `Err`: the move is over, completed or not.
    fn advance_state(
        &mut self,
        now: Instant,
        senses: Senses,
    ) -> Result<(WheelCommand, Option<MotionEvent>), Outcome> {
        if !self.under_way() {
            return Ok((WheelCommand::STOP, None));
        }
        let heading = senses.heading.ok_or(Outcome::CompassLost)?;
        let p = self.parameters;
        let (elapsed, before) = match self.last {
            Some((then, command)) => (now.since(then), command),
            None => (Duration::ZERO, WheelCommand::STOP),
        };
        if elapsed > p.late {
            return Err(Outcome::Late);
        }
        if before.drives() {
            let advancing = matches!(self.phase, Phase::Advancing(_));
            if self
                .progress
                .stalled(&p, elapsed, advancing, heading, senses.clearance)
            {
                return Err(Outcome::NoProgress);
            }
        }
        if let Phase::Starting { turn, advance } = self.phase {
            let target = heading.turned(turn);
            self.phase = Phase::Turning(Turn {
                target,
                began: now,
                settled: None,
                advance,
            });
            // A turn within the tolerance needs no settling: nothing has moved.
            if turn.0.abs() <= p.tolerance.0 {
                self.phase = Phase::Advancing(Advance::new(target, advance));
            } else {
                self.progress.begin_turn();
            }
        }
        match &mut self.phase {
            Phase::Turning(turn) => {
                let done = turn.step(&p, now, heading)?;
                let Some(command) = done else {
                    let advance = Advance::new(turn.target, turn.advance);
                    self.phase = Phase::Advancing(advance);
                    return Ok((WheelCommand::STOP, Some(MotionEvent::Turned)));
                };
                Ok((command, None))
            }
            Phase::Advancing(advance) => {
                Ok((advance.step(&p, elapsed, heading, senses.clearance)?, None))
            }
            Phase::Idle | Phase::Starting { .. } => Ok((WheelCommand::STOP, None)),
        }
    }

    fn end(&mut self, outcome: Outcome, heading: Option<Microdegrees>) -> Move {
        let (target, advanced) = match self.phase {
            Phase::Idle | Phase::Starting { .. } => (None, 0),
            Phase::Turning(turn) => (Some(turn.target), 0),
            Phase::Advancing(advance) => (Some(advance.target), advance.asked - advance.remaining),
        };
        self.phase = Phase::Idle;
        self.last = None;
        Move {
            outcome,
            heading_error: target
                .zip(heading)
                .map_or(Microdegrees(0), |(target, heading)| {
                    target.turn_from(heading)
                }),
            advanced: Micrometres((advanced / u64::from(MILLION)) as u32),
            proven: self.progress.proven(),
        }
    }
}

impl Turn {
    /// The command, or `None` when the turn is done.
    fn step(
        &mut self,
        p: &Parameters,
        now: Instant,
        heading: Microdegrees,
    ) -> Result<Option<WheelCommand>, Outcome> {
        if now.since(self.began) >= p.turn_timeout {
            return Err(Outcome::TurnTimeout);
        }
        let error = self.target.turn_from(heading).0;
        if error.abs() <= p.tolerance.0 {
            let since = *self.settled.get_or_insert(now);
            let done = now.since(since) >= p.settle;
            return Ok((!done).then_some(WheelCommand::STOP));
        }
        self.settled = None;
        let degrees = error.abs() / Microdegrees::PER_DEGREE;
        let duty = i32::from(p.turn_minimum) + degrees * i32::from(p.turn_gain);
        let duty = duty.min(i32::from(p.turn_maximum)) * error.signum();
        Ok(Some(WheelCommand::new(-duty, duty)))
    }
}

impl Advance {
    fn new(target: Microdegrees, way: Micrometres) -> Self {
        let asked = u64::from(way.0) * u64::from(MILLION);
        Self {
            target,
            remaining: asked,
            asked,
            duty: 0,
        }
    }

    fn step(
        &mut self,
        p: &Parameters,
        elapsed: Duration,
        heading: Microdegrees,
        clearance: Ranges,
    ) -> Result<WheelCommand, Outcome> {
        let speed = self.speed(p);
        self.remaining = self.remaining.saturating_sub(speed * elapsed.0);
        if self.remaining == 0 {
            return Err(Outcome::Completed);
        }
        if clearance.front <= p.front_stop || clearance.left.min(clearance.right) <= p.side_stop {
            return Err(Outcome::Obstacle);
        }
        // Slowing down at the ramp's rate takes half the present speed for this long; the command
        // given now holds for a period before that can begin.
        let dead_band = u32::from(p.dead_band) * MILLION;
        let cruise = u32::from(p.cruise) * MILLION;
        let braking = self.duty.saturating_sub(dead_band) / u32::from(p.ramp);
        let change = u32::from(p.ramp) * elapsed.0 as u32;
        // At a quarter of the speed the way left is short and the end is sure.
        let creep = dead_band + (cruise - dead_band) / 4;
        self.duty = if speed * (u64::from(braking) / 2 + elapsed.0) >= self.remaining {
            self.duty.saturating_sub(change).max(creep)
        } else {
            self.duty.max(dead_band).saturating_add(change).min(cruise)
        };
        let duty = (self.duty / MILLION) as i32;
        let error = self.target.turn_from(heading).0 / (Microdegrees::PER_DEGREE / 16);
        let hold = (error * i32::from(p.hold_gain) / 16).clamp(-duty / 4, duty / 4);
        Ok(WheelCommand::new(duty - hold, duty + hold))
    }

    /// Micrometres a second at the present duty.
    fn speed(&self, p: &Parameters) -> u64 {
        let dead_band = u64::from(p.dead_band) * u64::from(MILLION);
        let driven = u64::from(self.duty).saturating_sub(dead_band);
        let whole = u64::from(p.cruise - p.dead_band) * u64::from(MILLION);
        u64::from(p.cruise_speed.0) * driven / whole
    }
}

#[cfg(test)]
mod tests;
