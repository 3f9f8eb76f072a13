//! Reading logs, whole or cut off.

use std::collections::BTreeMap;

use crc::{CRC_32_ISO_HDLC, Crc};
use enumset::EnumSet;
use mcap::MAGIC;
use mcap::read::{ChunkReader, LinearReader, Options};
use mcap::records::{ChunkHeader, MessageHeader, Record};
use rover_shared::learning::Mode;

use super::arena::Arena;
use super::lengths;
use super::message::{Chain, End, Step};
use super::recording::{Recording, SOURCE};
use super::replayable::Sessions;
use super::{AFTER, ARENA_TOPIC, BEFORE, END_TOPIC, FORMAT, METADATA, Origin, STEP_TOPIC};

/// One message, in the order in which they were written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Of channel `/step`.
    Step(Box<Step>),
    /// Of channel `/end`.
    End(Box<End>),
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
    /// The number of the first message, from 1, whose checksum does not follow from those before.
    pub broken_at: Option<usize>,
    /// Whether the file ends before the log does.
    pub cut_off: bool,
}

/// Why a file is not a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It is not MCAP, or nothing of it can be read.
    #[error("not an MCAP file, or damaged: {0}")]
    Mcap(#[from] mcap::McapError),
    /// It is MCAP, but was not written by this program.
    #[error("an MCAP file, but not a log of a Turing rover: {0} is missing")]
    Foreign(&'static str),
    /// It is of another version.
    #[error("a log of format {0}, expected format {FORMAT}: use the version that wrote it")]
    Format(String),
    /// It is a recording that begins in the middle of a drive.
    #[error(
        "a recording in which no session's starting knowledge is known: record from before the \
         rover begins to drive"
    )]
    NoStart,
    /// A chunk's checksum is wrong.
    #[error("damaged after message {0}: {1}")]
    Damaged(usize, mcap::McapError),
    /// A record holds a length that cannot be true.
    #[error("damaged at byte {0}: a record there claims to hold more than it does")]
    Length(usize),
    /// A message is not what its channel holds.
    #[error("message {0} is not valid: {1}")]
    Message(usize, serde_json::Error),
}

impl Log {
    /// Reads a log from the contents of its file. A log that was cut off is read up to the cut. Of a
    /// rover's recording the sessions stand for the trials, from the first that begins in it.
    ///
    /// # Errors
    /// If it is not a log of this version, or a part of it was changed by anything but cutting.
    pub fn read(file: &[u8]) -> Result<Self, ReadError> {
        Self::read_parts(&[file])
    }

    /// The same of a recording that has several files, in order.
    ///
    /// # Errors
    /// As [`read`](Self::read); also if there are several files and they are no recording's.
    pub fn read_parts(files: &[impl AsRef<[u8]>]) -> Result<Self, ReadError> {
        let [file] = files else {
            return Sessions::from(Recording::read(files)?).try_into();
        };
        let file = file.as_ref();
        if !file.starts_with(MAGIC) {
            return Err(mcap::McapError::BadMagic.into());
        }
        let (metadata, mut attachments) = read_records(file)?;
        let metadata = metadata.ok_or(ReadError::Foreign("the metadata turing-rover"))?;
        if metadata
            .get("source")
            .is_some_and(|source| source == SOURCE)
        {
            return Sessions::from(Recording::read(&[file])?).try_into();
        }
        let origin = read_origin(&metadata)?;
        let before = attachments
            .remove(BEFORE)
            .ok_or(ReadError::Foreign("the attachment knowledge.rover"))?;
        let mut log = Self {
            origin,
            before,
            after: attachments.remove(AFTER),
            arenas: Vec::new(),
            free_running: false,
            entries: Vec::new(),
            broken_at: None,
            cut_off: false,
        };
        log.read_messages(file)?;
        Ok(log)
    }

    fn read_messages(&mut self, file: &[u8]) -> Result<(), ReadError> {
        let mut chain = Chain::new(&self.origin).map_err(|error| ReadError::Message(0, error))?;
        self.cut_off = for_each_message(file, |topic, _, data| {
            self.take(topic, data, &mut chain)?;
            Ok(self.entries.len())
        })?;
        Ok(())
    }

    fn take(&mut self, topic: &str, data: &[u8], chain: &mut Chain) -> Result<(), ReadError> {
        let number = self.entries.len() + 1;
        let invalid = |error| ReadError::Message(number, error);
        let intact = match topic {
            STEP_TOPIC => {
                let (step, intact) = chain.open(data).map_err(invalid)?;
                self.entries.push(Entry::Step(Box::new(step)));
                intact
            }
            END_TOPIC => {
                let (end, intact) = chain.open(data).map_err(invalid)?;
                self.entries.push(Entry::End(Box::new(end)));
                intact
            }
            ARENA_TOPIC => {
                let (arena, intact) = chain.open(data).map_err(invalid)?;
                self.arenas.push(arena);
                intact
            }
            _ => return Ok(()),
        };
        if !intact {
            self.broken_at.get_or_insert(number);
        }
        Ok(())
    }
}

