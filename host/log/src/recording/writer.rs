//! Writing recordings.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};

use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use mcap::WriteOptions;
use rover_shared::checksum::fingerprint;
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::PROTOCOL_VERSION;
use rover_shared::wire::message::Report;
use serde::Serialize;

use super::message::{
    Asked, END, Gap, Heard, KNOWLEDGE, LastWords, Provenance, Pulled, SOURCE, Topic, Truth,
};
use crate::arena::Arena;
use crate::container::writer::{Container, Times};
use crate::files::WriteError;
use rover_link::{Counters, Received, Sent};
use rover_simulator::arena::Pose;

/// Longest chunk; a killed recorder loses what was not written out yet.
const CHUNK: u64 = 64 * 1024;
/// A chunk that is not full is written out after this time.
const FLUSH: Duration = Duration::from_millis(2_000);

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

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
    container: Container<File>,
    channels: BTreeMap<Topic, u16>,
    /// Of all messages: it names the file.
    checksum: Digest<'static, u32>,
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
        // Found out now rather than hours later, when the first file is full.
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

    /// Writes a report.
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

    /// Writes that reports are missing.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn gap(&mut self, at: Instant, reason: &str) -> Result<(), WriteError> {
        let reason = reason.into();
        self.write(Topic::Gap, at, at, &Gap { reason })
    }

    /// Writes a command.
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

    /// Writes where an emulated rover was at a moment of its own clock, before the report of the action
    /// that began then.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn truth(&mut self, at: Instant, time: Instant, pose: Pose) -> Result<(), WriteError> {
        let pose = pose.into();
        self.write(Topic::Truth, at, time, &Truth { time, pose })
    }

    /// Writes out what is due, and begins another file if this one is full; call it often.
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
        let flushed = self.part.container.flush();
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
            follows: Some(self.part.checksum.clone().finalize()),
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
        let (log, publish) = (self.nanoseconds(at), self.nanoseconds(at));
        let name = format!("{KNOWLEDGE}{print:08x}.rover");
        let attached = self
            .part
            .container
            .attach(&name, bytes, Times { log, publish });
        attached.map_err(|error| self.error(error))
    }

    fn write(
        &mut self,
        topic: Topic,
        at: Instant,
        published: Instant,
        message: &impl Serialize,
    ) -> Result<(), WriteError> {
        let times = Times {
            log: self.nanoseconds(at),
            publish: published.0.saturating_mul(1_000),
        };
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
            .chunk_size(Some(CHUNK))
            // Chunks are put together in memory and written whole.
            .disable_seeking(true);
        let follows = provenance.follows.map(|checksum| checksum.to_string());
        let metadata = [
            ("source", SOURCE.into()),
            ("writer", provenance.writer.clone()),
            ("protocol", provenance.protocol.to_string()),
            ("part", provenance.part.to_string()),
            ("follows", follows.unwrap_or_default()),
        ];
        let mut container = Container::begin(file, options, metadata)?;
        let mut channels = BTreeMap::new();
        for topic in Topic::ALL {
            let name = format!("{topic:?}");
            let channel = container.channel(topic.name(), &name, &topic.schema())?;
            channels.insert(topic, channel);
        }
        container.flush()?;
        Ok(Self {
            container,
            channels,
            checksum: CRC.digest(),
            provenance: provenance.clone(),
            attached: BTreeSet::new(),
            messages: 0,
            flushed: Instant(0),
        })
    }

    fn write(
        &mut self,
        topic: Topic,
        times: Times,
        message: &impl Serialize,
    ) -> std::io::Result<()> {
        let channel = self.channels.get(&topic).copied().unwrap_or_default();
        let data = self
            .container
            .message(channel, self.messages, times, message)?;
        self.checksum.update(&data);
        self.messages = self.messages.wrapping_add(1);
        Ok(())
    }

    fn finish(&mut self, counters: Counters, lost: u64) -> std::io::Result<()> {
        let numbers = [
            ("messages", self.messages.into()),
            ("checksum", self.checksum.clone().finalize().into()),
            ("lost_frames", lost),
            ("damaged_frames", counters.damaged),
            ("unread_reports", counters.unread),
            ("reconnections", counters.reconnected),
        ];
        let metadata = numbers.map(|(name, value): (_, u64)| (name, value.to_string()));
        self.container.metadata(END, metadata)?;
        self.container.finish()
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
