//! `rover record`

use std::path::PathBuf;

use indicatif::ProgressBar;
use rover_log::recording::Written;
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;
use serde::Serialize;

use super::input::listed;
use super::interrupt::Interrupt;
use super::output::Failure;
use super::parse;
use super::port::PortAndFormat;
use super::steering::{self, Drive, DriveMode, RoverTask, Steering};
use super::watch::{Rover, Watch};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  rover record                                            what the rover does, until Ctrl-C
  rover record --arm --mode learn --task wander --for 1h  have it learn for an hour, then disarm
  rover replay rover-1.mcap --verify                      the recording through the core again")]
pub struct Arguments {
    /// Where to write it; never over another file [default: rover-1.mcap, or the next number]
    #[arg(long, value_name = "FILE.mcap", value_parser = parse::log_path)]
    out: Option<PathBuf>,
    /// Begin another file, FILE-2.mcap and so on, when one has this size
    #[arg(long, value_name = "SIZE", value_parser = parse::size)]
    rotate: Option<u64>,
    /// End after this time
    #[arg(long = "for", value_name = "TIME", value_parser = parse::duration)]
    span: Option<Duration>,
    /// Choose the task first
    #[arg(long, value_enum)]
    task: Option<RoverTask>,
    /// Choose the direction to follow first, in degrees clockwise as compasses have it
    #[arg(long, value_name = "DEG", value_parser = parse::compass, allow_hyphen_values = true)]
    direction: Option<Microdegrees>,
    /// Choose the seed of the session first
    #[arg(long)]
    seed: Option<u64>,
    /// Arm first, and disarm in the end
    #[arg(long)]
    arm: bool,
    /// Let the controller drive, and disarm in the end
    #[arg(long, value_enum)]
    mode: Option<DriveMode>,
    #[command(flatten)]
    common: PortAndFormat,
}

#[derive(Serialize)]
struct Answer {
    #[serde(flatten)]
    written: Written,
    drive: Drive,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (client, surroundings) = arguments.common.port.connect_with_truth()?;
    let interrupt = Interrupt::listen()?;
    let path = arguments.out.clone().unwrap_or_else(free_name);
    let mut rover = Rover::recorded(client, surroundings, &path, arguments.rotate)?;
    // Whether the rover is this program's to stop.
    let steers = arguments.arm || arguments.mode.is_some();
    let disarms = if steers { " and disarms" } else { "" };
    eprintln!(
        "rover: recording to {}; Ctrl-C ends it{disarms}",
        path.display()
    );
    let steering = Steering {
        task: arguments.task,
        direction: arguments.direction,
        seed: arguments.seed,
        arm: arguments.arm,
        mode: arguments.mode,
    };
    let begun = steering.begin(rover.client());
    let nothing_done = begun.is_err();
    let bar = ProgressBar::new_spinner();
    let watch = Watch {
        interrupt: &interrupt,
        span: arguments.span,
        until_stopped: false,
        bar: &bar,
    };
    let mut drive = Drive::default();
    let watched = begun.map_err(Failure::from).and_then(|()| {
        watch.run(&mut rover, &mut drive, |drive, _| {
            bar.set_message(drive.line());
            bar.tick();
            Ok(true)
        })
    });
    bar.finish_and_clear();
    // Disarmed first, whatever happened; then the file.
    let stopped = if steers {
        steering::stop(rover.client())
    } else {
        Ok(())
    };
    let written = rover.finish(&mut drive);
    // A rover that may still drive is reported before anything else.
    stopped?;
    if nothing_done {
        // A recording of a refusal is of no use, and would be in the way of the next try.
        for file in written.iter().flatten().flat_map(|written| &written.files) {
            let _ = std::fs::remove_file(file);
        }
    }
    watched?;
    let Some(written) = written? else {
        return Ok(());
    };
    let (files, messages) = (listed(&written.files, " "), written.messages);
    let text = format!("{}\n{messages} messages in {files}", drive.line());
    arguments.common.answer(&Answer { written, drive }, text)?;
    if !arguments.common.json {
        eprintln!("rover: next:  rover replay {files} --verify");
    }
    Ok(())
}

/// The first of `rover-1.mcap`, `rover-2.mcap` and so on that does not exist.
fn free_name() -> PathBuf {
    (1u32..)
        .map(|number| PathBuf::from(format!("rover-{number}.mcap")))
        .find(|path| !path.exists())
        .unwrap_or_else(|| PathBuf::from("rover.mcap"))
}
