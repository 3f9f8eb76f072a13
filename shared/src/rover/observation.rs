//! What the rover senses at one moment.

use crate::contract::{ChannelHealth, CompassHealth};
use crate::sensing::ir::{AdcCount, CHANNELS, IrReading};
use crate::time::Instant;
use crate::units::{Microdegrees, Micrometres};

/// What is sensed at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observation {
    /// When the range sensors were sampled.
    pub time: Instant,
    /// The range sensors.
    pub ir: IrReading,
    /// Where the rover points, if the compass can be believed.
    pub heading: Option<Microdegrees>,
    /// Whether it can.
    pub compass: CompassHealth,
}

impl Observation {
    /// Before anything was sensed.
    pub const NOTHING: Self = Self {
        time: Instant(0),
        ir: IrReading {
            counts: [AdcCount::ZERO; CHANNELS],
            distances: [Micrometres(0); CHANNELS],
            health: [ChannelHealth::Unknown; CHANNELS],
        },
        heading: None,
        compass: CompassHealth::Unknown,
    };
}
