//! The loop of Fig. 1: sense, perceive, act, and learn from the next sample.
//!
//! The records' serialised names carry the units, because logs are read by people.

use serde::{Deserialize, Serialize};

use crate::action::Action;
use crate::knowledge::Knowledge;
use crate::learning::{LearningRule, Memory, Mode, StaircaseChange, Transition};
use crate::parameters::Coefficients;
use crate::perception::{Corners, Noise, PatternCode, SettleTime};
use crate::random::Generator;
use crate::reward::{Reward, Task};
use crate::sensing::{Percept, Sample};
use crate::units::Microdegrees;

/// The controller: the knowledge, the action whose consequences are awaited, and the random
/// generator.
///
/// Call [`step`](Self::step) with one sample per action. There is no clock and no hidden state: the
/// same knowledge, seed, mode and samples produce the same bits on all machines. The [crate's
/// example](crate) runs one.
pub struct Controller<'a, R: LearningRule> {
    coefficients: &'a Coefficients,
    rule: R,
    knowledge: &'a mut Knowledge<R::Memory>,
    rng: Generator,
    mode: Mode,
    /// The last action, until its consequences are sensed.
    pending: Option<Pending>,
}

#[derive(Clone, Copy, Debug)]
struct Pending {
    percept: Percept,
    code: PatternCode,
    action: Action,
    reward: Reward,
}

/// The interpretation of one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Sensed {
    /// The angle to the target, positive on the left, in (-180, 180] degrees.
    #[serde(rename = "target_angle_udeg")]
    pub target_angle: Microdegrees,
    /// All stimuli, scaled.
    #[serde(rename = "percept_ppm")]
    pub percept: Percept,
    /// The reward function's components.
    #[serde(rename = "reward_micro")]
    pub reward: Reward,
}

/// What was learned from the action before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Learned {
    /// The pattern that had chosen the action.
    pub code: PatternCode,
    /// DRF, in millionths of reward.
    #[serde(rename = "reward_difference_micro")]
    pub reward_difference: i32,
    /// The phase of the pattern's action after it, without search.
    #[serde(rename = "phase_udeg")]
    pub phase: Microdegrees,
    /// The staircase's change, if the reward fell.
    pub staircase: Option<StaircaseChange>,
}

/// Whether the pattern vector knew a pattern when it occurred.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Familiarity {
    /// It is remembered.
    Known,
    /// It occurred for the first time.
    New,
    /// It occurred for the first time and replaced this pattern in a full vector.
    Replaced(PatternCode),
}

/// The pattern that arose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Perceived {
    /// The initial states of the corner cells.
    #[serde(rename = "corners_q20")]
    pub corners: Corners,
    /// The pattern.
    pub code: PatternCode,
    /// How long it took to settle, in the network's own time.
    #[serde(rename = "settle_time_64ths")]
    pub settle_time: SettleTime,
    /// Whether it was known.
    pub familiarity: Familiarity,
}

/// Everything that one [`Controller::step`] computed from its sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StepRecord {
    /// Number of this step in this knowledge, from 0.
    pub step: u32,
    /// The sample's interpretation; `None` if it does not determine the target angle.
    pub sensed: Option<Sensed>,
    /// What was learned from the action before.
    pub learned: Option<Learned>,
    /// The pattern that arose; `None` without a target, or if the network did not settle.
    pub perceived: Option<Perceived>,
    /// The action: [`Action::STAY`] if nothing was perceived.
    pub action: Action,
}

impl StepRecord {
    /// Whether the network had not settled at its step cap.
    pub fn unsettled(&self) -> bool {
        self.sensed.is_some() && self.perceived.is_none()
    }
}

impl<'a, R: LearningRule> Controller<'a, R> {
    /// A controller that continues from `knowledge`.
    pub fn new(
        coefficients: &'a Coefficients,
        rule: R,
        knowledge: &'a mut Knowledge<R::Memory>,
        rng: Generator,
        mode: Mode,
    ) -> Self {
        Self {
            coefficients,
            rule,
            knowledge,
            rng,
            mode,
            pending: None,
        }
    }

    /// The knowledge so far.
    pub fn knowledge(&self) -> &Knowledge<R::Memory> {
        self.knowledge
    }

