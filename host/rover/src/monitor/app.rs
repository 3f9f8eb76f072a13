//! The dashboard at work: periodic requests, keys, and the end.

use std::time::Duration;

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use rover_shared::wire::message::{Command, Report};

use super::feed::Feed;
use super::feed::{Connection, FeedEvent};
use super::keys::{Meaning, Prompt, Typed, meaning};
use super::knowledge_reader::KnowledgeReader;
use super::model::{Dashboard, Knowledge, Why};
use crate::lines::Kind;

/// Period of requests for the rover's status.
const STATUS: Duration = Duration::from_millis(500);
/// Time between two attempts to read its knowledge.
const AGAIN: Duration = Duration::from_secs(5);

/// A dashboard, its input and its requests.
#[derive(Default)]
pub struct App {
    /// What is shown.
    pub dashboard: Dashboard,
    /// A direction being typed.
    pub prompt: Option<Prompt>,
    /// Whether all keys are shown.
    pub help: bool,
    reader: KnowledgeReader,
    /// When its last reading began.
    pulled: Option<Duration>,
    /// When the status was last requested.
    asked: Option<Duration>,
    over: bool,
    disarms: bool,
}

impl App {
    /// Whether the user has quit.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Whether quitting has sent a disarming.
    pub fn disarms(&self) -> bool {
        self.disarms
    }

    /// Takes an event that came at `now` of the feed's clock.
    pub fn take(&mut self, now: Duration, event: &FeedEvent) {
        match event {
            FeedEvent::Report(report) => {
                if let Report::Knowledge(chunk) = &**report {
                    self.chunk(chunk);
                }
                if matches!(**report, Report::Hello(_)) {
                    self.forget_requests();
                }
            }
            FeedEvent::Answer {
                command: Command::PullKnowledge { .. },
                result: Err(_),
            } => self.reader.abandon(),
            FeedEvent::Connection(_) => self.forget_requests(),
            _ => {}
        }
        self.dashboard.take(now, event);
    }

    /// Sends the requests that are due.
    pub fn ask(&mut self, feed: &mut dyn Feed) {
        let now = feed.now();
        self.dashboard.now = now;
        if feed.is_log()
            || self.dashboard.rover.is_none()
            || !matches!(self.dashboard.connection, Connection::Open(_))
        {
            return;
        }
        let due =
            |then: Option<Duration>, after| then.is_none_or(|t| now.saturating_sub(t) >= after);
        if due(self.asked, STATUS) {
            self.asked = Some(now);
            feed.send(&Command::ReadStatus);
        }
        if self.wants_knowledge() && !self.reader.is_under_way() && due(self.pulled, AGAIN) {
            self.pulled = Some(now);
            self.reader.start();
        }
        if let Some(command) = self.reader.next(now) {
            feed.send(&command);
        }
    }

    /// Takes a key.
    pub fn key(&mut self, key: KeyEvent, feed: &mut dyn Feed) {
        let ctrl = key.modifiers.contains(KeyModifiers::CONTROL);
        // Stopping has priority over a half-typed number.
        let stops = key.code == KeyCode::Char(' ') || ctrl;
        if let Some(prompt) = &mut self.prompt
            && !stops
        {
            match prompt.take(key) {
                Typed::More => {}
                Typed::Away => self.prompt = None,
                Typed::Direction(direction) => {
                    self.prompt = None;
                    feed.send(&Command::SetDirection(direction));
                }
            }
            return;
        }
        if let Some(meaning) = meaning(key, feed.is_log()) {
            self.prompt = None;
            self.act(meaning, feed);
        }
    }

    /// Carries out a key or a typed line.
    pub fn act(&mut self, meaning: Meaning, feed: &mut dyn Feed) {
        match meaning {
            Meaning::Command(command) => feed.send(&command),
            Meaning::Control(control) => feed.control(control),
            Meaning::Turn(by) => match self.dashboard.direction {
                Some(direction) => {
                    let turned = direction.turned(by);
                    // Two presses in a row turn twice, whether or not the first was answered.
                    self.dashboard.direction = Some(turned);
                    feed.send(&Command::SetDirection(turned));
                }
                None => {
                    let text = "the direction is not known yet; type one with g";
                    self.dashboard.note(Kind::Trouble, text);
                }
            },
            Meaning::Type => self.prompt = Some(Prompt::default()),
            Meaning::Help => self.help = !self.help,
            Meaning::Quit => {
                if !feed.is_log() {
                    feed.send(&Command::Disarm);
                    self.disarms = true;
                }
                self.over = true;
            }
            Meaning::Leave => self.over = true,
        }
    }

    /// Whether the rover's knowledge can be read now, and should be.
    fn wants_knowledge(&self) -> bool {
        let dashboard = &self.dashboard;
        let has_some = dashboard
            .rover
            .as_ref()
            .is_some_and(|rover| rover.knowledge.is_some());
        let known = match &dashboard.knowledge {
            Knowledge::Known(mirror) => mirror.is_exact(),
            Knowledge::Unknown(why) => matches!(why, Why::Unreadable(_)),
        };
        has_some && !known && dashboard.state.is_some() && !dashboard.controller_drives()
    }

    fn chunk(&mut self, chunk: &rover_shared::wire::message::Chunk) {
        let Some(bytes) = self.reader.take(chunk) else {
            return;
        };
        let followed = self.dashboard.mirror().cloned();
        self.dashboard.learn_all(&bytes);
        // Nothing ends a session but the rover itself; what was followed must be what is there.
        if let (Some(followed), Some(read)) = (followed, self.dashboard.mirror())
            && !followed.agrees_with(read)
        {
            let text = "what was followed differed from the rover's knowledge; it was read anew";
            self.dashboard.note(Kind::Trouble, text);
        }
    }

    fn forget_requests(&mut self) {
        self.reader.abandon();
        (self.pulled, self.asked) = (None, None);
    }
}
