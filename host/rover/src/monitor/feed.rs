//! Where a dashboard gets what it shows: a rover, an emulated board, a log.

use std::time::Duration;

use rover_shared::contract::Refusal;
use rover_shared::wire::message::{Command, Report};

use rover_link::Counters;
use rover_log::Entry;

/// Something that can be watched.
pub trait Feed {
    /// The time on the feed's own clock: wall-clock time for a rover, emulated time for an emulated
    /// one, playing time for a log.
    fn now(&self) -> Duration;

    /// Waits for events, at most for `timeout`, and returns them in order. A feed with a clock of
    /// its own advances it by `timeout`. One that has to reconnect may take a quarter of a second.
    fn poll(&mut self, timeout: Duration) -> Vec<FeedEvent>;

    /// Sends a command. A later poll returns its [`FeedEvent::Answer`], or a
    /// [`FeedEvent::Unanswered`] after a bounded wait.
    fn send(&mut self, command: &Command);

    /// Changes how a log is played; a rover ignores it.
    fn control(&mut self, _control: Control) {}

    /// Whether it is a log, which takes no commands.
    fn is_log(&self) -> bool {
        false
    }

    /// Whether all of a log has been shown.
    fn ended(&self) -> bool {
        false
    }
}

/// A change of how a log is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Play if it is paused, pause if it is playing.
    PlayOrPause,
    /// Twice as fast.
    Faster,
    /// Half as fast.
    Slower,
    /// Skip n actions, backwards if negative, then pause. Entries, in a log without actions.
    Actions(i32),
    /// Go to the start.
    Start,
    /// Go to the end.
    End,
}

/// Something that happened at the rover, or on the way from there.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedEvent {
    /// The connection has changed.
    Connection(Connection),
    /// A report of the rover's.
    Report(Box<Report>),
    /// A command was answered.
    Answer {
        /// What was asked for.
        command: Command,
        /// Done, or why not.
        result: Result<(), Refusal>,
    },
    /// A command was not answered, or could not be sent.
    Unanswered {
        /// What was asked for.
        command: Command,
        /// A sentence that says why.
        reason: String,
    },
    /// Counters of frames on the way and of reports on this side.
    Frames(Counters),
    /// A log starts from its beginning: all that was shown before is void. Holds what a simulation
    /// starts from; a rover reports that itself.
    Begin(Option<Origin>),
    /// The rover's knowledge at this moment, as bytes, from a log.
    Knowledge(Vec<u8>),
    /// A gap in a log, and its reason.
    Gap(String),
    /// The next entry of a simulation's log.
    Logged(Entry),
    /// How a log is being played.
    Playback(Playback),
}

/// The connection to the rover.
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

/// How a log is being played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// Whether it is playing, not paused.
    pub playing: bool,
    /// Times as fast as it was recorded.
    pub speed: f64,
    /// Entries shown so far.
    pub at: usize,
    /// Entries that there are.
    pub of: usize,
    /// Whether the log ends earlier than it should.
    pub cut_off: bool,
}

impl FeedEvent {
    /// A report.
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
