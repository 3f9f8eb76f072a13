//! What the rover senses at one moment.

use crate::contract::{ChannelHealth, CompassHealth};
use crate::sensing::ir::{AdcCount, CHANNELS, IrReading};
use crate::time::Instant;
use crate::units::{Microdegrees, Micrometres};

/// The readings of all sensors at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observation {
    /// When the range sensors were sampled.
    pub time: Instant,
    /// The range sensors.
    pub ir: IrReading,
    /// The rover's heading, if the compass is good.
    pub heading: Option<Microdegrees>,
    /// Health of the compass.
    pub compass: CompassHealth,
}

impl Observation {
    /// No readings yet.
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
