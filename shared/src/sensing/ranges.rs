//! The ranges of the distance sensors, and the scaling of distances by them.

use serde::{Deserialize, Serialize};

use super::scaled::Scaled;
use crate::range_check::{ParameterError, check_all};
use crate::units::Micrometres;

/// Ranges of the distance sensors, in centimetres (pixels in the paper's arena).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensingParameters {
    /// Distances below this count as this, in front.
    pub front_near_cm: f64,
    /// Distances above this count as this, in front.
    pub front_far_cm: f64,
    /// As `front_near_cm`, for the left and right sensor.
    pub side_near_cm: f64,
    /// As `front_far_cm`, for the left and right sensor.
    pub side_far_cm: f64,
}

impl SensingParameters {
    /// III-A: 40 px in front, 20 px at the sides.
    pub const PAPER: Self = Self {
        front_near_cm: 0.0,
        front_far_cm: 40.0,
        side_near_cm: 0.0,
        side_far_cm: 20.0,
    };
    /// IV-A: 14 to 64 cm, for all four infrared sensors.
    pub const ROVER: Self = Self {
        front_near_cm: 14.0,
        front_far_cm: 64.0,
        side_near_cm: 14.0,
        side_far_cm: 64.0,
    };
}

impl Default for SensingParameters {
    fn default() -> Self {
        Self::PAPER
    }
}

/// The longest distance a sensor can be given, in cm: this robot's sensors see no farther.
const FARTHEST_CM: f64 = 10_000.0;

/// The range of a distance sensor; outside it distances saturate (III-A, IV-A).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DistanceRange {
    /// Distances up to here scale to -1.
    pub near: Micrometres,
    /// Distances from here on scale to 1.
    pub far: Micrometres,
}

impl DistanceRange {
    /// Scales a distance linearly: near to -1, far to 1, saturating beyond both.
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

impl SensorRanges {
    /// Checks the parameters and converts them.
    ///
    /// # Errors
    /// The first parameter outside its range, or a range of less than 1 cm.
    pub const fn new(p: &SensingParameters) -> Result<Self, ParameterError> {
        check_all! {
            "sensing.front_near_cm": p.front_near_cm, 0.0, FARTHEST_CM;
            "sensing.front_far_cm": p.front_far_cm, 0.0, FARTHEST_CM;
            "sensing.side_near_cm": p.side_near_cm, 0.0, FARTHEST_CM;
            "sensing.side_far_cm": p.side_far_cm, 0.0, FARTHEST_CM;
        }
        if p.front_far_cm - p.front_near_cm < 1.0 {
            return Err(ParameterError::EmptyRange {
                name: "sensing.front_far_cm",
            });
        }
        if p.side_far_cm - p.side_near_cm < 1.0 {
            return Err(ParameterError::EmptyRange {
                name: "sensing.side_far_cm",
            });
        }
        Ok(Self {
            front: DistanceRange {
                near: Micrometres::nearest_to_cm(p.front_near_cm),
                far: Micrometres::nearest_to_cm(p.front_far_cm),
            },
            side: DistanceRange {
                near: Micrometres::nearest_to_cm(p.side_near_cm),
                far: Micrometres::nearest_to_cm(p.side_far_cm),
            },
        })
    }
}
