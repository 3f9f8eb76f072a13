//! The sensing block (II-A): from what the sensors measured to what the lattice starts from.
//!
//! A [`Sample`] in physical units is scaled linearly into a [`Percept`] in [-1, 1]; each of its
//! four stimuli then passes through a [`neuron::SensingNeuron`], a learned ten-step staircase.

pub mod compass;
pub mod ir;
pub mod neuron;
mod ranges;
mod scaled;

pub use ranges::{DistanceRange, SensingParameters, SensorRanges};
pub use scaled::{OutOfScale, Scaled};

use serde::{Deserialize, Serialize};

use crate::units::{Microdegrees, Micrometres};
use neuron::StepIndex;

/// One reading of all sensors, in physical units, before any scaling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Sample {
    /// Free distance ahead: the shorter one where a robot has two front sensors (IV-A).
    #[serde(rename = "front_um")]
    pub front: Micrometres,
    /// Free distance on the left.
    #[serde(rename = "left_um")]
    pub left: Micrometres,
    /// Free distance on the right.
    #[serde(rename = "right_um")]
    pub right: Micrometres,
    /// The robot's heading, counter-clockwise in the world's frame.
    #[serde(rename = "heading_udeg")]
    pub heading: Microdegrees,
    /// Bearing of the target as seen from the robot, counter-clockwise in the world's frame;
    /// `None` for robots without a target sensor.
    #[serde(rename = "target_bearing_udeg")]
    pub target_bearing: Option<Microdegrees>,
}

/// The four stimuli, in the order of all arrays of four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Stimulus {
    /// Distance ahead, F; sets the upper left corner.
    Front,
    /// Distance on the left, L; sets the upper right corner.
    Left,
    /// Distance on the right, R; sets the lower left corner.
    Right,
    /// Angle to the target, T; sets the lower right corner.
    Target,
}

impl Stimulus {
    /// All four, in array order.
    pub const ALL: [Self; 4] = [Self::Front, Self::Left, Self::Right, Self::Target];
}

/// What the robot senses, scaled: the input of the four sensing neurons, in the order of
/// [`Stimulus`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Percept(pub [Scaled; 4]);

impl Percept {
    /// Scales a sample's distances by the sensors' ranges, and the angle to the target (positive
    /// on the left, in (-180, 180] degrees) by half a turn.
    pub fn new(sample: &Sample, target_angle: Microdegrees, ranges: &SensorRanges) -> Self {
        // Floored, so that the smallest turn to the right already lies in the step below 0.
        let half_turn = Microdegrees::HALF_TURN.0 / Scaled::ONE;
        Self([
            ranges.front.scale(sample.front),
            ranges.side.scale(sample.left),
            ranges.side.scale(sample.right),
            Scaled::saturating(i64::from(target_angle.0.div_euclid(half_turn))),
        ])
    }

    /// Returns the steps that the four stimuli lie in.
    pub fn steps(&self) -> [StepIndex; 4] {
        self.0.map(Scaled::step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGES: SensorRanges = SensorRanges {
        front: DistanceRange {
            near: Micrometres::from_cm(14),
            far: Micrometres::from_cm(64),
        },
        side: DistanceRange {
            near: Micrometres(0),
            far: Micrometres::from_cm(20),
        },
    };

    #[test]
    fn each_five_centimetres_of_the_rovers_sensor_are_one_step() {
        for cm in 0..80u32 {
            let expected = (cm.max(14) - 14) / 5;
            let step = RANGES.front.scale(Micrometres::from_cm(cm)).step();
            assert_eq!(u32::from(step.index() as u8), expected.min(9), "{cm} cm");
        }
    }

    #[test]
    fn just_below_a_border_is_the_step_below() {
        let step = |um| RANGES.front.scale(Micrometres(um)).step().index();
        assert_eq!([step(190_000), step(189_999)], [1, 0]);
    }

    #[test]
    fn the_target_angle_has_five_steps_on_either_side() {
        let sample = Sample {
            front: Micrometres::from_cm(40),
            left: Micrometres::from_cm(1),
            right: Micrometres(u32::MAX),
            heading: Microdegrees(0),
            target_bearing: None,
        };
        let step = |angle| Percept::new(&sample, Microdegrees(angle), &RANGES).steps()[3].index();
        assert_eq!(
            [
                step(0),
                step(-1),
                step(36_000_000),
                step(180_000_000),
                step(-179_999_999)
            ],
            [5, 4, 6, 9, 0]
        );
        let percept = Percept::new(&sample, Microdegrees(90_000_000), &RANGES);
        assert_eq!(
            percept.0.map(Scaled::millionths),
            [40_000, -900_000, 1_000_000, 500_000]
        );
    }
}
