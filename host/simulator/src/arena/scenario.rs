//! What a trial starts from.

use std::sync::Arc;

use parry2d_f64::math::Vector;
use serde::{Deserialize, Serialize};

use super::model::RobotModel;
use super::pose::Pose;
use super::whole::um;
use super::world::World;

/// What a robot has to reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// From the left wall.
    #[serde(rename = "x_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub x_cm: f64,
    /// From the lower wall.
    #[serde(rename = "y_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub y_cm: f64,
    /// Reached when the robot's centre is no farther away than this.
    #[serde(rename = "radius_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub radius_cm: f64,
}

/// Everything that a trial starts from.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Walls and obstacles.
    pub world: Arc<World>,
    /// The robot's body and sensors.
    pub robot: RobotModel,
    /// Where the robot starts.
    pub start: Pose,
    /// What it has to reach; `None` where the task is to follow a direction.
    pub goal: Option<Goal>,
}

impl Goal {
    /// The goal's centre.
    pub fn position(&self) -> Vector {
        Vector::new(self.x_cm, self.y_cm)
    }
}

impl Scenario {
    /// The distance from start to the centre of the goal, which paths are compared with; `None`
    /// without a goal.
    pub fn straight_cm(&self) -> Option<f64> {
        self.goal
            .map(|goal| goal.position().distance(self.start.position()))
    }
}
