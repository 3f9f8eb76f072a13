//! Everything that can be set: the paper's constants and those it leaves open, in natural units,
//! in one struct that is checked as a whole.
//!
//! [`Parameters`] are for people and files. What runs is made of them once, by
//! [`Coefficients::new`], which is `const`: on the board the tables are worked out by the compiler.

use serde::{Deserialize, Serialize};

use crate::perception::{Lattice, LatticeError, LatticeParameters};
use crate::reward::RewardTables;
use crate::sensing::neuron::Activation;
use crate::sensing::{DistanceRange, SensorRanges};
use crate::units::{Microdegrees, Micrometres};

/// Ranges of the distance sensors, in centimetres (pixels in the paper's arena).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensingParameters {
    /// Distances below this count as this, in front.
    pub front_near_cm: f64,
    /// Distances above this count as this, in front.
    pub front_far_cm: f64,
    /// The same for the left and right sensor.
    pub side_near_cm: f64,
    /// The same for the left and right sensor.
    pub side_far_cm: f64,
}

impl SensingParameters {
    /// III-A: 40 px in front, 20 px at the sides.
    pub const PAPER: Self = Self {
        front_near_cm: 0.0,
        front_far_cm: 40.0,
        side_near_cm: 0.0,
        side_far_cm: 20.0,
    };
    /// IV-A: 14 to 64 cm, for all four infrared sensors.
    pub const ROVER: Self = Self {
        front_near_cm: 14.0,
        front_far_cm: 64.0,
        side_near_cm: 14.0,
        side_far_cm: 64.0,
    };
}

impl Default for SensingParameters {
    fn default() -> Self {
        Self::PAPER
    }
}

/// Weights of the reward function, eq. (4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RewardParameters {
    /// k_F
    pub front_gain: f64,
    /// k_L = k_R
    pub side_gain: f64,
    /// h, per radian. (In degrees learning fails; see ARCHITECTURE.md, "Where the paper is silent".)
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

/// How the staircases and the motor map learn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LearningParameters {
    /// w_m: how far each action moves (III-B, IV-C).
    pub module_cm: f64,
    /// h(0) of the staircases: changes are uniform in [-h, h] (II-D).
    pub sensing_width: f64,
    /// h is multiplied by this at each action that is learned from (II-D).
    pub sensing_ageing: f64,
    /// Step amplitudes stay within plus and minus this. Not the paper's: its own grow to some tens,
    /// which costs fidelity in fixed point. A bound of 10 was no worse to learn with than one of
    /// 40, which hardly any session reaches.
    pub amplitude_limit: f64,
    /// A pattern's first phase is uniform within plus and minus this (III-A).
    pub initial_phase_deg: f64,
    /// Phases never leave plus and minus this. Not the paper's; found by experiment.
    pub phase_limit_deg: f64,
    /// Standard deviation of a new pattern's search. Not the paper's.
    pub initial_search_deg: f64,
    /// Standard deviation that the search ages towards. Not the paper's.
    pub final_search_deg: f64,
    /// (search - final) is multiplied by this at each use of the pattern. Not the paper's.
    pub search_ageing: f64,
    /// Share of the way that phase and expected gain move at one learning. Not the paper's.
    pub rate: f64,
}

impl LearningParameters {
    /// The paper's where it gives them, else those that learned best in its arena.
    pub const PAPER: Self = Self {
        module_cm: 4.0,
        sensing_width: 0.5,
        sensing_ageing: 0.999,
        amplitude_limit: 10.0,
        initial_phase_deg: 20.0,
        phase_limit_deg: 45.0,
        initial_search_deg: 12.0,
        final_search_deg: 1.0,
        search_ageing: 0.999,
        rate: 0.3,
    };
}

