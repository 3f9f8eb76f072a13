//! Sensing neurons (II-A, II-D, Fig. 3): piecewise constant, non-decreasing functions of ten
//! steps over [-1, 1] whose step amplitudes are learned.

use serde::{Deserialize, Serialize};

use crate::perception::Corners;

/// Steps of a sensing neuron (II-D).
pub const STEPS: usize = 10;

/// Which of the ten steps: 0 for inputs near -1, 9 for inputs near 1. (The paper counts 1 to 10.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("maximum" = 9)))]
#[serde(try_from = "u8", into = "u8")]
pub struct StepIndex(u8);

/// Error: a number above 9.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoSuchStep;

impl core::fmt::Display for NoSuchStep {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "expected a step from 0 to 9")
    }
}

impl TryFrom<u8> for StepIndex {
    type Error = NoSuchStep;

    fn try_from(index: u8) -> Result<Self, NoSuchStep> {
        if usize::from(index) < STEPS {
            Ok(Self(index))
        } else {
            Err(NoSuchStep)
        }
    }
}

impl From<StepIndex> for u8 {
    fn from(step: StepIndex) -> u8 {
        step.0
    }
}

impl StepIndex {
    /// Clamps a number to 0 to 9.
    pub const fn saturating(index: u32) -> Self {
        Self(if index >= STEPS as u32 {
            STEPS as u8 - 1
        } else {
            index as u8
        })
    }

    /// The step's number, 0 to 9.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// A step amplitude, that is, the initial state of a corner cell: fixed point with 20 fraction
/// bits.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct Activation(pub i32);

impl Activation {
    /// Fraction bits.
    pub const FRACTION_BITS: u32 = 20;
    /// The number that represents 1.
    pub const ONE: i32 = 1 << Self::FRACTION_BITS;
    /// The largest amplitude there can be: the largest state the lattice starts from.
    pub const LIMIT: Self = Self(Corners::MAX);

    /// The sum, clamped to +-`limit`.
    const fn saturating_add(self, change: i32, limit: Self) -> Self {
        let sum = self.0.saturating_add(change);
        Self(if sum > limit.0 {
            limit.0
        } else if sum < -limit.0 {
            -limit.0
        } else {
            sum
        })
    }
}

/// One sensing neuron: ten amplitudes, all zero before learning, never decreasing from one step to
/// the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct SensingNeuron {
    amplitudes: [Activation; STEPS],
}

impl SensingNeuron {
    /// A neuron before learning.
    pub const ZERO: Self = Self {
        amplitudes: [Activation(0); STEPS],
    };

    /// A neuron with these amplitudes; `None` unless they are non-decreasing and within +-`limit`.
    pub fn from_amplitudes(amplitudes: [Activation; STEPS], limit: Activation) -> Option<Self> {
        let ordered = amplitudes.is_sorted();
        let bounded = amplitudes
            .iter()
            .all(|a| (-limit.0..=limit.0).contains(&a.0));
        (ordered && bounded).then_some(Self { amplitudes })
    }

    /// The ten amplitudes, from the step at -1 to that at 1.
    pub fn amplitudes(&self) -> &[Activation; STEPS] {
        &self.amplitudes
    }

    /// The neuron's output for an input that lies in `step`.
    pub fn output(&self, step: StepIndex) -> Activation {
        self.amplitudes[step.index()]
    }

    /// Changes the amplitudes after a failure with the input in step `i`: a positive `change` is
    /// added to all steps j >= i (5), a negative one to all steps j <= i (6).
    ///
    /// The staircase stays non-decreasing: all steps above one that rises rise with it, all steps
    /// below one that falls fall with it. Amplitudes stop at +-`limit`.
    pub fn shift(&mut self, i: StepIndex, change: i32, limit: Activation) {
        let shifted = if change > 0 {
            &mut self.amplitudes[i.index()..]
        } else {
            &mut self.amplitudes[..=i.index()]
        };
        for amplitude in shifted {
            *amplitude = amplitude.saturating_add(change, limit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn amplitudes(neuron: &SensingNeuron) -> [i32; STEPS] {
        neuron.amplitudes.map(|a| a.0)
    }

    #[test]
    fn a_rise_reaches_all_steps_above_and_a_fall_all_steps_below() {
        let mut neuron = SensingNeuron::default();
        neuron.shift(StepIndex::saturating(7), 5, Activation::LIMIT);
        neuron.shift(StepIndex::saturating(2), -3, Activation::LIMIT);
        assert_eq!(amplitudes(&neuron), [-3, -3, -3, 0, 0, 0, 0, 5, 5, 5]);
    }

    proptest! {
        #[test]
        fn no_sequence_of_changes_makes_the_staircase_fall(
            changes in prop::collection::vec((0u32..10, any::<i32>()), 0..200),
            limit in 0..=Activation::LIMIT.0,
        ) {
            let mut neuron = SensingNeuron::default();
            for (step, change) in changes {
                neuron.shift(StepIndex::saturating(step), change, Activation(limit));
                prop_assert!(amplitudes(&neuron).iter().all(|a| a.abs() <= limit));
                prop_assert_eq!(
                    SensingNeuron::from_amplitudes(*neuron.amplitudes(), Activation(limit)), Some(neuron)
                );
            }
        }
    }

    #[test]
    fn falling_or_unbounded_amplitudes_are_refused() {
        let mut falling = [Activation(0); STEPS];
        falling[9] = Activation(-1);
        assert_eq!(
            SensingNeuron::from_amplitudes(falling, Activation::LIMIT),
            None
        );
        let unbounded = [Activation(Activation::LIMIT.0 + 1); STEPS];
        assert_eq!(
            SensingNeuron::from_amplitudes(unbounded, Activation::LIMIT),
            None
        );
    }
}
