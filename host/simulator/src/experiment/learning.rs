//! A learning session: from nothing, over many trials, each in an arena of its own (III-B).

use rover_shared::controller::Controller;
use rover_shared::learning::Mode;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::parameters::Coefficients;
use rover_shared::random::Generator;

use super::exam::{Exam, ExamResult, examine_knowledge};
use super::history::History;
use super::seeds::{Stream, generator};
use super::trial::{Conduct, Trial, run_trial};
use super::turing::{Known, Turing, Witness};
use crate::arena::ArenaSource;

/// What a session is made of. The same plan gives the same session, bit by bit.
#[derive(Clone, Debug)]
pub struct SessionPlan {
    /// Of controller, arenas and directions.
    pub seed: u64,
    /// How many trials.
    pub trials: u32,
    /// Actions allowed in each.
    pub steps: u32,
    /// Whether to follow a changing direction instead of aiming at a target.
    pub follow_direction: bool,
    /// Where the arenas come from.
    pub arenas: ArenaSource,
}

impl SessionPlan {
    /// The plan of the k-th session, from 0, of a series: each has a seed of its own.
    pub fn nth(&self, k: u64) -> Self {
        Self {
            seed: self.seed.wrapping_add(k),
            ..self.clone()
        }
    }

    /// The test of a session with this plan, in this many arenas.
    pub fn exam(&self, arenas: u32) -> Exam {
        Exam {
            seed: self.seed.wrapping_add(TEST_SEED),
            arenas,
            steps: self.steps,
            follow_direction: self.follow_direction,
            source: self.arenas.clone(),
        }
    }
}

/// Added to a session's seed for its test, so that no session is tested with the numbers another
/// one learned with.
const TEST_SEED: u64 = 0x7465_7374_0000_0000;

/// The result of a session.
#[derive(Clone, Debug)]
pub struct LearnedSession {
    /// The seed it started from.
    pub seed: u64,
    /// What was learned.
    pub knowledge: Box<Known>,
    /// How each trial went.
    pub trials: Vec<Trial>,
    /// How the staircases changed.
    pub history: History,
}

impl LearnedSession {
    /// The result of testing what was learned.
    pub fn test(&self, exam: &Exam, coefficients: &Coefficients) -> ExamResult {
        let trials = examine_knowledge(exam, coefficients, &self.knowledge);
        ExamResult::new(&trials, !exam.follow_direction)
    }
}

/// Runs a learning session; `after_trial` is called after each trial.
pub fn learn(
    plan: &SessionPlan,
    coefficients: &Coefficients,
    witness: impl Witness,
    mut after_trial: impl FnMut(&Trial),
) -> LearnedSession {
    let mut knowledge = Box::new(Known::new(&coefficients.learning));
    let limit = coefficients.learning.amplitude_limit;
    let mut history = History::new(knowledge.sensing.neurons, limit);
    let rng = Generator::new(plan.seed);
    let controller = Controller::new(coefficients, PaperRule, &mut knowledge, rng, Mode::Learn);
    let mut pilot = Turing::new(controller, (&mut history, witness));
    let mut arenas = generator(plan.seed, Stream::Learning);
    let mut conduct = Conduct::new(plan.steps, plan.follow_direction.then_some(plan.seed));
    let trials = (0..plan.trials)
        .map(|_| {
            let scenario = plan.arenas.scenario(&mut arenas);
            let trial = run_trial(&scenario, &mut conduct, &mut pilot);
            after_trial(&trial);
            trial
        })
        .collect();
    LearnedSession {
        seed: plan.seed,
        knowledge,
        trials,
        history,
    }
}
