//! How the staircases came to be what they are.

use rover_shared::controller::Learned;
use rover_shared::learning::StaircaseChange;
use rover_shared::sensing::Sample;
use rover_shared::sensing::neuron::{Activation, SensingNeuron};

use super::pilot::{Ending, TaskKind};
use super::turing::{Event, Witness};

/// The four staircases, which follow their changes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Staircases {
    /// In the order of [`Stimulus`](rover_shared::sensing::Stimulus).
    pub neurons: [SensingNeuron; 4],
    /// The bound of the amplitudes.
    pub limit: Activation,
}

impl Staircases {
    /// Makes one change, by (5) or (6).
    pub fn change(&mut self, change: &StaircaseChange) {
        let neuron = &mut self.neurons[change.stimulus as usize];
        neuron.shift(change.step, change.amount, self.limit);
    }
}

/// All changes of the staircases, (5) and (6), in order. With them, the staircases at any action
/// are known without running the core again.
#[derive(Clone, Debug)]
pub struct History {
    /// What the staircases were at first.
    start: Staircases,
    /// Before which action each change was made, counted from 0 over all trials.
    changes: Vec<(u64, StaircaseChange)>,
    actions: u64,
}

impl History {
    /// A history that begins with these staircases, whose amplitudes stay within `limit`.
    pub fn new(neurons: [SensingNeuron; 4], limit: Activation) -> Self {
        Self {
            start: Staircases { neurons, limit },
            changes: Vec::new(),
            actions: 0,
        }
    }

    /// An action was chosen, after this was learned from the one before.
    pub fn acted(&mut self, learned: Option<&Learned>) {
        self.concluded(learned);
        self.actions += 1;
    }

    /// This was learned from the last action of a trial.
    pub fn concluded(&mut self, learned: Option<&Learned>) {
        if let Some(change) = learned.and_then(|learned| learned.staircase) {
            self.changes.push((self.actions, change));
        }
    }

    /// How many actions there were.
    pub fn actions(&self) -> u64 {
        self.actions
    }

    /// The changes, each with the number of the action, from 0, that was chosen after it.
    pub fn changes(&self) -> &[(u64, StaircaseChange)] {
        &self.changes
    }

    /// The staircases by which action number `action`, from 0, was chosen; the last ones for
    /// numbers beyond the end.
    pub fn at(&self, action: u64) -> [SensingNeuron; 4] {
        self.after(
            self.changes
                .partition_point(|(before, _)| *before <= action),
        )
    }

    /// The staircases after a number of changes.
    pub fn after(&self, changes: usize) -> [SensingNeuron; 4] {
        let mut staircases = self.start.clone();
        for (_, change) in self.changes.iter().take(changes) {
            staircases.change(change);
        }
        staircases.neurons
    }
}

impl Witness for History {
    fn step(&mut self, event: &Event) {
        self.acted(event.record.learned.as_ref());
    }

    fn end(&mut self, _: &Sample, _: TaskKind, learned: Option<Learned>, _: Ending) {
        self.concluded(learned.as_ref());
    }
}
