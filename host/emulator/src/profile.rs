//! How long the firmware's action cycles take.
//!
//! The compiler puts most functions into their callers, so that there is none to measure that is a
//! whole cycle. What is left are the steps of the lattice, which only perceptions take, and the
//! executor's polls of tasks, one of which is the cycle that a perception belongs to:
//!
//! ```text
//!  ─────┤ poll of task `control`: sample in, learn, perceive, choose, motion begins ├─────► time
//!               ┤step├┤step├┤step├ ... ┤step├
//!               └──────── perception ───────┘
//! ```

use emulated_rp2040::elf::Image;
use emulated_rp2040::machine::Machine;
use emulated_rp2040::peripheral::Cycles;
use emulated_rp2040::probe::{Call, ProbeId};

/// What a mangled name of a step of the lattice contains.
const STEP: [&str; 3] = ["10perception", "7lattice", "7advance"];
/// What a mangled name of a poll of a task contains.
const POLL: [&str; 3] = ["16embassy_executor", "TaskStorage", "4poll"];

/// A program in which the cycles cannot be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the program has no function {0}: was it built with debug symbols?")]
pub struct NotFound(&'static str);

/// An action cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionCycle {
    /// When it began.
    pub at: Cycles,
    /// Cycles from the first to the last step of the lattice, without interrupts within steps.
    pub perception: Cycles,
    /// Cycles of all that the task did, without interrupts.
    pub whole: Cycles,
    /// Steps of the lattice.
    pub steps: u32,
}

/// Probes for the action cycles.
#[derive(Clone, Debug)]
pub struct Profile {
    step: ProbeId,
    polls: Vec<ProbeId>,
}

impl Profile {
    /// Begins to measure.
    ///
    /// # Errors
    /// The program has other functions than the firmware.
    pub fn start(machine: &mut Machine, image: &Image) -> Result<Self, NotFound> {
        let functions = |parts: &[&str; 3]| -> Vec<u32> {
            let matching = image.symbols_with(parts).filter(|symbol| symbol.size > 0);
            matching.map(|symbol| symbol.address).collect()
        };
        let step = *functions(&STEP)
            .first()
            .ok_or(NotFound("perception::lattice::State::advance"))?;
        let polls = functions(&POLL);
        if polls.is_empty() {
            return Err(NotFound("embassy_executor::raw::TaskStorage::poll"));
        }
        Ok(Self {
            step: machine.add_probe(step),
            polls: polls
                .into_iter()
                .map(|poll| machine.add_probe(poll))
                .collect(),
        })
    }

    /// The cycles measured so far.
    pub fn cycles(&self, machine: &Machine) -> Vec<ActionCycle> {
        let steps = machine.probe(self.step).calls();
        let mut cycles: Vec<ActionCycle> = self
            .polls
            .iter()
            .flat_map(|poll| machine.probe(*poll).calls())
            .filter_map(|poll| cycle(poll, steps))
            .collect();
        cycles.sort_by_key(|cycle| cycle.at);
        cycles
    }
}

/// The cycle that a poll is, if it took steps of the lattice. Steps are in the order of time.
fn cycle(poll: &Call, steps: &[Call]) -> Option<ActionCycle> {
    let first = steps.partition_point(|step| step.from < poll.from);
    let end = steps.partition_point(|step| step.from < poll.to);
    let within = steps.get(first..end)?;
    let (from, to) = (within.first()?.from, within.last()?.to);
    // Interrupts between two steps, a few cycles long each, are not told apart.
    let interrupted = within.iter().map(|step| step.interrupted).sum::<Cycles>();
    Some(ActionCycle {
        at: poll.from,
        perception: to - from - interrupted,
        whole: poll.cycles(),
        steps: within.len() as u32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn call(from: Cycles, to: Cycles, interrupted: Cycles) -> Call {
        Call {
            from,
            to,
            interrupted,
        }
    }

    #[test]
    fn a_poll_with_steps_is_a_cycle() {
        let steps = [call(110, 120, 0), call(121, 140, 5), call(310, 320, 0)];
        let found = cycle(&call(100, 200, 7), &steps);
        let expected = ActionCycle {
            at: 100,
            perception: 25,
            whole: 93,
            steps: 2,
        };
        assert_eq!(found, Some(expected));
        assert_eq!(cycle(&call(200, 300, 0), &steps), None);
    }
}
