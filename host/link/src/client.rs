//! The conversation with a rover.

use std::collections::VecDeque;

use rover_shared::contract::Refusal;
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::frame::{Encoder, FrameError, MAX_FRAME};
use rover_shared::wire::message::{Command, Hello, Report, Status};
use rover_shared::wire::{PROTOCOL_VERSION, SCHEMA_HASH, compatible};

use crate::error::LinkError;
use crate::inbox::{Counters, Inbox, Received};
use crate::names;
use crate::port::Port;

/// How long the rover has to answer a command. It answers within a control period, 20 ms, but
/// for the 400 ms that erasing a sector of its flash may take.
pub const ANSWER_WITHIN: Duration = Duration::from_millis(600);
/// How often a command that may be repeated is sent before giving up.
const ATTEMPTS: u32 = 3;
/// A rover looks every 40 ms whether its port was opened: the first hello may come too early.
const HELLO_ATTEMPTS: u32 = 8;
const HELLO_WITHIN: Duration = Duration::from_millis(250);
/// How long a rover may be busy with its flash: a dozen sectors, typically of 45 ms each.
const FLASH_WITHIN: Duration = Duration::from_millis(3_000);
/// The rover reports a late host after 0.5 s of silence, and stops after 2 s.
const HEARTBEAT: Duration = Duration::from_millis(200);
/// How long a read waits at most before heartbeats are looked at.
const SLICE: Duration = Duration::from_millis(50);
/// Commands kept for [`Client::take_sent`].
const MOST_SENT: usize = 512;
/// Pauses between attempts to connect again: doubled from the first to the last.
const PAUSES: (Duration, Duration) = (Duration::from_millis(20), Duration::from_millis(1_000));

/// The host's end of a conversation with a rover.
///
/// All reports are kept until they are read by [`next`](Self::next), except answers to commands,
/// unless [`keep_answers`](Self::keep_answers) asks for them.
pub struct Client {
    port: Box<dyn Port>,
    encoder: Encoder,
    inbox: Inbox,
    /// Received, and not sorted yet.
    fresh: VecDeque<Received>,
    /// Both sides were found to be made from the same contract.
    introduced: bool,
    hello: Hello,
    keep_answers: bool,
    /// Commands sent while answers are kept, and not taken yet.
    sent: VecDeque<Sent>,
    /// Heartbeats are sent; when the last was.
    heartbeat: Option<Instant>,
}

impl Client {
    /// Introduces host and rover to each other.
    ///
    /// # Errors
    /// No rover answers, or not in our protocol.
    pub fn open(port: Box<dyn Port>) -> Result<Self, LinkError> {
        let mut client = Self::new(port);
        client.introduce(HELLO_ATTEMPTS)?;
        Ok(client)
    }

    /// Disarms whatever rover is at the port, also one of another schema: stopping needs no
    /// introduction.
    ///
    /// # Errors
    /// It does not answer, or speaks another protocol.
    pub fn disarm(port: Box<dyn Port>) -> Result<(), LinkError> {
        let mut client = Self::new(port);
        client.port.send(&[0])?;
        client.ask(&Command::Disarm)
    }

    fn new(port: Box<dyn Port>) -> Self {
        let none = Hello {
            schema: 0,
            board: Default::default(),
            firmware: Default::default(),
            reset: rover_shared::contract::ResetReason::PowerOn,
            seed: 0,
            knowledge: None,
        };
        Self {
            port,
            encoder: Encoder::new(),
            inbox: Inbox::default(),
            fresh: VecDeque::new(),
            introduced: false,
            hello: none,
            keep_answers: false,
            sent: VecDeque::new(),
            heartbeat: None,
        }
    }

    /// The rover's last hello: who it is.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// What to call the port.
    pub fn port_name(&self) -> &str {
        self.port.name()
    }

    /// The time on the port's clock.
    pub fn now(&self) -> Instant {
        self.port.now()
    }

