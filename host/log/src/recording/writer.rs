//! Writing recordings.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, WriteOptions, Writer};
use rover_shared::checksum::fingerprint;
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::PROTOCOL_VERSION;
use rover_shared::wire::message::Report;
use serde::Serialize;

use super::{
    Asked, END, Gap, Heard, LastWords, Provenance, Pulled, SOURCE, Topic, Truth, attachment_name,
    schema,
};
use crate::arena::Arena;
use crate::files::WriteError;
use crate::message::Chain;
use crate::{FORMAT, METADATA};
use rover_link::{Counters, Received, Sent};
use rover_simulator::arena::Pose;

/// Longest chunk; a killed recorder loses what was not written out yet.
const CHUNK: u64 = 64 * 1024;
/// A chunk that is not full is written out after this time.
const FLUSH: Duration = Duration::from_millis(2_000);

/// Writes a recording, one file after the other.
pub struct RecordingWriter {
    path: PathBuf,
    rotate: Option<u64>,
    /// Time of the port's clock at 0, in nanoseconds since 1970.
    epoch_ns: u64,
    part: Part,
    number: u32,
    files: Vec<PathBuf>,
    /// The knowledge pulled last: each file has what its sessions start from.
    latest: Option<Vec<u8>>,
    /// Where an emulated rover drives.
    arena: Option<Arena>,
    /// Messages in the files before.
    messages: u64,
    lost: u64,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Written {
    /// The files, in order.
    pub files: Vec<PathBuf>,
    /// Messages in all of them.
    pub messages: u64,
    /// Frames that were lost on the way.
    pub lost_frames: u64,
}

/// One file.
struct Part {
    mcap: Writer<BufWriter<File>>,
    channels: BTreeMap<Topic, u16>,
    chain: Chain,
    provenance: Provenance,
    /// Fingerprints of the knowledge in it.
    attached: BTreeSet<u32>,
    messages: u32,
    flushed: Instant,
}

impl RecordingWriter {
    /// Begins a recording at `path`, where nothing may be yet. With `rotate`, a file that has
    /// reached this many bytes is finished and another begun, with `-2` and so on in its name.
    ///
    /// `epoch`: when the port's clock was 0; `None` if it is not the wall clock.
    ///
    /// # Errors
    /// The file exists, or cannot be written.
    pub fn create(
        path: &Path,
        rotate: Option<u64>,
        writer: &str,
        epoch: Option<std::time::SystemTime>,
    ) -> Result<Self, WriteError> {
        let epoch_ns = epoch
            .and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok())
            .map_or(0, |since| {
                u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
            });
        let provenance = Provenance {
            writer: writer.into(),
            protocol: PROTOCOL_VERSION,
            part: 1,
            follows: None,
        };
        // Not found out when the first file is full, hours later.
        let second = numbered(path, 2);
        if rotate.is_some() && second.exists() {
            let exists = std::io::ErrorKind::AlreadyExists.into();
            return Err(WriteError::new(&second, exists));
        }
        let part = Part::create(path, &provenance).map_err(|e| WriteError::new(path, e))?;
        Ok(Self {
            path: path.to_owned(),
            rotate,
            epoch_ns,
            part,
            number: 1,
            files: vec![path.to_owned()],
            latest: None,
            arena: None,
            messages: 0,
            lost: 0,
        })
    }

    /// Whether this knowledge is in the file that is being written.
    pub fn has_knowledge(&self, fingerprint: u32) -> bool {
        self.part.attached.contains(&fingerprint)
    }