    /// Whether the controller learns.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Switches to another mode; the last action is not learned from.
    pub fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
        self.pending = None;
    }

    /// Restarts with this generator and mode, and keeps the knowledge.
    pub fn restart(&mut self, rng: Generator, mode: Mode) {
        self.rng = rng;
        self.set_mode(mode);
    }

    /// The knowledge, for replacement; the last action is not learned from.
    pub fn knowledge_mut(&mut self) -> &mut Knowledge<R::Memory> {
        self.pending = None;
        self.knowledge
    }

    /// Discards the last action, because its consequences cannot be separated from another change
    /// (a new trial, another direction to follow).
    pub fn interrupt(&mut self) {
        self.pending = None;
    }

    /// Learns from the last action's consequences, then perceives and chooses the next action.
    pub fn step(&mut self, sample: &Sample, task: &impl Task) -> StepRecord {
        let step = self.knowledge.steps;
        self.knowledge.steps = step.wrapping_add(1);
        let Some(sensed) = self.sense(sample, task) else {
            self.pending = None;
            return StepRecord {
                step,
                sensed: None,
                learned: None,
                perceived: None,
                action: Action::STAY,
            };
        };
        let learned = self.learn(&sensed.reward);
        let perceived = self.perceive(&sensed.percept, step);
        let action = match perceived {
            Some(perceived) => self.act(&sensed, perceived.code),
            None => Action::STAY,
        };
        StepRecord {
            step,
            sensed: Some(sensed),
            learned,
            perceived,
            action,
        }
    }

    /// Learns from the consequences of a trial's last action, without choosing another.
    pub fn conclude(&mut self, sample: &Sample, task: &impl Task) -> Option<Learned> {
        let sensed = self.sense(sample, task);
        let learned = sensed.and_then(|sensed| self.learn(&sensed.reward));
        self.pending = None;
        learned
    }

    fn sense(&self, sample: &Sample, task: &impl Task) -> Option<Sensed> {
        let target_angle = task.target_angle(sample)?;
        let percept = Percept::new(sample, target_angle, &self.coefficients.ranges);
        let reward = self.coefficients.reward.reward(&percept, target_angle);
        Some(Sensed {
            target_angle,
            percept,
            reward,
        })
    }

    fn learn(&mut self, after: &Reward) -> Option<Learned> {
        let Pending {
            percept,
            code,
            action,
            reward,
        } = self.pending.take()?;
        if self.mode == Mode::Run {
            return None;
        }
        let transition = Transition {
            percept,
            code,
            action,
            before: reward,
            after: *after,
        };
        let knowledge = &mut *self.knowledge;
        let memory = knowledge.patterns.memory_mut(code)?;
        let staircase = self.rule.learn(
            &transition,
            memory,
            &mut knowledge.sensing,
            &self.coefficients.learning,
            &mut self.rng,
        );
        Some(Learned {
            code,
            reward_difference: transition.reward_difference(),
            phase: memory.phase(),
            staircase,
        })
    }

    fn perceive(&mut self, percept: &Percept, step: u32) -> Option<Perceived> {
        let corners = self.knowledge.sensing.corners(percept);
        let noise = Noise::draw(&mut self.rng);
        let settled = self.coefficients.lattice.settle(&corners, &noise).ok()?;
        let familiarity = self.recognise(settled.code, step);
        Some(Perceived {
            corners,
            code: settled.code,
            settle_time: settled.time,
            familiarity,
        })
    }

    fn recognise(&mut self, code: PatternCode, step: u32) -> Familiarity {
        let patterns = &mut self.knowledge.patterns;
        if patterns.occur(code, step) {
            return Familiarity::Known;
        }
        let learning = &self.coefficients.learning;
        let memory = self.rule.introduce(code, patterns, learning, &mut self.rng);
        match patterns.store(code, step, memory) {
            Some(forgotten) => Familiarity::Replaced(forgotten.code),
            None => Familiarity::New,
        }
    }

    fn act(&mut self, sensed: &Sensed, code: PatternCode) -> Action {
        let Some(element) = self.knowledge.patterns.get(code) else {
            return Action::STAY;
        };
        let learning = &self.coefficients.learning;
        let action = self
            .rule
            .act(&element.memory, self.mode, learning, &mut self.rng);
        self.pending = Some(Pending {
            percept: sensed.percept,
            code,
            action,
            reward: sensed.reward,
        });
        action
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::paper_rule::PaperRule;
    use crate::parameters::Parameters;
    use crate::reward::{AimAtTarget, FollowDirection};
    use crate::units::Micrometres;
    use std::vec::Vec;

    fn sample(front_cm: u32, bearing: i32) -> Sample {
        Sample {
            front: Micrometres::from_cm(front_cm),
            left: Micrometres::from_cm(20),
            right: Micrometres::from_cm(20),
            heading: Microdegrees(0),
            target_bearing: Some(Microdegrees::from_degrees(bearing)),
        }
    }

    /// Samples that get better and worse, so that both kinds of learning happen.
    fn drive(
        seed: u64,
        mode: Mode,
    ) -> (
        Vec<StepRecord>,
        Knowledge<crate::learning::paper_rule::MotorWeights>,
    ) {
        let coefficients = Coefficients::new(&Parameters::PAPER).unwrap();
        let mut knowledge = Knowledge::new(&coefficients.learning);
        let rng = Generator::new(seed);
        let mut controller = Controller::new(&coefficients, PaperRule, &mut knowledge, rng, mode);
        let records = (0..200)
            .map(|i| controller.step(&sample(40 - i % 37, (i as i32 * 17) % 90), &AimAtTarget))
            .collect();
        (records, knowledge)
    }

    #[test]
    fn one_seed_gives_one_course_of_events() {
        let (first, known_first) = drive(5, Mode::Learn);
        let (second, known_second) = drive(5, Mode::Learn);
        assert_eq!(first, second);
        assert!(known_first == known_second);
        assert_ne!(drive(6, Mode::Learn).0, first);
    }

    #[test]
    fn learning_waits_for_the_next_sample() {
        let (records, knowledge) = drive(5, Mode::Learn);
        assert_eq!(records[0].learned, None);
        let first = records[0].perceived.unwrap();
        assert_eq!(first.familiarity, Familiarity::New);
        assert_eq!(records[1].learned.unwrap().code, first.code);
        assert!(
            records
                .iter()
                .any(|r| r.learned.is_some_and(|l| l.staircase.is_some()))
        );
        assert_eq!(knowledge.steps, 200);
    }

    #[test]
    fn running_changes_neither_staircases_nor_weights() {
        let (records, knowledge) = drive(5, Mode::Run);
        assert!(records.iter().all(|record| record.learned.is_none()));
        let coefficients = Coefficients::new(&Parameters::PAPER).unwrap();
        assert_eq!(
            knowledge.sensing,
            crate::learning::SensingLayer::new(&coefficients.learning)
        );
        let first_search = coefficients.learning.initial_search;
        assert!(
            knowledge
                .patterns
                .elements()
                .iter()
                .all(|e| e.memory.search == first_search)
        );
    }

    #[test]
    fn nothing_is_learned_across_an_interruption_or_after_the_end() {
        let coefficients = Coefficients::new(&Parameters::PAPER).unwrap();
        let mut knowledge = Knowledge::new(&coefficients.learning);
        let rng = Generator::new(1);
        let mut controller =
            Controller::new(&coefficients, PaperRule, &mut knowledge, rng, Mode::Learn);
        controller.step(&sample(40, 0), &AimAtTarget);
        controller.interrupt();
        assert_eq!(controller.step(&sample(10, 0), &AimAtTarget).learned, None);
        assert!(controller.conclude(&sample(20, 0), &AimAtTarget).is_some());
        assert_eq!(controller.conclude(&sample(20, 0), &AimAtTarget), None);
        assert_eq!(controller.step(&sample(10, 0), &AimAtTarget).learned, None);
    }

    #[test]
    fn without_a_target_the_robot_stays() {
        let coefficients = Coefficients::new(&Parameters::PAPER).unwrap();
        let mut knowledge = Knowledge::new(&coefficients.learning);
        let rng = Generator::new(1);
        let mut controller =
            Controller::new(&coefficients, PaperRule, &mut knowledge, rng, Mode::Learn);
        let blind = Sample {
            target_bearing: None,
            ..sample(40, 0)
        };
        let record = controller.step(&blind, &AimAtTarget);
        assert_eq!(record.perceived, None);
        assert_eq!(record.action, Action::STAY);
        let follow = FollowDirection(Microdegrees(0));
        assert!(controller.step(&blind, &follow).perceived.is_some());
    }
}
