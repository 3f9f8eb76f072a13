//! How busy the core is.

use crate::peripheral::Cycles;

/// How the core spent its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Cycles in which it executed, or the boot ROM did in its place.
    pub busy: Cycles,
    /// Cycles in which it slept, or was locked up.
    pub idle: Cycles,
}

impl Load {
    /// The share of the time that it was busy, 0 to 1; 0 if no time passed.
    pub fn share(self) -> f64 {
        let all = self.busy + self.idle;
        if all == 0 {
            return 0.0;
        }
        self.busy as f64 / all as f64
    }

    /// What was added since `before`.
    pub const fn since(self, before: Self) -> Self {
        Self {
            busy: self.busy - before.busy,
            idle: self.idle - before.idle,
        }
    }
}
