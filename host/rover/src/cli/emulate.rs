//! `rover emulate`

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time;

use emulated_rp2040::defmt::Log;
use emulated_rp2040::elf::Image;
use indicatif::{ProgressBar, ProgressStyle};
use rover_emulator::EmulatedPort;
use rover_emulator::vehicle::{GRAMMAR, POSSIBLE, ScheduledFault};
use rover_emulator::{Emulation, EmulationReport, Meter};
use rover_link::Client;
use rover_log::files::Replacement;
use rover_log::knowledge;
use rover_log::recording::Written;
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;
use serde::Serialize;

use super::emulated::{self, FIRMWARE, SETTLING, read_firmware, rover_in};
use super::interrupt::Interrupt;
use super::output::{Failure, answer, print};
use super::steering::{self, Drive, DriveMode, RoverTask, Steering};
use super::watch::{Rover, Watch};
use super::{input, parse};
use crate::lines;

/// How long the board may be silent while it should be driving: a move takes some 3 s, and waiting
/// for a sensor ends in a fault after 2.
const SILENCE: Duration = Duration::from_millis(30_000);

#[derive(Debug, clap::Args)]
#[command(after_help = format!("Faults: {GRAMMAR}: {POSSIBLE}.

Examples:
  cargo fw && rover emulate                          500 actions of learning in a room of 5 m
  rover emulate --task follow --direction 90 --mode run --knowledge out/direction/knowledge.rover
  rover emulate --fault 20+3:compass-silent --fault \"action 60:ir left open\""))]