/// Hands over all messages of a file with their topics, in order, as far as the file reaches.
/// `take` gives how many were of use so far, for errors to say. True if the file is cut off.
pub(super) fn for_each_message(
    file: &[u8],
    mut take: impl FnMut(&str, MessageHeader, &[u8]) -> Result<usize, ReadError>,
) -> Result<bool, ReadError> {
    let mut topics = BTreeMap::new();
    let mut read = 0;
    let mut look_at = |record, read: &mut usize| {
        match record {
            Record::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                let topic = topics.get(&header.channel_id).map_or("", String::as_str);
                *read = take(topic, header, &data)?;
            }
            _ => {}
        }
        Ok::<_, ReadError>(())
    };
    for record in LinearReader::new_with_options(file, EnumSet::only(Options::IgnoreEndMagic))? {
        match record {
            Ok(Record::Chunk { header, data }) => {
                for record in whole_chunk(header, &data, read)? {
                    look_at(record, &mut read)?;
                }
            }
            Ok(record) => look_at(record, &mut read)?,
            Err(error) if is_cut(&error, file) => return Ok(true),
            Err(error) => return Err(ReadError::Damaged(read, error)),
        }
    }
    Ok(!file.ends_with(MAGIC))
}

/// The records of a chunk whose checksum is right: nothing else is taken apart.
fn whole_chunk(
    header: ChunkHeader,
    data: &[u8],
    at: usize,
) -> Result<Vec<Record<'static>>, ReadError> {
    let damaged = |error| ReadError::Damaged(at, error);
    if !header.compression.is_empty() {
        return Err(damaged(mcap::McapError::UnsupportedCompression(
            header.compression,
        )));
    }
    let calculated = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(data);
    let saved = header.uncompressed_crc;
    // Zero stands for "not calculated", which this program's logs never have.
    if calculated != saved {
        return Err(damaged(mcap::McapError::BadChunkCrc { saved, calculated }));
    }
    let records = ChunkReader::new(header, data).map_err(damaged)?;
    records
        .map(|record| record.map(Record::into_owned))
        .collect::<Result<_, _>>()
        .map_err(damaged)
}

pub(super) type Attachments = BTreeMap<String, Vec<u8>>;

/// Metadata and attachments, as far as the file reaches.
pub(super) fn read_records(
    file: &[u8],
) -> Result<(Option<BTreeMap<String, String>>, Attachments), ReadError> {
    if let Some(at) = lengths::first_impossible(file) {
        return Err(ReadError::Length(at));
    }
    let (mut metadata, mut attachments) = (None, Attachments::new());
    for record in LinearReader::new_with_options(file, EnumSet::only(Options::IgnoreEndMagic))? {
        match record {
            Ok(Record::Metadata(record)) if record.name == METADATA => {
                metadata = Some(record.metadata);
            }
            Ok(Record::Attachment { header, data, .. }) => {
                attachments.insert(header.name, data.into_owned());
            }
            Ok(_) => {}
            // How much is missing shows when the messages are read.
            Err(error) if metadata.is_some() && is_cut(&error, file) => break,
            Err(error) => return Err(error.into()),
        }
    }
    Ok((metadata, attachments))
}

fn read_origin(metadata: &BTreeMap<String, String>) -> Result<Origin, ReadError> {
    let text = |key| metadata.get(key).map_or("", String::as_str);
    if text("format") != FORMAT.to_string() {
        return Err(ReadError::Format(text("format").into()));
    }
    let mode = serde_json::Value::from(text("mode"));
    Ok(Origin {
        seed: text("seed")
            .parse()
            .map_err(|_| ReadError::Foreign("a valid seed"))?,
        mode: serde_json::from_value::<Mode>(mode)
            .map_err(|_| ReadError::Foreign("a valid mode"))?,
        writer: text("writer").into(),
    })
}

/// Whether the file was cut off rather than changed: what was cut off does not end as logs do.
fn is_cut(error: &mcap::McapError, file: &[u8]) -> bool {
    let early = matches!(
        error,
        mcap::McapError::UnexpectedEof
            | mcap::McapError::UnexpectedEoc
            | mcap::McapError::BadMagic
            | mcap::McapError::RecordTooLarge { .. }
    );
    early && !file.ends_with(MAGIC)
}
