//! The sensing block (II-A): from what the sensors measured to what the lattice starts from.
//!
//! A [`Sample`] in physical units is scaled linearly into a [`Percept`] in [-1, 1]; each of its
//! four stimuli then passes through a [`neuron::SensingNeuron`], a learned ten-step staircase.

pub mod compass;
pub mod ir;
pub mod neuron;

use serde::{Deserialize, Serialize};

use crate::units::{Microdegrees, Micrometres};
use neuron::{STEPS, StepIndex};

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
    /// Where the robot points, counter-clockwise in the world's frame.
    #[serde(rename = "heading_udeg")]
    pub heading: Microdegrees,
    /// Where the target lies as seen from the robot, counter-clockwise in the world's frame;
    /// `None` for robots without a target sensor.
    #[serde(rename = "target_bearing_udeg")]
    pub target_bearing: Option<Microdegrees>,
}

/// The four things the robot senses, in the order in which arrays of four hold them.
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

/// A stimulus scaled to [-1, 1], in millionths.
///
/// Decimal, so that the borders between the ten steps are hit exactly: a tenth of any sensor's
/// range is 200,000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("minimum" = -1_000_000, "maximum" = 1_000_000)))]
#[serde(try_from = "i32", into = "i32")]
pub struct Scaled(i32);

/// A number that is no scaled stimulus: outside [-1, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfScale;

impl core::fmt::Display for OutOfScale {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "expected a number from -1000000 to 1000000")
    }
}

impl TryFrom<i32> for Scaled {
    type Error = OutOfScale;

    fn try_from(millionths: i32) -> Result<Self, OutOfScale> {
        let scaled = Self::saturating(millionths.into());
        if scaled.0 == millionths {
            Ok(scaled)
        } else {
            Err(OutOfScale)
        }
    }
}

impl From<Scaled> for i32 {
    fn from(scaled: Scaled) -> i32 {
        scaled.0
    }
}

impl Scaled {
    /// What stands for 1.
    pub const ONE: i32 = 1_000_000;

    /// The value nearest to `millionths` that lies in [-1, 1].
    pub const fn saturating(millionths: i64) -> Self {
        if millionths > Self::ONE as i64 {
            Self(Self::ONE)
        } else if millionths < -(Self::ONE as i64) {
            Self(-Self::ONE)
        } else {
            Self(millionths as i32)
        }
    }

    /// The value in millionths, -1,000,000 to 1,000,000.
    pub const fn millionths(self) -> i32 {
        self.0
    }

    /// The step of a sensing neuron in which this input lies: floor(5 (s + 1)), at most 9.
    pub const fn step(self) -> StepIndex {
        let step = (self.0 + Self::ONE) / (2 * Self::ONE / STEPS as i32);
        StepIndex::saturating(step as u32)
    }
}

/// The range within which a distance sensor is believed; outside it saturates (III-A, IV-A).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DistanceRange {
    /// Distances up to here scale to -1.
    pub near: Micrometres,
    /// Distances from here on scale to 1.
    pub far: Micrometres,
}

impl DistanceRange {
    /// Scales linearly: near to -1, far to 1, saturating beyond both.
    pub fn scale(&self, distance: Micrometres) -> Scaled {
        let width = i64::from(self.far.0) - i64::from(self.near.0);
        let inside = i64::from(distance.0) - i64::from(self.near.0);
        Scaled::saturating(2 * i64::from(Scaled::ONE) * inside / width.max(1) - 1_000_000)
    }
}

/// The ranges of the distance sensors of one robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorRanges {
    /// Of the front sensor.
    pub front: DistanceRange,
    /// Of the left and the right sensor.
    pub side: DistanceRange,
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

    /// The steps that the four stimuli lie in.
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
