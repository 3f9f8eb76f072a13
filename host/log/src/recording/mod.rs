//! Recordings: logs of a rover, real or emulated, as it was heard over its port.
//!
//! | part | holds |
//! |---|---|
//! | metadata `turing-rover` | [`Provenance`] |
//! | channels `/hello`, `/action`, `/event`, `/fault`, `/status`, `/ack`, `/last_words` | what the rover said: the messages of [`rover_shared::wire::message`], each with the number of its frame and how many frames before it were lost |
//! | channel `/command` | what the host asked for: [`Asked`], whose acknowledgement in `/ack` names its number |
//! | channels `/truth`, `/arena` | of an emulated rover only, which does not know it itself: where it was before an action ([`Truth`]), and in what arena ([`Arena`](super::arena::Arena)) |
//! | attachments `knowledge-FINGERPRINT.rover` | knowledge that was pulled from the rover |
//! | channel `/knowledge` | when it was pulled: what the rover knew at that moment |
//! | channel `/gap` | that the connection was lost, or heard again |
//! | metadata `turing-rover-end` | how many frames came and were lost; missing if the recorder was killed |
//!
//! Log times are those of the host, publish times those of the rover (since its reset). Chunks are
//! written out whole, every two seconds, so that a recorder that is killed leaves a file that is
//! readable up to there. A recording may have several files, one following the other.
//!
//! | file | holds |
//! |---|---|
//! | `schema` | JSON Schemas of the messages |
//! | `writer` | [`RecordingWriter`] |
//! | `reader` | [`Recording`] |

mod reader;
pub mod schema;
mod writer;

pub use reader::{Recorded, Recording, What};
pub use writer::{RecordingWriter, Written};

use rover_shared::contract::TEXT_BYTES;
use rover_shared::time::Instant;
use rover_shared::wire::message::Command;
use serde::{Deserialize, Serialize};

use super::message::LoggedPose;

/// The value of `source` in the metadata, which simulations' logs do not have.
pub(super) const SOURCE: &str = "rover";
/// Name of the metadata at the end.
const END: &str = "turing-rover-end";

/// Where a recording comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Who wrote it: program and version.
    pub writer: String,
    /// The version of the wire's protocol.
    pub protocol: u8,
    /// The number of this file, from 1.
    pub part: u32,
    /// The checksum at the end of the file before; `None` for the first.
    pub follows: Option<u32>,
}

/// Something that the rover said, and how it came.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heard<T> {
    /// The number of its frame.
    pub frame: u16,
    /// How many frames are missing between the one recorded before and this one.
    pub lost_before: u32,
    /// What was said.
    #[serde(flatten)]
    pub message: T,
}

/// The text of [`Report::LastWords`](rover_shared::wire::message::Report::LastWords).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LastWords {
    /// What the run before the last reset ended with.
    pub text: heapless::String<TEXT_BYTES>,
}

/// What the rover knew at this moment; the knowledge itself is an attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pulled {
    /// Its fingerprint.
    pub fingerprint: u32,
    /// Its length.
    pub length_bytes: u32,
}

/// What the host asked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// The number of its frame.
    pub sequence: u16,
    /// What was asked for.
    pub command: Command,
}

/// Where an emulated rover was. The rover does not know it; nothing that it does depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// When, by the rover's clock: the time of the action that it began there.
    pub time: Instant,
    /// Its centre and heading.
    pub pose: LoggedPose,
}

/// What the rover said for a while is missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
}

/// The name of the attachment that holds this knowledge.
fn attachment_name(fingerprint: u32) -> String {
    format!("knowledge-{fingerprint:08x}.rover")
}
