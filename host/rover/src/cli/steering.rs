//! Setting a rover to work, watching it, and stopping it in the end.

use std::collections::BTreeMap;

use rover_shared::contract::{Mode, State, Task};
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{Command, Event, EventKind, Report};
use serde::Serialize;

use super::interrupt::Interrupt;
use super::{Failure, narrate};
use rover_link::{Client, LinkError, Received};

/// How long a rover that was unplugged is waited for.
pub const PATIENCE: Duration = Duration::from_millis(60_000);
/// How often interrupts are looked at.
const SLICE: Duration = Duration::from_millis(100);

/// Which controller mode drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ModeChoice {
    /// Try, and learn from the reward
    Learn,
    /// Act on what was learned, which stays as it is
    Run,
}

/// What a rover is set to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steering {
    pub task: Option<Task>,
    pub direction: Option<Microdegrees>,
    pub seed: Option<u64>,
    pub arm: bool,
    pub mode: Option<ModeChoice>,
}

impl Steering {
    /// Sets the rover to it.
    pub fn begin(&self, client: &mut Client) -> Result<(), LinkError> {
        if let Some(task) = self.task {
            client.ask(&Command::SetTask(task))?;
        }
        if let Some(direction) = self.direction {
            client.ask(&Command::SetDirection(direction))?;
        }
        if let Some(seed) = self.seed {
            client.ask(&Command::SetSeed(seed))?;
        }
        if self.arm {
            client.ask(&Command::Arm)?;
        }
        match self.mode {
            Some(ModeChoice::Learn) => client.ask(&Command::SetMode(Mode::Learn)),
            Some(ModeChoice::Run) => client.ask(&Command::SetMode(Mode::Run)),
            None => Ok(()),
        }
    }
}

/// Disarms a rover that this program set to work, also one that has to be connected again first.
pub fn stop(client: &mut Client) -> Result<(), Failure> {
    let disarmed = client.ask(&Command::Disarm).or_else(|error| match error {
        LinkError::Port(_) => client
            .reconnect(Duration::from_millis(3_000), &|| false)
            .and_then(|()| client.ask(&Command::Disarm)),
        error => Err(error),
    });
    disarmed.map_err(|error| {
        Failure::Failed(format!(
            "the rover could not be disarmed, switch its motors off: {error}"
        ))
    })
}

/// What was heard of a drive.
#[derive(Debug, Default, Serialize)]
pub struct Drive {
    /// Action cycles.
    pub actions: u64,
    /// How they ended.
    pub outcomes: BTreeMap<String, u64>,
    /// Frames that were lost on the way.
    pub lost_frames: u64,
    /// Why it ended.
    pub ended: Option<Ended>,
}

/// Why a drive ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// Somebody had enough.
    Interrupted,
    /// Its time was over.
    Time,
    /// The rover does not drive any more.
    ByRover(State),
}

impl Drive {
    /// Takes a report.
    pub fn hear(&mut self, received: &Received) {
        if let Report::Action(action) = &received.report {
            self.actions += 1;
            let outcome = format!("{:?}", action.outcome);
            *self.outcomes.entry(outcome).or_default() += 1;
        }
    }

    /// As one line for people.
    pub fn line(&self) -> String {
        let outcomes: Vec<_> = self
            .outcomes
            .iter()
            .map(|(outcome, count)| format!("{count} {outcome}"))
            .collect();
        let lost = match self.lost_frames {
            0 => "no frame lost".into(),
            lost => format!("{lost} frames lost"),
        };
        format!("{} actions ({}), {lost}", self.actions, outcomes.join(", "))
    }
}

/// Watches a rover until it is over: interrupted, out of time, or not driving any more. Connects
/// again when the cable was pulled.
pub fn watch(
    client: &mut Client,
    interrupt: &Interrupt,
    span: Option<Duration>,
) -> Result<Drive, Failure> {
    let until = span.map(|span| client.now().after(span));
    let lost = client.counters().lost;
    let mut drive = Drive::default();
    drive.ended = Some(loop {
        if interrupt.is_set() {
            break Ended::Interrupted;
        }
        if until.is_some_and(|until| client.now() >= until) {
            break Ended::Time;
        }
        let received = match client.next(SLICE) {
            Ok(Some(received)) => received,
            Ok(None) => continue,
            Err(LinkError::Port(error)) => {
                eprintln!("rover: {error}; waiting for it");
                client.reconnect(PATIENCE, &|| interrupt.is_set())?;
                eprintln!("rover: connected again");
                match client.status()?.state {
                    State::Driving(_) => continue,
                    state => break Ended::ByRover(state),
                }
            }
            Err(error) => return Err(error.into()),
        };
        drive.hear(&received);
        if let Some(line) = narrate::line(&received.report) {
            eprintln!("rover: {line}");
        }
        if let Report::Event(Event {
            kind: EventKind::State(state),
            ..
        }) = received.report
            && !matches!(state, State::Driving(_) | State::Armed)
        {
            break Ended::ByRover(state);
        }
    });
    drive.lost_frames = client.counters().lost - lost;
    Ok(drive)
}