    /// As [`Port::epoch`].
    pub fn epoch(&self) -> Option<std::time::SystemTime> {
        self.port.epoch()
    }

    /// What happened to frames so far.
    pub fn counters(&self) -> Counters {
        self.inbox.counters
    }

    /// Sets whether answers to commands are kept too, to be read by [`next`](Self::next), and the
    /// commands for [`take_sent`](Self::take_sent).
    pub fn keep_answers(&mut self, keep: bool) {
        self.keep_answers = keep;
    }

    /// The next command that was sent while answers are kept, repetitions included. At most 512 are
    /// kept; the oldest go first.
    pub fn take_sent(&mut self) -> Option<Sent> {
        self.sent.pop_front()
    }

    /// Sets whether heartbeats are sent, at every call that waits, as
    /// [`Mode::Host`](rover_shared::contract::Mode::Host) needs them.
    ///
    /// # Errors
    /// The first is refused or not answered; none are sent then.
    pub fn send_heartbeats(&mut self, on: bool) -> Result<(), LinkError> {
        self.heartbeat = None;
        if on {
            self.ask(&Command::Heartbeat)?;
            self.heartbeat = Some(self.port.now());
        }
        Ok(())
    }

    /// The next report; `None` if none came within `patience`.
    ///
    /// # Errors
    /// The port failed: [`reconnect`](Self::reconnect) before anything else.
    pub fn next(&mut self, patience: Duration) -> Result<Option<Received>, LinkError> {
        let until = self.port.now().after(patience);
        loop {
            while let Some(received) = self.fresh.pop_front() {
                self.sort(received)?;
            }
            if let Some(received) = self.inbox.take() {
                return Ok(Some(received));
            }
            let left = until.since(self.port.now());
            self.pump(left)?;
            if left == Duration::ZERO && self.fresh.is_empty() {
                return Ok(None);
            }
        }
    }

    /// Sends a command without waiting; returns the number that its acknowledgement names. If
    /// answers are kept, [`next`](Self::next) returns them, within [`ANSWER_WITHIN`] if all is well.
    ///
    /// # Errors
    /// The port failed.
    pub fn post(&mut self, command: &Command) -> Result<u16, LinkError> {
        let mut buffer = [0; MAX_FRAME];
        let sequence = self.encoder.next_sequence();
        let frame = self.encoder.encode(command, &mut buffer);
        let frame = frame.expect("a test of the contract holds every command against MAX_FRAME");
        self.port.send(frame)?;
        if self.keep_answers {
            if self.sent.len() == MOST_SENT {
                self.sent.pop_front();
            }
            self.sent.push_back(Sent {
                at: self.port.now(),
                sequence,
                command: command.clone(),
            });
        }
        Ok(sequence)
    }

    /// Has a command carried out. It is repeated if no answer comes, [unless it must not
    /// be](attempts).
    ///
    /// # Errors
    /// It is refused, or not answered.
    pub fn ask(&mut self, command: &Command) -> Result<(), LinkError> {
        self.transact(command, &mut |_| true)
    }

    /// Has a command carried out whose answer is a report: the first that `pick` accepts.
    ///
    /// # Errors
    /// It is refused, or not answered.
    pub fn ask_for<T>(
        &mut self,
        command: &Command,
        pick: impl Fn(Report) -> Option<T>,
    ) -> Result<T, LinkError> {
        let mut picked = None;
        self.transact(command, &mut |answer| {
            picked = answer.and_then(|report| pick(report.clone()));
            picked.is_some()
        })?;
        picked.ok_or_else(|| LinkError::Silent(names::command(command)))
    }

