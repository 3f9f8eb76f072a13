//! How fast staircases and motor map learn, in natural units and as the rule calculates with them.

use serde::{Deserialize, Serialize};

use crate::range_check::{ParameterError, check_all};
use crate::sensing::neuron::Activation;
use crate::units::{Microdegrees, Micrometres, fraction};

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
    /// Step amplitudes stay within +- this. Not the paper's: its own grow to some tens,
    /// which costs fidelity in fixed point. A bound of 10 was no worse to learn with than one of
    /// 40, which hardly any session reaches.
    pub amplitude_limit: f64,
    /// A pattern's first phase is uniform within +- this (III-A).
    pub initial_phase_deg: f64,
    /// Phases stay within +- this. Not the paper's; found by experiment.
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
    /// The paper's where it states them, else those that learned best in its arena.
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

/// [`LearningParameters`] in the units of the rule.
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

/// What the lattice can start from.
const LARGEST_AMPLITUDE: f64 = Activation::LIMIT.0 as f64 / Activation::ONE as f64;

impl LearningCoefficients {
    /// Checks the parameters and converts them.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub const fn new(p: &LearningParameters) -> Result<Self, ParameterError> {
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
        Ok(Self {
            module: Micrometres::nearest_to_cm(p.module_cm),
            sensing_width: fraction(p.sensing_width),
            sensing_ageing: fraction(p.sensing_ageing),
            amplitude_limit: Activation((p.amplitude_limit * Activation::ONE as f64 + 0.5) as i32),
            initial_phase: Microdegrees::nearest_to_degrees(p.initial_phase_deg),
            phase_limit: Microdegrees::nearest_to_degrees(p.phase_limit_deg),
            initial_search: Microdegrees::nearest_to_degrees(p.initial_search_deg),
            final_search: Microdegrees::nearest_to_degrees(p.final_search_deg),
            search_ageing: fraction(p.search_ageing),
            rate: (p.rate * 1e6 + 0.5) as u32,
        })
    }
}
