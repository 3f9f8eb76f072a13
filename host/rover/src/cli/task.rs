//! `rover task`

use indicatif::ProgressBar;
use rover_link::names;
use rover_shared::contract::State;
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;

use super::interrupt::Interrupt;
use super::output::Failure;
use super::parse;
use super::port::PortAndFormat;
use super::steering::{self, Drive, DriveMode, Ended, RoverTask, Steering};
use super::watch::{Rover, Watch};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  rover arm && rover task follow 90 --mode run      follow east until Ctrl-C, which disarms
  rover task wander --mode learn --arm --for 10m    learn for ten minutes
  rover task follow 0                               only choose the task")]
pub struct Arguments {
    /// The rover's task
    #[arg(value_enum)]
    task: RoverTask,
    /// The direction to follow, in degrees clockwise as compasses have it
    #[arg(value_name = "DEG", value_parser = parse::compass, allow_hyphen_values = true,
          required_if_eq("task", "follow"))]
    direction: Option<Microdegrees>,
    /// Let the controller drive; without it only the task is chosen
    #[arg(long, value_enum)]
    mode: Option<DriveMode>,
    /// Arm first
    #[arg(long, requires = "mode")]
    arm: bool,
    /// Seed of the session [default: the rover draws one]
    #[arg(long, requires = "mode")]
    seed: Option<u64>,
    /// Disarm after this time
    #[arg(long = "for", value_name = "TIME", value_parser = parse::duration, requires = "mode")]
    span: Option<Duration>,
    /// Leave the rover driving instead of watching it
    #[arg(long, requires = "mode", conflicts_with = "span")]
    detach: bool,
    #[command(flatten)]
    common: PortAndFormat,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let steering = Steering {
        task: Some(arguments.task),
        direction: arguments.direction,
        seed: arguments.seed,
        arm: arguments.arm,
        mode: arguments.mode,
    };
    let mut client = arguments.common.port.connect()?;
    if arguments.mode.is_none() || arguments.detach {
        steering.begin(&mut client)?;
        let status = client.status()?;
        let (task, state) = (names::task(status.task), names::state(status.state));
        return arguments
            .common
            .answer(&status, format_args!("{task}, {state}"));
    }
    // Before anything moves, so that Ctrl-C always disarms.
    let interrupt = Interrupt::listen()?;
    if let Err(error) = steering.begin(&mut client) {
        if arguments.arm {
            steering::stop(&mut client)?;
        }
        return Err(error.into());
    }
    eprintln!("rover: driving; Ctrl-C disarms");
    let watch = Watch {
        interrupt: &interrupt,
        span: arguments.span,
        until_stopped: true,
        bar: &ProgressBar::hidden(),
    };
    let mut rover = Rover::Client(Box::new(client));
    let mut drive = Drive::default();
    let watched = watch.run(&mut rover, &mut drive, |_, _| Ok(true));
    if !matches!(drive.ended, Some(Ended::ByRover(_))) {
        steering::stop(rover.client())?;
    }
    watched?;
    arguments.common.answer(&drive, drive.line())?;
    match drive.ended {
        Some(Ended::ByRover(State::Faulted(fault))) => Err(Failure::Failed(format!(
            "the rover stopped: {}: `rover disarm` acknowledges it",
            names::fault(fault)
        ))),
        _ => Ok(()),
    }
}
