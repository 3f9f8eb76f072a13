//! Tests: a controller that no longer learns, in arenas it has never met.

use rover_shared::controller::Controller;
use rover_shared::learning::Mode;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::parameters::Coefficients;
use rover_shared::random::Generator;
use serde::Serialize;

use super::measures::{Estimate, mean, proportion};
use super::seeds::{Stream, generator, numbered};
use super::trial::{Conduct, Trial, run_trial};
use super::turing::{Known, Turing};
use crate::arena::{ArenaSource, Scenario};

/// A series of test trials.
#[derive(Clone, Debug)]
pub struct Exam {
    /// Decides the arenas and directions; all controllers tested with one seed meet the same.
    pub seed: u64,
    /// How many arenas.
    pub arenas: u32,
    /// Actions allowed in each.
    pub steps: u32,
    /// Whether to follow a changing direction instead of aiming at a target.
    pub follow_direction: bool,
    /// Where the arenas come from.
    pub source: ArenaSource,
}

/// The result of a test, with 95 % intervals.
#[derive(Clone, Debug, Serialize)]
pub struct ExamResult {
    /// Share of arenas in which the target was reached; `None` where there is no target.
    pub reached: Option<Estimate>,
    /// Share in which it was reached without touching anything.
    pub clean: Option<Estimate>,
    /// Mean directedness (8).
    pub directedness: Option<Estimate>,
    /// Mean length of the way over the straight distance, where the target was reached.
    pub path_ratio: Option<Estimate>,
    /// Mean number of actions.
    pub steps: Option<Estimate>,
    /// Share of moves that were blocked.
    pub blocked: Option<Estimate>,
    /// Mean angle to the direction to follow with nothing in sight; `None` when aiming at a target.
    pub free_angle_deg: Option<Estimate>,
    /// How many arenas.
    pub arenas: usize,
}

impl Exam {
    /// The arenas, in order.
    pub fn scenarios(&self) -> impl Iterator<Item = Scenario> {
        let mut rng = generator(self.seed, Stream::Testing);
        (0..self.arenas).map(move |_| self.source.scenario(&mut rng))
    }

    fn conduct(&self, arena: u64) -> Conduct {
        let directions = self.follow_direction.then(|| numbered(self.seed, arena));
        Conduct::new(self.steps, directions)
    }
}

/// Conducts one trial in each arena by `drive`, which receives the arena's number.
pub fn examine(
    exam: &Exam,
    mut drive: impl FnMut(u64, &Scenario, &mut Conduct) -> Trial,
) -> Vec<Trial> {
    (0..)
        .zip(exam.scenarios())
        .map(|(i, scenario)| drive(i, &scenario, &mut exam.conduct(i)))
        .collect()
}

/// Tests what was learned. Each arena is met with the same knowledge: what one arena adds to the
/// pattern vector is forgotten before the next.
pub fn examine_knowledge(exam: &Exam, coefficients: &Coefficients, known: &Known) -> Vec<Trial> {
    examine(exam, |i, scenario, conduct| {
        let mut known = Box::new(known.clone());
        let rng = Generator::with_stream(numbered(exam.seed, i), Stream::Examined as u64);
        let controller = Controller::new(coefficients, PaperRule, &mut known, rng, Mode::Run);
        run_trial(scenario, conduct, &mut Turing::new(controller, ()))
    })
}

impl ExamResult {
    /// Sums up trials; `with_target` if reaching it was the task.
    pub fn new(trials: &[Trial], with_target: bool) -> Self {
        let share = |of: fn(&Trial) -> bool| {
            let hits = trials.iter().filter(|trial| of(trial)).count();
            proportion(hits, trials.len()).filter(|_| with_target)
        };
        let average =
            |of: fn(&Trial) -> Option<f64>| mean(&trials.iter().filter_map(of).collect::<Vec<_>>());
        Self {
            reached: share(Trial::reached),
            clean: share(Trial::clean),
            directedness: average(|trial| trial.directedness),
            path_ratio: average(|trial| trial.path_ratio),
            steps: average(|trial| Some(f64::from(trial.steps))),
            blocked: average(|t| {
                (t.steps > 0).then(|| f64::from(t.collisions) / f64::from(t.steps))
            }),
            free_angle_deg: average(|trial| trial.free_angle_deg),
            arenas: trials.len(),
        }
    }
}
