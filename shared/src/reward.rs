//! The reward function (4) and the tasks: what is to be done, never how.
//!
//! RF = - sum_i k_i exp(-gamma_i (D_i + 1)) - h |phi_T|, i = F, L, R, with the distances D_i scaled
//! to [-1, 1] and the angle phi_T to the target in radians. RF is 0 at best. (The paper's
//! equation carries a second minus in its f_i, which would reward collisions.)

use serde::{Deserialize, Serialize};

use crate::range_check::{ParameterError, check_all};
use crate::sensing::{Percept, Sample, Scaled, Stimulus};
use crate::series::exp;
use crate::units::Microdegrees;

/// Weights of the reward function, eq. (4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RewardParameters {
    /// k_F
    pub front_gain: f64,
    /// k_L = k_R
    pub side_gain: f64,
    /// h, per radian. (In degrees learning fails; see ARCHITECTURE.md, "Where the paper is
    /// silent".)
    pub target_gain: f64,
    /// gamma_F
    pub front_decay: f64,
    /// gamma_L = gamma_R
    pub side_decay: f64,
}

impl RewardParameters {
    /// III-A.
    pub const PAPER: Self = Self {
        front_gain: 700.0,
        side_gain: 400.0,
        target_gain: 20.0,
        front_decay: 2.0,
        side_decay: 3.0,
    };
}

impl Default for RewardParameters {
    fn default() -> Self {
        Self::PAPER
    }
}

/// A task: the direction in which the robot should go.
pub trait Task {
    /// Returns the angle phi_T from the robot's heading to the direction in which it should go,
    /// positive on the left; `None` if the sample does not determine it.
    fn target_angle(&self, sample: &Sample) -> Option<Microdegrees>;
}

/// Aim at a target that the robot senses (III).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AimAtTarget;

impl Task for AimAtTarget {
    fn target_angle(&self, sample: &Sample) -> Option<Microdegrees> {
        Some(sample.target_bearing?.turn_from(sample.heading))
    }
}

/// Follow a given direction by the compass (IV).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FollowDirection(
    /// Counter-clockwise in the frame of [`Sample::heading`].
    pub Microdegrees,
);

impl Task for FollowDirection {
    fn target_angle(&self, sample: &Sample) -> Option<Microdegrees> {
        Some(self.0.turn_from(sample.heading))
    }
}

/// The components of RF in millionths, in the order of [`Stimulus`]; none is positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Reward(pub [i32; 4]);

impl Reward {
    /// RF itself, in millionths.
    pub fn total(&self) -> i32 {
        // Fits: RewardTables::new bounds the sum of the largest components.
        self.0.iter().sum()
    }

    /// DRF(t) = RF(t) - RF(t-1), in millionths (II-C).
    pub fn difference(&self, before: &Self) -> i32 {
        self.total() - before.total()
    }

    /// Returns the stimulus whose component fell most since `before` (II-D); the first of equals.
    pub fn most_decreased(&self, before: &Self) -> Stimulus {
        let mut most = (Stimulus::Front, i32::MAX);
        for (i, stimulus) in Stimulus::ALL.into_iter().enumerate() {
            let change = self.0[i] - before.0[i];
            if change < most.1 {
                most = (stimulus, change);
            }
        }
        most.0
    }
}

/// Intervals of an obstacle table: 4,000 millionths each.
const INTERVALS: usize = 500;
/// Width of an interval, in millionths.
const INTERVAL: i32 = 2 * Scaled::ONE / INTERVALS as i32;

/// The reward function as tables of the obstacle terms, interpolated linearly.
///
/// With 500 intervals the interpolation is off by at most (gamma/250)^2 / 8 of the weight: 2e-5
/// for gamma = 3. It is monotone, which an approximated exponential need not be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RewardTables {
    front: [i32; INTERVALS + 1],
    side: [i32; INTERVALS + 1],
    /// Millionths of reward per microdegree, in Q32.
    target: i64,
}

impl RewardTables {
    /// Bound of -RF, so that RF and DRF fit 32 bits of millionths.
    pub const LARGEST: f64 = 2_000.0;

