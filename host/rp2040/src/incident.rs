//! Faults, resets and power cuts, which a real chip does not report.

use super::cpu::FaultReport;
use super::peripheral::Cycles;

/// Incidents that are kept; later ones are only counted.
const KEPT: usize = 64;

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incident {
    /// When.
    pub at: Cycles,
    /// What.
    pub kind: Kind,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Kind {
    /// A HardFault, which the program handles.
    #[error("hard fault: {0}")]
    HardFault(FaultReport),
    /// A fault where no HardFault can be taken. Only a reset helps, as that of the watchdog.
    #[error("lockup: {0}")]
    Lockup(FaultReport),
    /// The watchdog's reset.
    #[error("reset by the watchdog")]
    Watchdog {
        /// The last fault before it, if there was one.
        fault: Option<FaultReport>,
    },
    /// A reset of the core that the program asked for (SYSRESETREQ).
    #[error("reset by the program")]
    Requested,
    /// The RUN pin's reset.
    #[error("reset by the RUN pin")]
    RunPin,
    /// The brown-out detector's reset.
    #[error("reset by the brown-out detector")]
    BrownOut,
    /// The power was cut.
    #[error("power lost")]
    PowerLost,
}

/// All that happened.
#[derive(Clone, Debug, Default)]
pub struct Incidents {
    first: Vec<Incident>,
    count: u64,
}

impl Incidents {
    /// Adds one.
    pub(super) fn note(&mut self, incident: Incident) {
        self.count += 1;
        if self.first.len() < KEPT {
            self.first.push(incident);
        }
    }

    /// The first 64.
    pub fn first(&self) -> &[Incident] {
        &self.first
    }

    /// How many there were in all.
    pub const fn count(&self) -> u64 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_are_kept_and_all_are_counted() {
        let mut incidents = Incidents::default();
        for at in 0..100 {
            incidents.note(Incident {
                at,
                kind: Kind::RunPin,
            });
        }
        assert_eq!(incidents.first().len(), KEPT);
        assert_eq!(incidents.first()[63].at, 63);
        assert_eq!(incidents.count(), 100);
    }
}
