//! A rover at the end of a port as a feed.

use std::time::Duration;

use rover_shared::time::{Duration as Span, Instant};
use rover_shared::wire::message::{Ack, Command, Report};

use super::feed::{Connection, Feed, FeedEvent};
use rover_link::{ANSWER_WITHIN, Client, Counters, LinkError, attempts, names};

/// Commands that may wait for answers: a silent rover gets no more but a disarming.
const MOST_PENDING: usize = 8;

/// A rover that is watched.
pub struct RoverFeed {
    client: Client,
    /// What the next poll returns.
    events: Vec<FeedEvent>,
    connected: bool,
    /// Why the connection was last lost.
    lost: Option<String>,
    counters: Counters,
    /// Commands that were not answered yet.
    pending: Vec<Pending>,
}

/// A command that waits for its acknowledgement, while everything else goes on.
struct Pending {
    command: Command,
    /// The number of its frame.
    sequence: u16,
    /// When it is late.
    until: Instant,
    /// How many times it may be sent again then.
    left: u32,
}

impl Pending {
    /// A later command was sent, and a repetition of this one would come after it: only a disarming
    /// may.
    fn overtake(&mut self) {
        if self.command != Command::Disarm {
            self.left = 0;
        }
    }
}

/// Whether a command only reads, so that the order does not matter.
fn only_asks(command: &Command) -> bool {
    matches!(
        command,
        Command::ReadStatus | Command::PullKnowledge { .. } | Command::Ping | Command::Heartbeat
    )
}

impl RoverFeed {
    /// A connected rover.
    pub fn new(mut client: Client) -> Self {
        client.keep_answers(true);
        let mut feed = Self {
            counters: client.counters(),
            client,
            events: Vec::new(),
            connected: false,
            lost: None,
            pending: Vec::new(),
        };
        feed.connect();
        feed
    }

    fn connect(&mut self) {
        self.connected = true;
        let port = self.client.port_name().to_owned();
        let hello = Report::Hello(self.client.hello().clone());
        self.events.extend([
            FeedEvent::Connection(Connection::Open(port)),
            FeedEvent::report(hello),
        ]);
    }

    fn lose(&mut self, error: &LinkError) {
        let reason = error.to_string();
        // Once for each reason, however many attempts fail.
        if self.connected || self.lost.as_ref() != Some(&reason) {
            let lost = Connection::Lost(reason.clone());
            self.events.push(FeedEvent::Connection(lost));
        }
        for Pending { command, .. } in self.pending.drain(..) {
            let reason = reason.clone();
            self.events.push(FeedEvent::Unanswered { command, reason });
        }
        self.lost = Some(reason);
        self.connected = false;
    }

    /// Takes the reports that come within `span`.
    fn receive(&mut self, span: Span) {
        let until = self.client.now().after(span);
        loop {
            let left = until.since(self.client.now());
            match self.client.next(left) {
                Ok(Some(received)) => match received.report {
                    Report::Ack(ack) => self.acknowledged(ack),
                    report => self.events.push(FeedEvent::report(report)),
                },
                Ok(None) => return,
                Err(error) => return self.lose(&error),
            }
            if left == Span::ZERO {
                return;
            }
        }
    }

    fn acknowledged(&mut self, ack: Ack) {
        let of = |pending: &Pending| pending.sequence == ack.sequence;
        // Others are of repetitions, or of commands that were given up.
        if let Some(i) = self.pending.iter().position(of) {
            let command = self.pending.remove(i).command;
            let result = ack.result;
            self.events.push(FeedEvent::Answer { command, result });
        }
    }

    /// Sends unanswered commands again, or gives them up.
    fn repeat(&mut self) {
        let now = self.client.now();
        let (late, waiting) = std::mem::take(&mut self.pending)
            .into_iter()
            .partition::<Vec<_>, _>(|pending| pending.until <= now);
        self.pending = waiting;
        for Pending { command, left, .. } in late {
            if left > 0 && self.connected {
                self.post(command, left);
            } else {
                let reason = LinkError::Silent(names::command(&command)).to_string();
                self.events.push(FeedEvent::Unanswered { command, reason });
            }
        }
    }

    /// Sends a command, which may be sent `times` times in all from now on.
    fn post(&mut self, command: Command, times: u32) {
        match self.client.post(&command) {
            Ok(sequence) => self.pending.push(Pending {
                until: self.client.now().after(ANSWER_WITHIN),
                left: times.saturating_sub(1),
                command,
                sequence,
            }),
            Err(error) => {
                let reason = error.to_string();
                self.events.push(FeedEvent::Unanswered { command, reason });
                self.lose(&error);
            }
        }
    }

    /// Tries to connect again for `span`.
    fn retry(&mut self, span: Span) {
        // Answers to the hello are not the dashboard's.
        self.client.keep_answers(false);
        let tried = self.client.reconnect(span, &|| false);
        self.client.keep_answers(true);
        match tried {
            Ok(()) => self.connect(),
            // What is there now is not what was.
            Err(error @ LinkError::Mismatch { .. }) => self.lose(&error),
            Err(_) => {}
        }
    }
}

impl Feed for RoverFeed {
    fn now(&self) -> Duration {
        Duration::from_micros(self.client.now().0)
    }

    fn poll(&mut self, timeout: Duration) -> Vec<FeedEvent> {
        let span = Span(u64::try_from(timeout.as_micros()).unwrap_or(u64::MAX));
        if self.connected {
            self.receive(span);
            self.repeat();
        } else {
            self.retry(span);
        }
        let counters = self.client.counters();
        if counters != self.counters {
            self.counters = counters;
            self.events.push(FeedEvent::Frames(counters));
        }
        std::mem::take(&mut self.events)
    }

    fn send(&mut self, command: &Command) {
        let command = command.clone();
        if !self.connected {
            let reason = "the rover is not connected".into();
            self.events.push(FeedEvent::Unanswered { command, reason });
        } else if self.pending.len() >= MOST_PENDING && command != Command::Disarm {
            let reason = "the rover has not answered the commands before".into();
            self.events.push(FeedEvent::Unanswered { command, reason });
        } else {
            if !only_asks(&command) {
                self.pending.iter_mut().for_each(Pending::overtake);
            }
            let times = attempts(&command);
            self.post(command, times);
        }
    }
}
