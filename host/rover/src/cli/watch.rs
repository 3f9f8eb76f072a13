//! Watching a rover: the loop of all commands that let one drive.

use std::path::Path;

use indicatif::ProgressBar;
use rover_link::{Client, LinkError, Received, text};
use rover_log::recorder::{RecordError, Recorder};
use rover_log::recording::{RecordingWriter, Written};
use rover_shared::time::Duration;
use rover_shared::wire::message::{Event, EventKind, Fault, FaultReport, Report, State};

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
    Heard(Box<Client>),
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
            Self::Heard(client) => client,
            Self::Recorded(recorder) => recorder.client(),
        }
    }

    fn next(&mut self) -> Result<Option<Received>, RecordError> {
        match self {
            Self::Heard(client) => Ok(client.next(SLICE)?),
            Self::Recorded(recorder) => recorder.next(SLICE),
        }
    }

    fn reconnect(&mut self, why: &LinkError, interrupt: &Interrupt) -> Result<(), RecordError> {
        let give_up = || interrupt.is_set();
        match self {
            Self::Heard(client) => Ok(client.reconnect(PATIENCE, &give_up)?),
            Self::Recorded(recorder) => recorder.reconnect(why, PATIENCE, &give_up),
        }
    }

    /// Finishes the recording, if there is one, with the last reports, which `drive` counts.
    pub fn finish(self, drive: &mut Drive) -> Result<Option<Written>, Failure> {
        match self {
            Self::Heard(_) => Ok(None),
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
        while more(drive, rover.client().now().since(heard))? {
            if self.interrupt.is_set() {
                drive.ended = Some(Ended::Interrupted);
            } else if until.is_some_and(|until| rover.client().now() >= until) {
                drive.ended = Some(Ended::Time);
            } else {
                let stopped = match rover.next() {
                    Ok(Some(received)) => {
                        heard = rover.client().now();
                        drive.add(&received);
                        if let Some(line) = line(&received.report) {
                            self.print(&line);
                        }
                        stopped(&received.report)
                    }
                    Ok(None) => None,
                    Err(RecordError::Link(error @ LinkError::Port(_))) => {
                        self.reconnect(rover, &error)?;
                        heard = rover.client().now();
                        self.stopped_meanwhile(rover)?
                    }
                    Err(error) => return Err(error.into()),
                };
                drive.ended = stopped.filter(|_| self.until_stopped).map(Ended::ByRover);
            }
            if drive.ended.is_some() {
                break;
            }
        }
        Ok(())
    }

    /// Returns when the rover is back or the user interrupted.
    fn reconnect(&self, rover: &mut Rover, lost: &LinkError) -> Result<(), Failure> {
        self.print(&format!("{lost}; waiting for it"));
        match rover.reconnect(lost, self.interrupt) {
            Ok(()) => self.print("connected again"),
            Err(_) if self.interrupt.is_set() => {}
            Err(
                error @ (RecordError::Write(_) | RecordError::Link(LinkError::Mismatch { .. })),
            ) => {
                return Err(error.into());
            }
            Err(error) => {
                let seconds = PATIENCE.0 / 1_000_000;
                return Err(Failure::Failed(format!(
                    "the rover did not come back within {seconds} s: {error}"
                )));
            }
        }
        Ok(())
    }

    /// The state of a rover that was away and does not drive any more.
    fn stopped_meanwhile(&self, rover: &mut Rover) -> Result<Option<State>, Failure> {
        if !self.until_stopped || self.interrupt.is_set() {
            return Ok(None);
        }
        let state = rover.client().status()?.state;
        Ok(Some(state).filter(|state| !matches!(state, State::Driving(_))))
    }

    fn print(&self, line: &str) {
        self.bar.suspend(|| eprintln!("rover: {line}"));
    }
}

/// The line for a report, if people want to know: a rover that learns is blocked often, and the
/// outcomes of its actions tell.
pub fn line(report: &Report) -> Option<String> {
    if let Report::Fault(FaultReport {
        fault: Fault::Blocked,
        ..
    }) = report
    {
        return None;
    }
    lines::line(report).map(|line| text::printable(&line.text, false))
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
