//! `rover emulate`

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time;

use indicatif::{ProgressBar, ProgressStyle};
use rover_shared::time::Duration;
use rover_shared::wire::message::{Report, State};
use serde::Serialize;

use super::emulated::{self, FIRMWARE, SETTLING, read_firmware, rover_in};
use super::interrupt::Interrupt;
use super::steering::{self, Drive, ModeChoice, Steering};
use super::task::TaskChoice;
use super::{Failure, narrate, print, print_json, values};
use emulated_rp2040::defmt::Log;
use emulated_rp2040::elf::Image;
use rover_emulator::emulation::{Emulation, EmulationReport, Meter};
use rover_emulator::port::EmulatedPort;
use rover_emulator::vehicle::{GRAMMAR, POSSIBLE, ScheduledFault};
use rover_link::names;
use rover_link::{Client, LinkError, Received};
use rover_log::files::Replacement;
use rover_log::recorder::{RecordError, Recorder};
use rover_log::recording::{RecordingWriter, Written};

/// How long the board may say nothing while it should be driving: a move takes some 3 s, and one that
/// waits for a sensor ends in a fault after 2.
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
    /// What is to be done
    #[arg(long, value_enum, default_value_t = TaskChoice::Wander)]
    task: TaskChoice,
    /// The direction to follow, in degrees clockwise as compasses have it
    #[arg(long, value_name = "DEG", value_parser = values::compass, allow_hyphen_values = true)]
    direction: Option<rover_shared::units::Microdegrees>,
    /// Whether the rover learns
    #[arg(long, value_enum, default_value_t = ModeChoice::Learn)]
    mode: ModeChoice,
    /// Knowledge to begin with [default: none, as on a new board]
    #[arg(long, value_name = "FILE")]
    knowledge: Option<PathBuf>,
    /// Write what the rover knows in the end
    #[arg(long, value_name = "FILE.rover")]
    save: Option<PathBuf>,
    /// Decides all chance: start, noise, and what the rover draws
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Something that goes wrong, and when; may be given several times
    #[arg(long = "fault", value_name = "AT:WHAT")]
    faults: Vec<ScheduledFault>,
    /// Record what the board says
    #[arg(long, value_name = "FILE.mcap", value_parser = values::log_path)]
    log: Option<PathBuf>,
    /// Seconds of wall-clock time after which the run is given up
    #[arg(long, value_name = "SECONDS", default_value_t = 600)]
    limit: u64,
    /// Only wait for other programs, on a pseudo-terminal, in real time, until Ctrl-C: every command
    /// with --port works on it
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

/// Who listens to the rover.
enum Listener {
    Host(Box<Client>),
    Recorder(Box<Recorder>),
}

impl Listener {
    fn new(
        client: Client,
        rover: &Rc<RefCell<Emulation>>,
        log: Option<&Path>,
    ) -> Result<Self, Failure> {
        let Some(path) = log else {
            return Ok(Self::Host(Box::new(client)));
        };
        let writer = concat!("rover ", env!("CARGO_PKG_VERSION"));
        let log = RecordingWriter::create(path, None, writer, client.epoch())?;
        let truth = emulated::truth(rover);
        let recorder = Recorder::begin(client, Some(truth), log)?;
        Ok(Self::Recorder(Box::new(recorder)))
    }

    fn client(&mut self) -> &mut Client {
        match self {
            Self::Host(client) => client,
            Self::Recorder(recorder) => recorder.client(),
        }
    }

    fn next(&mut self, patience: Duration) -> Result<Option<Received>, RecordError> {
        match self {
            Self::Host(client) => Ok(client.next(patience)?),
            Self::Recorder(recorder) => recorder.next(patience),
        }
    }

    fn reconnect(
        &mut self,
        why: &LinkError,
        give_up: &dyn Fn() -> bool,
    ) -> Result<(), RecordError> {
        match self {
            Self::Host(client) => Ok(client.reconnect(steering::PATIENCE, give_up)?),
            Self::Recorder(recorder) => recorder.reconnect(why, steering::PATIENCE, give_up),
        }
    }

