//! Logs as figures need them: drives, what was learned, and how. This is the only place in which
//! figures know what a log looks like.

use std::collections::BTreeMap;
use std::sync::Arc;

use rover_shared::knowledge::KnowledgeError;
use rover_shared::learning::Mode;
use rover_shared::parameters::Coefficients;
use rover_shared::range_check::ParameterError;
use rover_shared::units::{Microdegrees, Micrometres};

use super::drive::Drive;
use rover_log::arena::NoArena;
use rover_log::knowledge;
use rover_log::knowledge::followed::Followed;
use rover_log::message::{End, Step};
use rover_log::{Entry, Log};
use rover_simulator::arena::{Motion, Pose, RobotModel, Scenario, Side, Vector, World, radians};
use rover_simulator::experiment::{
    Ending, Event, FreeHeading, History, TaskKind, Trial, directedness,
};

/// A log, taken apart into drives.
#[derive(Clone, Debug)]
pub struct LoggedSession {
    /// The seed of the controller's generator.
    pub seed: u64,
    /// Whether the controller learned.
    pub learning: bool,
    /// Whether there is more than what can be read.
    pub cut_off: bool,
    /// Whether nothing was known at its beginning.
    pub from_nothing: bool,
    /// Whether it is of a rover, which drives on and on: its drives are parts of that.
    pub free_running: bool,
    /// The parameters in use.
    pub coefficients: Coefficients,
    /// Its trials, in order.
    pub drives: Vec<Drive>,
    /// What was known at the end.
    pub lessons: Followed,
    /// How the staircases changed.
    pub history: History,
}

