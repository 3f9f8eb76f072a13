//! The action cycle: rest, sense, learn, perceive, choose, turn, advance; and moves for the host.

use super::{
    Activity, CHANGE, Cycle, DIRECTION_STREAM, NEXT_SEED_STREAM, Observation, Rover, SETTLE,
    Supervision, interrupts,
};
use crate::learning;
use crate::motion::{MotionEvent, Move, Senses, WheelCommand};
use crate::random::Generator;
use crate::reward::FollowDirection;
use crate::sensing::Sample;
use crate::sensing::ir::{AdcCount, Ranges};
use crate::supervisor::Input;
use crate::time::Instant;
use crate::units::Microdegrees;
use crate::wire::message::{ActionRecord, Event, EventKind, Mode, Outcome, Report, Task};

impl Rover<'_> {
    /// Ends a move from outside.
    pub(super) fn stop(
        &mut self,
        now: Instant,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) {
        if let Some(ended) = self.motion.stop() {
            self.end_move(now, ended, watch, report);
        }
    }

    pub(super) fn change_mode(
        &mut self,
        now: Instant,
        mode: Mode,
        report: &mut impl FnMut(Report),
    ) {
        let was_driving = matches!(self.mode, Mode::Learn | Mode::Run);
        if was_driving && !self.chosen {
            // No two sessions draw the same numbers unless somebody asks for it.
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
        self.activity = Activity::Resting { until: now };
        let parameters = self.coefficients.parameters();
        let (_, knowledge) = self
            .staging
            .current(self.controller.knowledge(), parameters);
        let kind = EventKind::Session {
            mode,
            seed: self.seed,
            knowledge,
        };
        report(Report::Event(Event { time: now, kind }));
    }

    /// Goes on with the action cycle.
    pub(super) fn drive(
        &mut self,
        now: Instant,
        seen: &Observation,
        enabled: bool,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) -> WheelCommand {
        if let Activity::Resting { until } = self.activity {
            let (true, Some(heading)) = (enabled && seen.time >= until, seen.heading) else {
                return WheelCommand::STOP;
            };
            self.begin_cycle(now, seen, heading, watch, report);
        }
        self.move_on(now, seen, watch, report)
    }

    /// Senses, learns, perceives and chooses.
    fn begin_cycle(
        &mut self,
        now: Instant,
        seen: &Observation,
        heading: Microdegrees,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) {
        if self.task == Task::FollowChangingDirection && self.chance.bits() < CHANGE {
            self.draw_direction();
        }
        if core::mem::take(&mut self.redirected) {
            self.controller.interrupt();
            let kind = EventKind::Direction(self.direction);
            report(Report::Event(Event { time: now, kind }));
        }
        let Ranges { front, left, right } = seen.ir.ranges();
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
            // Only counts; nothing to refuse.
            let _ = watch.handle(Input::Unsettled);
        }
        // Phases and modules lie within what a move allows: Coefficients checks them.
        let started = self.motion.start(step.action.phase, step.action.module);
        debug_assert_eq!(started, Ok(()));
        self.activity = Activity::Acting(Cycle {
            observation: *seen,
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

    /// Goes on with a move of the host's.
    pub(super) fn carry_out(
        &mut self,
        now: Instant,
        seen: &Observation,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) -> WheelCommand {
        match self.activity {
            Activity::Driven => self.move_on(now, seen, watch, report),
            _ => WheelCommand::STOP,
        }
    }

    fn move_on(
        &mut self,
        now: Instant,
        seen: &Observation,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) -> WheelCommand {
        let senses = Senses {
            heading: seen.heading,
            clearance: seen.ir.clearance(),
        };
        let (command, event) = self.motion.step(now, senses);
        if let Some(MotionEvent::Ended(ended)) = event {
            self.end_move(now, ended, watch, report);
        }
        command
    }

    fn end_move(
        &mut self,
        now: Instant,
        ended: Move,
        watch: &mut impl Supervision,
        report: &mut impl FnMut(Report),
    ) {
        let Move {
            outcome, proven, ..
        } = ended;
        if proven || outcome != Outcome::Completed {
            // Only tells; nothing to refuse.
            let _ = watch.handle(Input::Moved(outcome));
        }
        let resting = Activity::Resting {
            until: now.after(SETTLE),
        };
        match core::mem::replace(&mut self.activity, resting) {
            Activity::Acting(cycle) => {
                if interrupts(outcome) {
                    self.controller.interrupt();
                }
                let counters = watch.view().counters;
                let Cycle {
                    observation,
                    sample,
                    step,
                } = cycle;
                report(Report::Action(ActionRecord {
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
            Activity::Driven => {
                let kind = EventKind::MoveEnded(outcome);
                report(Report::Event(Event { time: now, kind }));
            }
            Activity::Resting { .. } => {}
        }
    }
}
