//! Do driven wheels move the rover?

use super::parameters::Parameters;
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
    proven: bool,
}

/// Driven time since something last changed.
#[derive(Clone, Debug, Default)]
struct Stretch {
    reference: Option<(Microdegrees, [Micrometres; 3])>,
    driven: Duration,
}

/// What a look at heading and ranges tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Look {
    /// Something changed since the reference was taken, which is taken anew.
    Moved,
    /// Nothing to tell yet.
    Open,
    /// The limit of driven time without progress is reached.
    Stalled,
}

impl Progress {
    /// Nothing driven yet.
    pub const fn new() -> Self {
        Self {
            turning: Stretch::NEW,
            advancing: Stretch::NEW,
            proven: false,
        }
    }

    /// A move begins. What changed since the last one, somebody else may have changed.
    pub fn begin_move(&mut self) {
        self.proven = false;
        self.advancing.reference = None;
    }

    /// Whether the move's driven wheels are known to have moved the rover: something changed.
    pub const fn proven(&self) -> bool {
        self.proven
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
        let turn = self.turning.take(p, in_turn, heading, ranges);
        let advance = self.advancing.take(p, in_advance, heading, ranges);
        let looks = [turn, advance];
        self.proven |= looks.contains(&Look::Moved);
        looks.contains(&Look::Stalled)
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
    ) -> Look {
        let (from, before) = *self.reference.get_or_insert((heading, ranges));
        let moved = heading.turn_from(from).0.abs() >= p.progress_angle.0
            || ranges
                .iter()
                .zip(&before)
                .any(|(now, then)| now.0.abs_diff(then.0) >= p.progress_distance.0);
        if moved {
            self.reference = Some((heading, ranges));
            self.driven = Duration::ZERO;
            return Look::Moved;
        }
        self.driven = self.driven.plus(driven);
        if self.driven < p.no_progress {
            return Look::Open;
        }
        self.driven = Duration::ZERO;
        Look::Stalled
    }
}
