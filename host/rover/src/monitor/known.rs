//! What the rover knows, as far as it can be told from outside: its knowledge as it was read, and
//! from then on what each action says was learned.
//!
//! A mirror follows actions as long as none is missing: the records count the steps of the very
//! knowledge. What a record does not tell is not guessed: the phase of a pattern that has just
//! been met is unknown until something is learned of it.

use rover_shared::action::pattern_vector::CAPACITY;
use rover_shared::checksum::fingerprint;
use rover_shared::controller::{Familiarity, Learned, Perceived, StepRecord};
use rover_shared::learning::Memory;
use rover_shared::perception::PatternCode;
use rover_shared::sensing::neuron::{Activation, SensingNeuron};
use rover_shared::units::Microdegrees;

use rover_log::knowledge;

/// A pattern of the pattern vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// Which.
    pub code: PatternCode,
    /// How often it has occurred.
    pub occurrences: u32,
    /// The step at which it last did.
    pub last_occurrence: u32,
    /// The phase of its action, search aside; `None` until it is known.
    pub phase: Option<Microdegrees>,
}

/// A copy of a rover's knowledge that is kept up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mirror {
    neurons: [SensingNeuron; 4],
    limit: Activation,
    steps: u32,
    patterns: Vec<Pattern>,
    /// Of the bytes it was made of, as long as nothing has changed since.
    fingerprint: Option<u32>,
}

/// The record does not continue what was followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap;

impl Mirror {
    /// A mirror of knowledge in its form as bytes.
    ///
    /// # Errors
    /// A sentence, if the bytes are no knowledge.
    pub fn new(bytes: &[u8]) -> Result<Self, String> {
        let (known, parameters) = knowledge::from_bytes(bytes).map_err(|e| e.to_string())?;
        let limit = parameters.learning.amplitude_limit * f64::from(Activation::ONE) + 0.5;
        let patterns = known.patterns.elements().iter().map(|element| Pattern {
            code: element.code,
            occurrences: element.occurrences,
            last_occurrence: element.last_occurrence,
            phase: Some(element.memory.phase()),
        });
        Ok(Self {
            neurons: known.sensing.neurons,
            // `as` saturates, and a staircase has no larger amplitude anyway.
            limit: Activation((limit as i32).clamp(0, Activation::LIMIT.0)),
            steps: known.steps,
            patterns: patterns.collect(),
            fingerprint: Some(fingerprint(bytes)),
        })
    }

    /// The four staircases.
    pub fn neurons(&self) -> &[SensingNeuron; 4] {
        &self.neurons
    }

    /// The patterns, in no particular order.
    pub fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    /// The patterns, the most used first.
    pub fn by_use(&self) -> Vec<Pattern> {
        let mut patterns = self.patterns.clone();
        patterns.sort_by_key(|p| (std::cmp::Reverse(p.occurrences), p.code));
        patterns
    }

    /// A pattern, if it is remembered.
    pub fn pattern(&self, code: PatternCode) -> Option<&Pattern> {
        self.patterns.iter().find(|pattern| pattern.code == code)
    }

    /// Steps made so far.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Whether it is still exactly what was read.
    pub fn is_exact(&self) -> bool {
        self.fingerprint.is_some()
    }

    /// Whether this can be the knowledge with that fingerprint.
    pub fn can_be(&self, fingerprint: u32) -> bool {
        self.fingerprint.is_none_or(|own| own == fingerprint)
    }

    /// Whether everything that both know is the same in both.
    pub fn agrees_with(&self, other: &Self) -> bool {
        let same = |mine: &Pattern| {
            other.pattern(mine.code).is_some_and(|theirs| {
                let (a, b) = (mine.phase, theirs.phase);
                let phases_agree = a.is_none() || b.is_none() || a == b;
                phases_agree
                    && mine.occurrences == theirs.occurrences
                    && mine.last_occurrence == theirs.last_occurrence
            })
        };
        self.neurons == other.neurons
            && self.steps == other.steps
            && self.patterns.len() == other.patterns.len()
            && self.patterns.iter().all(same)
    }

    /// Takes the next action of the rover whose knowledge this is.
    ///
    /// # Errors
    /// [`Gap`] if it is not the next, or of other knowledge: then this is a mirror no more.
    pub fn follow(&mut self, record: &StepRecord) -> Result<(), Gap> {
        if record.step != self.steps {
            return Err(Gap);
        }
        self.steps = self.steps.wrapping_add(1);
        self.fingerprint = None;
        if let Some(learned) = &record.learned {
            self.learn(learned)?;
        }
        match &record.perceived {
            Some(perceived) => self.meet(perceived, record.step),
            None => Ok(()),
        }
    }

    /// Takes what was learned from an action.
    ///
    /// # Errors
    /// [`Gap`] if the pattern is not remembered here.
    pub fn learn(&mut self, learned: &Learned) -> Result<(), Gap> {
        self.fingerprint = None;
        if let Some(change) = learned.staircase {
            let neuron = &mut self.neurons[change.stimulus as usize];
            neuron.shift(change.step, change.amount, self.limit);
        }
        let pattern = self.pattern_mut(learned.code).ok_or(Gap)?;
        pattern.phase = Some(learned.phase);
        Ok(())
    }

    fn meet(&mut self, perceived: &Perceived, step: u32) -> Result<(), Gap> {
        let known = self.pattern_mut(perceived.code);
        match (perceived.familiarity, known) {
            (Familiarity::Known, Some(pattern)) => {
                pattern.occurrences = pattern.occurrences.saturating_add(1);
                pattern.last_occurrence = step;
                return Ok(());
            }
            (Familiarity::Known, None) | (_, Some(_)) => return Err(Gap),
            (Familiarity::New | Familiarity::Replaced(_), None) => {}
        }
        let new = Pattern {
            code: perceived.code,
            occurrences: 1,
            last_occurrence: step,
            phase: None,
        };
        if let Familiarity::Replaced(forgotten) = perceived.familiarity {
            *self.pattern_mut(forgotten).ok_or(Gap)? = new;
        } else if self.patterns.len() < CAPACITY {
            self.patterns.push(new);
        } else {
            return Err(Gap);
        }
        Ok(())
    }

    fn pattern_mut(&mut self, code: PatternCode) -> Option<&mut Pattern> {
        self.patterns.iter_mut().find(|p| p.code == code)
    }
}
