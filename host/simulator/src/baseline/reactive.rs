//! A hand-written rule: what a person makes of the same three sensors. It shows what they allow,
//! and so how much is left to gain by learning better.

use rover_shared::units::Microdegrees;

use super::driver::{Driver, Observation, Ranges};
use crate::arena::{RobotModel, degrees, to_degrees};

/// Heads for the target; turns about before what is close ahead, always to the same side until it
/// is past; turns off from what is very close on a side; and does not turn towards what is close.
#[derive(Clone, Debug)]
pub struct Reactive {
    ranges: Ranges,
    /// The way chosen round the obstacle ahead: 1 = left, -1 = right.
    way: Option<f64>,
}

// The thresholds are shares of a sensor's range; they and the turns are the best of some twenty
// tried in 1000 arenas of each of the two target tasks and in five rooms of the rover's.

/// Closer ahead than this: turn about.
const FRONT_NEAR: f64 = 0.4;
/// Farther ahead than this: the obstacle is past, the next may be passed on another side.
const FRONT_PAST: f64 = 0.6;
/// Closer on a side than this: do not turn to it.
const SIDE_NEAR: f64 = 0.6;
/// Closer on a side than this: turn off.
const SIDE_CLOSE: f64 = 0.3;
/// A side has more room than the other if it is ahead by this.
const SIDE_DIFFERENCE: f64 = 0.1;

/// Largest turn towards the target.
const TURN_DEG: f64 = 45.0;
/// The turn away from what is close ahead. With 45 degrees the rover, which sees little of what it
/// is about to touch, is blocked five to nine times as often.
const TURN_ABOUT_DEG: f64 = 90.0;
/// The turn away from what is close on a side.
const TURN_OFF_DEG: f64 = 30.0;

impl Reactive {
    /// A driver for a robot of this model.
    pub fn new(model: &RobotModel) -> Self {
        Self {
            ranges: Ranges::of(model),
            way: None,
        }
    }
}

/// The side to pass an obstacle on: where there is more room, else where the target is.
fn way_round(left: f64, right: f64, target: f64) -> f64 {
    if (left - right).abs() > SIDE_DIFFERENCE {
        (left - right).signum()
    } else {
        1f64.copysign(target)
    }
}

impl Driver for Reactive {
    fn begin_trial(&mut self) {
        self.way = None;
    }

    fn act(&mut self, seen: &Observation) -> Microdegrees {
        let [front, left, right] = self.ranges.shares(&seen.sample);
        let target = to_degrees(seen.target).clamp(-TURN_DEG, TURN_DEG);
        if front < FRONT_NEAR {
            let way = *self
                .way
                .get_or_insert_with(|| way_round(left, right, target));
            return degrees(way * TURN_ABOUT_DEG);
        }
        if front > FRONT_PAST {
            self.way = None;
        }
        let side = if target > 0.0 { left } else { right };
        degrees(if left.min(right) < SIDE_CLOSE {
            TURN_OFF_DEG.copysign(left - right)
        } else if side < SIDE_NEAR {
            0.0
        } else {
            target
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The turn after these readings (cm), with the target at this bearing.
    fn turn(driver: &mut Reactive, front: u32, left: u32, right: u32, target: i32) -> i32 {
        let seen = Observation::example([front, left, right], f64::from(target));
        driver.act(&seen).0 / Microdegrees::PER_DEGREE
    }

    #[test]
    fn each_branch_of_the_rule() {
        let fresh = || Reactive::new(&RobotModel::paper());
        let table = [
            ((40, 20, 20, 30), 30),    // free: to the target
            ((40, 20, 20, -170), -45), // no farther at once than this
            ((40, 10, 20, 30), 0),     // the target is behind something close on the left
            ((40, 10, 20, -30), -30),  // or not
            ((40, 5, 20, 30), -30),    // very close on the left
            ((40, 20, 5, 30), 30),
            ((10, 20, 20, -5), -90), // close ahead: round it on the target's side,
            ((10, 12, 20, 5), -90),  // but rather where there is room
        ];
        for ((front, left, right, target), expected) in table {
            let case = (front, left, right, target);
            assert_eq!(
                turn(&mut fresh(), front, left, right, target),
                expected,
                "{case:?}"
            );
        }
    }

    #[test]
    fn the_way_round_is_kept_until_the_obstacle_is_past() {
        let mut driver = Reactive::new(&RobotModel::paper());
        assert_eq!(turn(&mut driver, 10, 20, 20, 5), 90);
        assert_eq!(turn(&mut driver, 20, 20, 20, -5), -5);
        assert_eq!(
            turn(&mut driver, 10, 20, 20, -5),
            90,
            "still the same obstacle"
        );
        assert_eq!(turn(&mut driver, 40, 20, 20, -5), -5);
        assert_eq!(turn(&mut driver, 10, 20, 20, -5), -90, "another one");
        driver.begin_trial();
        assert_eq!(turn(&mut driver, 10, 20, 20, 5), 90);
    }
}
