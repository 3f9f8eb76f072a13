//! Stimuli scaled to [-1, 1].

use serde::{Deserialize, Serialize};

use super::neuron::{STEPS, StepIndex};

/// A stimulus scaled to [-1, 1], in millionths.
///
/// Decimal, so that the borders between the ten steps are hit exactly: a tenth of any sensor's
/// range is 200,000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("minimum" = -1_000_000, "maximum" = 1_000_000)))]
#[serde(try_from = "i32", into = "i32")]
pub struct Scaled(i32);

/// Error: a number outside [-1, 1].
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
    /// The number of millionths in 1.
    pub const ONE: i32 = 1_000_000;

    /// Clamps `millionths` to [-1, 1].
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