    /// Checks the parameters and calculates the tables.
    ///
    /// # Errors
    /// A weight or decay outside its range, or weights whose sum could exceed
    /// [`LARGEST`](Self::LARGEST).
    pub const fn new(p: &RewardParameters) -> Result<Self, ParameterError> {
        check_all! {
            "reward.front_gain": p.front_gain, 0.0, Self::LARGEST;
            "reward.side_gain": p.side_gain, 0.0, Self::LARGEST;
            "reward.target_gain": p.target_gain, 0.0, Self::LARGEST;
            "reward.front_decay": p.front_decay, 0.0, 10.0;
            "reward.side_decay": p.side_decay, 0.0, 10.0;
        }
        let largest = p.front_gain + 2.0 * p.side_gain + p.target_gain * core::f64::consts::PI;
        if largest > Self::LARGEST {
            return Err(ParameterError::RewardTooLarge {
                most: Self::LARGEST,
            });
        }
        let per_microdegree = p.target_gain * core::f64::consts::PI / 180.0;
        Ok(Self {
            front: obstacle_table(p.front_gain, p.front_decay),
            side: obstacle_table(p.side_gain, p.side_decay),
            target: (per_microdegree * 4_294_967_296.0 + 0.5) as i64,
        })
    }

    /// Returns RF's components for a percept and its target angle.
    pub fn reward(&self, percept: &Percept, target_angle: Microdegrees) -> Reward {
        let [front, left, right, _] = percept.0;
        let angle = i64::from(target_angle.0.unsigned_abs());
        Reward([
            -interpolate(&self.front, front),
            -interpolate(&self.side, left),
            -interpolate(&self.side, right),
            -(((angle * self.target) >> 32) as i32),
        ])
    }
}

const fn obstacle_table(gain: f64, decay: f64) -> [i32; INTERVALS + 1] {
    let mut table = [0; INTERVALS + 1];
    let mut i = 0;
    while i <= INTERVALS {
        let distance = 2.0 * i as f64 / INTERVALS as f64; // D + 1
        table[i] = (gain * 1e6 * exp(-decay * distance) + 0.5) as i32;
        i += 1;
    }
    table
}

fn interpolate(table: &[i32; INTERVALS + 1], distance: Scaled) -> i32 {
    let offset = distance.millionths() + Scaled::ONE;
    let index = ((offset / INTERVAL) as usize).min(INTERVALS - 1);
    let along = i64::from(offset - index as i32 * INTERVAL);
    let rise = i64::from(table[index + 1] - table[index]);
    table[index] + (rise * along / i64::from(INTERVAL)) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn paper() -> RewardTables {
        RewardTables::new(&RewardParameters::PAPER).unwrap()
    }

    fn percept(distances: [i64; 3]) -> Percept {
        let [f, l, r] = distances.map(Scaled::saturating);
        Percept([f, l, r, Scaled::saturating(0)])
    }

    fn exact(distances: [i64; 3], degrees: f64) -> f64 {
        let term = |k: f64, gamma: f64, d: i64| k * (-gamma * (d as f64 / 1e6 + 1.0)).exp();
        -term(700.0, 2.0, distances[0])
            - term(400.0, 3.0, distances[1])
            - term(400.0, 3.0, distances[2])
            - 20.0 * degrees.to_radians().abs()
    }

    proptest! {
        #[test]
        fn it_is_equation_4(
            f in -1_000_000i64..=1_000_000,
            l in -1_000_000i64..=1_000_000,
            r in -1_000_000i64..=1_000_000,
            angle in -180_000_000i32..=180_000_000,
        ) {
            let reward = paper().reward(&percept([f, l, r]), Microdegrees(angle));
            let error = f64::from(reward.total()) / 1e6 - exact([f, l, r], f64::from(angle) / 1e6);
            prop_assert!(error.abs() < 0.03, "off by {error}");
            prop_assert!(reward.0.iter().all(|&component| component <= 0));
        }

        #[test]
        fn closer_never_pays(d in -1_000_000i64..1_000_000) {
            let at = |d| paper().reward(&percept([d, 0, 0]), Microdegrees(0)).total();
            prop_assert!(at(d) <= at(d + 1));
        }
    }

    #[test]
    fn the_component_that_fell_most_is_named() {
        let before = Reward([-10, -20, -30, -40]);
        assert_eq!(
            Reward([-10, -25, -30, -44]).most_decreased(&before),
            Stimulus::Left
        );
        assert_eq!(
            Reward([-15, -25, -30, -40]).most_decreased(&before),
            Stimulus::Front
        );
    }

    #[test]
    fn both_tasks_give_the_turn_that_is_asked_for() {
        let sample = Sample {
            front: Default::default(),
            left: Default::default(),
            right: Default::default(),
            heading: Microdegrees::from_degrees(170),
            target_bearing: Some(Microdegrees::from_degrees(-170)),
        };
        let twenty_left = Some(Microdegrees::from_degrees(20));
        assert_eq!(AimAtTarget.target_angle(&sample), twenty_left);
        let blind = Sample {
            target_bearing: None,
            ..sample
        };
        assert_eq!(AimAtTarget.target_angle(&blind), None);
        let follow = FollowDirection(Microdegrees::from_degrees(-170));
        assert_eq!(follow.target_angle(&blind), twenty_left);
    }
}
