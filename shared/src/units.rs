//! Quantities with their units in the type. All are integers, so that logs hold exactly what the
//! core computed with, and decimal, so that a person can read them.

use serde::{Deserialize, Serialize};

/// A distance in micrometres, 0 to 4.29 km. (1 cm, or one pixel of the paper's arena, is 10,000.)
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("unit" = "micrometres")))]
#[serde(transparent)]
pub struct Micrometres(pub u32);

impl Micrometres {
    /// Micrometres in one centimetre.
    pub const PER_CM: u32 = 10_000;

    /// A whole number of centimetres, up to 429,496.
    pub const fn from_cm(cm: u32) -> Self {
        Self(cm * Self::PER_CM)
    }

    /// The distance nearest to `cm` >= 0.
    pub(crate) const fn nearest_to_cm(cm: f64) -> Self {
        Self((cm * Self::PER_CM as f64 + 0.5) as u32)
    }
}

/// An angle in microdegrees, counter-clockwise positive.
///
/// Directions and differences of directions are kept in (-180, 180] degrees; see [`wrapped`].
///
/// [`wrapped`]: Microdegrees::wrapped
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("unit" = "microdegrees")))]
#[serde(transparent)]
pub struct Microdegrees(pub i32);

impl Microdegrees {
    /// Microdegrees in one degree.
    pub const PER_DEGREE: i32 = 1_000_000;
    /// Half a turn.
    pub const HALF_TURN: Self = Self(180 * Self::PER_DEGREE);

    /// A whole number of degrees, -2147 to 2147.
    pub const fn from_degrees(degrees: i32) -> Self {
        Self(degrees * Self::PER_DEGREE)
    }

    /// The angle nearest to `degrees` >= 0.
    pub(crate) const fn nearest_to_degrees(degrees: f64) -> Self {
        Self((degrees * Self::PER_DEGREE as f64 + 0.5) as i32)
    }

    /// The direction that `microdegrees`, any number of turns, stands for: in (-180, 180] degrees.
    pub const fn wrapped(microdegrees: i64) -> Self {
        let turn = 2 * Self::HALF_TURN.0 as i64;
        let positive = microdegrees.rem_euclid(turn);
        Self(if positive > Self::HALF_TURN.0 as i64 {
            positive - turn
        } else {
            positive
        } as i32)
    }

    /// The turn that leads from direction `from` to `self`, by the shorter way, in (-180, 180].
    pub const fn turn_from(self, from: Self) -> Self {
        Self::wrapped(self.0 as i64 - from.0 as i64)
    }

    /// This direction after a turn of `by`, in (-180, 180].
    pub const fn turned(self, by: Self) -> Self {
        Self::wrapped(self.0 as i64 + by.0 as i64)
    }
}

/// A number in [0, 1) as a fraction of 2^32.
pub(crate) const fn fraction(x: f64) -> u32 {
    (x * 4_294_967_296.0 + 0.5) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_wrap_into_the_half_open_turn() {
        let degrees = |d: i64| Microdegrees::wrapped(d * 1_000_000).0 / 1_000_000;
        assert_eq!(
            [
                degrees(180),
                degrees(-180),
                degrees(181),
                degrees(540),
                degrees(-359)
            ],
            [180, 180, -179, 180, 1]
        );
    }

    #[test]
    fn the_shorter_way_is_taken() {
        let (from, to) = (
            Microdegrees::from_degrees(170),
            Microdegrees::from_degrees(-170),
        );
        assert_eq!(to.turn_from(from), Microdegrees::from_degrees(20));
        assert_eq!(from.turned(Microdegrees::from_degrees(20)), to);
    }
}
