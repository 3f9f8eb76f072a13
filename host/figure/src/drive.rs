//! Drives kept action by action, to be drawn.

use std::ops::Range;

use rover_shared::controller::Controller;
use rover_shared::learning::Mode;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::parameters::Coefficients;
use rover_shared::perception::PatternCode;
use rover_shared::random::Generator;
use rover_shared::units::{Microdegrees, Micrometres};

use rover_simulator::arena::{Scenario, Side, Vector, degrees, micrometres, unit};
use rover_simulator::experiment::{
    Event, Exam, Known, SessionPlan, Stream, Trial, Turing, Witness, examine, generator, learn,
    numbered, run_trial,
};

/// A trial with all that happened in it.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Its number in the log or the test, from 1.
    pub number: u32,
    /// The number of its first action in the log or the session, from 0.
    pub first_action: u64,
    /// Actions of the trial before those that are kept.
    pub from: usize,
    /// Whether the scenario's walls and obstacles are those that were there.
    pub arena_known: bool,
    /// Where it took place.
    pub scenario: Scenario,
    /// Its actions, in order.
    pub events: Vec<Event>,
    /// What came of it.
    pub trial: Trial,
    /// Where the last of the actions led to.
    pub end: Vector,
}

/// What a distance sensor saw.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Where the sensor was.
    pub from: Vector,
    /// Where it pointed.
    pub axis: Microdegrees,
    /// Half its field of view, in degrees.
    pub half_field_deg: f64,
    /// How far it can see.
    pub range_cm: f64,
    /// What it measured, at most its range. (Of two sensors on one side only the shorter reading
    /// is known.)
    pub distance_cm: f64,
    /// Whether anything was within its range.
    pub seen: bool,
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
    fn simulated(
        number: u32,
        scenario: Scenario,
        Recorder(events): Recorder,
        trial: Trial,
    ) -> Self {
        let end = Vector::from_array(trial.end_cm);
        Self {
            number,
            first_action: 0,
            from: 0,
            arena_known: true,
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

    /// What each sensor saw before an action.
    pub fn readings(&self, event: &Event) -> impl Iterator<Item = Reading> {
        let pose = event.pose;
        let ahead = unit(pose.heading);
        let sample = event.sample;
        let seen = [Side::Front, Side::Left, Side::Right].map(|side| self.saw(event, side));
        self.scenario.robot.sensors.iter().map(move |sensor| {
            let (distance, seen) = match sensor.side {
                Side::Front => (sample.front, seen[0]),
                Side::Left => (sample.left, seen[1]),
                Side::Right => (sample.right, seen[2]),
            };
            let distance_cm = f64::from(distance.0) / f64::from(Micrometres::PER_CM);
            Reading {
                from: pose.position() + ahead.rotate(Vector::from_array(sensor.mount_cm)),
                axis: pose.heading.turned(degrees(sensor.axis_deg)),
                half_field_deg: sensor.half_field_deg,
                range_cm: sensor.max_cm,
                distance_cm: distance_cm.min(sensor.max_cm),
                seen,
            }
        })
    }

    /// A stretch of it, as if it had begun there; `trial` stays that of the whole drive.
    pub fn stretch(&self, actions: Range<usize>) -> Self {
        let mut drive = self.clone().first(actions.end);
        drive.events.drain(..actions.start.min(drive.events.len()));
        if let Some(event) = drive.events.first() {
            drive.scenario.start = event.pose;
        }
        drive.first_action += actions.start as u64;
        drive.from += actions.start;
        drive
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
    Some(Drive::simulated(1, scenario, recorder, trial))
}

/// The scenario as it is met: to who follows a direction, an arena's target is nothing.
fn met(scenario: &Scenario, follow_direction: bool) -> Scenario {
    let goal = scenario.goal.filter(|_| !follow_direction);
    Scenario {
        goal,
        ..scenario.clone()
    }
}

/// The drives of a test, as [`rover_simulator::experiment::examine_knowledge`] makes them.
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
        let number = i as u32 + 1;
        drives.push(Drive::simulated(number, met, recorder, trial.clone()));
        trial
    });
    drives
}
