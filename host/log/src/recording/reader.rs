//! Reading recordings, whole or cut off, of one file or several.

use std::collections::BTreeMap;
use std::sync::Arc;

use mcap::MAGIC;
use mcap::records::MessageHeader;
use rover_shared::checksum::fingerprint;
use rover_shared::wire::message::Report;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Asked, Gap, Heard, LastWords, Provenance, Pulled, SOURCE, Topic, Truth};
use crate::arena::Arena;
use crate::message::Chain;
use crate::reader::{for_each_message, read_records};
use crate::{FORMAT, ReadError};

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
    /// The number of the first message, from 1, whose checksum does not follow from those before.
    pub broken_at: Option<usize>,
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
    /// The number of its frame, if the rover said it.
    pub frame: Option<u16>,
    /// How many frames are missing before it.
    pub lost: u32,
    /// What it says.
    pub what: What,
}

/// What a message of a recording says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum What {
    /// What the rover said.
    Report(Box<Report>),
    /// What the rover knew at this moment.
    Knowledge(Pulled),
    /// Something is missing.
    Gap(Gap),
    /// What the host asked for.
    Command(Box<Asked>),
    /// Where an emulated rover was.
    Truth(Truth),
}

impl Recording {
    /// Whether the contents of a file are a recording, or the beginning of one.
    pub fn is_one(file: &[u8]) -> bool {
        read_records(file).is_ok_and(|(metadata, _)| {
            metadata.is_some_and(|metadata| metadata.get("source").is_some_and(|s| s == SOURCE))
        })
    }

    /// Which part of a recording the contents of a file are, from 1; `None` if they are none.
    pub fn part_of(file: &[u8]) -> Option<u32> {
        let (metadata, _) = read_records(file).ok()?;
        Some(read_provenance(&metadata?).ok()?.part)
    }

    /// Reads a recording from the contents of its files, in order.
    ///
    /// # Errors
    /// If one is no recording of this version, or a part of it was changed by anything but
    /// cutting.
    pub fn read(files: &[impl AsRef<[u8]>]) -> Result<Self, ReadError> {
        let mut recording = Self {
            writer: String::new(),
            messages: Vec::new(),
            knowledge: BTreeMap::new(),
            arena: None,
            broken_at: None,
            cut_off: false,
        };
        let mut chain: Option<Chain> = None;
        for file in files {
            let before = chain.map(|chain| chain.value());
            chain = Some(recording.read_part(file.as_ref(), before)?);
        }
        Ok(recording)
    }

    fn read_part(&mut self, file: &[u8], before: Option<u32>) -> Result<Chain, ReadError> {
        if !file.starts_with(MAGIC) {
            return Err(mcap::McapError::BadMagic.into());
        }
        let (metadata, attachments) = read_records(file)?;
        let metadata = metadata.ok_or(ReadError::Foreign("the metadata turing-rover"))?;
        let provenance = read_provenance(&metadata)?;
        let begins_here = before.is_none() && provenance.part == 1;
        if !begins_here && (before.is_none() || before != provenance.follows) {
            let reason = format!("file {} does not follow the one before", provenance.part);
            self.push(0, None, 0, What::Gap(Gap { reason }));
        }
        for (name, bytes) in attachments {
            // Under its true name, whatever it is called.
            if name.starts_with("knowledge-") {
                self.knowledge.insert(fingerprint(&bytes), bytes.into());
            }
        }
        let chain = Chain::new(&provenance).map_err(|error| ReadError::Message(0, error))?;
        self.writer = provenance.writer;
        self.read_messages(file, chain)
    }

    fn read_messages(&mut self, file: &[u8], mut chain: Chain) -> Result<Chain, ReadError> {
        self.cut_off = for_each_message(file, |topic, header, data| {
            if let Some(topic) = Topic::named(topic) {
                self.take(topic, header, data, &mut chain)?;
            }
            Ok(self.messages.len())
        })?;
        Ok(chain)
    }

    fn take(
        &mut self,
        topic: Topic,
        header: MessageHeader,
        data: &[u8],
        chain: &mut Chain,
    ) -> Result<(), ReadError> {
        let mut opening = Opening {
            recording: self,
            chain,
            header,
            data,
        };
        match topic {
            Topic::Hello => opening.report(Report::Hello),
            Topic::Action => opening.report(Report::Action),
            Topic::Event => opening.report(Report::Event),
            Topic::Fault => opening.report(Report::Fault),
            Topic::Status => opening.report(Report::Status),
            Topic::Ack => opening.report(Report::Ack),
            Topic::LastWords => opening.report(|words: LastWords| Report::LastWords(words.text)),
            Topic::Knowledge => opening.own(What::Knowledge),
            Topic::Gap => opening.own(What::Gap),
            Topic::Command => opening.own(|asked| What::Command(Box::new(asked))),
            Topic::Truth => opening.own(What::Truth),
            Topic::Arena => {
                // Each file of a recording has it.
                let arena = opening.open()?;
                self.arena.get_or_insert(arena);
                Ok(())
            }
        }
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

/// A message that is being read.
struct Opening<'a> {
    recording: &'a mut Recording,
    chain: &'a mut Chain,
    header: MessageHeader,
    data: &'a [u8],
}

impl Opening<'_> {
    fn report<T: Serialize + DeserializeOwned>(
        &mut self,
        report: impl FnOnce(T) -> Report,
    ) -> Result<(), ReadError> {
        let heard: Heard<T> = self.open()?;
        self.recording.push(
            self.header.log_time,
            Some(heard.frame),
            heard.lost_before,
            What::Report(Box::new(report(heard.message))),
        );
        Ok(())
    }

    fn own<T: Serialize + DeserializeOwned>(
        &mut self,
        what: impl FnOnce(T) -> What,
    ) -> Result<(), ReadError> {
        let message = self.open()?;
        self.recording
            .push(self.header.log_time, None, 0, what(message));
        Ok(())
    }

    fn open<T: Serialize + DeserializeOwned>(&mut self) -> Result<T, ReadError> {
        let number = self.recording.messages.len() + 1;
        let (message, intact) = self
            .chain
            .open(self.data)
            .map_err(|error| ReadError::Message(number, error))?;
        if !intact {
            self.recording.broken_at.get_or_insert(number);
        }
        Ok(message)
    }
}

fn read_provenance(metadata: &BTreeMap<String, String>) -> Result<Provenance, ReadError> {
    let text = |key| metadata.get(key).map_or("", String::as_str);
    if text("format") != FORMAT.to_string() {
        return Err(ReadError::Format(text("format").into()));
    }
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
