//! Do driven wheels move the rover?

use super::Parameters;
use crate::sensing::ir::Ranges;
use crate::time::Duration;
use crate::units::{Microdegrees, Micrometres};

/// Adds up the time for which the wheels were driven and nothing changed.
///
/// **A turn** must change the heading. Each is judged for itself: turns of a few degrees to and
/// fro keep the heading within what counts as no change, and each of them was made.
///
/// **An advance** must change a range, if there is anything ahead to tell by: with nothing in view
/// ahead, an advance proves nothing and its time does not count. (A rover that spins its wheels in
/// the open is thus found out at its next turn only.) The time is added up over as many advances
/// as it takes, for one of 7 cm is shorter than the limit.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    turning: Stretch,
    advancing: Stretch,
}

/// Driven time since something last changed.
#[derive(Clone, Debug, Default)]
struct Stretch {
    reference: Option<(Microdegrees, [Micrometres; 3])>,
    driven: Duration,
}

impl Progress {
    /// Nothing driven yet.
    pub const fn new() -> Self {
        Self {
            turning: Stretch::NEW,
            advancing: Stretch::NEW,
        }
    }

    /// A turn begins.
    pub fn begin_turn(&mut self) {
        self.turning = Stretch::NEW;
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
        let (in_turn, in_advance) = match (advancing, ranges[0] < p.in_view) {
            (false, _) => (driven, Duration::ZERO),
            (true, true) => (Duration::ZERO, driven),
            (true, false) => (Duration::ZERO, Duration::ZERO),
        };
        let turn = self.turning.stalled(p, in_turn, heading, ranges);
        let advance = self.advancing.stalled(p, in_advance, heading, ranges);
        turn || advance
    }
}

impl Stretch {
    const NEW: Self = Self {
        reference: None,
        driven: Duration::ZERO,
    };

    fn stalled(
        &mut self,
        p: &Parameters,
        driven: Duration,
        heading: Microdegrees,
        ranges: [Micrometres; 3],
    ) -> bool {
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
        } else {
            self.driven = self.driven.plus(driven);
        }
        let stalled = self.driven >= p.no_progress;
        if stalled {
            self.driven = Duration::ZERO;
        }
        stalled
    }
}
