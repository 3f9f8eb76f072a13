//! What all baselines have in common: what they see, and how they are driven.

use rover_shared::sensing::Sample;
use rover_shared::units::Microdegrees;

use crate::arena::{Robot, RobotModel, Side, centimetres};

/// What a driver is shown before it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// The reading of all sensors.
    pub sample: Sample,
    /// The turn that would make the robot face its target or the direction it has to follow, in
    /// (-180, 180] degrees, counter-clockwise.
    pub target: Microdegrees,
    /// The free distances of [`Robot::fan_cm`], for drivers that ask for them.
    pub fan_cm: Option<[f64; 37]>,
}

/// One action and what came of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experience<'a> {
    /// Seen before the action.
    pub before: &'a Observation,
    /// The turn taken.
    pub turn: Microdegrees,
    /// By how much the reward function (4) grew: DRF of (5).
    pub gain: f64,
    /// Seen after the action.
    pub after: &'a Observation,
}

/// Steers a robot: every action is a turn, followed by the robot's own step ahead.
pub trait Driver: Send {
    /// Forgets what only concerned the trial before; keeps what was learned.
    fn begin_trial(&mut self) {}

    /// The turn to take now.
    fn act(&mut self, seen: &Observation) -> Microdegrees;

    /// Learns from an action. Drivers that do not learn ignore it.
    fn learn(&mut self, _experience: &Experience<'_>) {}

    /// Ends learning: from now on the driver takes the actions it knows to be best.
    fn freeze(&mut self) {}

    /// How far the rays of [`Observation::fan_cm`] have to reach; `None` for drivers that do not
    /// use them.
    fn fan_reach_cm(&self) -> Option<f64> {
        None
    }
}

impl Observation {
    /// What a robot shows its driver. `direction` is the direction to follow, in the world's
    /// frame; without one it is where the target lies, and without that, straight ahead.
    pub fn of(robot: &Robot, direction: Option<Microdegrees>, driver: &dyn Driver) -> Self {
        let sample = robot.sense();
        let wanted = direction
            .or(sample.target_bearing)
            .unwrap_or(sample.heading);
        Self {
            sample,
            target: wanted.turn_from(sample.heading),
            fan_cm: driver.fan_reach_cm().map(|reach| robot.fan_cm(reach)),
        }
    }
}

/// Readings of the front, left and right sensor, each as a share of the sensor's range, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ranges([[f64; 2]; 3]);

impl Ranges {
    pub(super) fn of(model: &RobotModel) -> Self {
        Self([Side::Front, Side::Left, Side::Right].map(|side| model.range_cm(side)))
    }

    pub(super) fn shares(&self, sample: &Sample) -> [f64; 3] {
        let readings = [sample.front, sample.left, sample.right];
        std::array::from_fn(|i| {
            let [min, max] = self.0[i];
            ((centimetres(readings[i]) - min) / (max - min).max(f64::EPSILON)).clamp(0.0, 1.0)
        })
    }
}

#[cfg(test)]
impl Observation {
    /// These readings (cm) of the front, left and right sensor, with the target at this bearing.
    pub(super) fn example([front, left, right]: [u32; 3], target_deg: f64) -> Self {
        let cm = rover_shared::units::Micrometres::from_cm;
        Self {
            sample: Sample {
                front: cm(front),
                left: cm(left),
                right: cm(right),
                heading: Microdegrees(0),
                target_bearing: None,
            },
            target: crate::arena::degrees(target_deg),
            fan_cm: None,
        }
    }
}