    /// Frames lost so far.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Writes what the rover said.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn hear(&mut self, received: &Received) -> Result<(), WriteError> {
        self.lost = self.lost.saturating_add(received.lost.into());
        let (at, how) = (received.at, (received.sequence, received.lost));
        match &received.report {
            Report::Hello(hello) => self.heard(Topic::Hello, at, at, how, hello),
            Report::Action(action) => self.heard(Topic::Action, at, action.time, how, action),
            Report::Event(event) => self.heard(Topic::Event, at, event.time, how, event),
            Report::Fault(fault) => self.heard(Topic::Fault, at, fault.time, how, fault),
            Report::Status(status) => self.heard(Topic::Status, at, status.time, how, status),
            Report::Ack(ack) => self.heard(Topic::Ack, at, at, how, ack),
            Report::LastWords(text) => {
                let text = text.clone();
                self.heard(Topic::LastWords, at, at, how, &LastWords { text })
            }
            // Whole knowledge is attached, see `knowledge`.
            Report::Knowledge(_) => Ok(()),
        }
    }

    fn heard<T: Serialize + Clone>(
        &mut self,
        topic: Topic,
        at: Instant,
        published: Instant,
        (frame, lost_before): (u16, u32),
        message: &T,
    ) -> Result<(), WriteError> {
        let message = message.clone();
        let heard = Heard {
            frame,
            lost_before,
            message,
        };
        self.write(topic, at, published, &heard)
    }

    /// Writes that the rover knows this now.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn knowledge(&mut self, at: Instant, bytes: &[u8]) -> Result<(), WriteError> {
        let pulled = Pulled {
            fingerprint: fingerprint(bytes),
            length_bytes: bytes.len() as u32,
        };
        self.attach(at, bytes)?;
        self.latest = Some(bytes.to_vec());
        self.write(Topic::Knowledge, at, at, &pulled)
    }

    /// Writes that what the rover said for a while is missing.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn gap(&mut self, at: Instant, reason: &str) -> Result<(), WriteError> {
        let reason = reason.into();
        self.write(Topic::Gap, at, at, &Gap { reason })
    }

    /// Writes what the host asked for.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn command(&mut self, sent: &Sent) -> Result<(), WriteError> {
        let asked = Asked {
            sequence: sent.sequence,
            command: sent.command.clone(),
        };
        self.write(Topic::Command, sent.at, sent.at, &asked)
    }

    /// Writes where an emulated rover drives, into each file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn arena(&mut self, at: Instant, arena: Arena) -> Result<(), WriteError> {
        self.write(Topic::Arena, at, at, &arena)?;
        self.arena = Some(arena);
        Ok(())
    }

    /// Writes where an emulated rover was at a moment of its own clock; to be called before what it
    /// said of the action that began then.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn truth(&mut self, at: Instant, time: Instant, pose: Pose) -> Result<(), WriteError> {
        let pose = pose.into();
        self.write(Topic::Truth, at, time, &Truth { time, pose })
    }

    /// Writes out what is due; to be called every now and then.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn tick(&mut self, now: Instant) -> Result<(), WriteError> {
        if now.since(self.part.flushed) < FLUSH {
            return Ok(());
        }
        self.part.flushed = now;
        self.flush()?;
        let Some(limit) = self.rotate else {
            return Ok(());
        };
        let length = self
            .files
            .last()
            .and_then(|file| std::fs::metadata(file).ok())
            .map_or(0, |file| file.len());
        if length >= limit {
            self.next_part(now)?;
        }
        Ok(())
    }

    /// Writes out what there is.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        let flushed = self.part.mcap.flush().map_err(io_error);
        flushed.map_err(|error| self.error(error))
    }

    /// Finishes the recording.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self, counters: Counters) -> Result<Written, WriteError> {
        let finished = self.part.finish(counters, self.lost);
        finished.map_err(|error| self.error(error))?;
        Ok(Written {
            files: self.files,
            messages: self.messages + u64::from(self.part.messages),
            lost_frames: self.lost,
        })
    }

    fn next_part(&mut self, now: Instant) -> Result<(), WriteError> {
        let finished = self.part.finish(Counters::default(), self.lost);
        finished.map_err(|error| self.error(error))?;
        self.number += 1;
        let path = numbered(&self.path, self.number);
        let provenance = Provenance {
            part: self.number,
            follows: Some(self.part.chain.value()),
            ..self.part.provenance.clone()
        };
        let part = Part::create(&path, &provenance).map_err(|e| WriteError::new(&path, e))?;
        self.messages += u64::from(self.part.messages);
        self.part = part;
        self.part.flushed = now;
        self.files.push(path);
        if let Some(latest) = self.latest.take() {
            self.attach(now, &latest)?;
            self.latest = Some(latest);
        }
        if let Some(arena) = self.arena.take() {
            self.arena(now, arena)?;
        }
        Ok(())
    }

    fn attach(&mut self, at: Instant, bytes: &[u8]) -> Result<(), WriteError> {
        let print = fingerprint(bytes);
        if !self.part.attached.insert(print) {
            return Ok(());
        }
        let attachment = Attachment {
            log_time: self.nanoseconds(at),
            create_time: self.nanoseconds(at),
            name: attachment_name(print),
            media_type: "application/octet-stream".into(),
            data: bytes.into(),
        };
        let attached = self.part.mcap.attach(&attachment).map_err(io_error);
        attached.map_err(|error| self.error(error))
    }

    fn write(
        &mut self,
        topic: Topic,
        at: Instant,
        published: Instant,
        message: &impl Serialize,
    ) -> Result<(), WriteError> {
        let times = (self.nanoseconds(at), published.0.saturating_mul(1_000));
        let written = self.part.write(topic, times, message);
        written.map_err(|error| self.error(error))
    }

    fn nanoseconds(&self, at: Instant) -> u64 {
        self.epoch_ns.saturating_add(at.0.saturating_mul(1_000))
    }

    fn error(&self, error: std::io::Error) -> WriteError {
        WriteError::new(self.files.last().unwrap_or(&self.path), error)
    }
}

