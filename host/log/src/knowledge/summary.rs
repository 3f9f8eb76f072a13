//! What a robot knows, for people and scripts.

use std::fmt;

use rover_link::names;
use rover_shared::action::pattern_vector::Element;
use rover_shared::checksum::fingerprint;
use rover_shared::learning::paper_rule::MotorWeights;
use rover_shared::parameters::Parameters;
use rover_shared::sensing::Stimulus;
use serde::Serialize;

use crate::results;
use rover_simulator::experiment::Known;

/// What stands in a knowledge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// By which logs and rovers name it, in hexadecimal digits.
    pub fingerprint: String,
    /// Its length.
    pub bytes: usize,
    /// Steps that were learned in.
    pub steps: u32,
    /// How far staircases may still change, from 1 down.
    pub width: f64,
    /// Patterns that are remembered, the ones used most first.
    pub patterns: Vec<Pattern>,
    /// The amplitudes of the four staircases' ten steps.
    pub staircases: Vec<Staircase>,
}

/// One pattern and its action.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pattern {
    /// Pattern code (3).
    pub code: u16,
    /// How often it arose.
    pub occurrences: u32,
    /// When it last arose, as a number of steps.
    pub last_occurrence: u32,
    /// Its turn, to the left positive.
    pub phase_deg: f64,
    /// Width of the search around it.
    pub search_deg: f64,
}

/// One sensing neuron.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Staircase {
    /// What it senses.
    pub stimulus: Stimulus,
    /// Amplitudes of its steps, from near (or right) to far (or left).
    pub outputs: Vec<f64>,
}

impl Summary {
    /// Of knowledge, and the bytes that it came in.
    pub fn new(known: &Known, bytes: &[u8]) -> Self {
        let degrees = |angle: rover_shared::units::Microdegrees| f64::from(angle.0) / 1e6;
        let mut elements: Vec<_> = known.patterns.elements().iter().collect();
        elements.sort_by_key(|element| (std::cmp::Reverse(element.occurrences), element.code.0));
        let pattern = |element: &&Element<MotorWeights>| Pattern {
            code: element.code.0,
            occurrences: element.occurrences,
            last_occurrence: element.last_occurrence,
            phase_deg: degrees(element.memory.phase),
            search_deg: degrees(element.memory.search),
        };
        Self {
            fingerprint: format!("{:08x}", fingerprint(bytes)),
            bytes: bytes.len(),
            steps: known.steps,
            width: f64::from(known.sensing.width) / f64::from(u32::MAX),
            patterns: elements.iter().map(pattern).collect(),
            staircases: staircases(known),
        }
    }
}

fn staircases(known: &Known) -> Vec<Staircase> {
    use rover_shared::sensing::neuron::{Activation, STEPS, StepIndex};
    let output = |neuron: &rover_shared::sensing::neuron::SensingNeuron, step| {
        let activation = neuron.output(StepIndex::saturating(step));
        f64::from(activation.0) / f64::from(Activation::ONE)
    };
    Stimulus::ALL
        .into_iter()
        .zip(&known.sensing.neurons)
        .map(|(stimulus, neuron)| Staircase {
            stimulus,
            outputs: (0..STEPS as u32).map(|step| output(neuron, step)).collect(),
        })
        .collect()
}

/// A summary as text: what matters, with the patterns used most drawn.
pub fn describe(known: &Known, bytes: &[u8], parameters: &Parameters) -> String {
    let summary = Summary::new(known, bytes);
    let robot = if *parameters == Parameters::ROVER {
        "the rover's parameters"
    } else if *parameters == Parameters::PAPER {
        "the paper's parameters"
    } else {
        "other parameters than the rover's and the paper's"
    };
    let mut text = format!(
        "knowledge {}: {} bytes, {} patterns, {} steps, {robot}\n\n",
        summary.fingerprint,
        summary.bytes,
        summary.patterns.len(),
        summary.steps
    );
    text += &results::patterns(known, 5);
    text += "\nstaircases, from near to far (target: from right to left)\n";
    for staircase in &summary.staircases {
        text += &format!("  {staircase}\n");
    }
    text
}

impl fmt::Display for Staircase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = names::stimulus(self.stimulus);
        write!(f, "{name:<8}")?;
        for output in &self.outputs {
            write!(f, " {output:>6.2}")?;
        }
        Ok(())
    }
}
