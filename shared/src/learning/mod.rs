//! Learning from one action: what a rule is, and the rules.
//!
//! A [`LearningRule`] decides what is remembered of a pattern, which phase is tried, and how
//! staircases and memory change once the reward is known. The paper's is in [`paper_rule`]; another
//! is another file beside it and a line here. (`examples/custom_rule.rs` in this crate defines one
//! outside of it.)

pub mod paper_rule;
mod parameters;

pub use parameters::{LearningCoefficients, LearningParameters};

use crate::action::Action;
use crate::action::pattern_vector::PatternVector;
use crate::perception::{Corners, PatternCode};
use crate::random::Generator;
use crate::reward::Reward;
use crate::sensing::neuron::{SensingNeuron, StepIndex};
use crate::sensing::{Percept, Stimulus};
use crate::units::Microdegrees;

/// Whether the controller learns or only acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Try, and learn from the reward.
    Learn,
    /// Act on what was learned; staircases and memories do not change.
    Run,
}

/// The four sensing neurons and how far they may still change: what is learned at the sensing end.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct SensingLayer {
    /// The neurons, in the order of [`Stimulus`].
    pub neurons: [SensingNeuron; 4],
    /// h of II-D, as a fraction of 2^32.
    pub width: u32,
}

impl SensingLayer {
    /// Before learning: all amplitudes zero, the width at its largest.
    pub const fn new(c: &LearningCoefficients) -> Self {
        Self {
            neurons: [SensingNeuron::ZERO; 4],
            width: c.sensing_width,
        }
    }

    /// The initial states of the corner cells for a percept.
    pub fn corners(&self, percept: &Percept) -> Corners {
        let mut corners = [0; 4];
        for ((corner, neuron), step) in corners.iter_mut().zip(&self.neurons).zip(percept.steps()) {
            *corner = neuron.output(step).0;
        }
        Corners(corners)
    }
}

/// One action with what was sensed before it and the reward before and after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// What was sensed before the action.
    pub percept: Percept,
    /// The pattern that chose the action.
    pub code: PatternCode,
    /// The action.
    pub action: Action,
    /// The reward before it.
    pub before: Reward,
    /// The reward after it.
    pub after: Reward,
}

impl Transition {
    /// DRF, in millionths of reward.
    pub fn reward_difference(&self) -> i32 {
        self.after.difference(&self.before)
    }
}

/// A change of a staircase by (5) or (6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StaircaseChange {
    /// Whose staircase.
    pub stimulus: Stimulus,
    /// At which step.
    pub step: StepIndex,
    /// By how much, Q20: positive raises the steps from here up, negative lowers those from here
    /// down.
    #[serde(rename = "amount_q20")]
    pub amount: i32,
}

/// How staircases and motor map learn.
pub trait LearningRule {
    /// The rule's memory of each pattern.
    type Memory: Memory;

    /// Identifies the rule in stored knowledge; the paper's is 1.
    const ID: u8;

    /// Returns the memory of a pattern that occurs for the first time.
    fn introduce<const N: usize>(
        &self,
        code: PatternCode,
        known: &PatternVector<Self::Memory, N>,
        c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> Self::Memory;

    /// Chooses the action for a pattern.
    fn act(
        &self,
        memory: &Self::Memory,
        mode: Mode,
        c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> Action;

    /// Learns from one transition. `memory` is that of the transition's pattern.
    fn learn(
        &self,
        transition: &Transition,
        memory: &mut Self::Memory,
        sensing: &mut SensingLayer,
        c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> Option<StaircaseChange>;
}

/// A pattern's memory as bytes, for storage.
pub trait Memory: Copy + core::fmt::Debug + PartialEq {
    /// Its length in bytes.
    const SIZE: usize;

    /// The phase that the pattern's action has when running.
    fn phase(&self) -> Microdegrees;

    /// Writes the memory to `bytes`, which are [`SIZE`](Self::SIZE) long.
    fn write(&self, bytes: &mut [u8]);

    /// Reads what [`write`](Self::write) wrote; `None` if no rule could have written it.
    fn read(bytes: &[u8]) -> Option<Self>;
}
