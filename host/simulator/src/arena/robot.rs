//! A robot in a world: what it senses, and what becomes of its moves.

use std::sync::Arc;

use parry2d_f64::math::Vector;
use rover_shared::sensing::Sample;
use rover_shared::units::{Microdegrees, Micrometres};

use super::model::{RobotModel, Side};
use super::pose::{Pose, centimetres, degrees, micrometres, unit};
use super::scenario::{Goal, Scenario};
use super::world::World;

/// What became of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// The robot turned and moved.
    Moved,
    /// The robot turned, but something stood in the way of the move.
    Blocked,
}

/// A robot in a world.
#[derive(Clone, Debug)]
pub struct Robot {
    world: Arc<World>,
    model: RobotModel,
    pose: Pose,
    goal: Option<Goal>,
    collisions: u32,
    path_cm: f64,
    /// The directions of each sensor's rays as seen from a robot that points right.
    rays: Vec<Vec<Vector>>,
}

impl Robot {
    /// The robot of a scenario at its start.
    pub fn new(scenario: &Scenario) -> Self {
        let model = scenario.robot.clone();
        let fan = |axis: f64, half_field: f64, rays: u32| -> Vec<Vector> {
            let spacing = 2.0 * half_field / f64::from(rays.saturating_sub(1).max(1));
            let first = if rays > 1 { axis - half_field } else { axis };
            (0..rays.max(1))
                .map(|i| unit(degrees(first + spacing * f64::from(i))))
                .collect()
        };
        let rays = model
            .sensors
            .iter()
            .map(|s| fan(s.axis_deg, s.half_field_deg, s.rays))
            .collect();
        Self {
            world: Arc::clone(&scenario.world),
            model,
            pose: scenario.start,
            goal: scenario.goal,
            collisions: 0,
            path_cm: 0.0,
            rays,
        }
    }

    /// Where the robot is.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// The robot's body and sensors.
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The world it is in.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Blocked moves so far.
    pub fn collisions(&self) -> u32 {
        self.collisions
    }

    /// The length of all moves so far.
    pub fn path_cm(&self) -> f64 {
        self.path_cm
    }

    /// Puts the robot at a pose without checking that there is room: for simulations that move it
    /// by other rules than [`Robot::act`].
    pub fn place(&mut self, pose: Pose) {
        self.pose = pose;
    }

    /// Changes the goal, which the target sensor points to.
    pub fn set_goal(&mut self, goal: Option<Goal>) {
        self.goal = goal;
    }

    /// Whether the robot's centre is within the goal's radius. Never, without a goal.
    pub fn at_goal(&self) -> bool {
        self.goal
            .is_some_and(|goal| goal.position().distance(self.pose.position()) <= goal.radius_cm)
    }

    /// Turns by `turn`, then moves `advance` ahead. The move is blocked if, in its middle or at
    /// its end, the clearance would be below the contact radius: the robot then keeps the new
    /// heading and the old position, and the collision is counted.
    pub fn act(&mut self, turn: Microdegrees, advance: Micrometres) -> Motion {
        self.pose.heading = self.pose.heading.turned(turn);
        let from = self.pose.position();
        let length = centimetres(advance);
        let step = unit(self.pose.heading) * length;
        let free = |point| self.world.clearance(point) >= self.model.contact_radius_cm;
        let to = from + step;
        if !(free(from + step * 0.5) && free(to)) {
            self.collisions += 1;
            return Motion::Blocked;
        }
        (self.pose.x_cm, self.pose.y_cm) = (to.x, to.y);
        self.path_cm += length;
        Motion::Moved
    }

    /// The free distance that sensor number `sensor` of the model sees, at most `max_cm`, not
    /// limited to the sensor's own range. `max_cm` if there is no such sensor.
    pub fn distance_cm(&self, sensor: usize, max_cm: f64) -> f64 {
        let (Some(model), Some(rays)) = (self.model.sensors.get(sensor), self.rays.get(sensor))
        else {
            return max_cm;
        };
        let ahead = unit(self.pose.heading);
        let from = self.pose.position() + ahead.rotate(Vector::from_array(model.mount_cm));
        // Each ray only needs to beat the nearest so far.
        rays.iter().fold(max_cm, |nearest, ray| {
            self.world.ray_along(from, ahead.rotate(*ray), nearest)
        })
    }

