//! The paper's learning rule: staircases (II-D) and the simplified motor map (II-C).
//!
//! The paper has phases learned by a simplified motor map driven by DRF, without formulas. Those
//! used here, after Schulten's motor maps, learned best of some hundred variants: a phase moves
//! towards the one tried if its reward exceeds the pattern's expectation (`DRF > b`), and the
//! expectation follows the reward.

use serde::{Deserialize, Serialize};

use super::parameters::LearningCoefficients;
use super::{LearningRule, Memory, Mode, SensingLayer, StaircaseChange, Transition};
use crate::action::Action;
use crate::action::pattern_vector::PatternVector;
use crate::perception::PatternCode;
use crate::random::{Generator, NORMAL_FRACTION_BITS};
use crate::sensing::neuron::Activation;
use crate::units::Microdegrees;

/// What a pattern has learned to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MotorWeights {
    /// w_p: the phase of its action.
    pub phase: Microdegrees,
    /// a: the standard deviation of the search around it.
    pub search: Microdegrees,
    /// b: the reward difference expected of it, in millionths.
    pub expected_gain: i32,
}

impl Memory for MotorWeights {
    const SIZE: usize = 12;

    fn phase(&self) -> Microdegrees {
        self.phase
    }

    fn write(&self, bytes: &mut [u8]) {
        let fields = [self.phase.0, self.search.0, self.expected_gain];
        for (bytes, field) in bytes.chunks_exact_mut(4).zip(fields) {
            bytes.copy_from_slice(&field.to_le_bytes());
        }
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let field = |i: usize| {
            let bytes = bytes.get(4 * i..4 * i + 4)?;
            Some(i32::from_le_bytes(bytes.try_into().ok()?))
        };
        let weights = Self {
            phase: Microdegrees(field(0)?),
            search: Microdegrees(field(1)?),
            expected_gain: field(2)?,
        };
        let half_turn = Microdegrees::HALF_TURN.0;
        let possible = (-half_turn..=half_turn).contains(&weights.phase.0)
            && (0..=half_turn).contains(&weights.search.0);
        possible.then_some(weights)
    }
}

/// The paper's rule: staircases by (5) and (6), phases by the simplified motor map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct PaperRule;

impl LearningRule for PaperRule {
    type Memory = MotorWeights;
    const ID: u8 = 1;

