//! An arena that stays the same from trial to trial, with what is left to chance.

use std::sync::Arc;

use rand_pcg::Pcg32;

use super::layout::Margins;
use super::model::RobotModel;
use super::pose::Pose;
use super::reach::Reach;
use super::scenario::{Goal, Scenario};
use super::world::World;

/// What the robot has to do in a fixed arena.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Task {
    /// Reach a given goal.
    Reach(Goal),
    /// Reach a goal of this radius in a random place, new for each trial.
    ReachAnywhere {
        /// The goal's radius.
        radius_cm: f64,
    },
    /// Follow a direction: there is no goal.
    Follow,
}

impl Task {
    /// The goal that is given, if one is.
    fn goal(self) -> Option<Goal> {
        match self {
            Self::Reach(goal) => Some(goal),
            Self::ReachAnywhere { .. } | Self::Follow => None,
        }
    }
}

/// A fixed arena; start and goal may be random.
#[derive(Clone, Debug)]
pub(super) struct Fixed {
    world: Arc<World>,
    robot: RobotModel,
    chance: Arc<Chance>,
    /// A start and goal that are known to fit, for when no draw does.
    fallback: (Pose, Option<Goal>),
}

/// What is given of start and goal, and where the rest may be.
#[derive(Debug)]
struct Chance {
    start: Option<Pose>,
    task: Task,
    margins: Margins,
    /// A random place is connected to the given one, or to the largest part of the arena.
    reach: Option<Reach>,
}

/// Attempts at start and goal, each of them many draws, before it is taken that there is no room.
const ATTEMPTS: usize = 50;

impl Fixed {
    /// Checks that there is room for what is left to chance. A random start and goal have, beyond
    /// the robot's contact radius, as much room as in the paper's arena (18 and 23 cm, 60 cm
    /// apart); where the arena is too narrow for that, half of it, a quarter, or none.
    ///
    /// # Errors
    /// With a sentence, if the robot fits nowhere.
    pub(super) fn new(
        world: World,
        robot: RobotModel,
        start: Option<Pose>,
        task: Task,
    ) -> Result<Self, String> {
        let contact = robot.contact_radius_cm;
        let given = task.goal().map(|goal| goal.position());
        let is_random = start.is_none() || matches!(task, Task::ReachAnywhere { .. });
        let origin = start.map(|start| start.position()).or(given);
        let reach = is_random.then(|| Reach::new(&world, contact, origin));
        let margins = Margins {
            start_cm: contact,
            goal_cm: contact,
            apart_cm: 0.0,
        };
        let mut chance = Chance {
            start,
            task,
            margins,
            reach,
        };
        // Any generator will do: it decides no more than which margins are taken.
        let mut rng = Pcg32::new(0, 0);
        for share in [1.0, 0.5, 0.25, 0.0] {
            chance.margins = Margins {
                start_cm: contact + 18.0 * share,
                goal_cm: contact + 23.0 * share,
                apart_cm: Margins::PAPER.apart_cm * share,
            };
            if let Some(fallback) = chance.draw(&world, &mut rng) {
                return Ok(Self {
                    world: Arc::new(world),
                    robot,
                    chance: Arc::new(chance),
                    fallback,
                });
            }
        }
        Err(format!(
            "there is no room for a random start or goal: expected places with {contact} cm free \
             around them, the robot's contact radius"
        ))
    }

    /// The robot.
    pub(super) fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// The next trial.
    pub(super) fn scenario(&self, rng: &mut Pcg32) -> Scenario {
        let (start, goal) = self.chance.draw(&self.world, rng).unwrap_or(self.fallback);
        Scenario {
            world: Arc::clone(&self.world),
            robot: self.robot.clone(),
            start,
            goal,
        }
    }
}

impl Chance {
    fn draw(&self, world: &World, rng: &mut Pcg32) -> Option<(Pose, Option<Goal>)> {
        (0..ATTEMPTS).find_map(|_| self.attempt(world, rng))
    }

    fn attempt(&self, world: &World, rng: &mut Pcg32) -> Option<(Pose, Option<Goal>)> {
        let reachable = |place| {
            self.reach
                .as_ref()
                .is_none_or(|reach| reach.contains(place))
        };
        let margins = &self.margins;
        let given = self.task.goal();
        let start = match self.start {
            Some(start) => start,
            None => margins.start(world, given.map(|goal| goal.position()), reachable, rng)?,
        };
        let goal = match self.task {
            Task::ReachAnywhere { radius_cm } => {
                Some(margins.goal(world, start.position(), radius_cm, reachable, rng)?)
            }
            Task::Reach(_) | Task::Follow => given,
        };
        Some((start, goal))
    }
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::{Obstacle, Rect};
    use super::*;

    /// A room of 100 by 80 and a pocket of 30 by 80 behind a wall without a door.
    fn world() -> World {
        let wall = Rect {
            x_cm: 100.0,
            y_cm: 0.0,
            w_cm: 5.0,
            h_cm: 80.0,
        };
        World::new(135.0, 80.0, vec![Obstacle::Rect(wall)])
    }

    #[test]
    fn random_starts_and_goals_are_in_the_same_room_with_space_around_them() {
        let task = Task::ReachAnywhere { radius_cm: 5.0 };
        let fixed = Fixed::new(world(), RobotModel::paper(), None, task).expect("there is room");
        let mut rng = Pcg32::new(3, 3);
        for _ in 0..200 {
            let scenario = fixed.scenario(&mut rng);
            let goal = scenario.goal.expect("asked for").position();
            assert!(scenario.start.x_cm < 100.0 && goal.x < 100.0);
            // At least half of the paper's margins fit into this room.
            assert!(scenario.world.clearance(scenario.start.position()) >= 11.0);
            assert!(scenario.world.clearance(goal) >= 13.5);
            assert!(goal.distance(scenario.start.position()) >= 30.0);
        }
    }

    #[test]
    fn a_random_goal_is_where_the_given_start_can_get_to() {
        let start = Pose {
            x_cm: 120.0,
            y_cm: 40.0,
            heading: super::super::pose::degrees(0.0),
        };
        let task = Task::ReachAnywhere { radius_cm: 5.0 };
        let fixed = Fixed::new(world(), RobotModel::paper(), Some(start), task).expect("fits");
        let goal = fixed
            .scenario(&mut Pcg32::new(4, 4))
            .goal
            .expect("asked for");
        assert!(goal.x_cm > 105.0);
    }

    #[test]
    fn no_room_is_a_sentence() {
        let tiny = World::new(3.0, 3.0, Vec::new());
        let error =
            Fixed::new(tiny, RobotModel::paper(), None, Task::Follow).expect_err("too small");
        assert!(
            error.contains("no room") && error.contains("2 cm"),
            "{error}"
        );
    }
}
