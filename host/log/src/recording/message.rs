//! The channels of a recording and their messages.

use rover_shared::contract::{FaultReport, TEXT_BYTES};
use rover_shared::time::Instant;
use rover_shared::wire::message::{Ack, ActionRecord, Command, Event, Hello, Status};
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

use crate::arena::Arena;
use crate::message::LoggedPose;
use crate::schema;

/// The value of `source` in the metadata, which simulations' logs do not have.
pub(crate) const SOURCE: &str = "rover";
/// Name of the metadata at the end.
pub(super) const END: &str = "turing-rover-end";
/// Beginning of the names of attachments that hold knowledge.
pub(super) const KNOWLEDGE: &str = "knowledge-";

/// Where a recording comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// Who wrote it: program and version.
    pub writer: String,
    /// The version of the wire's protocol.
    pub protocol: u8,
    /// The number of this file, from 1.
    pub part: u32,
    /// The checksum of the file before, which its last metadata has too; `None` for the first.
    pub follows: Option<u32>,
}

/// A report, and how it came.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Heard<T> {
    /// The number of its frame, counted from 0 after each hello; it wraps.
    pub frame: u16,
    /// Frames missing between the one recorded before and this one.
    pub lost_before: u32,
    /// The report.
    #[serde(flatten)]
    pub message: T,
}

/// What was kept over a reset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LastWords {
    /// What the run before the last reset ended with.
    #[schemars(with = "String")]
    pub text: heapless::String<TEXT_BYTES>,
}

/// What the rover knew at this moment; the knowledge itself is an attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pulled {
    /// Its fingerprint.
    pub fingerprint: u32,
    /// Its length in bytes.
    pub length_bytes: u32,
}

/// A command of the host.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// The number of its frame, which its acknowledgement names.
    pub sequence: u16,
    /// The command.
    pub command: Command,
}

/// Where an emulated rover was. The rover does not know it; nothing that it does depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// When, by the rover's clock: the time of the action that it began there.
    pub time: Instant,
    /// Its centre and heading.
    pub pose: LoggedPose,
}

/// Reports are missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gap {
    /// Why.
    pub reason: String,
}

/// The channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the table above says what they hold")]
pub enum Topic {
    Hello,
    Action,
    Event,
    Fault,
    Status,
    Ack,
    LastWords,
    Knowledge,
    Gap,
    Command,
    Arena,
    Truth,
}

impl Topic {
    /// All of them, in the order of their channels.
    pub const ALL: [Self; 12] = [
        Self::Hello,
        Self::Action,
        Self::Event,
        Self::Fault,
        Self::Status,
        Self::Ack,
        Self::LastWords,
        Self::Knowledge,
        Self::Gap,
        Self::Command,
        Self::Arena,
        Self::Truth,
    ];

    /// The channel's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hello => "/hello",
            Self::Action => "/action",
            Self::Event => "/event",
            Self::Fault => "/fault",
            Self::Status => "/status",
            Self::Ack => "/ack",
            Self::LastWords => "/last_words",
            Self::Knowledge => "/knowledge",
            Self::Gap => "/gap",
            Self::Command => "/command",
            Self::Arena => "/arena",
            Self::Truth => "/truth",
        }
    }

    /// The channel with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// The JSON Schema of its messages.
    pub fn schema(self) -> Schema {
        let title = &format!("{self:?}");
        match self {
            Self::Hello => heard::<Hello>(title),
            Self::Action => heard::<ActionRecord>(title),
            Self::Event => heard::<Event>(title),
            Self::Fault => heard::<FaultReport>(title),
            Self::Status => heard::<Status>(title),
            Self::Ack => heard::<Ack>(title),
            Self::LastWords => heard::<LastWords>(title),
            Self::Knowledge => schema::of::<Pulled>(title),
            Self::Gap => schema::of::<Gap>(title),
            Self::Command => schema::of::<Asked>(title),
            Self::Arena => schema::of::<Arena>(title),
            Self::Truth => schema::of::<Truth>(title),
        }
    }
}

/// The schema of a report with its frame, described as the report is.
fn heard<T: JsonSchema>(title: &str) -> Schema {
    let mut schema = schema::of::<Heard<T>>(title);
    if let Some(description) = schema::of::<T>(title).remove("description") {
        schema.insert("description".into(), description);
    }
    schema
}
