//! `rover record`

use std::path::PathBuf;

use indicatif::ProgressBar;
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::Report;
use serde::Serialize;

use super::interrupt::Interrupt;
use super::port::PortArguments;
use super::steering::{self, Drive, Ended, ModeChoice, PATIENCE, Steering};
use super::task::TaskChoice;
use super::{Failure, narrate, print, print_json, values};
use rover_link::LinkError;
use rover_log::recorder::{RecordError, Recorder};
use rover_log::recording::{RecordingWriter, Written};

/// How often interrupts are looked at.
const SLICE: Duration = Duration::from_millis(100);

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  rover record                                            what the rover does, until Ctrl-C
  rover record --arm --mode learn --task wander --for 1h  have it learn for an hour, then disarm
  rover replay rover-1.mcap --verify                      the recording through the core again")]
pub struct Arguments {
    /// Where to write it; never over another file [default: rover-1.mcap, or the next number]
    #[arg(long, value_name = "FILE.mcap", value_parser = values::log_path)]
    out: Option<PathBuf>,
    /// Begin another file, FILE-2.mcap and so on, when one has this size
    #[arg(long, value_name = "SIZE", value_parser = values::size)]
    rotate: Option<u64>,
    /// End after this time
    #[arg(long = "for", value_name = "TIME", value_parser = values::duration)]
    span: Option<Duration>,
    /// Choose the task first
    #[arg(long, value_enum)]
    task: Option<TaskChoice>,
    /// Choose the direction to follow first, in degrees clockwise as compasses have it
    #[arg(long, value_name = "DEG", value_parser = values::compass, allow_hyphen_values = true)]
    direction: Option<Microdegrees>,
    /// Choose the seed of the session first
    #[arg(long)]
    seed: Option<u64>,
    /// Arm first, and disarm in the end
    #[arg(long)]
    arm: bool,
    /// Let the controller drive, and disarm in the end
    #[arg(long, value_enum)]
    mode: Option<ModeChoice>,
    #[command(flatten)]
    port: PortArguments,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    #[serde(flatten)]
    written: Written,
    drive: Drive,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (client, truth) = arguments.port.connect_with_truth()?;
    let path = arguments.out.clone().unwrap_or_else(free_name);
    let writer = concat!("rover ", env!("CARGO_PKG_VERSION"));
    let log = RecordingWriter::create(&path, arguments.rotate, writer, client.epoch())?;
    let interrupt = Interrupt::listen()?;
    eprintln!(
        "rover: recording to {}; Ctrl-C ends it{}",
        path.display(),
        if arguments.steers() {
            " and disarms"
        } else {
            ""
        }
    );
    let mut recorder = Recorder::begin(client, truth, log)?;
    let steering = Steering {
        task: arguments.task.map(TaskChoice::task),
        direction: arguments.direction,
        seed: arguments.seed,
        arm: arguments.arm,
        mode: arguments.mode,
    };
    let begun = steering.begin(recorder.client());
    let nothing_done = begun.is_err();
    let mut heard = match begun {
        Ok(()) => record(&mut recorder, &interrupt, arguments.span),
        Err(error) => Err(error.into()),
    };
    // Disarmed first, whatever happened; then the file.
    let stopped = if arguments.steers() {
        steering::stop(recorder.client())
    } else {
        Ok(())
    };
    let written = recorder.finish(|received| {
        if let Ok(drive) = &mut heard {
            drive.hear(received);
            drive.lost_frames += u64::from(received.lost);
        }
    });
    // A rover that may still drive is told of before anything else.
    stopped?;
    if nothing_done {
        // A recording of a refusal is of no use, and would be in the way of the next try.
        for file in written.iter().flat_map(|written| &written.files) {
            let _ = std::fs::remove_file(file);
        }
    }
    let (drive, written) = (heard?, written?);
    tell(arguments, &Answer { written, drive })
}

impl Arguments {
    fn steers(&self) -> bool {
        self.arm || self.mode.is_some()
    }
}

fn record(
    recorder: &mut Recorder,
    interrupt: &Interrupt,
    span: Option<Duration>,
) -> Result<Drive, Failure> {
    let until = span.map(|span| recorder.client().now().after(span));
    let lost = recorder.client().counters().lost;
    let bar = ProgressBar::new_spinner();
    let mut drive = Drive::default();
    drive.ended = Some(loop {
        if interrupt.is_set() {
            break Ended::Interrupted;
        }
        if until.is_some_and(|until| recorder.client().now() >= until) {
            break Ended::Time;
        }
        match recorder.next(SLICE) {
            Ok(Some(received)) => {
                drive.hear(&received);
                if let Some(line) = narrate::line(&received.report) {
                    bar.suspend(|| eprintln!("rover: {line}"));
                }
                if let Report::Action(_) = received.report {
                    drive.lost_frames = recorder.client().counters().lost - lost;
                    bar.set_message(drive.line());
                    bar.tick();
                }
            }
            Ok(None) => {}
            Err(RecordError::Link(error @ LinkError::Port(_))) => {
                bar.suspend(|| eprintln!("rover: {error}; waiting for it"));
                match recorder.reconnect(&error, PATIENCE, &|| interrupt.is_set()) {
                    Ok(()) => bar.suspend(|| eprintln!("rover: connected again")),
                    Err(_) if interrupt.is_set() => break Ended::Interrupted,
                    Err(error) => return Err(error.into()),
                }
            }
            Err(error) => return Err(error.into()),
        }
    });
    bar.finish_and_clear();
    drive.lost_frames = recorder.client().counters().lost - lost;
    Ok(drive)
}

fn tell(arguments: &Arguments, answer: &Answer) -> Result<(), Failure> {
    if arguments.json {
        return print_json(answer);
    }
    let files: Vec<_> = answer
        .written
        .files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    print(&format!(
        "{}\n{} messages in {}\n",
        answer.drive.line(),
        answer.written.messages,
        files.join(" ")
    ))?;
    eprintln!("rover: next:  rover replay {} --verify", files.join(" "));
    Ok(())
}

/// The first of `rover-1.mcap`, `rover-2.mcap` and so on that does not exist.
fn free_name() -> PathBuf {
    (1u32..)
        .map(|number| PathBuf::from(format!("rover-{number}.mcap")))
        .find(|path| !path.exists())
        .unwrap_or_else(|| PathBuf::from("rover.mcap"))
}
