//! Writing logs.

use std::collections::BTreeMap;
use std::io::{BufWriter, Seek, Write};
use std::sync::Arc;

use mcap::records::MessageHeader;
use mcap::{Attachment, WriteOptions, Writer};
use rover_shared::controller::Learned;
use rover_shared::sensing::Sample;
use serde::Serialize;

use super::arena::{ARENA_SCHEMA, Arena};
use super::message::{Chain, END_SCHEMA, End, STEP_SCHEMA, Step};
use super::{AFTER, ARENA_TOPIC, BEFORE, END_TOPIC, FORMAT, METADATA, Origin, STEP_TOPIC};
use rover_simulator::arena::{Scenario, World};
use rover_simulator::experiment::{Ending, Event, TaskKind, Witness};

/// Nanoseconds of log time per action.
const ACTION_NS: u64 = 1_000_000_000;

/// Writes a log. As a [`Witness`] it writes what a pilot does; the first error is kept for
/// [`finish`](Self::finish), and nothing is written after it.
pub struct LogWriter<W: Write + Seek> {
    mcap: Writer<BufWriter<W>>,
    channels: [u16; 3],
    chain: Chain,
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
        let options = WriteOptions::new()
            .compression(None)
            .library("turing-rover");
        let mut mcap = options.create(BufWriter::new(file)).map_err(io_error)?;
        mcap.write_metadata(&mcap::records::Metadata {
            name: METADATA.into(),
            metadata: BTreeMap::from([
                ("format".into(), FORMAT.to_string()),
                ("seed".into(), origin.seed.to_string()),
                ("mode".into(), json_name(&origin.mode)),
                ("writer".into(), origin.writer.clone()),
            ]),
        })
        .map_err(io_error)?;
        attach(&mut mcap, BEFORE, knowledge, 0)?;
        let mut channel = |topic: &str, name: &str, schema: &str| {
            let schema = mcap.add_schema(name, "jsonschema", schema.as_bytes())?;
            mcap.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        let channels = [
            channel(STEP_TOPIC, "Step", STEP_SCHEMA).map_err(io_error)?,
            channel(END_TOPIC, "End", END_SCHEMA).map_err(io_error)?,
            channel(ARENA_TOPIC, "Arena", ARENA_SCHEMA).map_err(io_error)?,
        ];
        Ok(Self {
            mcap,
            channels,
            chain: Chain::new(origin)?,
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
        let time = self.time();
        attach(&mut self.mcap, AFTER, knowledge, time)?;
        self.mcap.finish().map_err(io_error)?;
        self.mcap
            .into_inner()
            .into_inner()
            .map_err(|error| error.into_error())
    }

    /// Writes one step.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_step(&mut self, step: &Step) -> std::io::Result<()> {
        self.write(0, step)?;
        self.actions += 1;
        Ok(())
    }

    /// Writes the end of a trial.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_end(&mut self, end: &End) -> std::io::Result<()> {
        self.write(1, end)
    }

    /// Writes where the trial that begins takes place.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_arena(&mut self, scenario: &Scenario) -> std::io::Result<()> {
        let before = self.world.replace(scenario.world.clone());
        let same_place = before.is_some_and(|world| Arc::ptr_eq(&world, &scenario.world));
        self.write(2, &Arena::new(self.trial, scenario, same_place))
    }

    fn write(&mut self, channel: usize, message: &impl Serialize) -> std::io::Result<()> {
        let data = self.chain.seal(message)?;
        let time = self.time();
        let header = MessageHeader {
            channel_id: self.channels[channel],
            // Counts actions round and round: readers use it to notice gaps, and times to order.
            sequence: self.actions as u32,
            log_time: time,
            publish_time: time,
        };
        self.mcap
            .write_to_known_channel(&header, &data)
            .map_err(io_error)
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

fn attach<W: Write + Seek>(
    mcap: &mut Writer<W>,
    name: &str,
    data: &[u8],
    time: u64,
) -> std::io::Result<()> {
    let attachment = Attachment {
        log_time: time,
        create_time: 0,
        name: name.into(),
        media_type: "application/octet-stream".into(),
        data: data.into(),
    };
    mcap.attach(&attachment).map_err(io_error)
}

/// A value without fields by its name in JSON.
fn json_name(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        other => unreachable!("a variant without fields is a string, not {other:?}"),
    }
}

fn io_error(error: mcap::McapError) -> std::io::Error {
    match error {
        mcap::McapError::Io(error) => error,
        other => std::io::Error::other(other),
    }
}
