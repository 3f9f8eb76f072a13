//! Progress detection: whether the driven wheels move the rover.

use super::parameters::Parameters;
use crate::sensing::ir::Ranges;
use crate::time::Duration;
use crate::units::{Microdegrees, Micrometres};

/// Accumulates the time for which the wheels were driven without a change.
///
/// **A turn** must change the heading. Each turn is judged separately: small turns to and fro keep
/// the heading within what counts as no change, although each was made.
///
/// **An advance** must change a range if something is in view ahead; otherwise its time does not
/// count. (A rover that spins its wheels in the open is detected at its next turn only.) The time
/// accumulates over consecutive advances, since one of 7 cm is shorter than the limit.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    turning: Stretch,
    advancing: Stretch,
    proven: bool,
}

/// Driven time since the last change.
#[derive(Clone, Debug, Default)]
struct Stretch {
    reference: Option<(Microdegrees, [Micrometres; 3])>,
    driven: Duration,
}

/// Result of one evaluation of heading and ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    /// They changed since the reference, which is replaced.
    Moved,
    /// No change, and the limit is not reached.
    Open,
    /// The limit of driven time without change is reached.
    Stalled,
}

impl Progress {
    /// No driven time.
    pub const fn new() -> Self {
        Self {
            turning: Stretch::NEW,
            advancing: Stretch::NEW,
            proven: false,
        }
    }

    /// Begins a move. Changes between moves are ignored: the rover may have been carried.
    pub fn begin_move(&mut self) {
        self.proven = false;
        self.advancing.reference = None;
    }

    /// Whether this move is known to have moved the rover: heading or ranges changed.
    pub const fn proven(&self) -> bool {
        self.proven
    }

    /// Begins a turn.
    pub fn begin_turn(&mut self) {
        self.turning = Stretch::NEW;
    }

    /// Evaluates what is sensed after the wheels were driven for `driven`; `advancing`: forwards
    /// rather than in place. Returns true when the limit of driven time without progress is
    /// reached, and restarts the count.
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
        let turn = self.turning.take(p, in_turn, heading, ranges);
        let advance = self.advancing.take(p, in_advance, heading, ranges);
        let changes = [turn, advance];
        self.proven |= changes.contains(&Change::Moved);
        changes.contains(&Change::Stalled)
    }
}

impl Stretch {
    const NEW: Self = Self {
        reference: None,
        driven: Duration::ZERO,
    };

    fn take(
        &mut self,
        p: &Parameters,
        driven: Duration,
        heading: Microdegrees,
        ranges: [Micrometres; 3],
    ) -> Change {
        let (from, before) = *self.reference.get_or_insert((heading, ranges));
        let moved = heading.turn_from(from).0.abs() >= p.progress_angle.0
            || ranges
                .iter()
                .zip(&before)
                .any(|(now, then)| now.0.abs_diff(then.0) >= p.progress_distance.0);
        if moved {
            self.reference = Some((heading, ranges));
            self.driven = Duration::ZERO;
            return Change::Moved;
        }
        self.driven = self.driven.plus(driven);
        if self.driven < p.no_progress {
            return Change::Open;
        }
        self.driven = Duration::ZERO;
        Change::Stalled
    }
}