    fn introduce<const N: usize>(
        &self,
        _code: PatternCode,
        _known: &PatternVector<MotorWeights, N>,
        c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> MotorWeights {
        MotorWeights {
            phase: Microdegrees(rng.symmetric(c.initial_phase.0.unsigned_abs())),
            search: c.initial_search,
            expected_gain: 0,
        }
    }

    fn act(
        &self,
        weights: &MotorWeights,
        mode: Mode,
        c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> Action {
        let phase = match mode {
            Mode::Run => weights.phase,
            Mode::Learn => {
                let deviate = i64::from(rng.normal()) * i64::from(weights.search.0);
                let tried = i64::from(weights.phase.0) + (deviate >> NORMAL_FRACTION_BITS);
                limited(tried, c)
            }
        };
        Action {
            phase,
            module: c.module,
        }
    }

    fn learn(
        &self,
        transition: &Transition,
        weights: &mut MotorWeights,
        sensing: &mut SensingLayer,
        c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> Option<StaircaseChange> {
        let gain = transition.reward_difference();
        let surprise = i64::from(gain) - i64::from(weights.expected_gain);
        if surprise > 0 {
            let way = i64::from(transition.action.phase.0) - i64::from(weights.phase.0);
            weights.phase = limited(i64::from(weights.phase.0) + share(way, c.rate), c);
        }
        let expected = i64::from(weights.expected_gain) + share(surprise, c.rate);
        weights.expected_gain = expected.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        let above_final = weights.search.0 - c.final_search.0;
        weights.search.0 = c.final_search.0 + aged(above_final, c.search_ageing);

        let change = (gain < 0).then(|| disturb(transition, sensing, c, rng));
        sensing.width = ((u64::from(sensing.width) * u64::from(c.sensing_ageing)) >> 32) as u32;
        change
    }
}

/// II-D: the neuron whose component of RF fell most changes at random around the step that its
/// input lay in before the action.
fn disturb(
    transition: &Transition,
    sensing: &mut SensingLayer,
    c: &LearningCoefficients,
    rng: &mut Generator,
) -> StaircaseChange {
    let stimulus = transition.after.most_decreased(&transition.before);
    let step = transition.percept.0[stimulus as usize].step();
    let amount = rng.symmetric(sensing.width >> (32 - Activation::FRACTION_BITS));
    sensing.neurons[stimulus as usize].shift(step, amount, c.amplitude_limit);
    StaircaseChange {
        stimulus,
        step,
        amount,
    }
}

/// The share `rate` (in millionths) of `way`.
fn share(way: i64, rate: u32) -> i64 {
    way * i64::from(rate) / 1_000_000
}

/// `x` times a fraction of 2^32.
fn aged(x: i32, ageing: u32) -> i32 {
    ((i64::from(x) * i64::from(ageing)) >> 32) as i32
}

/// A phase within the limit.
fn limited(phase: i64, c: &LearningCoefficients) -> Microdegrees {
    let limit = i64::from(c.phase_limit.0);
    Microdegrees(phase.clamp(-limit, limit) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearningParameters;
    use crate::reward::Reward;
    use crate::sensing::{Percept, Scaled, Stimulus};
    use crate::units::Micrometres;

    fn coefficients() -> LearningCoefficients {
        LearningCoefficients::new(&LearningParameters::PAPER).unwrap()
    }

    fn weights(phase: i32, expected_gain: i32) -> MotorWeights {
        let phase = Microdegrees::from_degrees(phase);
        MotorWeights {
            phase,
            search: Microdegrees::from_degrees(12),
            expected_gain,
        }
    }

    /// A transition in which an action of `phase` degrees changed the components so.
    fn transition(phase: i32, change: [i32; 4]) -> Transition {
        let scaled = [-1_000_000, -400_000, 0, 999_999].map(Scaled::saturating);
        Transition {
            percept: Percept(scaled),
            code: PatternCode(1),
            action: Action {
                phase: Microdegrees::from_degrees(phase),
                module: Micrometres::from_cm(4),
            },
            before: Reward([-50_000_000; 4]),
            after: Reward(change.map(|c| c - 50_000_000)),
        }
    }

    fn learn(
        weights: &mut MotorWeights,
        t: &Transition,
    ) -> (SensingLayer, Option<StaircaseChange>) {
        let c = coefficients();
        let mut sensing = SensingLayer::new(&c);
        let rng = &mut Generator::new(1);
        let change = PaperRule.learn(t, weights, &mut sensing, &c, rng);
        (sensing, change)
    }

    #[test]
    fn better_than_expected_moves_the_phase_three_tenths_of_the_way() {
        let mut w = weights(10, 1_000_000);
        let (sensing, change) = learn(&mut w, &transition(20, [2_000_000, 0, 0, 0]));
        assert_eq!(w.phase, Microdegrees::from_degrees(13));
        assert_eq!(w.expected_gain, 1_300_000);
        assert_eq!(w.search.0, 1_000_000 + 10_989_000);
        assert_eq!(change, None);
        assert_eq!(sensing.neurons, [Default::default(); 4]);
    }

    #[test]
    fn a_gain_below_expectation_leaves_the_phase() {
        let mut w = weights(10, 1_000_000);
        learn(&mut w, &transition(20, [0, 0, 500_000, 0]));
        assert_eq!(w.phase, Microdegrees::from_degrees(10));
        assert_eq!(w.expected_gain, 850_000);
    }

    #[test]
    fn a_loss_disturbs_the_neuron_whose_component_fell_most_at_the_step_of_its_input() {
        let mut w = weights(10, 0);
        let (sensing, change) = learn(&mut w, &transition(20, [-10, -3_000_000, 0, 100]));
        let change = change.unwrap();
        assert_eq!((change.stimulus, change.step.index()), (Stimulus::Left, 3));
        assert!(change.amount != 0 && change.amount.abs() <= Activation::ONE / 2);
        let left = sensing.neurons[1].amplitudes();
        assert_eq!(left[3].0, change.amount);
        assert_eq!(
            [sensing.neurons[0], sensing.neurons[2]],
            [Default::default(); 2]
        );
    }

    #[test]
    fn the_width_of_staircase_changes_ages_at_every_action() {
        let (sensing, _) = learn(&mut weights(0, 0), &transition(0, [1; 4]));
        let expected = 0.5 * 0.999 * 2f64.powi(32);
        assert!((f64::from(sensing.width) - expected).abs() < 2.0);
    }

    #[test]
    fn phases_never_leave_their_limit() {
        let c = coefficients();
        let mut rng = Generator::new(2);
        for _ in 0..1_000 {
            let action = PaperRule.act(&weights(44, 0), Mode::Learn, &c, &mut rng);
            assert!(action.phase.0.abs() <= c.phase_limit.0);
        }
        let running = PaperRule.act(&weights(44, 0), Mode::Run, &c, &mut rng);
        assert_eq!(running.phase, Microdegrees::from_degrees(44));
    }
}
