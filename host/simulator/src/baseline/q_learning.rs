//! Tabular Q-learning (Watkins, 1989): what a standard learner makes of the same sensors, the same
//! reward and the same trials.

use rand_pcg::Pcg32;
use rover_shared::units::Microdegrees;

use super::driver::{Driver, Experience, Observation, Ranges};
use crate::arena::{RobotModel, to_degrees};
use crate::chance::uniform;

/// A table of action values over the three ranges in four steps each and the target's bearing in
/// ten, 640 states, and seven turns. It is rewarded with the growth of the reward function, the
/// quantity that drives all learning in the paper.
#[derive(Clone, Debug)]
pub struct QLearning {
    ranges: Ranges,
    values: Vec<[f64; TURNS_DEG.len()]>,
    rng: Pcg32,
    exploration: f64,
}

/// The turns to choose from: those of the paper's robot lie between these limits after learning.
const TURNS_DEG: [i32; 7] = [-45, -20, -8, 0, 8, 20, 45];
/// Steps of a range.
const RANGE_STEPS: usize = 4;
/// Steps of the target's bearing.
const TARGET_STEPS: usize = 10;

/// Weight of new experience.
const LEARNING_RATE: f64 = 0.1;
/// Weight of the next state's value: rewards some ten steps ahead count.
const DISCOUNT: f64 = 0.9;
/// Share of random actions at first, its decay per action, and its least value.
const EXPLORATION: [f64; 3] = [0.5, 0.9998, 0.02];

impl QLearning {
    /// An empty table for a robot of this model; what it tries follows from `seed`.
    pub fn new(model: &RobotModel, seed: u64) -> Self {
        Self {
            ranges: Ranges::of(model),
            values: vec![[0.0; TURNS_DEG.len()]; RANGE_STEPS.pow(3) * TARGET_STEPS],
            rng: Pcg32::new(seed, 0x712d6c6561726e),
            exploration: EXPLORATION[0],
        }
    }

    fn state(&self, seen: &Observation) -> usize {
        let step = |share: f64, steps: usize| ((share * steps as f64) as usize).min(steps - 1);
        let target = (to_degrees(seen.target) / 180.0 + 1.0) / 2.0;
        let ranges = self
            .ranges
            .shares(&seen.sample)
            .map(|share| step(share, RANGE_STEPS));
        let [front, left, right] = ranges;
        ((front * RANGE_STEPS + left) * RANGE_STEPS + right) * TARGET_STEPS
            + step(target, TARGET_STEPS)
    }

    /// The first of the best actions in a state.
    fn best(&self, state: usize) -> usize {
        let values = &self.values[state];
        (1..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
    }

    fn chance(&mut self) -> f64 {
        uniform(&mut self.rng, 0.0, 1.0)
    }
}

impl Driver for QLearning {
    fn act(&mut self, seen: &Observation) -> Microdegrees {
        let action = if self.exploration > 0.0 && self.chance() < self.exploration {
            (self.chance() * TURNS_DEG.len() as f64) as usize
        } else {
            self.best(self.state(seen))
        };
        Microdegrees::from_degrees(TURNS_DEG[action])
    }

    fn learn(&mut self, experience: &Experience<'_>) {
        let turn = experience.turn.0 / Microdegrees::PER_DEGREE;
        let Some(action) = TURNS_DEG.iter().position(|&t| t == turn) else {
            return;
        };
        let after = self.state(experience.after);
        let goal = experience.gain + DISCOUNT * self.values[after][self.best(after)];
        let state = self.state(experience.before);
        let value = &mut self.values[state][action];
        *value += LEARNING_RATE * (goal - *value);
        let [_, decay, least] = EXPLORATION;
        self.exploration = (self.exploration * decay).max(least);
    }

    fn freeze(&mut self) {
        self.exploration = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(front: u32, left: u32, right: u32, target: f64) -> Observation {
        Observation::example([front, left, right], target)
    }

    #[test]
    fn the_steps_tile_the_ranges() {
        let table = QLearning::new(&RobotModel::paper(), 1);
        let state = |front, left, right, target| table.state(&seen(front, left, right, target));
        assert_eq!(state(0, 0, 0, -179.9), 0);
        assert_eq!(state(40, 20, 20, 180.0), table.values.len() - 1);
        assert_eq!(state(0, 0, 5, -179.9), TARGET_STEPS);
        assert_eq!(state(9, 4, 4, -144.1), 0);
        assert_eq!(state(9, 4, 4, -143.9), 1);
        assert_ne!(state(40, 20, 20, -0.1), state(40, 20, 20, 0.1));
    }

    #[test]
    fn what_gains_most_is_done_once_frozen() {
        let mut driver = QLearning::new(&RobotModel::paper(), 1);
        let (before, after) = (seen(40, 20, 20, 100.0), seen(40, 20, 20, 60.0));
        for turn in TURNS_DEG {
            let gain = if turn == 20 { 1.0 } else { -1.0 };
            let turn = Microdegrees::from_degrees(turn);
            driver.learn(&Experience {
                before: &before,
                turn,
                gain,
                after: &after,
            });
        }
        driver.freeze();
        for _ in 0..50 {
            assert_eq!(driver.act(&before), Microdegrees::from_degrees(20));
        }
    }

    #[test]
    fn future_gains_count_less() {
        let mut driver = QLearning::new(&RobotModel::paper(), 1);
        let (first, second) = (seen(40, 20, 20, 100.0), seen(40, 20, 20, 60.0));
        let turn = Microdegrees::from_degrees(45);
        let mut step = |before: &Observation, gain: f64, after: &Observation| {
            for _ in 0..1000 {
                driver.learn(&Experience {
                    before,
                    turn,
                    gain,
                    after,
                });
            }
            driver.values[driver.state(before)][6]
        };
        let third = seen(40, 20, 20, 0.0);
        assert!((step(&second, 10.0, &third) - 10.0).abs() < 1e-3);
        assert!((step(&first, 0.0, &second) - DISCOUNT * 10.0).abs() < 1e-3);
    }
}
