//! Writing logs.

use std::io::{Seek, Write};
use std::sync::Arc;

use mcap::WriteOptions;
use rover_shared::controller::Learned;
use rover_shared::sensing::Sample;
use serde::Serialize;

use crate::arena::Arena;
use crate::container::writer::{Container, Times};
use crate::log::{AFTER, ARENA_TOPIC, BEFORE, END_TOPIC, Origin, STEP_TOPIC};
use crate::message::{End, Step};
use crate::schema;
use rover_simulator::arena::{Scenario, World};
use rover_simulator::experiment::{Ending, Event, TaskKind, Witness};

/// Nanoseconds of log time per action.
const ACTION_NS: u64 = 1_000_000_000;

/// Writes a log. As a [`Witness`] it writes what a pilot does; the first error is kept for
/// [`finish`](Self::finish), and nothing is written after it.
pub struct LogWriter<W: Write + Seek> {
    container: Container<W>,
    steps: u16,
    ends: u16,
    arenas: u16,
    trial: u32,
    /// The world of the trial before.
    world: Option<Arc<World>>,
    actions: u64,
    error: Option<std::io::Error>,
}

impl<W: Write + Seek> LogWriter<W> {
    /// Starts a log with what it starts from. `knowledge` is in its form as bytes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(file: W, origin: &Origin, knowledge: &[u8]) -> std::io::Result<Self> {
        let metadata = [
            ("seed", origin.seed.to_string()),
            ("mode", json_name(&origin.mode)),
            ("writer", origin.writer.clone()),
        ];
        let mut container = Container::begin(file, WriteOptions::new(), metadata)?;
        container.attach(BEFORE, knowledge, Times { log: 0, publish: 0 })?;
        Ok(Self {
            steps: container.channel(STEP_TOPIC, "Step", &schema::of::<Step>("Step"))?,
            ends: container.channel(END_TOPIC, "End", &schema::of::<End>("End"))?,
            arenas: container.channel(ARENA_TOPIC, "Arena", &schema::of::<Arena>("Arena"))?,
            container,
            trial: 1,
            world: None,
            actions: 0,
            error: None,
        })
    }

    /// Writes the knowledge at the end, and the index.
    ///
    /// # Errors
    /// The first that occurred since the log was begun.
    pub fn finish(mut self, knowledge: &[u8]) -> std::io::Result<W> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        let log = self.time();
        self.container
            .attach(AFTER, knowledge, Times { log, publish: 0 })?;
        self.container.finish()?;
        self.container.into_inner()
    }

    /// Writes one step.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_step(&mut self, step: &Step) -> std::io::Result<()> {
        self.write(self.steps, step)?;
        self.actions += 1;
        Ok(())
    }

    /// Writes the end of a trial.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_end(&mut self, end: &End) -> std::io::Result<()> {
        self.write(self.ends, end)
    }

    /// Writes where the trial that begins takes place.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_arena(&mut self, scenario: &Scenario) -> std::io::Result<()> {
        let before = self.world.replace(scenario.world.clone());
        let same_place = before.is_some_and(|world| Arc::ptr_eq(&world, &scenario.world));
        let arena = Arena::new(self.trial, scenario, same_place);
        self.write(self.arenas, &arena)
    }

    fn write(&mut self, channel: u16, message: &impl Serialize) -> std::io::Result<()> {
        let (log, publish) = (self.time(), self.time());
        // Counts actions round and round: readers use it to notice gaps, and times to order.
        let sequence = self.actions as u32;
        self.container
            .message(channel, sequence, Times { log, publish }, message)
            .map(|_| ())
    }

    fn time(&self) -> u64 {
        self.actions.saturating_mul(ACTION_NS)
    }

    fn note(&mut self, result: std::io::Result<()>) {
        if let Err(error) = result {
            self.error.get_or_insert(error);
        }
    }
}

impl<W: Write + Seek> Witness for LogWriter<W> {
    fn begin(&mut self, scenario: &Scenario) {
        if self.error.is_some() {
            return;
        }
        let written = self.write_arena(scenario);
        self.note(written);
    }

    fn step(&mut self, event: &Event) {
        if self.error.is_some() {
            return;
        }
        let written = self.write_step(&Step {
            trial: self.trial,
            interrupted: event.interrupted,
            task: event.task,
            sample: event.sample,
            record: event.record,
            motion: Some(event.motion),
            pose: Some(event.pose.into()),
        });
        self.note(written);
    }

    fn end(&mut self, sample: &Sample, task: TaskKind, learned: Option<Learned>, ending: Ending) {
        if self.error.is_some() {
            return;
        }
        let (trial, sample) = (self.trial, *sample);
        let written = self.write_end(&End {
            trial,
            task,
            sample,
            learned,
            ending,
        });
        self.note(written);
        self.trial += 1;
    }
}

/// A value without fields by its name in JSON.
fn json_name(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        other => unreachable!("a variant without fields is a string, not {other:?}"),
    }
}
