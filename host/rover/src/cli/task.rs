//! `rover task`

use rover_shared::contract::{State, Task};
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;

use super::interrupt::Interrupt;
use super::port::PortArguments;
use super::steering::{self, Ended, ModeChoice, Steering};
use super::{Failure, print, print_json, values};
use rover_link::names;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  rover arm && rover task follow 90 --mode run      follow east until Ctrl-C, which disarms
  rover task wander --mode learn --arm --for 10m    learn for ten minutes
  rover task follow 0                               only choose the task")]
pub struct Arguments {
    /// What is to be done
    #[arg(value_enum)]
    task: TaskChoice,
    /// The direction to follow, in degrees clockwise as compasses have it
    #[arg(value_name = "DEG", value_parser = values::compass, allow_hyphen_values = true,
          required_if_eq("task", "follow"))]
    direction: Option<Microdegrees>,
    /// Let the controller drive; without it only the task is chosen
    #[arg(long, value_enum)]
    mode: Option<ModeChoice>,
    /// Arm first
    #[arg(long, requires = "mode")]
    arm: bool,
    /// Seed of the session [default: the rover draws one]
    #[arg(long, requires = "mode")]
    seed: Option<u64>,
    /// Disarm after this time
    #[arg(long = "for", value_name = "TIME", value_parser = values::duration, requires = "mode")]
    span: Option<Duration>,
    /// Leave the rover driving instead of watching it
    #[arg(long, requires = "mode", conflicts_with = "span")]
    detach: bool,
    #[command(flatten)]
    port: PortArguments,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What a rover can be told to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TaskChoice {
    /// Follow a direction
    Follow,
    /// Follow a direction that is redrawn at random
    Wander,
}

impl TaskChoice {
    /// As the wire has it.
    pub fn task(self) -> Task {
        match self {
            Self::Follow => Task::FollowDirection,
            Self::Wander => Task::FollowChangingDirection,
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let steering = Steering {
        task: Some(arguments.task.task()),
        direction: arguments.direction,
        seed: arguments.seed,
        arm: arguments.arm,
        mode: arguments.mode,
    };
    let mut client = arguments.port.connect()?;
    if arguments.mode.is_none() || arguments.detach {
        steering.begin(&mut client)?;
        let status = client.status()?;
        if arguments.json {
            return print_json(&status);
        }
        return print(&format!(
            "{}, {}\n",
            names::task(status.task),
            names::state(status.state)
        ));
    }
    // Before anything moves, so that Ctrl-C always disarms.
    let interrupt = Interrupt::listen()?;
    let begun = steering.begin(&mut client);
    if let Err(error) = begun {
        if arguments.arm {
            steering::stop(&mut client)?;
        }
        return Err(error.into());
    }
    eprintln!("rover: driving; Ctrl-C disarms");
    let watched = steering::watch(&mut client, &interrupt, arguments.span);
    if !matches!(
        watched,
        Ok(steering::Drive {
            ended: Some(Ended::ByRover(_)),
            ..
        })
    ) {
        steering::stop(&mut client)?;
    }
    let drive = watched?;
    if arguments.json {
        print_json(&drive)?;
    } else {
        print(&format!("{}\n", drive.line()))?;
    }
    match drive.ended {
        Some(Ended::ByRover(State::Faulted(fault))) => Err(Failure::Failed(format!(
            "the rover stopped: {}: `rover disarm` acknowledges it",
            names::fault(fault)
        ))),
        _ => Ok(()),
    }
}
