//! Drives kept action by action, to be drawn.

use rover_shared::action::motor_map::PaperRule;
use rover_shared::controller::Controller;
use rover_shared::learning::Mode;
use rover_shared::parameters::Coefficients;
use rover_shared::perception::PatternCode;
use rover_shared::random::Generator;

use crate::arena::{Scenario, Side, Vector, micrometres};
use crate::experiment::{
    Event, Exam, Known, SessionPlan, Stream, Trial, Turing, Witness, examine, generator, learn,
    numbered, run_trial,
};

/// A trial with all that happened in it.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Where it took place.
    pub scenario: Scenario,
    /// Its actions, in order.
    pub events: Vec<Event>,
    /// What came of it.
    pub trial: Trial,
    /// Where the last of the actions led to.
    pub end: Vector,
}

/// Keeps every event.
#[derive(Default)]
struct Recorder(Vec<Event>);

impl Witness for Recorder {
    fn step(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

impl Drive {
    fn new(scenario: Scenario, Recorder(events): Recorder, trial: Trial) -> Self {
        let end = Vector::from_array(trial.end_cm);
        Self {
            scenario,
            events,
            trial,
            end,
        }
    }

    /// The positions of the robot's centre: before each action, and after the last.
    pub fn positions(&self) -> Vec<Vector> {
        let before = self.events.iter().map(|event| event.pose.position());
        before.chain([self.end]).collect()
    }

    /// For each action, the pattern that chose it; `None` if there was none.
    pub fn codes(&self) -> impl Iterator<Item = Option<PatternCode>> {
        self.events
            .iter()
            .map(|event| Some(event.record.perceived?.code))
    }

    /// Whether a sensor on this side saw anything in its range before an action.
    pub fn saw(&self, event: &Event, side: Side) -> bool {
        let range = micrometres(self.scenario.robot.range_cm(side)[1]);
        let distance = match side {
            Side::Front => event.sample.front,
            Side::Left => event.sample.left,
            Side::Right => event.sample.right,
        };
        distance < range
    }

    /// Only its first actions; `trial` stays that of the whole drive.
    pub fn first(mut self, actions: usize) -> Self {
        if let Some(next) = self.events.get(actions) {
            self.end = next.pose.position();
            self.events.truncate(actions);
        }
        self
    }
}

/// The first trial of a session, made again: a seed decides all that happens in it. `None` if the
/// session has no trials.
pub fn first_trial(plan: &SessionPlan, coefficients: &Coefficients) -> Option<Drive> {
    let plan = SessionPlan {
        trials: plan.trials.min(1),
        ..plan.clone()
    };
    let mut arenas = generator(plan.seed, Stream::Learning);
    let scenario = met(&plan.arenas.scenario(&mut arenas), plan.follow_direction);
    let mut recorder = Recorder::default();
    let session = learn(&plan, coefficients, &mut recorder, |_| ());
    let trial = session.trials.into_iter().next()?;
    Some(Drive::new(scenario, recorder, trial))
}

/// The scenario as it is met: to who follows a direction, an arena's target is nothing.
fn met(scenario: &Scenario, follow_direction: bool) -> Scenario {
    let goal = scenario.goal.filter(|_| !follow_direction);
    Scenario {
        goal,
        ..scenario.clone()
    }
}

/// The drives of a test, as [`crate::experiment::examine_knowledge`] makes them.
pub fn test_drives(exam: &Exam, coefficients: &Coefficients, known: &Known) -> Vec<Drive> {
    let mut drives = Vec::new();
    examine(exam, |i, scenario, conduct| {
        let mut known = Box::new(known.clone());
        let rng = Generator::with_stream(numbered(exam.seed, i), Stream::Examined as u64);
        let controller = Controller::new(coefficients, PaperRule, &mut known, rng, Mode::Run);
        let mut recorder = Recorder::default();
        let trial = run_trial(
            scenario,
            conduct,
            &mut Turing::new(controller, &mut recorder),
        );
        let met = met(scenario, exam.follow_direction);
        drives.push(Drive::new(met, recorder, trial.clone()));
        trial
    });
    drives
}
