//! What steers the robot of a trial.

use rover_shared::action::Action;
use rover_shared::reward::{AimAtTarget, FollowDirection, Task};
use rover_shared::sensing::Sample;
use rover_shared::units::Microdegrees;
use serde::{Deserialize, Serialize};

use crate::arena::{Motion, Robot, Scenario};

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

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// At the target.
    Reached,
    /// All actions were used up.
    OutOfSteps,
}

/// Steers a robot through trials.
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
