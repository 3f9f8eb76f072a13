//! The state of the dashboard: a pure model of all events, with bounded memory.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use rover_shared::contract::{
    ChannelHealth, CompassHealth, Counters, Mode, Outcome, Refusal, State, Task,
};
use rover_shared::controller::StepRecord;
use rover_shared::sensing::Sample;
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::{Command, Hello};

use super::feed::{Connection, Playback};
use crate::lines::{Kind, Line};
use rover_log::knowledge::followed::Followed;

/// Actions that the history holds; no terminal has more columns.
pub const HISTORY: usize = 512;
/// Silence that is shown: the status is requested twice a second, and answered at once.
const SILENCE: Duration = Duration::from_secs(1);
/// Notes that are kept.
pub const NOTES: usize = 200;

/// All that is shown.
#[derive(Clone, Debug, Default)]
pub struct Dashboard {
    /// The way to the rover.
    pub connection: Connection,
    /// Who the rover is.
    pub rover: Option<Hello>,
    /// What the supervisor allows.
    pub state: Option<State>,
    /// Whether wheel commands reach the motors.
    pub motors_enabled: Option<bool>,
    /// What is being done.
    pub task: Option<Task>,
    /// The direction to follow.
    pub direction: Option<Microdegrees>,
    /// The session that runs, or ran last.
    pub session: Option<Session>,
    /// What the sensors say.
    pub readings: Option<Readings>,
    /// Health of the range sensors.
    pub ranges: Option<[ChannelHealth; 4]>,
    /// Health of the compass.
    pub compass: Option<CompassHealth>,
    /// The latest action.
    pub action: Option<Action>,
    /// Actions, the latest last; `None` stands for some that were missed.
    pub history: VecDeque<Option<Moment>>,
    /// How often each fault was counted on the board.
    pub counters: Counters,
    /// Frames lost and dropped on this side.
    pub frames: rover_link::Counters,
    /// Actions that never came, by the gaps of the step numbers.
    pub missed: u32,
    /// What the rover knows.
    pub knowledge: Knowledge,
    /// What was refused last, until it succeeds.
    pub refused: Option<(Command, Refusal)>,
    /// What happened, the latest last.
    pub notes: VecDeque<Note>,
    /// Notes since the start, those no longer kept included.
    pub noted: u64,
    /// How a log is being played.
    pub playback: Option<Playback>,
    /// The trial of a simulation's log.
    pub trial: Option<u32>,
    /// The rover's clock in its last report with a time, microseconds.
    pub time: Option<u64>,
    /// When that was, on the feed's clock.
    pub timed: Duration,
    /// When the last report came, on the feed's clock.
    pub heard: Option<Duration>,
    /// The feed's clock.
    pub now: Duration,
}

/// A session: from the moment the controller begins to drive until it stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Session {
    /// Learning or not; `None` where a log does not say.
    pub mode: Option<Mode>,
    /// What its generator starts from.
    pub seed: u64,
    /// Fingerprint of the knowledge it starts from.
    pub knowledge: u32,
}

/// What the sensors say at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Readings {
    /// The board's clock, microseconds, where there is a board.
    pub time: Option<u64>,
    /// Free way ahead: the shorter one of both front sensors.
    pub front: Micrometres,
    /// What each channel's curve makes of its counts, where it is known: front left, front right,
    /// left, right.
    pub distances: [Option<Micrometres>; 4],
    /// Median ADC counts of these channels, where there is an ADC.
    pub counts: Option<[u16; 4]>,
    /// Where the rover points; `None` if the compass cannot be believed.
    pub heading: Option<Microdegrees>,
}

/// An action, and what led to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Action {
    /// The sample in physical units.
    pub sample: Sample,
    /// What the controller made of it.
    pub step: StepRecord,
    /// How the move ended, where that is known.
    pub outcome: Option<Outcome>,
}

/// A moment of the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// The action's phase.
    pub phase: Microdegrees,
    /// RF in millionths; `None` where the target was not sensed.
    pub reward: Option<i32>,
}

/// A line about something that happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The rover's clock, if it was known, microseconds.
    pub time: Option<u64>,
    /// What happened.
    pub line: Line,
}

/// What the rover knows, or why that is not known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// Followed since it was read.
    Known(Box<Followed>),
    /// Not known here.
    Unknown(Why),
}

impl Default for Knowledge {
    fn default() -> Self {
        Self::Unknown(Why::NotRead)
    }
}

/// Why the rover's knowledge is not known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Why {
    /// It was not read yet.
    NotRead,
    /// Actions were missed since.
    Missed,
    /// The rover has other knowledge since.
    Replaced,
    /// The rover has none.
    None,
    /// What was read is no knowledge.
    Unreadable(String),
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotRead => f.write_str("not read from the rover yet"),
            Self::Missed => f.write_str("actions were missed since it was read"),
            Self::Replaced => f.write_str("the rover has other knowledge since"),
            Self::None => f.write_str("the rover has no valid knowledge"),
            Self::Unreadable(error) => write!(f, "unreadable: {error}"),
        }
    }
}

impl Dashboard {
    /// Whether the controller drives, so that its knowledge cannot be read.
    pub fn controller_drives(&self) -> bool {
        matches!(self.state, Some(State::Driving(Mode::Learn | Mode::Run)))
    }

    /// The knowledge, if it is known.
    pub fn mirror(&self) -> Option<&Followed> {
        match &self.knowledge {
            Knowledge::Known(mirror) => Some(mirror),
            Knowledge::Unknown(_) => None,
        }
    }

    /// Takes the knowledge as it was read, as bytes.
    pub fn learn_all(&mut self, bytes: &[u8]) {
        self.knowledge = match Followed::new(bytes) {
            Ok(mirror) => Knowledge::Known(Box::new(mirror)),
            Err(error) => Knowledge::Unknown(Why::Unreadable(error)),
        };
    }

    /// What the rover's clock shows now, microseconds: both clocks run alike.
    pub fn rover_time(&self) -> Option<u64> {
        let since = self.now.saturating_sub(self.timed).as_micros();
        let since = u64::try_from(since).unwrap_or(u64::MAX);
        self.time.map(|time| time.saturating_add(since))
    }

    /// A report with the rover's time came.
    pub(super) fn set_time(&mut self, time: u64) {
        self.time = Some(time);
        self.timed = self.now;
    }

    /// How long the rover has been silent, if that is longer than it should be.
    pub fn silence(&self) -> Option<Duration> {
        let silence = self.now.saturating_sub(self.heard?);
        (silence >= SILENCE).then_some(silence)
    }

    /// Adds a note.
    pub fn note(&mut self, kind: Kind, text: impl Into<String>) {
        let text = text.into();
        self.note_line(Line { kind, text });
    }

    /// Adds a note with this line.
    pub fn note_line(&mut self, line: Line) {
        if self.notes.len() == NOTES {
            self.notes.pop_front();
        }
        self.noted += 1;
        self.notes.push_back(Note {
            time: self.rover_time(),
            line,
        });
    }
}
