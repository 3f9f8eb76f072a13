//! What a dashboard is told, wherever it comes from.

use rover_shared::contract::Refusal;
use rover_shared::wire::message::{Command, Report};

use rover_link::Counters;
use rover_log::Entry;

/// Something that happened at the other end, or on the way from there.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// The way to the rover has changed.
    Connection(Connection),
    /// The rover said something.
    Report(Box<Report>),
    /// A command was answered.
    Answer {
        /// What was asked for.
        command: Command,
        /// Done, or why not.
        result: Result<(), Refusal>,
    },
    /// A command was not answered, or could not be sent; a sentence that says why.
    Unanswered {
        /// What was asked for.
        command: Command,
        /// Why it was not.
        reason: String,
    },
    /// What happened to frames on the way, and reports on this side.
    Frames(Counters),
    /// A log is shown from its start: all that was shown before is void. What a simulation starts
    /// from; a rover says that itself.
    Begin(Option<Origin>),
    /// The rover's knowledge as it is now, as bytes, from a log.
    Knowledge(Vec<u8>),
    /// A log lacks what the rover said for a while, for this reason.
    Gap(String),
    /// The next entry of a simulation's log.
    Logged(Entry),
    /// How a log is being shown.
    Playback(Playback),
}

/// The way to the rover.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum Connection {
    /// Nothing is known yet.
    #[default]
    None,
    /// Looking for this port.
    Searching(String),
    /// The rover at this port answers.
    Open(String),
    /// Cut, for this reason; it is being looked for again.
    Lost(String),
    /// No rover but a log: this file.
    Log(String),
}

/// What a simulation starts from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The seed of the controller's generator.
    pub seed: u64,
    /// The knowledge as bytes.
    pub knowledge: Vec<u8>,
}

/// How a log is being shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// Whether it goes on by itself.
    pub playing: bool,
    /// How many times as fast as it was recorded.
    pub speed: f64,
    /// Entries shown so far.
    pub at: usize,
    /// Entries that there are.
    pub of: usize,
    /// Whether the log ends earlier than it should.
    pub cut_off: bool,
}

impl Happening {
    /// A report that was heard.
    pub fn report(report: Report) -> Self {
        Self::Report(Box::new(report))
    }

    /// Whether the rover, or the one of a simulation, acted.
    pub fn is_action(&self) -> bool {
        match self {
            Self::Report(report) => matches!(**report, Report::Action(_)),
            Self::Logged(entry) => matches!(entry, Entry::Step(_)),
            _ => false,
        }
    }
}
