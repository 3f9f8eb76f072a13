//! What one robot knows and another does not.

use std::fmt;

use rover_link::names;
use rover_shared::sensing::Stimulus;
use serde::Serialize;

use super::summary::{Pattern, Summary};

/// How two knowledges differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Whether they are the same, byte by byte.
    pub equal: bool,
    /// Whether they were learned with the same parameters.
    pub same_parameters: bool,
    /// Fingerprints of the first and the second.
    pub fingerprints: [String; 2],
    /// Steps that each was learned in.
    pub steps: [u32; 2],
    /// Codes of patterns that only the first remembers.
    pub only_first: Vec<u16>,
    /// Codes of patterns that only the second remembers.
    pub only_second: Vec<u16>,
    /// Patterns of both whose turns differ, the most different first.
    pub phases: Vec<PhaseChange>,
    /// The largest difference of an amplitude, of each staircase.
    pub staircases: Vec<StaircaseChange>,
}

/// A pattern whose turn differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseChange {
    /// Pattern code (3).
    pub code: u16,
    /// Its turn in the first and in the second, to the left positive.
    pub phase_deg: [f64; 2],
}

/// How far two staircases are apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StaircaseChange {
    /// What it senses.
    pub stimulus: Stimulus,
    /// The largest difference of an amplitude.
    pub largest: f64,
}

impl Difference {
    /// Between two knowledges; `same_parameters`: whether these are equal.
    pub fn between(first: &Summary, second: &Summary, same_parameters: bool) -> Self {
        let only = |these: &Summary, others: &Summary| {
            let mut codes: Vec<_> = these
                .patterns
                .iter()
                .map(|pattern| pattern.code)
                .filter(|code| find(others, *code).is_none())
                .collect();
            codes.sort_unstable();
            codes
        };
        let mut phases: Vec<_> = first
            .patterns
            .iter()
            .filter_map(|a| {
                let phase_deg = [a.phase_deg, find(second, a.code)?.phase_deg];
                let code = a.code;
                (phase_deg[0] != phase_deg[1]).then_some(PhaseChange { code, phase_deg })
            })
            .collect();
        let distance = |change: &PhaseChange| (change.phase_deg[0] - change.phase_deg[1]).abs();
        phases.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
        let staircases = first.staircases.iter().zip(&second.staircases);
        let staircases = staircases.map(|(a, b)| StaircaseChange {
            stimulus: a.stimulus,
            largest: a
                .outputs
                .iter()
                .zip(&b.outputs)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max),
        });
        Self {
            equal: first.fingerprint == second.fingerprint && first.bytes == second.bytes,
            same_parameters,
            fingerprints: [first.fingerprint.clone(), second.fingerprint.clone()],
            steps: [first.steps, second.steps],
            only_first: only(first, second),
            only_second: only(second, first),
            phases,
            staircases: staircases.collect(),
        }
    }
}

fn find(summary: &Summary, code: u16) -> Option<&Pattern> {
    summary.patterns.iter().find(|pattern| pattern.code == code)
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = &self.fingerprints;
        if self.equal {
            return writeln!(f, "the same: {first}");
        }
        writeln!(f, "{first} and {second} differ")?;
        if !self.same_parameters {
            writeln!(f, "  learned with different parameters")?;
        }
        writeln!(f, "  steps: {} and {}", self.steps[0], self.steps[1])?;
        writeln!(
            f,
            "  patterns: {} only in the first, {} only in the second, {} with other turns",
            self.only_first.len(),
            self.only_second.len(),
            self.phases.len()
        )?;
        for change in self.phases.iter().take(10) {
            let [a, b] = change.phase_deg;
            writeln!(f, "    code {:<6} {a:>8.2} and {b:>8.2} deg", change.code)?;
        }
        for change in &self.staircases {
            let name = names::stimulus(change.stimulus);
            writeln!(f, "  staircase {name}: up to {:.3} apart", change.largest)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::summary::Staircase;
    use super::*;

    fn summary(fingerprint: &str, patterns: &[(u16, f64)], amplitude: f64) -> Summary {
        let pattern = |&(code, phase_deg): &(u16, f64)| Pattern {
            code,
            occurrences: 1,
            last_occurrence: 0,
            phase_deg,
            search_deg: 1.0,
        };
        Summary {
            fingerprint: fingerprint.into(),
            bytes: 10,
            steps: 3,
            width: 0.5,
            patterns: patterns.iter().map(pattern).collect(),
            staircases: vec![Staircase {
                stimulus: Stimulus::Front,
                outputs: vec![0.0, amplitude],
            }],
        }
    }

    #[test]
    fn what_differs_is_named_and_what_does_not_is_not() {
        let first = summary("a", &[(1, 5.0), (2, 6.0), (3, 7.0), (9, 1.0)], 1.0);
        let second = summary("b", &[(2, 6.5), (3, -7.0), (4, 0.0), (9, 1.0)], -0.5);
        let difference = Difference::between(&first, &second, true);
        assert!(!difference.equal);
        assert_eq!(difference.only_first, [1]);
        assert_eq!(difference.only_second, [4]);
        let codes: Vec<_> = difference.phases.iter().map(|change| change.code).collect();
        assert_eq!(codes, [3, 2]);
        assert_eq!(difference.staircases[0].largest, 1.5);
        assert!(Difference::between(&first, &first, true).equal);
    }
}
