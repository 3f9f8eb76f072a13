//! The action cycle: rest, sense, learn, perceive, choose, turn, advance; and the host's moves.

use super::observation::Observation;
use super::state::{Activity, Cycle};
use super::supervision::Supervision;
use super::{DIRECTION_STREAM, NEXT_SEED_STREAM, Rover, SETTLE, interrupts};
use crate::contract::{Mode, Outcome, State, Task};
use crate::learning;
use crate::motion::{MotionEvent, Move, Senses, WheelCommand};
use crate::random::Generator;
use crate::reward::FollowDirection;
use crate::sensing::Sample;
use crate::sensing::ir::{AdcCount, Ranges};
use crate::supervisor::Input;
use crate::time::Instant;
use crate::units::Microdegrees;
use crate::wire::message::{ActionRecord, Event, EventKind, Report};

/// Chance, as a fraction of 2^32, that the direction to follow is redrawn before an action: 2 %,
/// some fifty actions in one direction. (IV-C says "changed at random" and no more.)
const CHANGE: u32 = (u32::MAX / 100) * 2;

/// One control period: its time and observation, the supervisor, and where reports go.
struct Period<'p, W, F> {
    now: Instant,
    seen: &'p Observation,
    watch: &'p mut W,
    report: &'p mut F,
}

impl<W: Supervision, F: FnMut(Report)> Period<'_, W, F> {
    fn report_event(&mut self, kind: EventKind) {
        let time = self.now;
        (self.report)(Report::Event(Event { time, kind }));
    }

    /// Informs the supervisor, which refuses nothing of the kind.
    fn inform(&mut self, input: Input) {
        let _ = self.watch.handle(input);
    }
}

