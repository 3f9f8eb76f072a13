//! The message of channel `/arena`: where a trial takes place. Simulators know it; a rover on a
//! floor does not, and its logs have no such messages.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::message::LoggedPose;
use rover_simulator::arena::{
    Circle, Goal, Obstacle, OccupancyGrid, Polygon, Pose, RangeSensor, Rect, RobotModel, Scenario,
    Side, World,
};

/// Where a trial takes place, written before its first step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Arena {
    /// Counts trials, from 1.
    pub trial: u32,
    /// What stands where, and the robot; `None` if nothing has changed since the trial before: a
    /// map may have thousands of shapes.
    pub place: Option<Place>,
    /// Where the robot starts.
    pub start: LoggedPose,
    /// What it has to reach, if anything.
    pub goal: Option<Disc>,
}

/// Walls, obstacles and the robot among them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Inner width.
    pub width_um: i64,
    /// Inner height.
    pub height_um: i64,
    /// What stands in it.
    pub obstacles: Vec<Shape>,
    /// The robot's move at each action.
    pub step_um: i64,
    /// The largest turn of an action.
    pub max_turn_udeg: i64,
    /// Radius of the robot's body: a move that ends nearer to something is blocked.
    pub contact_radius_um: i64,
    /// Its distance sensors.
    pub sensors: Vec<Sensor>,
}

/// A circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Of its centre, from the left wall.
    pub x_um: i64,
    /// Of its centre, from the lower wall.
    pub y_um: i64,
    /// Its radius.
    pub radius_um: i64,
}

/// The outline of an obstacle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// With its lower left corner. Maps are written as one for each run of occupied cells.
    Rect {
        /// From the left wall.
        x_um: i64,
        /// From the lower wall.
        y_um: i64,
        /// Width.
        w_um: i64,
        /// Height.
        h_um: i64,
    },
    /// A circle.
    Circle {
        /// Of its centre, from the left wall.
        x_um: i64,
        /// Of its centre, from the lower wall.
        y_um: i64,
        /// Its radius.
        radius_um: i64,
    },
    /// A polygon.
    Polygon {
        /// Its corners, x and y.
        points_um: Vec<[i64; 2]>,
    },
}

/// A distance sensor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// What it is for: `front`, `left` or `right`.
    pub side: LoggedSide,
    /// Ahead of the robot's centre, and left of it.
    pub mount_um: [i64; 2],
    /// Where it points, counter-clockwise from straight ahead.
    pub axis_udeg: i64,
    /// Half of its field of view.
    pub half_field_udeg: i64,
    /// How many rays sample the field.
    pub rays: u32,
    /// Its lowest reading.
    pub min_um: i64,
    /// Its highest reading.
    pub max_um: i64,
}

/// [`Side`] by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoggedSide {
    /// Ahead.
    Front,
    /// On the left.
    Left,
    /// On the right.
    Right,
}

/// The message of a trial, and of the one before, make no arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoArena {
    /// The place is that of the trial before, of which there is none.
    #[error("trial {0} refers to the arena of a trial before it, which the log does not have")]
    Nowhere(u32),
    /// The place cannot be.
    #[error("the arena of trial {0} has no extent, or an obstacle that is not a shape")]
    Impossible(u32),
}

impl Arena {
    /// The message for a scenario; `same_place` if walls, obstacles and robot are those of the
    /// message before.
    pub fn new(trial: u32, scenario: &Scenario, same_place: bool) -> Self {
        Self {
            trial,
            place: (!same_place).then(|| Place::new(scenario)),
            start: scenario.start.into(),
            goal: scenario.goal.map(|goal| Disc {
                x_um: um(goal.x_cm),
                y_um: um(goal.y_cm),
                radius_um: um(goal.radius_cm),
            }),
        }
    }

    /// The scenario that was logged, after that of the trial before.
    ///
    /// # Errors
    /// [`NoArena`], if a log was made by hand or changed.
    pub fn scenario(&self, before: Option<&Scenario>) -> Result<Scenario, NoArena> {
        let (world, robot) = match &self.place {
            Some(place) => place
                .restore()
                .ok_or(NoArena::Impossible(self.trial))
                .map(|(world, robot)| (Arc::new(world), robot))?,
            None => {
                let before = before.ok_or(NoArena::Nowhere(self.trial))?;
                (before.world.clone(), before.robot.clone())
            }
        };
        Ok(Scenario {
            world,
            robot,
            start: self.start.into(),
            goal: self.goal.map(|goal| Goal {
                x_cm: cm(goal.x_um),
                y_cm: cm(goal.y_um),
                radius_cm: cm(goal.radius_um),
            }),
        })
    }
}

