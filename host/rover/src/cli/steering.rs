//! Setting a rover to work, and stopping it in the end.

use rover_link::{Client, LinkError, Received, names};
use rover_shared::contract::{Mode, Outcome, State, Task};
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{Command, Report};
use serde::{Serialize, Serializer};

use super::output::Failure;

/// The tasks of a rover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum RoverTask {
    /// Follow a direction
    Follow,
    /// Follow a direction that is redrawn at random
    Wander,
}

impl From<RoverTask> for Task {
    fn from(task: RoverTask) -> Self {
        match task {
            RoverTask::Follow => Self::FollowDirection,
            RoverTask::Wander => Self::FollowChangingDirection,
        }
    }
}

/// How the controller drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DriveMode {
    /// Try, and learn from the reward
    Learn,
    /// Act on what was learned, which stays as it is
    Run,
}

/// What a rover is set to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steering {
    pub task: Option<RoverTask>,
    pub direction: Option<Microdegrees>,
    pub seed: Option<u64>,
    pub arm: bool,
    pub mode: Option<DriveMode>,
}

impl Steering {
    /// Sends the commands.
    pub fn begin(&self, client: &mut Client) -> Result<(), LinkError> {
        let mode = self.mode.map(|mode| match mode {
            DriveMode::Learn => Mode::Learn,
            DriveMode::Run => Mode::Run,
        });
        let commands = [
            self.task.map(|task| Command::SetTask(task.into())),
            self.direction.map(Command::SetDirection),
            self.seed.map(Command::SetSeed),
            self.arm.then_some(Command::Arm),
            mode.map(Command::SetMode),
        ];
        commands
            .iter()
            .flatten()
            .try_for_each(|command| client.ask(command))
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

/// The reports of a drive, counted.
#[derive(Debug, Default, Serialize)]
pub struct Drive {
    /// Action cycles.
    pub actions: u64,
    /// How they ended.
    #[serde(serialize_with = "as_map")]
    pub outcomes: Vec<(Outcome, u64)>,
    /// Frames that were lost on the way.
    pub lost_frames: u64,
    /// Why it ended.
    pub ended: Option<Ended>,
}

/// Why a drive ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The user interrupted it.
    Interrupted,
    /// Its time was over.
    Time,
    /// The rover does not drive any more.
    ByRover(State),
}

impl Drive {
    /// Counts a report.
    pub fn add(&mut self, received: &Received) {
        self.lost_frames += u64::from(received.lost);
        let Report::Action(action) = &received.report else {
            return;
        };
        self.actions += 1;
        match self
            .outcomes
            .iter_mut()
            .find(|(of, _)| *of == action.outcome)
        {
            Some((_, count)) => *count += 1,
            None => self.outcomes.push((action.outcome, 1)),
        }
    }

    /// As one line for people.
    pub fn line(&self) -> String {
        let outcome = |(of, count): &(Outcome, u64)| format!("{count} {}", names::outcome(*of));
        let outcomes: Vec<_> = self.outcomes.iter().map(outcome).collect();
        let lost = match self.lost_frames {
            0 => "no frame lost".into(),
            lost => format!("{lost} frames lost"),
        };
        let ended = match self.ended {
            Some(Ended::ByRover(state)) => format!("; then {}", names::state(state)),
            Some(Ended::Interrupted) => "; then interrupted".into(),
            Some(Ended::Time) | None => String::new(),
        };
        format!(
            "{} actions ({}), {lost}{ended}",
            self.actions,
            outcomes.join(", ")
        )
    }
}

fn as_map<S: Serializer>(outcomes: &[(Outcome, u64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(outcomes.iter().copied())
}
