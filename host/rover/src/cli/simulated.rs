//! Rovers in simulated arenas: their tasks and parameters, for `learn` and `test`.

use rover_simulator::arena::ArenaSource;
use rover_simulator::experiment::{Stream, generator};

use super::output::Failure;

/// The tasks of a rover in an arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ArenaTask {
    /// Aim at a target, avoiding obstacles (III)
    Target,
    /// Follow a direction that changes at random, avoiding obstacles (IV)
    Direction,
}

impl ArenaTask {
    /// Trials to learn a task: 200 of at most 500 actions (III-B), or 10,000 actions in all, which
    /// at one a second are the rover's 160 minutes (IV-B).
    pub fn trials(self) -> u32 {
        match self {
            Self::Target => 200,
            Self::Direction => 20,
        }
    }

    /// The arena that a task is learned in unless another is named.
    pub fn arena(self) -> &'static str {
        match self {
            Self::Target => "paper",
            Self::Direction => "rover-5m",
        }
    }

    /// Refuses an arena that does not have what the task needs.
    pub fn check(self, name: &str, arenas: &ArenaSource) -> Result<(), Failure> {
        let scenario = arenas.scenario(&mut generator(0, Stream::Testing));
        if self == Self::Target && scenario.goal.is_none() {
            return Err(Failure::Usage(format!(
                "arena {name} has no target; add --task direction, or name an arena that has one"
            )));
        }
        Ok(())
    }
}