/// Why a log cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoggedSessionError {
    /// Its knowledge cannot be read.
    #[error("the log's knowledge cannot be read: {0}")]
    Knowledge(#[from] KnowledgeError),
    /// Its parameters cannot be used.
    #[error("the log's parameters cannot be used: {0}")]
    Parameters(#[from] ParameterError),
    /// Its arenas are none.
    #[error("{0}")]
    Arena(#[from] NoArena),
    /// Nothing happened.
    #[error("the log holds no actions, so there is nothing to draw")]
    Empty,
}

impl LoggedSession {
    /// Takes a log apart.
    ///
    /// # Errors
    /// If its knowledge or its arenas cannot be used, or if it has no actions.
    pub fn new(log: &Log) -> Result<Self, LoggedSessionError> {
        let (before, parameters) = knowledge::from_bytes(&log.before)?;
        let coefficients = Coefficients::new(&parameters)?;
        let limit = coefficients.learning.amplitude_limit;
        let mut history = History::new(before.sensing.neurons, limit);
        let mut lessons = Followed::of(&before, limit);
        let mut trials: BTreeMap<u32, Logged> = BTreeMap::new();
        for entry in &log.entries {
            match entry {
                Entry::Step(step) => {
                    let first_action = history.actions();
                    let trial = trials.entry(step.trial).or_insert_with(|| Logged {
                        first_action,
                        ..Logged::default()
                    });
                    trial.steps.push(step);
                    history.acted(step.record.learned.as_ref());
                    // What a gap leaves unknown is not drawn.
                    let _ = lessons.follow(&step.record);
                }
                Entry::End(end) => {
                    trials.entry(end.trial).or_default().end = Some(end);
                    history.concluded(end.learned.as_ref());
                    let _ = end.learned.map(|learned| lessons.learn(&learned));
                }
            }
        }
        if let Some(after) = &log.after {
            lessons = Followed::of(&knowledge::from_bytes(after)?.0, limit);
        }
        let scenarios = scenarios(log)?;
        let module = coefficients.learning.module;
        let drives = trials
            .iter()
            .filter(|(_, trial)| !trial.steps.is_empty())
            .map(|(number, trial)| {
                trial.drive(*number, scenarios.get(number), &coefficients, module)
            });
        let drives: Vec<Drive> = if log.free_running {
            (1..)
                .zip(drives.flat_map(|drive| parts(&drive)))
                .map(|(number, part)| Drive { number, ..part })
                .collect()
        } else {
            drives.collect()
        };
        if drives.is_empty() {
            return Err(LoggedSessionError::Empty);
        }
        Ok(Self {
            seed: log.origin.seed,
            learning: log.origin.mode == Mode::Learn,
            cut_off: log.cut_off || log.after.is_none(),
            free_running: log.free_running,
            from_nothing: before.patterns.elements().is_empty(),
            coefficients,
            drives,
            lessons,
            history,
        })
    }

    /// Whether it followed a direction rather than aimed at a target.
    pub fn follows_direction(&self) -> bool {
        let mut events = self.drives.iter().flat_map(|drive| &drive.events);
        events.any(|event| matches!(event.task, TaskKind::FollowDirection { .. }))
    }
}

/// Where each trial took place, as far as the log knows.
fn scenarios(log: &Log) -> Result<BTreeMap<u32, Scenario>, NoArena> {
    let mut scenarios = BTreeMap::new();
    let mut before: Option<Scenario> = None;
    for arena in &log.arenas {
        let scenario = arena.scenario(before.as_ref())?;
        before = Some(scenario.clone());
        scenarios.insert(arena.trial, scenario);
    }
    Ok(scenarios)
}

/// The messages of one trial.
#[derive(Default)]
struct Logged<'a> {
    first_action: u64,
    steps: Vec<&'a Step>,
    end: Option<&'a End>,
}

impl Logged<'_> {
    fn drive(
        &self,
        number: u32,
        scenario: Option<&Scenario>,
        coefficients: &Coefficients,
        module: Micrometres,
    ) -> Drive {
        let follows = |step: &&Step| matches!(step.task, TaskKind::FollowDirection { .. });
        let follow_direction = self.steps.iter().any(follows);
        let mut poses = self.poses(module);
        // An arena is of no use where the log does not say where in it the robot was.
        let placed = self.steps.iter().all(|step| step.pose.is_some());
        let scenario = scenario.filter(|_| placed);
        let arena_known = scenario.is_some();
        let scenario = match scenario {
            Some(scenario) => Scenario {
                goal: scenario.goal.filter(|_| !follow_direction),
                ..scenario.clone()
            },
            None => around(&mut poses, coefficients),
        };
        let end = poses.pop().map_or(Vector::ZERO, |pose| pose.position());
        let events: Vec<Event> = self
            .steps
            .iter()
            .zip(poses)
            .map(|(step, pose)| Event {
                interrupted: step.interrupted,
                task: step.task,
                sample: step.sample,
                pose,
                record: step.record,
                motion: moved(step),
            })
            .collect();
        let ending = self.end.map_or(Ending::OutOfSteps, |end| end.ending);
        let trial = came_of(&events, end, &scenario, ending);
        Drive {
            number,
            first_action: self.first_action,
            from: 0,
            arena_known,
            scenario,
            events,
            trial,
            end,
        }
    }

    /// Where the robot was before each action, and after the last. Where the log does not say, by
    /// dead reckoning: each move is as long as the module, in the direction that the compass shows
    /// after it; moves of which nobody knows whether they were made are left out.
    fn poses(&self, module: Micrometres) -> Vec<Pose> {
        let length = f64::from(module.0) / f64::from(Micrometres::PER_CM);
        let mut poses: Vec<Pose> = Vec::with_capacity(self.steps.len() + 1);
        let mut reckoned = Vector::ZERO;
        for (i, step) in self.steps.iter().enumerate() {
            let pose = step.pose.map_or(
                Pose {
                    x_cm: reckoned.x,
                    y_cm: reckoned.y,
                    heading: step.sample.heading,
                },
                Pose::from,
            );
            poses.push(pose);
            let turned = step.sample.heading.turned(step.record.action.phase);
            let after = match (self.steps.get(i + 1), self.end) {
                (Some(next), _) => next.sample.heading,
                (None, Some(end)) => end.sample.heading,
                (None, None) => turned,
            };
            reckoned = pose.position();
            if step.motion == Some(Motion::Moved) {
                let (sin, cos) = libm::sincos(radians(after));
                reckoned += Vector::new(cos, sin) * length;
            }
        }
        poses.push(Pose {
            x_cm: reckoned.x,
            y_cm: reckoned.y,
            heading: Microdegrees(0),
        });
        poses
    }
}