pub struct Arguments {
    /// The firmware
    #[arg(long, value_name = "FILE", default_value = FIRMWARE)]
    elf: PathBuf,
    /// rover-5m, rover, or a file (.toml, or a ROS map's .yaml)
    #[arg(long, value_name = "FILE|NAME", default_value = "rover-5m")]
    arena: String,
    /// Actions to drive
    #[arg(long, value_name = "N", default_value_t = 500)]
    steps: u32,
    /// The rover's task
    #[arg(long, value_enum, default_value_t = RoverTask::Wander)]
    task: RoverTask,
    /// The direction to follow, in degrees clockwise as compasses have it
    #[arg(long, value_name = "DEG", value_parser = parse::compass, allow_hyphen_values = true)]
    direction: Option<Microdegrees>,
    /// Whether the rover learns
    #[arg(long, value_enum, default_value_t = DriveMode::Learn)]
    mode: DriveMode,
    /// Knowledge to start with [default: none, as on a new board]
    #[arg(long, value_name = "FILE")]
    knowledge: Option<PathBuf>,
    /// Write the rover's knowledge at the end
    #[arg(long, value_name = "FILE.rover")]
    save: Option<PathBuf>,
    /// Seed of all random numbers: start, noise, and what the rover draws
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A fault, and when it begins; may be repeated
    #[arg(long = "fault", value_name = "AT:WHAT")]
    faults: Vec<ScheduledFault>,
    /// Record the board's reports
    #[arg(long, value_name = "FILE.mcap", value_parser = parse::log_path)]
    log: Option<PathBuf>,
    /// Seconds of wall-clock time after which the run is aborted
    #[arg(long, value_name = "SECONDS", default_value_t = 600)]
    limit: u64,
    /// Serve the board to other programs on a pseudo-terminal, in real time, until Ctrl-C: every
    /// command with --port works on it
    #[arg(long, conflicts_with_all = ["log", "report", "json", "knowledge", "save"])]
    pty: bool,
    /// Show the firmware's own log lines, if it was built with them (cargo fw --features defmt)
    #[arg(short, long)]
    verbose: bool,
    /// Measure times, load and sizes; slower
    #[arg(long)]
    report: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What the command prints for machines.
#[derive(Serialize)]
struct Outcome {
    drive: Drive,
    emulated_seconds: f64,
    wall_seconds: f64,
    /// Emulated time over wall-clock time.
    times_real_time: f64,
    /// Resets, hard faults and power cuts of the board.
    incidents: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    log: Option<Written>,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<EmulationReport>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.direction.is_some() && arguments.task != RoverTask::Follow {
        let text = "--direction is for --task follow: wandering draws its own directions";
        return Err(Failure::Usage(text.into()));
    }
    let image = read_firmware(&arguments.elf)?;
    let place = arguments
        .save
        .as_deref()
        .map(Replacement::new)
        .transpose()?;
    let rover = rover_in(&image, &arguments.arena, &arguments.faults, arguments.seed)?;
    let rover = Rc::new(RefCell::new(rover));
    let meter = arguments
        .report
        .then(|| Meter::new(&mut rover.borrow_mut(), &image))
        .transpose()?;
    let interrupt = Interrupt::listen()?;
    if arguments.pty {
        return serve(&mut rover.borrow_mut(), &interrupt);
    }
    let began = time::Instant::now();
    let mut client = Client::open(Box::new(EmulatedPort::open(Rc::clone(&rover))?))?;
    eprintln!("rover: {}", lines::hello(client.hello()));
    if let Some(path) = &arguments.knowledge {
        let loaded = knowledge::load(path)?;
        let bytes = knowledge::to_bytes(&loaded.known, loaded.coefficients.parameters());
        client.push_knowledge(&bytes, |_, _| {})?;
    }
    client.wait(SETTLING)?;
    let mut watched = match &arguments.log {
        Some(path) => Rover::recorded(client, Some(emulated::truth(&rover)), path, None)?,
        None => Rover::Client(Box::new(client)),
    };
    let steering = Steering {
        task: Some(arguments.task),
        direction: arguments.direction,
        seed: Some(arguments.seed),
        arm: true,
        mode: Some(arguments.mode),
    };
    steering.begin(watched.client())?;
    let mut drive = Drive::default();
    let driven = watch(
        arguments,
        &rover,
        &mut watched,
        &interrupt,
        began,
        &mut drive,
    );
    // Whatever happened: the motors off, then the file whole.
    let stopped = steering::stop(watched.client());
    let saved = match place {
        Some(place) if stopped.is_ok() => save(watched.client(), place),
        _ => Ok(()),
    };
    let log = watched.finish(&mut drive);
    tell_outstanding(&rover.borrow());
    let ended = driven.and(stopped).and(saved);
    let log = match (log, &ended) {
        (Ok(log), _) => log,
        (Err(error), Ok(())) => return Err(error),
        (Err(_), Err(_)) => None,
    };
    let emulated_seconds = rover.borrow().now().0 as f64 / 1e6;
    let wall_seconds = began.elapsed().as_secs_f64();
    let outcome = Outcome {
        drive,
        emulated_seconds,
        wall_seconds,
        times_real_time: emulated_seconds / wall_seconds,
        incidents: rover.borrow().machine().incidents().count(),
        log,
        report: meter.map(|meter| meter.report(&rover.borrow())),
    };
    answer(arguments.json, &outcome, text(&outcome))?;
    ended
}

fn save(client: &mut Client, place: Replacement) -> Result<(), Failure> {
    let bytes = client.pull_knowledge(|_, _| {})?;
    Ok(place.complete(&bytes)?)
}

/// Names the faults that never came about: the rover was not tested with them.
fn tell_outstanding(rover: &Emulation) {
    for fault in rover.outstanding() {
        eprintln!("rover: the run ended before this fault came about: {fault}");
    }
}

/// Serves the rover to other programs.
#[cfg(unix)]
fn serve(rover: &mut Emulation, interrupt: &Interrupt) -> Result<(), Failure> {
    use super::pseudo_terminal::PseudoTerminal;
    /// How often bytes are carried.
    const EVERY: Duration = Duration::from_millis(5);
    let mut terminal = PseudoTerminal::new()?;
    print(&format!("{}\n", terminal.path()))?;
    eprintln!(
        "rover: an emulated rover is there; try, in another terminal:\n  \
         rover monitor --port {}",
        terminal.path()
    );
    let began = time::Instant::now();
    let start = rover.now();
    while !interrupt.is_set() {
        rover.run(EVERY);
        terminal.carry(rover);
        let emulated = time::Duration::from_micros(rover.now().since(start).0);
        if let Some(ahead) = emulated.checked_sub(began.elapsed()) {
            std::thread::sleep(ahead);
        }
    }
    Ok(())
}

#[cfg(not(unix))]
fn serve(_: &mut Emulation, _: &Interrupt) -> Result<(), Failure> {
    Err(Failure::Usage(
        "there are no pseudo-terminals on this system: use the commands' own --emulate".into(),
    ))
}

/// Watches the rover until it has done its actions or stopped.
fn watch(
    arguments: &Arguments,
    rover: &RefCell<Emulation>,
    watched: &mut Rover,
    interrupt: &Interrupt,
    began: time::Instant,
    drive: &mut Drive,
) -> Result<(), Failure> {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} actions  {msg}")?;
    let bar = ProgressBar::new(arguments.steps.into()).with_style(style);
    let mut log = firmware_log(arguments)?;
    let watch = Watch {
        interrupt,
        span: None,
        until_stopped: true,
        bar: &bar,
    };
    let driven = watch.run(watched, drive, |drive, silence| {
        let mut rover = rover.borrow_mut();
        let (emulated, wall) = (rover.now().0 as f64 / 1e6, began.elapsed());
        for line in log
            .iter_mut()
            .flat_map(|log| log.lines(rover.machine_mut()))
        {
            bar.suspend(|| eprintln!("board: {line}"));
        }
        bar.set_position(drive.actions);
        let speed = emulated / wall.as_secs_f64().max(0.001);
        bar.set_message(format!("{speed:.0} times real time"));
        let (actions, limit) = (drive.actions, arguments.limit);
        if actions >= arguments.steps.into() {
            return Ok(false);
        }
        if wall.as_secs() >= limit {
            return Err(Failure::Failed(format!(
                "given up after {limit} s of wall-clock time, {emulated:.1} emulated seconds and \
                 {actions} actions (--limit SECONDS allows more)"
            )));
        }
        if silence >= SILENCE {
            return Err(Failure::Failed(format!(
                "the emulated board has sent nothing for {} s while it should be driving",
                SILENCE.0 / 1_000_000
            )));
        }
        Ok(true)
    });
    bar.finish_and_clear();
    driven.map_err(|failure| match failure {
        Failure::Failed(why) => Failure::Failed(format!("{why}; {}", rover.borrow().whereabouts())),
        usage @ Failure::Usage(_) => usage,
    })
}

/// The firmware's log, with `--verbose`.
fn firmware_log(arguments: &Arguments) -> Result<Option<Log>, Failure> {
    if !arguments.verbose {
        return Ok(None);
    }
    let elf = input::read(&arguments.elf)?;
    let log = Log::new(&elf, &Image::parse(&elf)?)?;
    log.map(Some).ok_or_else(|| {
        let what = "was built without log lines: cargo fw --features defmt";
        Failure::of(arguments.elf.display(), what)
    })
}

fn text(outcome: &Outcome) -> String {
    let Outcome {
        drive,
        emulated_seconds,
        wall_seconds,
        times_real_time,
        incidents,
        log,
        report,
    } = outcome;
    let mut text = format!(
        "{}\n{emulated_seconds:.1} s emulated in {wall_seconds:.1} s, {times_real_time:.0} times \
         real time; {incidents} resets, hard faults and power cuts of the board\n",
        drive.line()
    );
    if let Some(log) = log {
        for file in &log.files {
            text.push_str(&format!("recorded in {}\n", file.display()));
        }
    }
    if let Some(report) = report {
        text.push_str(&report.to_string());
    }
    text
}
