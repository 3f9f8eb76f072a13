//! Recording a rover while a program talks to it.

use std::collections::VecDeque;

use rover_shared::contract::{Mode, Refusal, State};
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::message::{Event, EventKind, Report};

use crate::arena::Arena;
use crate::files::WriteError;
use crate::recording::{RecordingWriter, Written};
use rover_link::{Client, LinkError, Received};
use rover_simulator::arena::{Pose, Scenario};

/// How often the rover's state is asked for, and recorded.
const STATUS_EVERY: Duration = Duration::from_millis(10_000);
/// How long after the end of a drive the rover may still send reports of it.
const LAST_WORD: Duration = Duration::from_millis(200);

/// Why a recording stopped.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The connection failed; [`Recorder::reconnect`] may help.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The recording cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// What an emulation knows and its rover does not.
pub trait Truth {
    /// Where the rover was switched on, and what stands around it.
    fn scenario(&self) -> Scenario;

    /// Where the rover was at a moment of its own clock; `None` if that is too long ago or still to
    /// come.
    fn pose_at(&self, rover_time: Instant) -> Option<Pose>;
}

/// Records a rover's reports.
pub struct Recorder {
    client: Client,
    truth: Option<Box<dyn Truth>>,
    log: RecordingWriter,
    asked: Instant,
    /// Reports that arrived, and were written, while knowledge was pulled.
    heard: VecDeque<Received>,
    /// Knowledge is to be pulled as soon as the rover allows it.
    pull: bool,
}

impl Recorder {
    /// Begins: with who the rover is, its state, and what it knows if it does not drive; of an
    /// emulated rover also with its arena.
    ///
    /// # Errors
    /// The connection or the file failed.
    pub fn begin(
        mut client: Client,
        truth: Option<Box<dyn Truth>>,
        log: RecordingWriter,
    ) -> Result<Self, RecordError> {
        let hello = Received {
            at: client.now(),
            sequence: 0,
            lost: 0,
            report: Report::Hello(client.hello().clone()),
        };
        client.keep_answers(true);
        let mut recorder = Self {
            asked: client.now(),
            client,
            truth,
            log,
            heard: VecDeque::new(),
            pull: true,
        };
        recorder.log.hear(&hello)?;
        if let Some(truth) = &recorder.truth {
            let arena = Arena::new(1, &truth.scenario(), false);
            recorder.log.arena(recorder.client.now(), arena)?;
        }
        recorder.look()?;
        Ok(recorder)
    }

    /// The rover that is recorded: commands may be given to it.
    pub fn client(&mut self) -> &mut Client {
        &mut self.client
    }

    /// The next report, which has been written; `None` if none came within `patience`.
    ///
    /// # Errors
    /// The connection or the file failed.
    pub fn next(&mut self, patience: Duration) -> Result<Option<Received>, RecordError> {
        let now = self.client.now();
        self.log.tick(now)?;
        if now.since(self.asked) >= STATUS_EVERY {
            self.asked = now;
            self.ask()?;
        }
        if self.pull {
            self.pull()?;
        }
        if let Some(heard) = self.heard.pop_front() {
            return Ok(Some(heard));
        }
        let next = self.client.next(patience)?;
        self.write_commands()?;
        if let Some(received) = &next {
            self.write(received)?;
        }
        Ok(next)
    }

    /// Writes a report; before it the commands that it may answer, and before an action where an
    /// emulated rover was.
    fn write(&mut self, received: &Received) -> Result<(), WriteError> {
        self.write_commands()?;
        if let Report::Action(action) = &received.report
            && let Some(truth) = &self.truth
            && let Some(pose) = truth.pose_at(action.time)
        {
            self.log.truth(received.at, action.time, pose)?;
        }
        self.pull |= ends_drive(&received.report);
        self.log.hear(received)
    }

    fn write_commands(&mut self) -> Result<(), WriteError> {
        while let Some(sent) = self.client.take_sent() {
            self.log.command(&sent)?;
        }
        Ok(())
    }

    /// Connects again after the port failed, and notes the gap.
    ///
    /// # Errors
    /// As [`Client::reconnect`]; the recording goes on all the same.
    pub fn reconnect(
        &mut self,
        why: &LinkError,
        patience: Duration,
        give_up: &dyn Fn() -> bool,
    ) -> Result<(), RecordError> {
        self.log.gap(self.client.now(), &why.to_string())?;
        // What has arrived is safe, however long it takes.
        self.log.flush()?;
        let until = self.client.now().after(patience);
        loop {
            let left = until.since(self.client.now());
            self.client.reconnect(left, give_up)?;
            match self.look() {
                Err(RecordError::Link(LinkError::Port(_))) if self.client.now() < until => {}
                done => return done,
            }
        }
    }

    /// Ends the recording with what the rover knows, if it does not drive; its last reports are passed
    /// to `hear` too.
    ///
    /// # Errors
    /// The file cannot be written. A connection that failed is no error.
    pub fn finish(mut self, mut hear: impl FnMut(&Received)) -> Result<Written, WriteError> {
        self.pull = true;
        let until = self.client.now().after(LAST_WORD);
        let mut drained = 0;
        while self.client.now() < until || drained > 0 {
            drained = match self.next(until.since(self.client.now())) {
                Ok(None) => 0,
                Ok(Some(received)) => {
                    hear(&received);
                    1
                }
                Err(RecordError::Write(error)) => return Err(error),
                Err(RecordError::Link(_)) => break,
            };
        }
        self.log.finish(self.client.counters())
    }

    /// Asks for state and knowledge, which are not reported unasked.
    fn look(&mut self) -> Result<(), RecordError> {
        self.asked = self.client.now();
        self.ask()?;
        self.pull = true;
        self.pull()
    }

    /// Asks for the rover's state. Silence is no reason to stop: a rover that hangs is reset by its
    /// watchdog, and the port is lost.
    fn ask(&mut self) -> Result<(), RecordError> {
        match self.client.status() {
            Ok(_) | Err(LinkError::Silent(_)) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn pull(&mut self) -> Result<(), RecordError> {
        self.pull = false;
        self.client.keep_answers(false);
        let pulled = self.client.pull_knowledge(|_, _| {});
        self.client.keep_answers(true);
        match pulled {
            Ok(bytes) => {
                // What arrived before is written before.
                while let Some(received) = self.client.next(Duration::ZERO)? {
                    self.write(&received)?;
                    self.heard.push_back(received);
                }
                Ok(self.log.knowledge(self.client.now(), &bytes)?)
            }
            // Refused while it drives: asked for again when it stops.
            Err(LinkError::Refused {
                refusal: Refusal::Armed | Refusal::KnowledgeInvalid,
                ..
            })
            | Err(LinkError::Transfer(_) | LinkError::Silent(_)) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

fn ends_drive(report: &Report) -> bool {
    matches!(
        report,
        Report::Event(Event {
            kind: EventKind::State(
                State::Disarmed | State::Armed | State::Faulted(_) | State::Driving(Mode::Host)
            ),
            ..
        })
    )
}