impl Part {
    fn create(path: &Path, provenance: &Provenance) -> std::io::Result<Self> {
        // Never over another: a recording cannot be made again.
        let file = File::options().write(true).create_new(true).open(path)?;
        let options = WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK))
            // Chunks are put together in memory and written whole.
            .disable_seeking(true)
            .library("turing-rover");
        let mut mcap = options.create(BufWriter::new(file)).map_err(io_error)?;
        let follows = provenance.follows.map(|chain| chain.to_string());
        mcap.write_metadata(&Metadata {
            name: METADATA.into(),
            metadata: BTreeMap::from([
                ("format".into(), FORMAT.to_string()),
                ("source".into(), SOURCE.into()),
                ("writer".into(), provenance.writer.clone()),
                ("protocol".into(), provenance.protocol.to_string()),
                ("part".into(), provenance.part.to_string()),
                ("follows".into(), follows.unwrap_or_default()),
            ]),
        })
        .map_err(io_error)?;
        let mut channels = BTreeMap::new();
        for topic in Topic::ALL {
            let text = serde_json::to_string(&schema::of(topic))?;
            let name = format!("{topic:?}");
            let schema = mcap.add_schema(&name, "jsonschema", text.as_bytes());
            let schema = schema.map_err(io_error)?;
            let channel = mcap.add_channel(schema, topic.name(), "json", &BTreeMap::new());
            channels.insert(topic, channel.map_err(io_error)?);
        }
        mcap.flush().map_err(io_error)?;
        Ok(Self {
            mcap,
            channels,
            chain: Chain::new(provenance)?,
            provenance: provenance.clone(),
            attached: BTreeSet::new(),
            messages: 0,
            flushed: Instant(0),
        })
    }

    fn write(
        &mut self,
        topic: Topic,
        (log_time, publish_time): (u64, u64),
        message: &impl Serialize,
    ) -> std::io::Result<()> {
        let data = self.chain.seal(message)?;
        let channel_id = self.channels.get(&topic).copied().unwrap_or_default();
        let header = MessageHeader {
            channel_id,
            sequence: self.messages,
            log_time,
            publish_time,
        };
        self.messages = self.messages.wrapping_add(1);
        self.mcap
            .write_to_known_channel(&header, &data)
            .map_err(io_error)
    }

    fn finish(&mut self, counters: Counters, lost: u64) -> std::io::Result<()> {
        let number = |name: &str, value: u64| (name.to_owned(), value.to_string());
        self.mcap
            .write_metadata(&Metadata {
                name: END.into(),
                metadata: BTreeMap::from([
                    number("messages", self.messages.into()),
                    number("lost_frames", lost),
                    number("damaged_frames", counters.damaged),
                    number("unread_reports", counters.unread),
                    number("reconnections", counters.reconnected),
                ]),
            })
            .map_err(io_error)?;
        self.mcap.finish().map_err(io_error)?;
        Ok(())
    }
}

/// `drive.mcap` as `drive-2.mcap`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

fn io_error(error: mcap::McapError) -> std::io::Error {
    match error {
        mcap::McapError::Io(error) => error,
        other => std::io::Error::other(other),
    }
}
