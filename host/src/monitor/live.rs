//! A rover at the end of a port as a source.

use std::time::Duration;

use rover_shared::time::Duration as Span;
use rover_shared::wire::message::{Command, Report};

use super::happening::{Connection, Happening};
use super::source::Source;
use crate::link::{Client, Counters, LinkError};

/// A rover that is watched.
pub struct Live {
    client: Client,
    /// What is to be given by the next poll.
    happened: Vec<Happening>,
    connected: bool,
    /// Why the connection was last lost.
    lost: Option<String>,
    counters: Counters,
}

impl Live {
    /// A rover that was introduced.
    pub fn new(client: Client) -> Self {
        let mut live = Self {
            counters: client.counters(),
            client,
            happened: Vec::new(),
            connected: false,
            lost: None,
        };
        live.connect();
        live
    }

    fn connect(&mut self) {
        self.connected = true;
        let port = self.client.port_name().to_owned();
        let hello = Report::Hello(self.client.hello().clone());
        self.happened.extend([
            Happening::Connection(Connection::Open(port)),
            Happening::report(hello),
        ]);
    }

    fn lose(&mut self, error: &LinkError) {
        let reason = error.to_string();
        // Said once for each reason, however often it is tried.
        if self.connected || self.lost.as_ref() != Some(&reason) {
            let lost = Connection::Lost(reason.clone());
            self.happened.push(Happening::Connection(lost));
        }
        self.lost = Some(reason);
        self.connected = false;
    }

    /// Hears what comes within `span`.
    fn hear(&mut self, span: Span) {
        let until = self.client.now().after(span);
        loop {
            let left = until.since(self.client.now());
            match self.client.next(left) {
                Ok(Some(received)) => self.happened.push(Happening::report(received.report)),
                Ok(None) => return,
                Err(error) => return self.lose(&error),
            }
            if left == Span::ZERO {
                return;
            }
        }
    }

    /// Tries to connect again for `span`.
    fn retry(&mut self, span: Span) {
        match self.client.reconnect(span, &|| false) {
            Ok(()) => self.connect(),
            // What is there now is not what was.
            Err(error @ LinkError::Mismatch { .. }) => self.lose(&error),
            Err(_) => {}
        }
    }

    fn ask(&mut self, command: &Command) -> Result<(), LinkError> {
        let report = match command {
            Command::ReadStatus => Report::Status(self.client.status()?),
            Command::PullKnowledge { .. } => {
                let chunk = |report| match report {
                    Report::Knowledge(chunk) => Some(chunk),
                    _ => None,
                };
                Report::Knowledge(self.client.ask_for(command, chunk)?)
            }
            _ => return self.client.ask(command),
        };
        self.happened.push(Happening::report(report));
        Ok(())
    }
}

impl Source for Live {
    fn now(&self) -> Duration {
        Duration::from_micros(self.client.now().0)
    }

    fn poll(&mut self, timeout: Duration) -> Vec<Happening> {
        let span = Span(u64::try_from(timeout.as_micros()).unwrap_or(u64::MAX));
        if self.connected {
            self.hear(span);
        } else {
            self.retry(span);
        }
        let counters = self.client.counters();
        if counters != self.counters {
            self.counters = counters;
            self.happened.push(Happening::Frames(counters));
        }
        std::mem::take(&mut self.happened)
    }

    fn send(&mut self, command: &Command) {
        let command = command.clone();
        if !self.connected {
            let reason = "the rover is not connected".into();
            self.happened
                .push(Happening::Unanswered { command, reason });
            return;
        }
        let answer = match self.ask(&command) {
            Ok(()) => Happening::Answer {
                command,
                result: Ok(()),
            },
            Err(LinkError::Refused { refusal, .. }) => Happening::Answer {
                command,
                result: Err(refusal),
            },
            Err(error) => {
                if matches!(error, LinkError::Port(_) | LinkError::Mismatch { .. }) {
                    self.lose(&error);
                }
                let reason = error.to_string();
                Happening::Unanswered { command, reason }
            }
        };
        self.happened.push(answer);
    }
}