impl Default for LearningParameters {
    fn default() -> Self {
        Self::PAPER
    }
}

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

    /// How many numbers [`to_array`](Self::to_array) gives.
    pub const COUNT: usize = 24;

    /// All parameters in the order of their declaration, for storage.
    pub const fn to_array(&self) -> [f64; Self::COUNT] {
        let (n, s, r, l) = (&self.lattice, &self.sensing, &self.reward, &self.learning);
        [
            n.mu,
            n.epsilon,
            n.s,
            n.d1,
            n.d2,
            s.front_near_cm,
            s.front_far_cm,
            s.side_near_cm,
            s.side_far_cm,
            r.front_gain,
            r.side_gain,
            r.target_gain,
            r.front_decay,
            r.side_decay,
            l.module_cm,
            l.sensing_width,
            l.sensing_ageing,
            l.amplitude_limit,
            l.initial_phase_deg,
            l.phase_limit_deg,
            l.initial_search_deg,
            l.final_search_deg,
            l.search_ageing,
            l.rate,
        ]
    }

    /// The inverse of [`to_array`](Self::to_array).
    pub const fn from_array(values: &[f64; Self::COUNT]) -> Self {
        let [
            mu,
            epsilon,
            s,
            d1,
            d2,
            front_near_cm,
            front_far_cm,
            side_near_cm,
            side_far_cm,
            front_gain,
            side_gain,
            target_gain,
            front_decay,
            side_decay,
            module_cm,
            sensing_width,
            sensing_ageing,
            amplitude_limit,
            initial_phase_deg,
            phase_limit_deg,
            initial_search_deg,
            final_search_deg,
            search_ageing,
            rate,
        ] = *values;
        Self {
            lattice: LatticeParameters {
                mu,
                epsilon,
                s,
                d1,
                d2,
            },
            sensing: SensingParameters {
                front_near_cm,
                front_far_cm,
                side_near_cm,
                side_far_cm,
            },
            reward: RewardParameters {
                front_gain,
                side_gain,
                target_gain,
                front_decay,
                side_decay,
            },
            learning: LearningParameters {
                module_cm,
                sensing_width,
                sensing_ageing,
                amplitude_limit,
                initial_phase_deg,
                phase_limit_deg,
                initial_search_deg,
                final_search_deg,
                search_ageing,
                rate,
            },
        }
    }
}

/// Why a set of parameters cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterError {
    /// The lattice would not form Turing patterns, or not ones the engine can calculate.
    Lattice(LatticeError),
    /// A number lies outside its range.
    OutOfRange {
        /// The parameter, as it is called in a file.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The smallest value allowed.
        least: f64,
        /// The largest value allowed.
        most: f64,
    },
    /// The far end of a sensor's range is not at least 1 cm beyond the near end.
    EmptyRange {
        /// The parameter that is too small, as it is called in a file.
        name: &'static str,
    },
    /// k_F + 2 k_L + h pi exceeds [`RewardTables::LARGEST`], beyond which a reward does not fit.
    RewardTooLarge,
}

impl core::fmt::Display for ParameterError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Lattice(error) => write!(f, "{error}"),
            Self::OutOfRange {
                name,
                value,
                least,
                most,
            } => {
                write!(
                    f,
                    "parameter {name} is {value}, expected a number from {least} to {most}"
                )
            }
            Self::EmptyRange { name } => {
                write!(
                    f,
                    "parameter {name} must be at least 1 cm beyond its near end"
                )
            }
            Self::RewardTooLarge => write!(
                f,
                "the reward weights are too large: front_gain + 2 side_gain + pi target_gain must not exceed {}",
                RewardTables::LARGEST
            ),
        }
    }
}

impl core::error::Error for ParameterError {}

/// Learning parameters as the rule calculates with them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LearningCoefficients {
    /// w_m.
    pub module: Micrometres,
    /// First width of the staircases' changes, as a fraction of 2^32.
    pub sensing_width: u32,
    /// Ageing of that width, as a fraction of 2^32.
    pub sensing_ageing: u32,
    /// Bound of the step amplitudes.
    pub amplitude_limit: Activation,
    /// Half the range of first phases.
    pub initial_phase: Microdegrees,
    /// Bound of all phases.
    pub phase_limit: Microdegrees,
    /// First width of a pattern's search.
    pub initial_search: Microdegrees,
    /// Last width of a pattern's search.
    pub final_search: Microdegrees,
    /// Ageing of the search, as a fraction of 2^32.
    pub search_ageing: u32,
    /// Learning rate, in millionths.
    pub rate: u32,
}

/// What the core runs on: everything that can be worked out from [`Parameters`] beforehand.
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
    /// Checks all parameters and works out the tables.
    ///
    /// # Errors
    /// The first parameter that is not a finite number within its range, violates the conditions
    /// for Turing patterns (2), or makes a range empty.
    pub const fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        let lattice = match Lattice::new(&parameters.lattice) {
            Ok(lattice) => lattice,
            Err(error) => return Err(ParameterError::Lattice(error)),
        };
        let ranges = match sensor_ranges(&parameters.sensing) {
            Ok(ranges) => ranges,
            Err(error) => return Err(error),
        };
        let reward = match RewardTables::new(&parameters.reward) {
            Ok(reward) => reward,
            Err(error) => return Err(error),
        };
        let learning = match learning_coefficients(&parameters.learning) {
            Ok(learning) => learning,
            Err(error) => return Err(error),
        };
        Ok(Self {
            parameters: *parameters,
            lattice,
            ranges,
            reward,
            learning,
        })
    }

    /// The parameters these were worked out from.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}

