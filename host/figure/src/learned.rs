//! What was learned, as far as figures show it.

use std::collections::BTreeMap;

use rover_shared::controller::Learned;
use rover_shared::perception::PatternCode;
use rover_shared::sensing::neuron::SensingNeuron;
use rover_shared::units::Microdegrees;

use rover_simulator::experiment::Known;

/// The staircases, and the turn that each pattern stands for.
#[derive(Clone, Debug)]
pub struct Lessons {
    /// The staircases, in the order of [`rover_shared::sensing::Stimulus`].
    pub neurons: [SensingNeuron; 4],
    phases: BTreeMap<PatternCode, Microdegrees>,
}

impl Lessons {
    /// What knowledge holds.
    pub fn of(known: &Known) -> Self {
        let elements = known.patterns.elements().iter();
        Self {
            neurons: known.sensing.neurons,
            phases: elements
                .map(|element| (element.code, element.memory.phase))
                .collect(),
        }
    }

    /// Takes note of the phase that a pattern was left with.
    pub fn note(&mut self, learned: Option<&Learned>) {
        if let Some(learned) = learned {
            self.phases.insert(learned.code, learned.phase);
        }
    }

    /// How many patterns are known.
    pub fn patterns(&self) -> usize {
        self.phases.len()
    }

    /// The turn that a pattern stands for, in degrees, positive to the left; `None` if it was
    /// never learned.
    pub fn turn_deg(&self, code: PatternCode) -> Option<f64> {
        self.phases.get(&code).map(|phase| f64::from(phase.0) / 1e6)
    }
}