impl Rover<'_> {
    /// One control period: continues the action cycle and returns the wheels' command, which is
    /// still to pass the supervisor's gate.
    pub fn step(
        &mut self,
        now: Instant,
        seen: &Observation,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) -> WheelCommand {
        let mut period = Period {
            now,
            seen,
            watch,
            report,
        };
        let view = period.watch.view();
        let mode = match view.state {
            State::Driving(mode) => mode,
            _ => Mode::Idle,
        };
        if mode != self.mode {
            // Out of idleness only a host can have begun a move, which is to go on.
            if self.mode != Mode::Idle {
                self.stop(&mut period);
            }
            self.change_mode(mode, &mut period);
        }
        if !view.motors_enabled {
            self.stop(&mut period);
        }
        let command = match self.mode {
            Mode::Learn | Mode::Run => self.drive(view.motors_enabled, &mut period),
            Mode::Host => match self.activity {
                Activity::Driven => self.continue_move(&mut period),
                _ => WheelCommand::STOP,
            },
            Mode::Idle => WheelCommand::STOP,
        };
        self.report_changes(&mut period);
        command
    }

    /// Reports what changed since the last step, and faults.
    fn report_changes(&mut self, period: &mut Period<'_, impl Supervision, impl FnMut(Report)>) {
        let Observation { ir, compass, .. } = *period.seen;
        let state = period.watch.view().state;
        if state != self.reported.state {
            self.reported.state = state;
            period.report_event(EventKind::State(state));
        }
        let channels = (0..).zip(ir.health).zip(&mut self.reported.ranges);
        for ((channel, health), before) in channels {
            if health != *before {
                *before = health;
                period.report_event(EventKind::Range { channel, health });
            }
        }
        if compass != self.reported.compass {
            self.reported.compass = compass;
            period.report_event(EventKind::Compass(compass));
        }
        // One a step: a report that finds its queue full is a fault again.
        if let Some(fault) = period.watch.take_fault() {
            (period.report)(Report::Fault(fault));
        }
    }

    /// Stops the move under way.
    fn stop(&mut self, period: &mut Period<'_, impl Supervision, impl FnMut(Report)>) {
        if let Some(ended) = self.motion.stop() {
            self.end_move(ended, period);
        }
    }

    fn change_mode(
        &mut self,
        mode: Mode,
        period: &mut Period<'_, impl Supervision, impl FnMut(Report)>,
    ) {
        let was_driving = matches!(self.mode, Mode::Learn | Mode::Run);
        if was_driving && !self.chosen {
            // No two sessions draw the same numbers unless the host sets the seed.
            let mut next = Generator::with_stream(self.seed, NEXT_SEED_STREAM);
            self.seed = u64::from(next.bits()) << 32 | u64::from(next.bits());
        }
        self.mode = mode;
        let learning = match mode {
            Mode::Idle | Mode::Host => return self.controller.interrupt(),
            Mode::Learn => learning::Mode::Learn,
            Mode::Run => learning::Mode::Run,
        };
        self.chosen = false;
        self.controller.restart(Generator::new(self.seed), learning);
        self.chance = Generator::with_stream(self.seed, DIRECTION_STREAM);
        if self.task == Task::FollowChangingDirection {
            self.draw_direction();
        }
        self.redirected = true;
        self.activity = Activity::Resting { until: period.now };
        let seed = self.seed;
        let (_, knowledge) = self.current();
        period.report_event(EventKind::Session {
            mode,
            seed,
            knowledge,
        });
    }

    /// Continues the action cycle.
    fn drive(
        &mut self,
        enabled: bool,
        period: &mut Period<'_, impl Supervision, impl FnMut(Report)>,
    ) -> WheelCommand {
        if let Activity::Resting { until } = self.activity {
            let rested = enabled && period.seen.time >= until;
            let (true, Some(heading)) = (rested, period.seen.heading) else {
                return WheelCommand::STOP;
            };
            self.begin_cycle(heading, period);
        }
        self.continue_move(period)
    }

    /// Senses, learns, perceives and chooses.
    fn begin_cycle(
        &mut self,
        heading: Microdegrees,
        period: &mut Period<'_, impl Supervision, impl FnMut(Report)>,
    ) {
        if self.task == Task::FollowChangingDirection && self.chance.bits() < CHANGE {
            self.draw_direction();
        }
        if core::mem::take(&mut self.redirected) {
            self.controller.interrupt();
            period.report_event(EventKind::Direction(self.direction));
        }
        let Ranges { front, left, right } = period.seen.ir.ranges();
        let sample = Sample {
            front,
            left,
            right,
            heading,
            target_bearing: None,
        };
        let step = self
            .controller
            .step(&sample, &FollowDirection(self.direction));
        self.steps = self.steps.saturating_add(1);
        self.staging.changed();
        self.saving.knowledge |= self.mode == Mode::Learn;
        if step.unsettled() {
            period.inform(Input::Unsettled);
        }
        // Coefficients has checked that phases and modules lie within a move's limits.
        let started = self.motion.start(step.action.phase, step.action.module);
        debug_assert_eq!(started, Ok(()));
        self.activity = Activity::Acting(Cycle {
            observation: *period.seen,
            sample,
            step,
        });
    }

    fn draw_direction(&mut self) {
        let half = Microdegrees::HALF_TURN.0;
        let drawn = self.chance.symmetric(half.unsigned_abs());
        self.direction = Microdegrees::wrapped(drawn.into());
        self.redirected = true;
    }

    fn continue_move(
        &mut self,
        period: &mut Period<'_, impl Supervision, impl FnMut(Report)>,
    ) -> WheelCommand {
        let senses = Senses {
            heading: period.seen.heading,
            clearance: period.seen.ir.clearance(),
        };
        let (command, event) = self.motion.step(period.now, senses);
        if let Some(MotionEvent::Ended(ended)) = event {
            self.end_move(ended, period);
        }
        command
    }

    fn end_move(
        &mut self,
        ended: Move,
        period: &mut Period<'_, impl Supervision, impl FnMut(Report)>,
    ) {
        let Move {
            outcome, proven, ..
        } = ended;
        if proven || outcome != Outcome::Completed {
            period.inform(Input::Moved(outcome));
        }
        let resting = Activity::Resting {
            until: period.now.after(SETTLE),
        };
        match core::mem::replace(&mut self.activity, resting) {
            Activity::Acting(cycle) => {
                if interrupts(outcome) {
                    self.controller.interrupt();
                }
                let counters = period.watch.view().counters;
                let Cycle {
                    observation,
                    sample,
                    step,
                } = cycle;
                (period.report)(Report::Action(ActionRecord {
                    time: observation.time,
                    counts: observation.ir.counts.map(AdcCount::get),
                    ranges: observation.ir.health,
                    compass: observation.compass,
                    sample,
                    step,
                    outcome,
                    counters,
                }));
            }
            Activity::Driven => period.report_event(EventKind::MoveEnded(outcome)),
            Activity::Resting { .. } => {}
        }
    }
}
