//! Who steers the robot of a trial.

use rover_shared::action::Action;
use rover_shared::action::motor_map::{MotorWeights, PaperRule};
use rover_shared::controller::{Controller, Learned, StepRecord};
use rover_shared::knowledge::Knowledge;
use rover_shared::reward::{AimAtTarget, FollowDirection, Task};
use rover_shared::sensing::Sample;
use rover_shared::units::Microdegrees;
use serde::{Deserialize, Serialize};

use super::trial::Ending;
use crate::arena::{Motion, Pose, Robot, Scenario};

/// What is known after learning by the paper's rule.
pub type Known = Knowledge<MotorWeights>;

/// The task of a step, as logs have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum TaskKind {
    /// Aim at a target (III).
    AimAtTarget,
    /// Follow a direction (IV).
    FollowDirection {
        /// Counter-clockwise in the world's frame.
        direction_udeg: Microdegrees,
    },
}

impl Task for TaskKind {
    fn target_angle(&self, sample: &Sample) -> Option<Microdegrees> {
        match self {
            Self::AimAtTarget => AimAtTarget.target_angle(sample),
            Self::FollowDirection { direction_udeg } => {
                FollowDirection(*direction_udeg).target_angle(sample)
            }
        }
    }
}

/// Somebody who steers a robot through trials.
pub trait Pilot {
    /// A new trial begins: what went before has nothing to do with what comes.
    fn begin_trial(&mut self, scenario: &Scenario);

    /// The direction to follow has changed: the next reward says nothing about the last action.
    fn task_changed(&mut self);

    /// Chooses the next action.
    fn act(&mut self, robot: &Robot, sample: &Sample, task: TaskKind) -> Action;

    /// Learns what became of the last action chosen.
    fn moved(&mut self, _motion: Motion) {}

    /// The trial is over; `sample` shows what the last action led to.
    fn end_trial(&mut self, _sample: &Sample, _task: TaskKind, _ending: Ending) {}
}

/// What a [`Turing`] pilot reports of each step.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Whether the step began without memory of the action before.
    pub interrupted: bool,
    /// What was to be done.
    pub task: TaskKind,
    /// What was sensed.
    pub sample: Sample,
    /// Where the robot was.
    pub pose: Pose,
    /// What the core made of it.
    pub record: StepRecord,
    /// What became of the action.
    pub motion: Motion,
}

/// Receives what a [`Turing`] pilot does, for logs and figures.
pub trait Witness {
    /// A trial begins.
    fn begin(&mut self, _scenario: &Scenario) {}

    /// A step was made.
    fn step(&mut self, _event: &Event) {}

    /// A trial is over, and this was learned from its last action.
    fn end(
        &mut self,
        _sample: &Sample,
        _task: TaskKind,
        _learned: Option<Learned>,
        _ending: Ending,
    ) {
    }
}

/// Sees nothing.
impl Witness for () {}

impl<W: Witness> Witness for &mut W {
    fn begin(&mut self, scenario: &Scenario) {
        (**self).begin(scenario);
    }

    fn step(&mut self, event: &Event) {
        (**self).step(event);
    }

    fn end(&mut self, sample: &Sample, task: TaskKind, learned: Option<Learned>, ending: Ending) {
        (**self).end(sample, task, learned, ending);
    }
}

/// Two witnesses see the same.
impl<A: Witness, B: Witness> Witness for (A, B) {
    fn begin(&mut self, scenario: &Scenario) {
        self.0.begin(scenario);
        self.1.begin(scenario);
    }

    fn step(&mut self, event: &Event) {
        self.0.step(event);
        self.1.step(event);
    }

    fn end(&mut self, sample: &Sample, task: TaskKind, learned: Option<Learned>, ending: Ending) {
        self.0.end(sample, task, learned, ending);
        self.1.end(sample, task, learned, ending);
    }
}

/// The architecture of the paper as a pilot.
pub struct Turing<'a, W> {
    controller: Controller<'a, PaperRule>,
    witness: W,
    interrupted: bool,
    unfinished: Option<(TaskKind, Sample, Pose, StepRecord, bool)>,
}

impl<'a, W: Witness> Turing<'a, W> {
    /// A pilot that steers by `controller` and reports to `witness`.
    pub fn new(controller: Controller<'a, PaperRule>, witness: W) -> Self {
        Self {
            controller,
            witness,
            interrupted: true,
            unfinished: None,
        }
    }
}

impl<W: Witness> Pilot for Turing<'_, W> {
    fn begin_trial(&mut self, scenario: &Scenario) {
        self.witness.begin(scenario);
        self.task_changed();
    }

    fn task_changed(&mut self) {
        self.controller.interrupt();
        self.interrupted = true;
    }

    fn act(&mut self, robot: &Robot, sample: &Sample, task: TaskKind) -> Action {
        let record = self.controller.step(sample, &task);
        let interrupted = std::mem::take(&mut self.interrupted);
        self.unfinished = Some((task, *sample, robot.pose(), record, interrupted));
        record.action
    }

    fn moved(&mut self, motion: Motion) {
        if let Some((task, sample, pose, record, interrupted)) = self.unfinished.take() {
            self.witness.step(&Event {
                interrupted,
                task,
                sample,
                pose,
                record,
                motion,
            });
        }
    }

    fn end_trial(&mut self, sample: &Sample, task: TaskKind, ending: Ending) {
        let learned = self.controller.conclude(sample, &task);
        self.witness.end(sample, task, learned, ending);
    }
}
