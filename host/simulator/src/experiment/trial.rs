//! One trial: a robot in an arena until it arrives or has used up its actions.

use rand_core::Rng as _;
use rand_pcg::Pcg32;
use rover_shared::sensing::Sample;
use rover_shared::units::Microdegrees;

use super::measures::directedness;
use super::pilot::{Pilot, TaskKind};
use crate::arena::{Motion, Robot, RobotModel, Scenario};

/// How a trial is conducted.
#[derive(Clone, Debug)]
pub struct Conduct {
    /// Actions allowed (III-B: 500).
    pub steps: u32,
    /// What to do: with `Some`, follow a direction that changes by chance; with `None`, aim at the
    /// target.
    pub directions: Option<Directions>,
}

/// Directions that change at random (IV-A).
#[derive(Clone, Debug)]
pub struct Directions {
    rng: Pcg32,
    current: Microdegrees,
}

impl Directions {
    /// Chance that the direction changes at an action, as a fraction of 2^32: 0.02.
    const CHANGE: u32 = 85_899_346;

    /// Directions drawn from `rng`.
    pub fn new(mut rng: Pcg32) -> Self {
        let current = any_direction(&mut rng);
        Self { rng, current }
    }

    fn changed(&mut self) -> bool {
        let change = self.rng.next_u32() < Self::CHANGE;
        if change {
            self.current = any_direction(&mut self.rng);
        }
        change
    }
}

fn any_direction(rng: &mut Pcg32) -> Microdegrees {
    let turn = 2 * i64::from(Microdegrees::HALF_TURN.0);
    Microdegrees::wrapped((i64::from(rng.next_u32()) * turn) >> 32)
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// At the target.
    Reached,
    /// All actions were used up.
    OutOfSteps,
}

/// What became of a trial.
#[derive(Clone, Debug)]
pub struct Trial {
    /// How it ended.
    pub ending: Ending,
    /// Actions taken.
    pub steps: u32,
    /// Moves that ended at an obstacle.
    pub collisions: u32,
    /// Where the robot was at the end.
    pub end_cm: [f64; 2],
    /// Length of the way driven over the straight distance from start to target; `None` without
    /// a target, or if it was not reached.
    pub path_ratio: Option<f64>,
    /// (8), from all moves.
    pub directedness: Option<f64>,
    /// With a direction to follow and nothing in sight for as long as a turn takes: the mean of
    /// the angle to it, in degrees.
    pub free_angle_deg: Option<f64>,
}

impl Trial {
    /// Whether the target was reached.
    pub fn reached(&self) -> bool {
        self.ending == Ending::Reached
    }

    /// Whether it was reached without a collision.
    pub fn clean(&self) -> bool {
        self.reached() && self.collisions == 0
    }
}

/// Lets `pilot` steer the robot of `scenario`.
pub fn run_trial(scenario: &Scenario, conduct: &mut Conduct, pilot: &mut impl Pilot) -> Trial {
    let mut robot = Robot::new(scenario);
    if conduct.directions.is_some() {
        // Who follows a direction has no target, even in an arena that has one.
        robot.set_goal(None);
    }
    let mut path_cm = vec![robot.pose().position().to_array()];
    let mut free = FreeHeading::default();
    pilot.begin_trial(scenario);
    let mut sample = robot.sense();
    let mut steps = 0;
    while steps < conduct.steps && !robot.at_goal() {
        let task = next_task(conduct, pilot, &mut free, &sample, &robot);
        let action = pilot.act(&robot, &sample, task);
        let motion = robot.act(action.phase, action.module);
        pilot.moved(motion);
        if motion == Motion::Moved {
            path_cm.push(robot.pose().position().to_array());
        }
        steps += 1;
        sample = robot.sense();
    }
    let reached = robot.at_goal();
    let ending = if reached {
        Ending::Reached
    } else {
        Ending::OutOfSteps
    };
    pilot.end_trial(&sample, current_task(conduct), ending);
    let straight = scenario.straight_cm();
    Trial {
        ending,
        steps,
        collisions: robot.collisions(),
        path_ratio: straight
            .filter(|&straight| reached && straight > 0.0)
            .map(|straight| robot.path_cm() / straight),
        directedness: directedness(&path_cm),
        end_cm: robot.pose().position().to_array(),
        free_angle_deg: free.mean(),
    }
}

fn current_task(conduct: &Conduct) -> TaskKind {
    match &conduct.directions {
        None => TaskKind::AimAtTarget,
        Some(directions) => TaskKind::FollowDirection {
            direction_udeg: directions.current,
        },
    }
}

fn next_task(
    conduct: &mut Conduct,
    pilot: &mut impl Pilot,
    free: &mut FreeHeading,
    sample: &Sample,
    robot: &Robot,
) -> TaskKind {
    if let Some(directions) = &mut conduct.directions {
        if directions.changed() {
            pilot.task_changed();
            free.restart();
        }
        free.note(sample, directions.current, robot.model());
    }
    current_task(conduct)
}

/// Collects the angle to the direction to follow where nothing hinders.
#[derive(Default)]
pub struct FreeHeading {
    undisturbed: u32,
    angles_deg: Vec<f64>,
}

impl FreeHeading {
    /// Actions that a turn by 180 degrees takes with zig-zag phases of about 10 degrees.
    const TURN: u32 = 20;

    /// The direction has changed, or something was in sight.
    pub fn restart(&mut self) {
        self.undisturbed = 0;
    }

    /// Takes note of a sample.
    pub fn note(&mut self, sample: &Sample, direction: Microdegrees, robot: &RobotModel) {
        use crate::arena::Side;
        let range = |side| crate::arena::micrometres(robot.range_cm(side)[1]);
        let free = sample.front >= range(Side::Front)
            && sample.left >= range(Side::Left)
            && sample.right >= range(Side::Right);
        self.undisturbed = if free { self.undisturbed + 1 } else { 0 };
        if self.undisturbed > Self::TURN {
            let angle = direction.turn_from(sample.heading);
            self.angles_deg.push(f64::from(angle.0.abs()) / 1e6);
        }
    }

    /// The mean angle in degrees.
    pub fn mean(&self) -> Option<f64> {
        super::measures::mean(&self.angles_deg).map(|mean| mean.value)
    }
}
