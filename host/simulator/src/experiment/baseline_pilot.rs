//! The controllers of [`crate::baseline`] as pilots, and how they learn.

use rand_pcg::Pcg32;
use rover_shared::action::Action;
use rover_shared::parameters::Coefficients;
use rover_shared::reward::Task as _;
use rover_shared::sensing::{Percept, Sample};
use rover_shared::units::Microdegrees;

use super::exam::Exam;
use super::pilot::{Ending, Pilot, TaskKind};
use super::seeds::{Stream, generator};
use super::trial::{Conduct, run_trial};
use crate::arena::{Robot, Scenario};
use crate::baseline::{Driver, Experience, Observation};

/// A baseline as a pilot. It moves by the same step and is rewarded by the same function as the
/// paper's controller.
pub struct BaselinePilot<'a> {
    driver: &'a mut dyn Driver,
    coefficients: &'a Coefficients,
    last: Option<Last>,
}

struct Last {
    seen: Observation,
    turn: Microdegrees,
    reward: i32,
}

impl<'a> BaselinePilot<'a> {
    /// `driver` as a pilot, rewarded by the function of `coefficients`.
    pub fn new(driver: &'a mut dyn Driver, coefficients: &'a Coefficients) -> Self {
        Self {
            driver,
            coefficients,
            last: None,
        }
    }

    fn learn(&mut self, after: &Observation, reward: i32) {
        if let Some(Last {
            seen,
            turn,
            reward: before,
        }) = self.last.take()
        {
            let gain = f64::from(reward - before) / 1e6;
            self.driver.learn(&Experience {
                before: &seen,
                turn,
                gain,
                after,
            });
        }
    }

    fn reward(&self, sample: &Sample, target: Microdegrees) -> i32 {
        let percept = Percept::new(sample, target, &self.coefficients.ranges);
        self.coefficients.reward.reward(&percept, target).total()
    }
}

impl Pilot for BaselinePilot<'_> {
    fn begin_trial(&mut self, _scenario: &Scenario) {
        self.last = None;
        self.driver.begin_trial();
    }

    fn task_changed(&mut self) {
        self.last = None;
    }

    fn act(&mut self, robot: &Robot, sample: &Sample, task: TaskKind) -> Action {
        let direction = match task {
            TaskKind::AimAtTarget => None,
            TaskKind::FollowDirection { direction_udeg } => Some(direction_udeg),
        };
        let seen = Observation::of(robot, direction, &*self.driver);
        let reward = self.reward(sample, seen.target);
        self.learn(&seen, reward);
        let turn = self.driver.act(&seen);
        self.last = Some(Last { seen, turn, reward });
        Action {
            phase: turn,
            module: self.coefficients.learning.module,
        }
    }

    fn end_trial(&mut self, sample: &Sample, task: TaskKind, _ending: Ending) {
        let target = task.target_angle(sample).unwrap_or_default();
        let after = Observation {
            sample: *sample,
            target,
            fan_cm: None,
        };
        let reward = self.reward(sample, target);
        self.learn(&after, reward);
    }
}

/// Trials in which a baseline learns: as many as the paper's controller has (III-B).
const LEARNING_TRIALS: u32 = 200;

/// Teaches a baseline in arenas like those of `exam`, but never the same ones.
pub fn teach(driver: &mut dyn Driver, exam: &Exam, coefficients: &Coefficients) {
    let mut rng: Pcg32 = generator(exam.seed, Stream::Learning);
    let directions = exam.follow_direction.then(|| exam.seed.wrapping_sub(1));
    let mut conduct = Conduct::new(exam.steps, directions);
    for _ in 0..LEARNING_TRIALS {
        let scenario = exam.source.scenario(&mut rng);
        run_trial(
            &scenario,
            &mut conduct,
            &mut BaselinePilot::new(driver, coefficients),
        );
    }
    driver.freeze();
}