/// Actions of a part of a rover's drive.
pub(super) const PART: usize = 100;

/// A rover's drive in parts; a last one of less than half belongs to the one before.
fn parts(drive: &Drive) -> Vec<Drive> {
    let actions = drive.events.len();
    let count = ((actions + PART / 2) / PART).max(1);
    (0..count)
        .map(|i| {
            let end = if i + 1 == count {
                actions
            } else {
                (i + 1) * PART
            };
            let mut part = drive.stretch(i * PART..end);
            part.from = 0;
            part.trial = came_of(&part.events, part.end, &part.scenario, Ending::OutOfSteps);
            part
        })
        .collect()
}

/// What came of a trial, worked out as the simulator does.
fn came_of(events: &[Event], end: Vector, scenario: &Scenario, ending: Ending) -> Trial {
    let mut free = FreeHeading::default();
    for (i, event) in events.iter().enumerate() {
        if let TaskKind::FollowDirection { direction_udeg } = event.task {
            if event.interrupted && i > 0 {
                free.restart();
            }
            free.note(&event.sample, direction_udeg, &scenario.robot);
        }
    }
    let positions: Vec<[f64; 2]> = events
        .iter()
        .map(|event| event.pose.position().to_array())
        .chain([end.to_array()])
        .collect();
    let blocked = events
        .iter()
        .filter(|event| event.motion == Motion::Blocked);
    let length: f64 = positions
        .windows(2)
        .map(|ends| libm::hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]))
        .sum();
    let straight = scenario.straight_cm().filter(|straight| *straight > 0.0);
    Trial {
        ending,
        steps: events.len() as u32,
        collisions: blocked.count() as u32,
        end_cm: end.to_array(),
        path_ratio: straight
            .filter(|_| ending == Ending::Reached)
            .map(|straight| length / straight),
        directedness: directedness(&positions),
        free_angle_deg: free.mean(),
    }
}

/// What became of an action. Where nobody can tell, nothing is known to have been in the way.
fn moved(step: &Step) -> Motion {
    step.motion.unwrap_or(Motion::Moved)
}

/// Room around a drive whose arena is not known.
const MARGIN_CM: f64 = 70.0;

/// A world without walls in sight that holds a drive; the poses are shifted into it.
fn around(poses: &mut [Pose], coefficients: &Coefficients) -> Scenario {
    let positions = || poses.iter().map(Pose::position);
    let low = positions().fold(Vector::splat(f64::INFINITY), Vector::min);
    let high = positions().fold(Vector::splat(f64::NEG_INFINITY), Vector::max);
    let (low, size) = (low - Vector::splat(MARGIN_CM), high - low);
    for pose in poses.iter_mut() {
        pose.x_cm -= low.x;
        pose.y_cm -= low.y;
    }
    let size = size + Vector::splat(2.0 * MARGIN_CM);
    let start = poses.first().copied().unwrap_or(Pose {
        x_cm: 0.0,
        y_cm: 0.0,
        heading: Microdegrees(0),
    });
    Scenario {
        world: Arc::new(World::new(size.x, size.y, Vec::new())),
        robot: rover(coefficients),
        start,
        goal: None,
    }
}

/// The rover of IV-A, with the ranges that the parameters give its sensors.
fn rover(coefficients: &Coefficients) -> RobotModel {
    let sensing = &coefficients.parameters().sensing;
    let mut model = RobotModel::rover(10.0);
    model.step_cm = coefficients.parameters().learning.module_cm;
    for sensor in &mut model.sensors {
        [sensor.min_cm, sensor.max_cm] = match sensor.side {
            Side::Front => [sensing.front_near_cm, sensing.front_far_cm],
            Side::Left | Side::Right => [sensing.side_near_cm, sensing.side_far_cm],
        };
    }
    model
}