impl Place {
    fn new(scenario: &Scenario) -> Self {
        let Scenario { world, robot, .. } = scenario;
        Self {
            width_um: um(world.width_cm()),
            height_um: um(world.height_cm()),
            obstacles: world.obstacles().iter().flat_map(shapes).collect(),
            step_um: um(robot.step_cm),
            max_turn_udeg: udeg(robot.max_turn_deg),
            contact_radius_um: um(robot.contact_radius_cm),
            sensors: robot.sensors.iter().map(Sensor::new).collect(),
        }
    }

    /// The place, unless it is none: a log may come from anywhere.
    fn restore(&self) -> Option<(World, RobotModel)> {
        let extents = [self.width_um, self.height_um];
        if extents
            .iter()
            .any(|extent| !(1..=FARTHEST_UM).contains(extent))
        {
            return None;
        }
        let obstacles = self.obstacles.iter().map(Shape::restore);
        let [width, height] = extents.map(cm);
        let world = World::new(width, height, obstacles.collect::<Option<_>>()?);
        let robot = RobotModel {
            step_cm: cm(self.step_um),
            max_turn_deg: self.max_turn_udeg as f64 / 1e6,
            contact_radius_cm: cm(self.contact_radius_um),
            sensors: self.sensors.iter().map(Sensor::restore).collect(),
        };
        Some((world, robot))
    }
}

/// Arenas wider than 10 km are none.
const FARTHEST_UM: i64 = 10_000_000_000;

fn shapes(obstacle: &Obstacle) -> Vec<Shape> {
    match obstacle {
        Obstacle::Rect(rect) => vec![Shape::rect(rect)],
        Obstacle::Circle(circle) => vec![Shape::Circle {
            x_um: um(circle.x_cm),
            y_um: um(circle.y_cm),
            radius_um: um(circle.r_cm),
        }],
        Obstacle::Polygon(polygon) => vec![Shape::Polygon {
            points_um: polygon
                .points()
                .iter()
                .map(|p| [um(p.x), um(p.y)])
                .collect(),
        }],
        Obstacle::Grid(grid) => runs(grid),
    }
}

/// A map's occupied cells, row by row, neighbours in one rectangle.
fn runs(grid: &OccupancyGrid) -> Vec<Shape> {
    let mut shapes = Vec::new();
    for row in 0..grid.rows() {
        let mut column = 0;
        while column < grid.columns() {
            let from = column;
            while column < grid.columns() && grid.is_occupied(column, row) {
                column += 1;
            }
            if column > from {
                shapes.push(Shape::rect(&Rect {
                    x_cm: from as f64 * grid.cell_cm(),
                    y_cm: row as f64 * grid.cell_cm(),
                    w_cm: (column - from) as f64 * grid.cell_cm(),
                    h_cm: grid.cell_cm(),
                }));
            }
            column += 1;
        }
    }
    shapes
}

impl Shape {
    fn rect(rect: &Rect) -> Self {
        Self::Rect {
            x_um: um(rect.x_cm),
            y_um: um(rect.y_cm),
            w_um: um(rect.w_cm),
            h_um: um(rect.h_cm),
        }
    }

    fn restore(&self) -> Option<Obstacle> {
        let inside = |value: &i64| value.unsigned_abs() <= FARTHEST_UM.unsigned_abs();
        match self {
            Self::Rect {
                x_um,
                y_um,
                w_um,
                h_um,
            } => {
                let numbers = [*x_um, *y_um, *w_um, *h_um];
                let [x_cm, y_cm, w_cm, h_cm] = numbers.map(cm);
                let is_one = numbers.iter().all(inside) && *w_um >= 0 && *h_um >= 0;
                is_one.then_some(Obstacle::Rect(Rect {
                    x_cm,
                    y_cm,
                    w_cm,
                    h_cm,
                }))
            }
            Self::Circle {
                x_um,
                y_um,
                radius_um,
            } => {
                let numbers = [*x_um, *y_um, *radius_um];
                let [x_cm, y_cm, r_cm] = numbers.map(cm);
                let is_one = numbers.iter().all(inside) && *radius_um >= 0;
                is_one.then_some(Obstacle::Circle(Circle { x_cm, y_cm, r_cm }))
            }
            Self::Polygon { points_um } => {
                if !points_um.iter().flatten().all(inside) {
                    return None;
                }
                let points = points_um.iter().map(|point| point.map(cm)).collect();
                Polygon::new(points).ok().map(Obstacle::Polygon)
            }
        }
    }
}