    /// The rover's state.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn status(&mut self) -> Result<Status, LinkError> {
        self.ask_for(&Command::ReadStatus, |report| match report {
            Report::Status(status) => Some(status),
            _ => None,
        })
    }

    /// Connects anew after the port failed. Tries until `patience` is over or `give_up` says so,
    /// with growing pauses.
    ///
    /// # Errors
    /// The last one; at once if the rover that is found speaks another protocol.
    pub fn reconnect(
        &mut self,
        patience: Duration,
        give_up: &dyn Fn() -> bool,
    ) -> Result<(), LinkError> {
        let until = self.port.now().after(patience);
        let mut pause = PAUSES.0;
        // At least one, however short the patience.
        let attempts = u32::try_from(patience.0 / HELLO_WITHIN.0).unwrap_or(u32::MAX);
        let attempts = attempts.clamp(1, HELLO_ATTEMPTS);
        loop {
            let tried = self.port.reopen().map_err(LinkError::from);
            match tried.and_then(|()| self.introduce(attempts)) {
                Ok(()) => {
                    let counters = &mut self.inbox.counters;
                    counters.reconnected = counters.reconnected.saturating_add(1);
                    return Ok(());
                }
                Err(error @ LinkError::Mismatch { .. }) => return Err(error),
                Err(error) if give_up() || self.port.now() >= until => return Err(error),
                Err(_) => {}
            }
            self.port.wait(pause.min(until.since(self.port.now())));
            pause = pause.plus(pause).min(PAUSES.1);
        }
    }

    /// Lets time pass without losing what is said meanwhile.
    ///
    /// # Errors
    /// The port failed.
    pub fn wait(&mut self, span: Duration) -> Result<(), LinkError> {
        let until = self.port.now().after(span);
        loop {
            let left = until.since(self.port.now());
            if left == Duration::ZERO {
                return Ok(());
            }
            self.pump(left)?;
            while let Some(received) = self.fresh.pop_front() {
                self.sort(received)?;
            }
        }
    }

    /// Puts back what was read and not used, before what waits.
    pub(crate) fn put_back(&mut self, read: Vec<Received>) {
        self.inbox.put_back(read);
    }

    fn introduce(&mut self, attempts: u32) -> Result<(), LinkError> {
        self.encoder = Encoder::new();
        self.inbox.restart();
        self.fresh.clear();
        // Ends whatever noise the opening made at the other end.
        self.port.send(&[0])?;
        let schema = SCHEMA_HASH;
        for _ in 0..attempts {
            let sequence = self.post(&Command::Hello { schema })?;
            let until = self.port.now().after(HELLO_WITHIN);
            let (mut open, mut hello) = (false, None);
            while self.port.now() < until {
                self.pump(until.since(self.port.now()))?;
                while let Some(received) = self.fresh.pop_front() {
                    match &received.report {
                        Report::Hello(theirs) => {
                            self.check(PROTOCOL_VERSION, theirs.schema)?;
                            hello = Some(theirs.clone());
                            self.keep_if(self.keep_answers, received);
                        }
                        Report::Ack(ack) => {
                            open |= ack.sequence == sequence && ack.result.is_ok();
                            self.keep_if(self.keep_answers, received);
                        }
                        _ => self.inbox.keep(received),
                    }
                }
                if open && let Some(hello) = hello {
                    self.introduced = true;
                    self.hello = hello;
                    return Ok(());
                }
            }
        }
        Err(LinkError::NoAnswer(self.port.name().into()))
    }

    fn check(&self, version: u8, schema: u32) -> Result<(), LinkError> {
        compatible(version, schema).map_err(|mismatch| LinkError::Mismatch {
            port: self.port.name().into(),
            mismatch,
        })
    }

    /// Has a command answered: acknowledged (`None`), and the reports after that up to the first
    /// that is `wanted`. While the flash is being written, as for a second after a disarming, it is
    /// asked again.
    fn transact(
        &mut self,
        command: &Command,
        wanted: &mut dyn FnMut(Option<&Report>) -> bool,
    ) -> Result<(), LinkError> {
        let until = self.port.now().after(FLASH_WITHIN);
        loop {
            match self.transact_once(command, wanted) {
                Err(LinkError::Refused {
                    refusal: Refusal::FlashBusy,
                    ..
                }) if self.port.now() < until => self.wait(PAUSES.0)?,
                done => return done,
            }
        }
    }

    fn transact_once(
        &mut self,
        command: &Command,
        wanted: &mut dyn FnMut(Option<&Report>) -> bool,
    ) -> Result<(), LinkError> {
        for _ in 0..attempts(command) {
            let sequence = self.post(command)?;
            let until = self.port.now().after(ANSWER_WITHIN);
            let mut acknowledged = false;
            while self.port.now() < until {
                self.pump(until.since(self.port.now()))?;
                while let Some(received) = self.fresh.pop_front() {
                    match &received.report {
                        Report::Ack(ack) if ack.sequence == sequence => {
                            let result = ack.result;
                            self.keep_if(self.keep_answers, received);
                            if let Err(refusal) = result {
                                let command = names::command(command);
                                return Err(LinkError::Refused { command, refusal });
                            }
                            if wanted(None) {
                                return Ok(());
                            }
                            acknowledged = true;
                        }
                        report if acknowledged && wanted(Some(report)) => {
                            self.keep_if(self.keep_answers, received);
                            return Ok(());
                        }
                        _ => self.sort(received)?,
                    }
                }
            }
        }
        Err(LinkError::Silent(names::command(command)))
    }

    /// Keeps or drops a report that answers no command.
    fn sort(&mut self, received: Received) -> Result<(), LinkError> {
        match &received.report {
            // Of a heartbeat, or late.
            Report::Ack(_) => self.keep_if(self.keep_answers, received),
            Report::Hello(hello) if self.introduced => {
                self.check(PROTOCOL_VERSION, hello.schema)?;
                self.hello = hello.clone();
                let restarted = received.sequence == 0;
                self.inbox.keep(received);
                if restarted {
                    let schema = SCHEMA_HASH;
                    self.post(&Command::Hello { schema })?;
                }
            }
            _ => self.inbox.keep(received),
        }
        Ok(())
    }

    fn keep_if(&mut self, keep: bool, received: Received) {
        if keep {
            self.inbox.keep(received);
        } else {
            self.inbox.pass(&received);
        }
    }

    /// Receives what has come, waiting at most for `patience` or a slice of time; sends heartbeats.
    fn pump(&mut self, patience: Duration) -> Result<(), LinkError> {
        if let Some(last) = self.heartbeat
            && self.port.now().since(last) >= HEARTBEAT
        {
            self.post(&Command::Heartbeat)?;
            self.heartbeat = Some(self.port.now());
        }
        let mut buffer = [0; 1_024];
        let length = self.port.receive(&mut buffer, patience.min(SLICE))?;
        let at = self.port.now();
        for byte in buffer.iter().take(length) {
            match self.inbox.push(at, *byte) {
                Some(Ok(received)) => self.fresh.push_back(received),
                Some(Err(FrameError::Version(mismatch))) => {
                    let port = self.port.name().into();
                    return Err(LinkError::Mismatch { port, mismatch });
                }
                Some(Err(_)) | None => {}
            }
        }
        Ok(())
    }
}

/// A command, as it was sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent {
    /// When, on the port's clock.
    pub at: Instant,
    /// The number of its frame, which its acknowledgement names.
    pub sequence: u16,
    /// The command.
    pub command: Command,
}

/// How often a command may be sent if no acknowledgement comes: once if it may have been carried
/// out and would do harm a second time.
pub fn attempts(command: &Command) -> u32 {
    let harmless_twice = match command {
        Command::Drive { .. } | Command::StoreKnowledge => false,
        // Again after the last chunk of a transfer is no continuation of it.
        Command::PushKnowledge(chunk) => chunk.offset + (chunk.data.len() as u32) < chunk.total,
        _ => true,
    };
    if harmless_twice { ATTEMPTS } else { 1 }
}