    /// The free distances from the robot's centre in 37 directions, 5 degrees apart, from 90
    /// degrees to the right (first) to 90 degrees to the left, each at most `max_cm`. No robot of
    /// the paper has this sensor: it is what the vector field histogram is given.
    pub fn fan_cm(&self, max_cm: f64) -> [f64; 37] {
        let from = self.pose.position();
        std::array::from_fn(|i| {
            let bearing = Microdegrees::from_degrees(5 * i as i32 - 90);
            self.world
                .ray_along(from, unit(self.pose.heading.turned(bearing)), max_cm)
        })
    }

    /// Reads all sensors: for each side the nearest that one of its sensors sees, within that
    /// sensor's range; the heading; and, with a goal, where it lies.
    pub fn sense(&self) -> Sample {
        Sample {
            front: self.nearest(Side::Front),
            left: self.nearest(Side::Left),
            right: self.nearest(Side::Right),
            heading: self.pose.heading,
            target_bearing: self.goal.map(|goal| {
                let to = goal.position() - self.pose.position();
                degrees(libm::atan2(to.y, to.x).to_degrees())
            }),
        }
    }

    fn nearest(&self, side: Side) -> Micrometres {
        let sensors = self
            .model
            .sensors
            .iter()
            .enumerate()
            .filter(|(_, s)| s.side == side);
        let readings = sensors.map(|(i, s)| self.distance_cm(i, s.max_cm).max(s.min_cm));
        micrometres(readings.fold(f64::INFINITY, f64::min))
    }
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::{Obstacle, Rect};
    use super::*;

    const ADVANCE: Micrometres = Micrometres::from_cm(4);

    /// A robot of the paper in a room of 200 by 100 with a block from (100, 40) to (120, 60).
    fn robot(model: RobotModel, x_cm: f64, y_cm: f64, heading_deg: f64) -> Robot {
        let block = Rect {
            x_cm: 100.0,
            y_cm: 40.0,
            w_cm: 20.0,
            h_cm: 20.0,
        };
        Robot::new(&Scenario {
            world: Arc::new(World::new(200.0, 100.0, vec![Obstacle::Rect(block)])),
            robot: model,
            start: Pose {
                x_cm,
                y_cm,
                heading: degrees(heading_deg),
            },
            goal: Some(Goal {
                x_cm: 150.0,
                y_cm: 50.0,
                radius_cm: 12.0,
            }),
        })
    }

    fn paper(x_cm: f64, y_cm: f64, heading_deg: f64) -> Robot {
        robot(RobotModel::paper(), x_cm, y_cm, heading_deg)
    }

    #[test]
    fn nothing_in_range_reads_as_the_range() {
        let sample = paper(50.0, 50.0, 0.0).sense();
        let cm = Micrometres::from_cm;
        assert_eq!(
            (sample.front, sample.left, sample.right),
            (cm(40), cm(20), cm(20))
        );
        assert_eq!(sample.heading, Microdegrees(0));
        assert_eq!(sample.target_bearing, Some(Microdegrees(0)));
    }

    #[test]
    fn each_sensor_sees_the_nearest_in_its_own_field() {
        let cm = Micrometres::from_cm;
        // The block straight ahead, 15 away; it is out of both side fields.
        let ahead = paper(85.0, 50.0, 0.0).sense();
        assert_eq!(
            (ahead.front, ahead.left, ahead.right),
            (cm(15), cm(20), cm(20))
        );
        // Facing up, it is on the right; turned about, on the left.
        let up = paper(90.0, 50.0, 90.0).sense();
        assert_eq!((up.front, up.left, up.right), (cm(40), cm(20), cm(10)));
        let down = paper(90.0, 50.0, -90.0).sense();
        assert_eq!(
            (down.front, down.left, down.right),
            (cm(40), cm(10), cm(20))
        );
        // The corner of the room: the front field's edges meet both walls at 5 * sqrt(2) cm.
        let corner = paper(5.0, 5.0, 225.0).sense();
        assert_eq!(
            corner.front,
            micrometres(5.0),
            "rays to both walls are 45 degrees off"
        );
        assert_eq!(
            (corner.left, corner.right),
            (micrometres(5.0), micrometres(5.0))
        );
    }