impl Sensor {
    fn new(sensor: &RangeSensor) -> Self {
        Self {
            side: match sensor.side {
                Side::Front => LoggedSide::Front,
                Side::Left => LoggedSide::Left,
                Side::Right => LoggedSide::Right,
            },
            mount_um: sensor.mount_cm.map(um),
            axis_udeg: udeg(sensor.axis_deg),
            half_field_udeg: udeg(sensor.half_field_deg),
            rays: sensor.rays as u32,
            min_um: um(sensor.min_cm),
            max_um: um(sensor.max_cm),
        }
    }

    fn restore(&self) -> RangeSensor {
        RangeSensor {
            side: match self.side {
                LoggedSide::Front => Side::Front,
                LoggedSide::Left => Side::Left,
                LoggedSide::Right => Side::Right,
            },
            mount_cm: self.mount_um.map(cm),
            axis_deg: self.axis_udeg as f64 / 1e6,
            half_field_deg: self.half_field_udeg as f64 / 1e6,
            rays: self.rays as usize,
            min_cm: cm(self.min_um),
            max_cm: cm(self.max_um),
        }
    }
}

impl From<LoggedPose> for Pose {
    fn from(pose: LoggedPose) -> Self {
        Self {
            x_cm: cm(pose.x_um),
            y_cm: cm(pose.y_um),
            heading: pose.heading_udeg,
        }
    }
}

fn um(cm: f64) -> i64 {
    (cm * 1e4).round() as i64
}

fn cm(um: i64) -> f64 {
    um as f64 / 1e4
}

fn udeg(angle_deg: f64) -> i64 {
    (angle_deg * 1e6).round() as i64
}

#[cfg(test)]
mod tests {
    use rand_pcg::Pcg32;

    use super::*;
    use rover_simulator::arena::Layout;

    fn scenario() -> Scenario {
        Layout::paper().draw(&mut Pcg32::new(1, 1))
    }

    #[test]
    fn what_is_written_is_read_again_to_a_micrometre() {
        for layout in [Layout::paper(), Layout::rover(500.0, 3, 10.0)] {
            let scenario = layout.draw(&mut Pcg32::new(7, 1));
            let first = Arena::new(1, &scenario, false);
            let json = serde_json::to_vec(&first).unwrap();
            let read: Arena = serde_json::from_slice(&json).unwrap();
            assert_eq!(read, first);
            let restored = read.scenario(None).unwrap();
            assert_eq!(Arena::new(1, &restored, false), first);
            assert_eq!(restored.world.obstacles().len(), layout.rectangles);
            let second = Arena::new(2, &scenario, true)
                .scenario(Some(&restored))
                .unwrap();
            assert!(Arc::ptr_eq(&second.world, &restored.world));
        }
    }

    #[test]
    fn a_map_becomes_one_rectangle_for_each_run_of_cells() {
        let occupied = [true, true, false, true, false, false, false, false];
        let grid = OccupancyGrid::new(4, 5.0, occupied.to_vec());
        let rect = |x_um, w_um| Shape::Rect {
            x_um,
            y_um: 0,
            w_um,
            h_um: 50_000,
        };
        assert_eq!(runs(&grid), [rect(0, 100_000), rect(150_000, 50_000)]);
    }

    #[test]
    fn impossible_arenas_are_refused() {
        let message = Arena::new(3, &scenario(), false);
        let changed = |change: fn(&mut Place)| {
            let mut message = message.clone();
            change(message.place.as_mut().unwrap());
            message.scenario(None).err()
        };
        let impossible = Some(NoArena::Impossible(3));
        assert_eq!(changed(|place| place.width_um = 0), impossible);
        assert_eq!(changed(|place| place.height_um = i64::MAX), impossible);
        let flat = Shape::Polygon {
            points_um: vec![[0, 0], [1, 0]],
        };
        let mut with_flat = message.clone();
        with_flat.place.as_mut().unwrap().obstacles.push(flat);
        assert_eq!(with_flat.scenario(None).err(), impossible);
        let nowhere = Arena {
            place: None,
            ..message.clone()
        };
        assert_eq!(nowhere.scenario(None).err(), Some(NoArena::Nowhere(3)));
    }
}