    fn finish(self, hear: impl FnMut(&Received)) -> Result<Option<Written>, Failure> {
        match self {
            Self::Host(_) => Ok(None),
            Self::Recorder(recorder) => Ok(Some(recorder.finish(hear)?)),
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.direction.is_some() && arguments.task != TaskChoice::Follow {
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
    eprintln!("rover: {}", narrate::hello(client.hello()));
    if let Some(path) = &arguments.knowledge {
        let loaded = rover_log::knowledge::load(path)?;
        let bytes = rover_log::knowledge::to_bytes(&loaded.known, loaded.coefficients.parameters());
        client.push_knowledge(&bytes, |_, _| {})?;
    }
    let steering = Steering {
        task: Some(arguments.task.task()),
        direction: arguments.direction,
        seed: Some(arguments.seed),
        arm: true,
        mode: Some(arguments.mode),
    };
    client.wait(SETTLING)?;
    let mut listener = Listener::new(client, &rover, arguments.log.as_deref())?;
    steering.begin(listener.client())?;
    let mut drive = Drive::default();
    let driven = watch(
        arguments,
        &rover,
        &mut listener,
        &interrupt,
        began,
        &mut drive,
    );
    // Whatever happened: the motors off, then the file whole.
    let stopped = steering::stop(listener.client());
    let saved = match place {
        Some(place) if stopped.is_ok() => save(listener.client(), place),
        _ => Ok(()),
    };
    let log = listener.finish(|received| drive.hear(received));
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
    if arguments.json {
        print_json(&outcome)?;
    } else {
        print(&text(&outcome))?;
    }
    ended
}

fn save(client: &mut Client, place: Replacement) -> Result<(), Failure> {
    let bytes = client.pull_knowledge(|_, _| {})?;
    Ok(place.complete(&bytes)?)
}

/// Faults that were asked for and never came about, so that nobody thinks that the rover stood them.
fn tell_outstanding(rover: &Emulation) {
    for fault in rover.outstanding() {
        eprintln!("rover: the run ended before this fault came about: {fault}");
    }
}

/// Lets other programs have the rover.
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
    listener: &mut Listener,
    interrupt: &Interrupt,
    began: time::Instant,
    drive: &mut Drive,
) -> Result<(), Failure> {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} actions  {msg}")?;
    let bar = ProgressBar::new(arguments.steps.into()).with_style(style);
    let mut log = firmware_log(arguments)?;
    let mut heard = listener.client().now();
    while drive.actions < arguments.steps.into() {
        if interrupt.is_set() {
            drive.ended = Some(steering::Ended::Interrupted);
            break;
        }
        if let Some(log) = &mut log {
            for line in log.lines(rover.borrow_mut().machine_mut()) {
                bar.suspend(|| eprintln!("board: {line}"));
            }
        }
        let wall = began.elapsed();
        if wall.as_secs() >= arguments.limit {
            return Err(given_up(&rover.borrow(), drive, arguments.limit));
        }
        let received = match listener.next(SLICE) {
            Ok(Some(received)) => received,
            Ok(None) if listener.client().now().since(heard) < SILENCE => continue,
            Ok(None) => return Err(silent(&rover.borrow())),
            Err(RecordError::Link(error @ LinkError::Port(_))) => {
                bar.suspend(|| eprintln!("rover: {error}; waiting for it"));
                let back = listener.reconnect(&error, &|| interrupt.is_set());
                back.map_err(|_| gone(&rover.borrow()))?;
                match listener.client().status()?.state {
                    State::Driving(_) => continue,
                    state => {
                        drive.ended = Some(steering::Ended::ByRover(state));
                        break;
                    }
                }
            }
            Err(error) => return Err(error.into()),
        };
        heard = listener.client().now();
        drive.hear(&received);
        bar.set_position(drive.actions);
        let emulated = rover.borrow().now().0 as f64 / 1e6;
        bar.set_message(format!(
            "{:.0} times real time",
            emulated / wall.as_secs_f64().max(0.001)
        ));
        if let Some(line) = narrate::line(&received.report) {
            bar.suspend(|| eprintln!("rover: {line}"));
        }
        if let Some(state) = stopped(&received.report) {
            drive.ended = Some(steering::Ended::ByRover(state));
            break;
        }
    }
    bar.finish_and_clear();
    drive.lost_frames = listener.client().counters().lost;
    Ok(())
}

/// The firmware's log, if it is to be shown.
fn firmware_log(arguments: &Arguments) -> Result<Option<Log>, Failure> {
    if !arguments.verbose {
        return Ok(None);
    }
    let elf = std::fs::read(&arguments.elf)?;
    let log = Log::new(&elf, &Image::parse(&elf)?)?;
    log.map(Some).ok_or_else(|| {
        Failure::Failed(format!(
            "{}: was built without log lines: cargo fw --features defmt",
            arguments.elf.display()
        ))
    })
}

/// How long to listen before interrupts and the limit are looked at.
const SLICE: Duration = Duration::from_millis(1_000);

/// The state in which the rover does not drive any more, if it says so.
fn stopped(report: &Report) -> Option<State> {
    use rover_shared::wire::message::{Event, EventKind};
    match report {
        Report::Event(Event {
            kind: EventKind::State(state @ (State::Disarmed | State::Faulted(_))),
            ..
        }) => Some(*state),
        _ => None,
    }
}

fn gone(rover: &Emulation) -> Failure {
    Failure::Failed(format!(
        "the emulated board left the cable and did not come back within {} s; {}",
        steering::PATIENCE.0 / 1_000_000,
        rover.whereabouts()
    ))
}

fn silent(rover: &Emulation) -> Failure {
    Failure::Failed(format!(
        "the emulated board has said nothing for {} s while it should be driving; {}",
        SILENCE.0 / 1_000_000,
        rover.whereabouts()
    ))
}

fn given_up(rover: &Emulation, drive: &Drive, limit: u64) -> Failure {
    Failure::Failed(format!(
        "given up after {limit} s of wall-clock time, {:.1} emulated seconds and {} actions; {}; \
         --limit SECONDS allows more",
        rover.now().0 as f64 / 1e6,
        drive.actions,
        rover.whereabouts()
    ))
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
    let ended = match drive.ended {
        Some(steering::Ended::ByRover(state)) => format!("; then {}", names::state(state)),
        Some(steering::Ended::Interrupted) => "; then interrupted".into(),
        Some(steering::Ended::Time) | None => String::new(),
    };
    let mut text = format!(
        "{}{ended}\n{emulated_seconds:.1} s emulated in {wall_seconds:.1} s, {times_real_time:.0} times \
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
