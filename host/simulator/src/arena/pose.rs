//! Poses, and lengths and angles in the core's units.

use parry2d_f64::math::Vector;
use rover_shared::units::{Microdegrees, Micrometres};

/// Where a robot is and where it points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// From the left wall.
    pub x_cm: f64,
    /// From the lower wall.
    pub y_cm: f64,
    /// Counter-clockwise, 0 = right, 90 degrees = up.
    pub heading: Microdegrees,
}

impl Pose {
    /// The robot's centre.
    pub fn position(&self) -> Vector {
        Vector::new(self.x_cm, self.y_cm)
    }
}

/// Centimetres in the core's unit: rounded to a micrometre, never below 0.
pub fn micrometres(cm: f64) -> Micrometres {
    // `as` saturates, so that nothing outside the range of the type can wrap.
    Micrometres((cm * f64::from(Micrometres::PER_CM)).round() as u32)
}

/// Degrees, any number of turns, in the core's unit.
pub fn degrees(degrees: f64) -> Microdegrees {
    Microdegrees::wrapped((degrees * f64::from(Microdegrees::PER_DEGREE)).round() as i64)
}

/// A length in centimetres.
pub fn centimetres(length: Micrometres) -> f64 {
    f64::from(length.0) / f64::from(Micrometres::PER_CM)
}

/// An angle in degrees.
pub fn to_degrees(angle: Microdegrees) -> f64 {
    f64::from(angle.0) / f64::from(Microdegrees::PER_DEGREE)
}

/// An angle in radians.
pub fn radians(angle: Microdegrees) -> f64 {
    to_degrees(angle).to_radians()
}

/// The vector of length 1 in a direction.
pub fn unit(direction: Microdegrees) -> Vector {
    let (sin, cos) = libm::sincos(radians(direction));
    Vector::new(cos, sin)
}
