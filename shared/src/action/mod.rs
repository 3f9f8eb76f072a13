//! The action selection network (II-C): the patterns that have occurred, and what each is bound to.
//!
//! How a pattern's action is learned, the motor map, is up to the [learning rule](crate::learning).

pub mod pattern_vector;

use serde::{Deserialize, Serialize};

use crate::units::{Microdegrees, Micrometres};

/// A movement: first turn, then go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Action {
    /// How far to turn on the spot, positive to the left.
    #[serde(rename = "phase_udeg")]
    pub phase: Microdegrees,
    /// How far to go then.
    #[serde(rename = "module_um")]
    pub module: Micrometres,
}

impl Action {
    /// Stay: what is done when there is no percept to act upon.
    pub const STAY: Self = Self {
        phase: Microdegrees(0),
        module: Micrometres(0),
    };
}
