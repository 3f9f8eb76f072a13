//! What a log holds, and reading that of a simulation.

use rover_shared::learning::Mode;
use serde::{Deserialize, Serialize};

use crate::arena::Arena;
use crate::container::reader::{Extras, Message, for_each_message};
use crate::error::ReadError;
use crate::message::{self, End, Step};

/// The attachment with what was known at the start.
pub(crate) const BEFORE: &str = "knowledge.rover";
/// The attachment with what was known at the end.
pub(crate) const AFTER: &str = "knowledge-after.rover";
/// The channel of [`Arena`].
pub(crate) const ARENA_TOPIC: &str = "/arena";
/// The channel of [`Step`].
pub(crate) const STEP_TOPIC: &str = "/step";
/// The channel of [`End`].
pub(crate) const END_TOPIC: &str = "/end";

/// What a log started from, besides the knowledge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The seed of the controller's generator.
    pub seed: u64,
    /// Whether the controller learned.
    pub mode: Mode,
    /// Who wrote the log: program and version.
    pub writer: String,
}

/// One message, in the order in which they were written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Of channel `/step`.
    Step(Box<Step>),
    /// Of channel `/end`.
    End(Box<End>),
}

impl Entry {
    /// The trial that it belongs to, from 1; of a recording the session.
    pub fn trial(&self) -> u32 {
        match self {
            Self::Step(step) => step.trial,
            Self::End(end) => end.trial,
        }
    }
}

/// A log.
#[derive(Clone, Debug)]
pub struct Log {
    /// What it started from.
    pub origin: Origin,
    /// The knowledge at the start, as bytes.
    pub before: Vec<u8>,
    /// The knowledge at the end, as bytes; `None` if the log is cut off or was not finished.
    pub after: Option<Vec<u8>>,
    /// Where trials took place, as far as that is known.
    pub arenas: Vec<Arena>,
    /// Whether its trials are sessions of a rover, which has no trials: it drives on and on.
    pub free_running: bool,
    /// All messages on what was done that can be read.
    pub entries: Vec<Entry>,
    /// Whether the file ends before the log does.
    pub cut_off: bool,
}

impl Log {
    /// Reads a simulation's log, up to where it is cut off.
    pub(crate) fn of_simulation(file: &[u8]) -> Result<Self, ReadError> {
        let extras = Extras::read(file)?;
        let header = extras.header()?;
        let text = |key| header.get(key).map_or("", String::as_str);
        let seed = text("seed").parse();
        let mode = serde_json::from_value::<Mode>(text("mode").into());
        let origin = Origin {
            seed: seed.map_err(|_| ReadError::Foreign("a valid seed"))?,
            mode: mode.map_err(|_| ReadError::Foreign("a valid mode"))?,
            writer: text("writer").into(),
        };
        let attachment = |name| extras.attachments.get(name).map(|bytes| bytes.to_vec());
        let before = attachment(BEFORE);
        let mut log = Self {
            origin,
            before: before.ok_or(ReadError::Foreign("the attachment knowledge.rover"))?,
            after: attachment(AFTER),
            arenas: Vec::new(),
            free_running: false,
            entries: Vec::new(),
            cut_off: false,
        };
        log.cut_off = for_each_message(file, |message| {
            let number = log.entries.len() + 1;
            log.take(message)
                .map_err(|error| ReadError::Message(number, error))
        })?;
        Ok(log)
    }

    fn take(&mut self, message: &Message<'_>) -> Result<(), serde_json::Error> {
        match message.topic {
            STEP_TOPIC => {
                let (step, _) = message::read(message.data)?;
                self.entries.push(Entry::Step(Box::new(step)));
            }
            END_TOPIC => {
                let (end, _) = message::read(message.data)?;
                self.entries.push(Entry::End(Box::new(end)));
            }
            ARENA_TOPIC => self.arenas.push(message::read(message.data)?.0),
            _ => {}
        }
        Ok(())
    }
}
