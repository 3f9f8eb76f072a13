//! A body in an empty square room.

use rover_shared::motion::WheelCommand;
use rover_shared::rover::PERIOD;
use rover_shared::units::Microdegrees;

/// Half the room's width, and the half of the rover that keeps its middle from the walls, in cm.
const ROOM: f64 = 150.0;
const BODY: f64 = 17.5;
/// Where the rover is.
#[derive(Debug, Default)]
pub struct Body {
    /// From the middle of the room, in cm.
    x: f64,
    y: f64,
    /// Counter-clockwise.
    pub heading: Microdegrees,
}

impl Body {
    /// One control period with these wheels: full duty against each other turns by 180 degrees a
    /// second, and full duty ahead goes 40 cm a second.
    pub fn move_on(&mut self, wheels: WheelCommand) {
        let (left, right) = (i32::from(wheels.left()), i32::from(wheels.right()));
        self.heading = self.heading.turned(Microdegrees((right - left) * 1_800));
        let ahead = f64::from(left + right) / 2_000.0 * 40.0 * PERIOD.0 as f64 / 1e6;
        let (sin, cos) = self.towards(0.0);
        let within = |x: f64| x.clamp(BODY - ROOM, ROOM - BODY);
        self.x = within(self.x + ahead * cos);
        self.y = within(self.y + ahead * sin);
    }

    /// Sine and cosine of the direction that many degrees to the left of the heading.
    fn towards(&self, degrees: f64) -> (f64, f64) {
        libm::sincos((f64::from(self.heading.0) / 1e6 + degrees).to_radians())
    }

    /// Free way from 10 cm behind the bumper in that direction to the wall, in cm.
    pub fn free_cm(&self, degrees: f64) -> f64 {
        let (sin, cos) = self.towards(degrees);
        let to_wall = |from: f64, slope: f64| {
            if slope.abs() < 1e-9 {
                f64::INFINITY
            } else {
                (ROOM * slope.signum() - from) / slope
            }
        };
        to_wall(self.x, cos).min(to_wall(self.y, sin)) - (BODY - 10.0)
    }
}
