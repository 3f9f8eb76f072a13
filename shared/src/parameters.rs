//! All parameters of the core in one struct that is checked as a whole: the paper's constants and
//! those it leaves open, in natural units. Each block defines its own.
//!
//! [`Parameters`] are for people and files. [`Coefficients::new`] turns them into the tables that
//! the core runs on; it is `const`, so that the compiler calculates the board's tables.

use serde::{Deserialize, Serialize};

use crate::learning::{LearningCoefficients, LearningParameters};
use crate::perception::{Lattice, LatticeParameters};
use crate::range_check::{ParameterError, const_try};
use crate::reward::{RewardParameters, RewardTables};
use crate::sensing::{SensingParameters, SensorRanges};

/// All parameters. In a file (TOML) whatever is left out is as in the preset it changes.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Of the reaction-diffusion network, eq. (1).
    pub lattice: LatticeParameters,
    /// Of the sensors.
    pub sensing: SensingParameters,
    /// Of the reward function, eq. (4).
    pub reward: RewardParameters,
    /// Of both kinds of learning.
    pub learning: LearningParameters,
}

impl Parameters {
    /// The paper's simulated robot (III).
    pub const PAPER: Self = Self {
        lattice: LatticeParameters::PAPER,
        sensing: SensingParameters::PAPER,
        reward: RewardParameters::PAPER,
        learning: LearningParameters::PAPER,
    };

    /// The robot of the harder arena: longer steps, sharper turns.
    pub const HARDER: Self = Self {
        learning: LearningParameters {
            module_cm: 5.0,
            phase_limit_deg: 90.0,
            ..LearningParameters::PAPER
        },
        ..Self::PAPER
    };

    /// The paper's roving robot (IV): infrared sensors from 14 to 64 cm, steps of 7 cm.
    pub const ROVER: Self = Self {
        sensing: SensingParameters::ROVER,
        learning: LearningParameters {
            module_cm: 7.0,
            ..LearningParameters::PAPER
        },
        ..Self::PAPER
    };
}

/// Defines the conversion of [`Parameters`] to and from one array, in the order given.
macro_rules! storage_order {
    ($($block:ident: $Block:ident { $($field:ident),* })*) => {
        impl Parameters {
            /// Length of the array returned by [`to_array`](Self::to_array).
            pub const COUNT: usize = [$($(stringify!($field),)*)*].len();

            /// All parameters in the order of their declaration, for storage.
            pub const fn to_array(&self) -> [f64; Self::COUNT] {
                [$($(self.$block.$field,)*)*]
            }

            /// The inverse of [`to_array`](Self::to_array).
            pub const fn from_array(values: &[f64; Self::COUNT]) -> Self {
                let [$($($field,)*)*] = *values;
                Self { $($block: $Block { $($field),* },)* }
            }
        }
    };
}

// The order of knowledge files: only ever appended to, with another version of their layout.
storage_order! {
    lattice: LatticeParameters { mu, epsilon, s, d1, d2 }
    sensing: SensingParameters { front_near_cm, front_far_cm, side_near_cm, side_far_cm }
    reward: RewardParameters { front_gain, side_gain, target_gain, front_decay, side_decay }
    learning: LearningParameters {
        module_cm, sensing_width, sensing_ageing, amplitude_limit, initial_phase_deg,
        phase_limit_deg, initial_search_deg, final_search_deg, search_ageing, rate
    }
}

/// What the core runs on: everything that can be calculated from [`Parameters`] beforehand.
#[derive(Clone, Debug)]
pub struct Coefficients {
    parameters: Parameters,
    /// The reaction-diffusion network.
    pub lattice: Lattice,
    /// The sensors' ranges.
    pub ranges: SensorRanges,
    /// The reward function.
    pub reward: RewardTables,
    /// Both kinds of learning.
    pub learning: LearningCoefficients,
}

impl Coefficients {
    /// Checks all parameters and calculates the tables.
    ///
    /// # Errors
    /// The first parameter that is not a finite number within its range, violates the conditions
    /// for Turing patterns (2), or makes a range empty.
    pub const fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        let lattice = match Lattice::new(&parameters.lattice) {
            Ok(lattice) => lattice,
            Err(error) => return Err(ParameterError::Lattice(error)),
        };
        Ok(Self {
            parameters: *parameters,
            lattice,
            ranges: const_try!(SensorRanges::new(&parameters.sensing)),
            reward: const_try!(RewardTables::new(&parameters.reward)),
            learning: const_try!(LearningCoefficients::new(&parameters.learning)),
        })
    }

    /// The parameters these were calculated from.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Micrometres;
    use std::string::ToString;

    /// That the compiler can work the tables out is what the board relies on.
    static ROVER: Coefficients = match Coefficients::new(&Parameters::ROVER) {
        Ok(coefficients) => coefficients,
        Err(_) => panic!("the rover's parameters are valid"),
    };

    #[test]
    fn tables_from_the_compiler_equal_those_made_at_run_time() {
        let at_run_time = Coefficients::new(&std::hint::black_box(Parameters::ROVER)).unwrap();
        assert_eq!(std::format!("{ROVER:?}"), std::format!("{at_run_time:?}"));
        assert_eq!(ROVER.learning.module, Micrometres::from_cm(7));
    }

    #[test]
    fn storage_order_is_its_own_inverse() {
        let mut values = Parameters::PAPER.to_array();
        for (i, value) in values.iter_mut().enumerate() {
            *value += i as f64;
        }
        assert_eq!(Parameters::from_array(&values).to_array(), values);
    }

    #[test]
    fn every_number_is_checked() {
        for i in 0..Parameters::COUNT {
            for bad in [f64::NAN, f64::INFINITY, -1e9, 1e9] {
                let mut values = Parameters::PAPER.to_array();
                values[i] = bad;
                let refused = Coefficients::new(&Parameters::from_array(&values));
                assert!(refused.is_err(), "parameter {i} = {bad}");
            }
        }
    }

    #[test]
    fn messages_say_what_was_expected() {
        let mut p = Parameters::PAPER;
        p.learning.rate = 1.5;
        assert_eq!(
            Coefficients::new(&p).unwrap_err().to_string(),
            "parameter learning.rate is 1.5, expected a number from 0 to 1"
        );
        p = Parameters::PAPER;
        p.sensing.side_far_cm = 0.5;
        assert!(
            Coefficients::new(&p)
                .unwrap_err()
                .to_string()
                .contains("side_far_cm")
        );
    }
}
