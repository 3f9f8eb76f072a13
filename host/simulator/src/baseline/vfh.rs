//! A vector field histogram: what a robot with a real range scanner would do.
//!
//! In the manner of Borenstein and Koren (1991), cited in IV-A, with the enlarged obstacles of
//! Ulrich and Borenstein, "VFH+" (1998): every direction in which the robot's body would touch
//! something in sight is blocked; of the free ones it takes the one nearest to the target. There is
//! no map: the histogram is built anew from each scan. It sees 37 ranges where the paper's robot
//! sees three, so that it shows what the sensors cost, not what learning costs.

use rover_shared::units::Microdegrees;

use super::driver::{Driver, Observation};
use crate::arena::{RobotModel, Side, degrees, to_degrees};

/// See the top of the file. Needs [`Observation::fan_cm`]; without it, it heads for the target.
#[derive(Clone, Debug)]
pub struct Vfh {
    reach_cm: f64,
    body_cm: f64,
    step_cm: f64,
}

/// Rays of the fan, 5 degrees apart, symmetric to straight ahead.
const RAYS: usize = 37;
const SPACING_DEG: f64 = 5.0;

/// Room kept beside the robot, in steps: what it may drift while it turns.
const SAFETY_STEPS: f64 = 0.5;

/// How much the present heading counts against the target when directions are compared: enough to
/// settle ties, so that an obstacle straight ahead is not passed left and right in turn.
const INERTIA: f64 = 0.2;

impl Vfh {
    /// A driver for a robot of this model, which sees as far as its front sensor.
    pub fn new(model: &RobotModel) -> Self {
        let [_, sight_cm] = model.range_cm(Side::Front);
        Self {
            // From the centre, where the front sensor counts from the edge of the body.
            reach_cm: sight_cm
                + model
                    .sensors
                    .iter()
                    .map(|s| s.mount_cm[0])
                    .fold(0.0, f64::max),
            body_cm: model.contact_radius_cm,
            step_cm: model.step_cm,
        }
    }

    /// Marks the rays along which the body, with room to spare, would touch what some ray hits:
    /// each hit blocks the half angle that the body takes up at its distance.
    fn blocked(&self, fan_cm: &[f64; RAYS]) -> [bool; RAYS] {
        let width = self.body_cm + SAFETY_STEPS * self.step_cm;
        let mut blocked = [false; RAYS];
        for (hit, &distance) in fan_cm
            .iter()
            .enumerate()
            .filter(|(_, d)| **d < self.reach_cm)
        {
            let ratio = (width / distance.max(f64::EPSILON)).min(1.0);
            let half_angle = libm::asin(ratio).to_degrees();
            for (i, sector) in blocked.iter_mut().enumerate() {
                *sector |= i.abs_diff(hit) as f64 * SPACING_DEG < half_angle;
            }
        }
        blocked
    }
}

fn bearing(ray: usize) -> f64 {
    ray as f64 * SPACING_DEG - 90.0
}

impl Driver for Vfh {
    fn act(&mut self, seen: &Observation) -> Microdegrees {
        let target = to_degrees(seen.target).clamp(-90.0, 90.0);
        let Some(fan) = &seen.fan_cm else {
            return degrees(target);
        };
        let blocked = self.blocked(fan);
        let cost = |ray: usize| (bearing(ray) - target).abs() + INERTIA * bearing(ray).abs();
        let free = (0..RAYS).filter(|&ray| !blocked[ray]);
        match free.min_by(|&a, &b| cost(a).total_cmp(&cost(b))) {
            // The target itself lies between two rays: go there rather than beside it.
            Some(ray) if (bearing(ray) - target).abs() < SPACING_DEG => degrees(target),
            Some(ray) => degrees(bearing(ray)),
            None => turn_about(fan),
        }
    }

    fn fan_reach_cm(&self) -> Option<f64> {
        Some(self.reach_cm)
    }
}

/// Boxed in: turn by 90 degrees to the side with more room.
fn turn_about(fan: &[f64; RAYS]) -> Microdegrees {
    let right: f64 = fan[..RAYS / 2].iter().sum();
    let left: f64 = fan[RAYS / 2 + 1..].iter().sum();
    Microdegrees::from_degrees(if left >= right { 90 } else { -90 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The turn with these ranges, the target at this bearing.
    fn turn(fan_cm: Option<[f64; RAYS]>, target: i32) -> i32 {
        let seen = Observation {
            fan_cm,
            ..Observation::example([40; 3], f64::from(target))
        };
        Vfh::new(&RobotModel::paper()).act(&seen).0 / Microdegrees::PER_DEGREE
    }

    #[test]
    fn takes_the_free_direction_nearest_to_the_target() {
        let open = [40.0; RAYS];
        assert_eq!(turn(Some(open), 33), 33);
        assert_eq!(turn(Some(open), 170), 90);
        // An obstacle 20 ahead, from 20 degrees on the right to 10 on the left. The body and its
        // margin, 4, take up 11.5 degrees at that distance: the nearest free rays are at -35, 25.
        let mut ahead = open;
        ahead[14..=20].fill(20.0);
        assert_eq!(turn(Some(ahead), 0), 25);
        assert_eq!(turn(Some(ahead), -30), -35);
        assert_eq!(turn(Some([3.0; RAYS]), 0), 90, "boxed in: turn about");
        assert_eq!(turn(None, 33), 33, "without ranges: to the target");
    }
}
