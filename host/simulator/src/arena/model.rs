//! What a robot is: its step, its body and its range sensors.

use rover_shared::units::Micrometres;
use serde::{Deserialize, Serialize};

use super::pose::micrometres;
use super::whole::{udeg, um};

/// The sensing neuron that a range sensor feeds (Fig. 2a).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Ahead; of several sensors, the one that sees nearest counts (IV-A).
    Front,
    /// To the left.
    Left,
    /// To the right.
    Right,
}

/// A sensor that reports the free distance within its field of view: a fan of rays, the shortest
/// of which counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RangeSensor {
    /// The neuron it feeds.
    pub side: Side,
    /// Where the distance is measured from: forward and to the left of the robot's centre.
    #[serde(rename = "mount_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "[i64; 2]"))]
    pub mount_cm: [f64; 2],
    /// Where the middle of the field points, counter-clockwise from straight ahead.
    #[serde(rename = "axis_udeg", with = "udeg")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub axis_deg: f64,
    /// The field reaches this far to both sides of the axis.
    #[serde(rename = "half_field_udeg", with = "udeg")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub half_field_deg: f64,
    /// Rays, spread evenly over the field with one at each edge; at least 1 (then on the axis).
    pub rays: u32,
    /// The reading where something is nearer than this.
    #[serde(rename = "min_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub min_cm: f64,
    /// The reading where nothing is nearer than this.
    #[serde(rename = "max_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub max_cm: f64,
}

/// A robot's body, step and sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RobotModel {
    /// The module of all actions, w_m (II-C).
    #[serde(rename = "step_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub step_cm: f64,
    /// The largest turn that an action may have, which the phases are limited to. Not the paper's.
    #[serde(rename = "max_turn_udeg", with = "udeg")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub max_turn_deg: f64,
    /// A move that would bring the robot's centre closer than this to anything is blocked.
    #[serde(rename = "contact_radius_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub contact_radius_cm: f64,
    /// Range sensors: at least one for each [`Side`].
    pub sensors: Vec<RangeSensor>,
}

/// Rays this far apart leave no gap that a 10 cm obstacle fits into at the longest range.
const RAY_SPACING_DEG: f64 = 5.0;

/// Half the rover's side of 35 cm (IV-A): its body is taken to be a disc, so that it can always
/// turn on the spot, as the rule of motion requires.
const ROVER_RADIUS_CM: f64 = 17.5;

impl RangeSensor {
    fn rays_for(half_field_deg: f64) -> u32 {
        (2.0 * half_field_deg / RAY_SPACING_DEG).round() as u32 + 1
    }

    /// The sensors of III-A: measured from the centre, 45 degrees to both sides of the axis.
    fn of_paper(side: Side, axis_deg: f64, max_cm: f64) -> Self {
        let (half_field_deg, mount_cm) = (45.0, [0.0, 0.0]);
        let rays = Self::rays_for(half_field_deg);
        Self {
            side,
            mount_cm,
            axis_deg,
            half_field_deg,
            rays,
            min_cm: 0.0,
            max_cm,
        }
    }

    /// A GP2D12 on the edge of the rover's body at `mount_deg`, pointing to `axis_deg`.
    fn gp2d12(side: Side, mount_deg: f64, axis_deg: f64, beam_deg: f64) -> Self {
        let (sin, cos) = libm::sincos(mount_deg.to_radians());
        Self {
            side,
            mount_cm: [ROVER_RADIUS_CM * cos, ROVER_RADIUS_CM * sin],
            axis_deg,
            half_field_deg: beam_deg / 2.0,
            rays: Self::rays_for(beam_deg / 2.0),
            // IV-A: "from 14 to 64 cm to limit noise".
            min_cm: 14.0,
            max_cm: 64.0,
        }
    }
}

impl RobotModel {
    /// The simulated robot of III-A: a point of contact radius 2 that moves 4 at a time; front
    /// range 40, side range 20, fields of +-45 degrees. The paper gives neither step nor radius:
    /// with these, learning comes out as it describes.
    pub fn paper() -> Self {
        Self {
            step_cm: 4.0,
            max_turn_deg: 45.0,
            contact_radius_cm: 2.0,
            sensors: vec![
                RangeSensor::of_paper(Side::Front, 0.0, 40.0),
                RangeSensor::of_paper(Side::Left, 90.0, 20.0),
                RangeSensor::of_paper(Side::Right, -90.0, 20.0),
            ],
        }
    }

    /// The simulated robot, twice as wide and a quarter faster.
    pub fn harder() -> Self {
        Self {
            step_cm: 5.0,
            max_turn_deg: 90.0,
            contact_radius_cm: 4.0,
            ..Self::paper()
        }
    }

    /// The roving robot of IV-A: a disc of radius 17.5 cm that moves 7 cm at a time, with four
    /// GP2D12 at its edge: two that look ahead, half a radius to the left and right of the
    /// middle, and two that look 45 degrees to the side. Sensors are ordered front left, front
    /// right, left, right. `beam_deg` is the width of a sensor's field.
    pub fn rover(beam_deg: f64) -> Self {
        Self {
            step_cm: 7.0,
            max_turn_deg: 45.0,
            contact_radius_cm: ROVER_RADIUS_CM,
            sensors: vec![
                RangeSensor::gp2d12(Side::Front, 30.0, 0.0, beam_deg),
                RangeSensor::gp2d12(Side::Front, -30.0, 0.0, beam_deg),
                RangeSensor::gp2d12(Side::Left, 45.0, 45.0, beam_deg),
                RangeSensor::gp2d12(Side::Right, -45.0, -45.0, beam_deg),
            ],
        }
    }

    /// [`RobotModel::step_cm`] in the core's unit.
    pub fn step(&self) -> Micrometres {
        micrometres(self.step_cm)
    }

    /// The lowest and highest reading of the sensors on a side: what -1 and 1 stand for once the
    /// reading is scaled. `[0, 0]` if there is none.
    pub fn range_cm(&self, side: Side) -> [f64; 2] {
        let on_side = self.sensors.iter().find(|sensor| sensor.side == side);
        on_side.map_or([0.0, 0.0], |sensor| [sensor.min_cm, sensor.max_cm])
    }
}
