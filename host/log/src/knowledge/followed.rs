//! What a robot knows as its log goes on: its knowledge at some moment, and from then on what each
//! action says was learned.
//!
//! The records count the steps of the very knowledge, so a missing action is noticed. What a record
//! does not say is not guessed: the phase of a pattern that was just met is unknown until something
//! is learned of it.

use rover_shared::action::pattern_vector::CAPACITY;
use rover_shared::checksum::fingerprint;
use rover_shared::controller::{Familiarity, Learned, Perceived, StepRecord};
use rover_shared::learning::Memory;
use rover_shared::perception::PatternCode;
use rover_shared::sensing::neuron::{Activation, SensingNeuron};
use rover_shared::units::Microdegrees;

use rover_simulator::experiment::{Known, Staircases};

use super::file::from_bytes;

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

/// A copy of a robot's knowledge that follows its actions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Followed {
    staircases: Staircases,
    steps: u32,
    patterns: Vec<Pattern>,
    /// Of the bytes it was made of, as long as nothing has changed since.
    fingerprint: Option<u32>,
}

/// The record does not continue what was followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap;

impl Followed {
    /// Of knowledge in its form as bytes.
    ///
    /// # Errors
    /// A sentence, if the bytes are no knowledge.
    pub fn new(bytes: &[u8]) -> Result<Self, String> {
        let (known, parameters) = from_bytes(bytes).map_err(|error| error.to_string())?;
        let limit = parameters.learning.amplitude_limit * f64::from(Activation::ONE) + 0.5;
        // `as` saturates, and a staircase has no larger amplitude anyway.
        let limit = Activation((limit as i32).clamp(0, Activation::LIMIT.0));
        let fingerprint = Some(fingerprint(bytes));
        Ok(Self {
            fingerprint,
            ..Self::of(&known, limit)
        })
    }

    /// Of knowledge whose amplitudes stay within `limit`.
    pub fn of(known: &Known, limit: Activation) -> Self {
        let patterns = known.patterns.elements().iter().map(|element| Pattern {
            code: element.code,
            occurrences: element.occurrences,
            last_occurrence: element.last_occurrence,
            phase: Some(element.memory.phase()),
        });
        Self {
            staircases: Staircases {
                neurons: known.sensing.neurons,
                limit,
            },
            steps: known.steps,
            patterns: patterns.collect(),
            fingerprint: None,
        }
    }

    /// The four staircases.
    pub fn neurons(&self) -> &[SensingNeuron; 4] {
        &self.staircases.neurons
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

    /// The turn that a pattern stands for, in degrees, positive to the left; `None` if it is unknown.
    pub fn turn_deg(&self, code: PatternCode) -> Option<f64> {
        let phase = self.pattern(code)?.phase?;
        Some(f64::from(phase.0) / 1e6)
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
        self.staircases == other.staircases
            && self.steps == other.steps
            && self.patterns.len() == other.patterns.len()
            && self.patterns.iter().all(same)
    }

    /// Takes the next action of the robot whose knowledge this is. Also of an action that is not the
    /// next one, or of other knowledge, all is taken that its record says.
    ///
    /// # Errors
    /// [`Gap`] if it is not the next: then this may differ from the knowledge.
    pub fn follow(&mut self, record: &StepRecord) -> Result<(), Gap> {
        let next = record.step == self.steps;
        self.steps = record.step.wrapping_add(1);
        self.fingerprint = None;
        let learned = record
            .learned
            .map_or(Ok(()), |learned| self.learn(&learned));
        let met = match &record.perceived {
            Some(perceived) => self.meet(perceived, record.step),
            None => Ok(()),
        };
        if next { learned.and(met) } else { Err(Gap) }
    }

    /// Takes what was learned from an action.
    ///
    /// # Errors
    /// [`Gap`] if the pattern was not remembered here.
    pub fn learn(&mut self, learned: &Learned) -> Result<(), Gap> {
        self.fingerprint = None;
        if let Some(change) = &learned.staircase {
            self.staircases.change(change);
        }
        let known = self.pattern_mut(learned.code);
        let missing = known.is_none();
        match known {
            Some(pattern) => pattern.phase = Some(learned.phase),
            None => self.patterns.push(Pattern {
                code: learned.code,
                occurrences: 1,
                last_occurrence: self.steps.saturating_sub(1),
                phase: Some(learned.phase),
            }),
        }
        if missing { Err(Gap) } else { Ok(()) }
    }

    fn meet(&mut self, perceived: &Perceived, step: u32) -> Result<(), Gap> {
        let forgotten = match perceived.familiarity {
            Familiarity::Replaced(forgotten) => {
                let before = self.patterns.len();
                self.patterns.retain(|pattern| pattern.code != forgotten);
                self.patterns.len() < before
            }
            Familiarity::Known | Familiarity::New => true,
        };
        let remembered = perceived.familiarity == Familiarity::Known;
        let known = self.pattern_mut(perceived.code);
        let expected = known.is_some() == remembered && forgotten;
        match known {
            Some(pattern) => {
                pattern.occurrences = pattern.occurrences.saturating_add(1);
                pattern.last_occurrence = step;
            }
            None => self.patterns.push(Pattern {
                code: perceived.code,
                occurrences: 1,
                last_occurrence: step,
                phase: None,
            }),
        }
        if expected && self.patterns.len() <= CAPACITY {
            Ok(())
        } else {
            Err(Gap)
        }
    }

    fn pattern_mut(&mut self, code: PatternCode) -> Option<&mut Pattern> {
        self.patterns.iter_mut().find(|p| p.code == code)
    }
}