    #[test]
    fn the_target_is_seen_from_everywhere() {
        let bearing = |x, y, heading| paper(x, y, heading).sense().target_bearing;
        assert_eq!(
            bearing(150.0, 20.0, 77.0),
            Some(Microdegrees::from_degrees(90))
        );
        assert_eq!(
            bearing(180.0, 80.0, 0.0),
            Some(Microdegrees::from_degrees(-135))
        );
        let mut without = paper(50.0, 50.0, 0.0);
        without.set_goal(None);
        assert_eq!(without.sense().target_bearing, None);
        assert!(!without.at_goal());
    }

    #[test]
    fn a_free_move_turns_first() {
        let mut robot = paper(50.0, 50.0, 0.0);
        assert_eq!(
            robot.act(Microdegrees::from_degrees(90), ADVANCE),
            Motion::Moved
        );
        let pose = robot.pose();
        assert!(
            (pose.x_cm - 50.0).abs() < 1e-12 && (pose.y_cm - 54.0).abs() < 1e-12,
            "{pose:?}"
        );
        assert_eq!(pose.heading, Microdegrees::from_degrees(90));
        assert_eq!((robot.collisions(), robot.path_cm()), (0, 4.0));
    }

    #[test]
    fn a_blocked_move_keeps_the_rotation_and_the_position() {
        // The end would be 1 cm from the block, the contact radius is 2.
        let mut robot = paper(95.0, 50.0, 10.0);
        assert_eq!(
            robot.act(Microdegrees::from_degrees(-10), ADVANCE),
            Motion::Blocked
        );
        let expected = Pose {
            x_cm: 95.0,
            y_cm: 50.0,
            heading: Microdegrees(0),
        };
        assert_eq!(robot.pose(), expected);
        assert_eq!((robot.collisions(), robot.path_cm()), (1, 0.0));
        // Exactly the contact radius is still free.
        assert_eq!(
            robot.act(Microdegrees(0), Micrometres::from_cm(3)),
            Motion::Moved
        );
    }

    #[test]
    fn a_move_is_blocked_by_what_is_in_its_middle() {
        // The end at 124 is free again, the middle at 110 is inside the block.
        let mut robot = paper(96.0, 50.0, 0.0);
        assert_eq!(
            robot.act(Microdegrees(0), Micrometres::from_cm(28)),
            Motion::Blocked
        );
    }

    #[test]
    fn the_goal_is_reached_at_its_radius() {
        assert!(paper(138.0, 50.0, 0.0).at_goal());
        assert!(!paper(137.9, 50.0, 0.0).at_goal());
    }

    #[test]
    fn the_rover_measures_from_the_edge_of_its_body() {
        // The block's left face is at 100. Two sensors look ahead from half a radius to the left
        // and right, at 17.5 * cos(30 deg) ahead of the centre.
        let model = RobotModel::rover(10.0);
        let ahead = 17.5 * libm::cos(30f64.to_radians());
        let at = |distance: f64| robot(model.clone(), 100.0 - ahead - distance, 50.0, 0.0).sense();
        assert_eq!(at(30.0).front, micrometres(30.0));
        assert_eq!(
            at(10.0).front,
            micrometres(14.0),
            "nearer than 14 cm reads as 14 cm"
        );
        assert_eq!(
            at(30.0).left,
            micrometres(
                (100.0 - 50.0 - 17.5 * libm::sin(45f64.to_radians()))
                    / libm::sin(50f64.to_radians())
            ),
            "the wall, along the ray that is turned most to it"
        );
        // The two front sensors are 17.5 cm apart: something on one side is seen by one of them.
        let aside = robot(model, 50.0, 33.0, 0.0);
        assert!(aside.distance_cm(0, 80.0) < 36.0 && aside.distance_cm(1, 80.0) > 60.0);
    }

    #[test]
    fn the_fan_goes_from_right_to_left() {
        let fan = paper(190.0, 50.0, 0.0).fan_cm(30.0);
        assert_eq!((fan[0], fan[36]), (30.0, 30.0));
        assert!((fan[18] - 10.0).abs() < 1e-9);
        let up = paper(190.0, 50.0, 90.0).fan_cm(30.0);
        assert!((up[0] - 10.0).abs() < 1e-9, "the right wall");
        assert_eq!(up[36], 30.0);
    }
}
