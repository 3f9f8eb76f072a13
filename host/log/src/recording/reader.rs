//! Reading recordings, whole or cut off, of one file or several.

use std::collections::BTreeMap;
use std::sync::Arc;

use rover_shared::checksum::fingerprint;
use rover_shared::wire::message::Report;
use serde::de::DeserializeOwned;

use super::message::{
    Asked, END, Gap, Heard, KNOWLEDGE, LastWords, Provenance, Pulled, SOURCE, Topic, Truth,
};
use crate::arena::Arena;
use crate::container::reader::{Extras, Message, Metadata, for_each_message};
use crate::error::ReadError;
use crate::format::METADATA;
use crate::message;

/// A recording.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Who wrote it: program and version.
    pub writer: String,
    /// All messages that can be read.
    pub messages: Vec<Recorded>,
    /// The knowledge in it, as bytes, by its fingerprint.
    pub knowledge: BTreeMap<u32, Arc<[u8]>>,
    /// Where an emulated rover was switched on, and what stands around it.
    pub arena: Option<Arena>,
    /// Whether the last file ends before the recording does.
    pub cut_off: bool,
}

/// A message, and how it came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recorded {
    /// The number of the message, from 1.
    pub number: usize,
    /// When it was recorded: nanoseconds since 1970, or since the start of an emulation.
    pub log_time_ns: u64,
    /// The number of its frame, if it is a report.
    pub frame: Option<u16>,
    /// How many frames are missing before it.
    pub lost: u32,
    /// What it says.
    pub what: What,
}

/// What a message of a recording says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum What {
    /// A report.
    Report(Box<Report>),
    /// What the rover knew at this moment.
    Knowledge(Pulled),
    /// Reports are missing.
    Gap(Gap),
    /// A command.
    Command(Box<Asked>),
    /// Where an emulated rover was.
    Truth(Truth),
}

impl Recording {
    /// Whether the contents of a file are a recording, or the beginning of one.
    pub fn is_one(file: &[u8]) -> bool {
        Extras::read(file).is_ok_and(|extras| {
            let header = extras.metadata(METADATA);
            header.is_some_and(|header| header.get("source").is_some_and(|s| s == SOURCE))
        })
    }

    /// Which part of a recording the contents of a file are, from 1; `None` if they are none.
    pub fn part_of(file: &[u8]) -> Option<u32> {
        let extras = Extras::read(file).ok()?;
        Some(read_provenance(extras.header().ok()?).ok()?.part)
    }

    /// Reads a recording from the contents of its files, in order.
    ///
    /// # Errors
    /// If one is no recording that can be read, or damaged.
    pub fn read(files: &[impl AsRef<[u8]>]) -> Result<Self, ReadError> {
        let mut recording = Self {
            writer: String::new(),
            messages: Vec::new(),
            knowledge: BTreeMap::new(),
            arena: None,
            cut_off: false,
        };
        let mut before = None;
        for file in files {
            before = recording.read_part(file.as_ref(), before)?;
        }
        Ok(recording)
    }

    /// Reads a file that follows the one with the checksum `before`, and returns its checksum.
    fn read_part(&mut self, file: &[u8], before: Option<u32>) -> Result<Option<u32>, ReadError> {
        let extras = Extras::read(file)?;
        let provenance = read_provenance(extras.header()?)?;
        let begins_here = self.messages.is_empty() && provenance.part == 1;
        if !begins_here && (before.is_none() || before != provenance.follows) {
            let reason = format!("file {} does not follow the one before", provenance.part);
            self.push(0, None, 0, What::Gap(Gap { reason }));
        }
        for (name, bytes) in &extras.attachments {
            // Under its true name, whatever it is called.
            if name.starts_with(KNOWLEDGE) {
                self.knowledge.insert(fingerprint(bytes), (*bytes).into());
            }
        }
        self.writer = provenance.writer;
        let mut chain = None;
        self.cut_off = for_each_message(file, |message| {
            let number = self.messages.len() + 1;
            if let Some(topic) = Topic::named(message.topic) {
                let taken = self.take(topic, message);
                chain = taken.map_err(|error| ReadError::Message(number, error))?;
            }
            Ok(())
        })?;
        let checksum = extras.metadata(END).and_then(|end| end.get("checksum"));
        let checksum = checksum.and_then(|checksum| checksum.parse().ok());
        // In format 1 it is that of the last message.
        Ok(checksum.or(chain.and_then(|chain| chain.try_into().ok())))
    }

    /// Takes a message, and returns the checksum that it has in format 1.
    fn take(&mut self, topic: Topic, message: &Message<'_>) -> serde_json::Result<Option<u64>> {
        match topic {
            Topic::Hello => self.heard(message, Report::Hello),
            Topic::Action => self.heard(message, Report::Action),
            Topic::Event => self.heard(message, Report::Event),
            Topic::Fault => self.heard(message, Report::Fault),
            Topic::Status => self.heard(message, Report::Status),
            Topic::Ack => self.heard(message, Report::Ack),
            Topic::LastWords => {
                self.heard(message, |words: LastWords| Report::LastWords(words.text))
            }
            Topic::Knowledge => self.own(message, What::Knowledge),
            Topic::Gap => self.own(message, What::Gap),
            Topic::Command => self.own(message, |asked| What::Command(Box::new(asked))),
            Topic::Truth => self.own(message, What::Truth),
            Topic::Arena => {
                // Each file of a recording has it.
                let (arena, chain) = message::read(message.data)?;
                self.arena.get_or_insert(arena);
                Ok(chain)
            }
        }
    }

    fn heard<T: DeserializeOwned>(
        &mut self,
        message: &Message<'_>,
        report: impl FnOnce(T) -> Report,
    ) -> serde_json::Result<Option<u64>> {
        let (heard, chain): (Heard<T>, _) = message::read(message.data)?;
        let what = What::Report(Box::new(report(heard.message)));
        let (frame, lost) = (Some(heard.frame), heard.lost_before);
        self.push(message.log_time_ns, frame, lost, what);
        Ok(chain)
    }

    fn own<T: DeserializeOwned>(
        &mut self,
        message: &Message<'_>,
        what: impl FnOnce(T) -> What,
    ) -> serde_json::Result<Option<u64>> {
        let (read, chain) = message::read(message.data)?;
        self.push(message.log_time_ns, None, 0, what(read));
        Ok(chain)
    }

    fn push(&mut self, log_time_ns: u64, frame: Option<u16>, lost: u32, what: What) {
        self.messages.push(Recorded {
            number: self.messages.len() + 1,
            log_time_ns,
            frame,
            lost,
            what,
        });
    }
}

fn read_provenance(header: &Metadata) -> Result<Provenance, ReadError> {
    let text = |key| header.get(key).map_or("", String::as_str);
    if text("source") != SOURCE {
        return Err(ReadError::Foreign("a rover as its source"));
    }
    let protocol = text("protocol").parse();
    let part = text("part").parse();
    let follows = Some(text("follows")).filter(|text| !text.is_empty());
    let follows = follows.map(str::parse).transpose();
    Ok(Provenance {
        writer: text("writer").into(),
        protocol: protocol.map_err(|_| ReadError::Foreign("a valid protocol version"))?,
        part: part.map_err(|_| ReadError::Foreign("a valid part number"))?,
        follows: follows.map_err(|_| ReadError::Foreign("a valid checksum of the part before"))?,
    })
}