/// Fails unless `value` is a number from `least` to `most`.
pub(crate) const fn check(
    name: &'static str,
    value: f64,
    least: f64,
    most: f64,
) -> Result<(), ParameterError> {
    if value >= least && value <= most {
        Ok(())
    } else {
        Err(ParameterError::OutOfRange {
            name,
            value,
            least,
            most,
        })
    }
}

/// Runs checks one after another inside a `const fn`, where `?` is not available.
macro_rules! check_all {
    ($($name:literal: $value:expr, $least:expr, $most:expr;)*) => {
        $(if let Err(error) = $crate::parameters::check($name, $value, $least, $most) {
            return Err(error);
        })*
    };
}
pub(crate) use check_all;

/// The longest distance a sensor can be given, in cm: sensors that see farther are not this robot's.
const FARTHEST_CM: f64 = 10_000.0;

/// What the lattice can start from.
const LARGEST_AMPLITUDE: f64 = Activation::LIMIT.0 as f64 / Activation::ONE as f64;

const fn sensor_ranges(p: &SensingParameters) -> Result<SensorRanges, ParameterError> {
    check_all! {
        "sensing.front_near_cm": p.front_near_cm, 0.0, FARTHEST_CM;
        "sensing.front_far_cm": p.front_far_cm, 0.0, FARTHEST_CM;
        "sensing.side_near_cm": p.side_near_cm, 0.0, FARTHEST_CM;
        "sensing.side_far_cm": p.side_far_cm, 0.0, FARTHEST_CM;
    }
    if p.front_far_cm - p.front_near_cm < 1.0 {
        return Err(ParameterError::EmptyRange {
            name: "sensing.front_far_cm",
        });
    }
    if p.side_far_cm - p.side_near_cm < 1.0 {
        return Err(ParameterError::EmptyRange {
            name: "sensing.side_far_cm",
        });
    }
    Ok(SensorRanges {
        front: DistanceRange {
            near: from_cm(p.front_near_cm),
            far: from_cm(p.front_far_cm),
        },
        side: DistanceRange {
            near: from_cm(p.side_near_cm),
            far: from_cm(p.side_far_cm),
        },
    })
}

const fn learning_coefficients(
    p: &LearningParameters,
) -> Result<LearningCoefficients, ParameterError> {
    check_all! {
        "learning.module_cm": p.module_cm, 0.1, 1_000.0;
        "learning.sensing_width": p.sensing_width, 0.0, 0.999;
        "learning.sensing_ageing": p.sensing_ageing, 0.0, 0.999_999;
        "learning.amplitude_limit": p.amplitude_limit, 0.0, LARGEST_AMPLITUDE;
        "learning.initial_phase_deg": p.initial_phase_deg, 0.0, 180.0;
        "learning.phase_limit_deg": p.phase_limit_deg, 1.0, 180.0;
        "learning.initial_search_deg": p.initial_search_deg, 0.0, 90.0;
        "learning.final_search_deg": p.final_search_deg, 0.0, 90.0;
        "learning.search_ageing": p.search_ageing, 0.0, 0.999_999;
        "learning.rate": p.rate, 0.0, 1.0;
    }
    Ok(LearningCoefficients {
        module: from_cm(p.module_cm),
        sensing_width: fraction(p.sensing_width),
        sensing_ageing: fraction(p.sensing_ageing),
        amplitude_limit: Activation((p.amplitude_limit * Activation::ONE as f64 + 0.5) as i32),
        initial_phase: from_degrees(p.initial_phase_deg),
        phase_limit: from_degrees(p.phase_limit_deg),
        initial_search: from_degrees(p.initial_search_deg),
        final_search: from_degrees(p.final_search_deg),
        search_ageing: fraction(p.search_ageing),
        rate: (p.rate * 1e6 + 0.5) as u32,
    })
}

const fn from_cm(cm: f64) -> Micrometres {
    Micrometres((cm * Micrometres::PER_CM as f64 + 0.5) as u32)
}

/// Only for angles that are not negative.
const fn from_degrees(degrees: f64) -> Microdegrees {
    Microdegrees((degrees * Microdegrees::PER_DEGREE as f64 + 0.5) as i32)
}

/// A number in [0, 1) as a fraction of 2^32.
const fn fraction(x: f64) -> u32 {
    (x * 4_294_967_296.0 + 0.5) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
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
