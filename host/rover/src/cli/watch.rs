//! Watching a rover: the loop of all commands that let one drive.

use std::path::Path;

use indicatif::ProgressBar;
use rover_link::{Client, LinkError, Received, text};
use rover_log::recorder::{RecordError, Recorder};
use rover_log::recording::{RecordingWriter, Written};
use rover_shared::contract::{Fault, State};
use rover_shared::time::Duration;
use rover_shared::wire::message::{Event, EventKind, Report};

use super::interrupt::Interrupt;
use super::output::Failure;
use super::port::Surroundings;
use super::steering::{Drive, Ended};
use crate::lines;

/// How long a rover that was unplugged is waited for.
pub const PATIENCE: Duration = Duration::from_millis(60_000);
/// How often interrupts are looked at.
const SLICE: Duration = Duration::from_millis(100);

/// A rover that is watched, recorded or not.
pub enum Rover {
    Client(Box<Client>),
    Recorded(Box<Recorder>),
}

impl Rover {
    /// A rover that is recorded to this file, and to others when it has the size `rotate`.
    pub fn recorded(
        client: Client,
        surroundings: Surroundings,
        path: &Path,
        rotate: Option<u64>,
    ) -> Result<Self, Failure> {
        let writer = concat!("rover ", env!("CARGO_PKG_VERSION"));
        let log = RecordingWriter::create(path, rotate, writer, client.epoch())?;
        let recorder = Recorder::begin(client, surroundings, log)?;
        Ok(Self::Recorded(Box::new(recorder)))
    }

    /// To send commands.
    pub fn client(&mut self) -> &mut Client {
        match self {
            Self::Client(client) => client,
            Self::Recorded(recorder) => recorder.client(),
        }
    }

    fn next(&mut self) -> Result<Option<Received>, RecordError> {
        match self {
            Self::Client(client) => Ok(client.next(SLICE)?),
            Self::Recorded(recorder) => recorder.next(SLICE),
        }
    }

    fn reconnect(&mut self, why: &LinkError, interrupt: &Interrupt) -> Result<(), RecordError> {
        let give_up = || interrupt.is_set();
        match self {
            Self::Client(client) => Ok(client.reconnect(PATIENCE, &give_up)?),
            Self::Recorded(recorder) => recorder.reconnect(why, PATIENCE, &give_up),
        }
    }

    /// Finishes the recording, if there is one, with the last reports, which `drive` counts.
    pub fn finish(self, drive: &mut Drive) -> Result<Option<Written>, Failure> {
        match self {
            Self::Client(_) => Ok(None),
            Self::Recorded(recorder) => Ok(Some(recorder.finish(|received| drive.add(received))?)),
        }
    }
}

/// How a rover is watched.
pub struct Watch<'a> {
    pub interrupt: &'a Interrupt,
    /// The time after which it ends, on the port's clock.
    pub span: Option<Duration>,
    /// Whether it ends when the rover stops driving.
    pub until_stopped: bool,
    /// Progress, above which reports are printed.
    pub bar: &'a ProgressBar,
}

impl Watch<'_> {
    /// Watches a rover until the end, and reconnects when the cable was pulled. `more` is called
    /// after every report and at least every 100 ms, with the time since the last report; its
    /// `false` is an end too.
    pub fn run(
        &self,
        rover: &mut Rover,
        drive: &mut Drive,
        mut more: impl FnMut(&Drive, Duration) -> Result<bool, Failure>,
    ) -> Result<(), Failure> {
        let until = self.span.map(|span| rover.client().now().after(span));
        let mut heard = rover.client().now();
        while drive.ended.is_none() && more(drive, rover.client().now().since(heard))? {
            if self.interrupt.is_set() {
                drive.ended = Some(Ended::Interrupted);
                continue;
            }
            if until.is_some_and(|until| rover.client().now() >= until) {
                drive.ended = Some(Ended::Time);
                continue;
            }
            let stopped = match rover.next() {
                Ok(Some(received)) => {
                    drive.add(&received);
                    if let Some(line) = line(&received.report) {
                        self.print(&line);
                    }
                    stopped(&received.report)
                }
                Ok(None) => continue,
                Err(RecordError::Link(error @ LinkError::Port(_))) => {
                    self.reconnect(rover, &error)?
                }
                Err(error) => return Err(error.into()),
            };
            heard = rover.client().now();
            drive.ended = stopped.filter(|_| self.until_stopped).map(Ended::ByRover);
        }
        Ok(())
    }

    /// Waits until the rover is back or the user interrupts. Returns its state if it does not drive
    /// any more.
    fn reconnect(&self, rover: &mut Rover, lost: &LinkError) -> Result<Option<State>, Failure> {
        self.print(&format!("{lost}; waiting for it"));
        match rover.reconnect(lost, self.interrupt) {
            Ok(()) => self.print("connected again"),
            Err(_) if self.interrupt.is_set() => return Ok(None),
            Err(RecordError::Link(error)) if !matches!(error, LinkError::Mismatch { .. }) => {
                let seconds = PATIENCE.0 / 1_000_000;
                let what = format!("the rover did not come back within {seconds} s");
                return Err(Failure::of(what, error));
            }
            Err(error) => return Err(error.into()),
        }
        let state = rover.client().status()?.state;
        Ok((!matches!(state, State::Driving(_))).then_some(state))
    }

    fn print(&self, line: &str) {
        self.bar.suspend(|| eprintln!("rover: {line}"));
    }
}

/// The line for a report, if people want to know: a rover that learns is blocked often, and the
/// outcomes of its actions tell.
pub fn line(report: &Report) -> Option<String> {
    let blocked = matches!(report, Report::Fault(report) if report.fault == Fault::Blocked);
    let line = lines::line(report).filter(|_| !blocked)?;
    Some(text::printable(&line.text, false))
}

/// The state in which the rover does not drive any more, if it reports one.
fn stopped(report: &Report) -> Option<State> {
    match report {
        Report::Event(Event {
            kind: EventKind::State(state @ (State::Disarmed | State::Faulted(_))),
            ..
        }) => Some(*state),
        _ => None,
    }
}
