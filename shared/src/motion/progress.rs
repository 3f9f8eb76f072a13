//! Do driven wheels move the rover?

use super::Parameters;
use crate::sensing::ir::Ranges;
use crate::time::Duration;
use crate::units::{Microdegrees, Micrometres};

/// Adds up the time for which the wheels were driven and nothing changed, over as many moves as
/// it takes: one advance of 7 cm is shorter than the limit.
///
/// Turning in place must change the heading. An advance must change a range, if there is
/// anything ahead to tell by: with nothing in view ahead, an advance proves nothing and its time
/// does not count. (A rover that spins its wheels in the open is thus found out at its next turn
/// only.)
#[derive(Clone, Debug, Default)]
pub struct Progress {
    reference: Option<(Microdegrees, [Micrometres; 3])>,
    driven: Duration,
}

impl Progress {
    /// Nothing driven yet.
    pub const fn new() -> Self {
        Self {
            reference: None,
            driven: Duration::ZERO,
        }
    }

    /// Takes what is sensed after the wheels were driven for `driven`; `advancing`: forwards
    /// rather than in place. True when the limit of driven time without progress is reached,
    /// and then begins anew.
    pub fn stalled(
        &mut self,
        p: &Parameters,
        driven: Duration,
        advancing: bool,
        heading: Microdegrees,
        clearance: Ranges,
    ) -> bool {
        let ranges = [clearance.front, clearance.left, clearance.right].map(|r| r.min(p.in_view));
        let moved = match &self.reference {
            None => true,
            Some((from, before)) => {
                heading.turn_from(*from).0.abs() >= p.progress_angle.0
                    || ranges
                        .iter()
                        .zip(before)
                        .any(|(now, then)| now.0.abs_diff(then.0) >= p.progress_distance.0)
            }
        };
        if moved {
            self.reference = Some((heading, ranges));
            self.driven = Duration::ZERO;
        } else if !advancing || ranges[0] < p.in_view {
            self.driven = self.driven.plus(driven);
        }
        let stalled = self.driven >= p.no_progress;
        if stalled {
            self.driven = Duration::ZERO;
        }
        stalled
    }
}
