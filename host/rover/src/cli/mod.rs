//! The command line of `rover`: one file a subcommand.
//!
//! Results go to stdout, progress and explanations to stderr. Exit status: 0 done, 1 failed,
//! 2 wrong usage.

mod arm;
mod calibrate;
mod completions;
mod disarm;
mod drive;
mod emulate;
mod emulated;
mod figures;
mod interrupt;
mod knowledge;
mod learn;
mod man;
mod monitor;
mod narrate;
mod perceive;
mod port;
mod ports;
#[cfg(unix)]
mod pseudo_terminal;
mod record;
mod replay;
mod status;
mod steering;
mod task;
mod test;
mod uf2;
mod values;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// A rover that perceives by growing Turing patterns.
#[derive(Debug, Parser)]
#[command(name = "rover", version, about, max_term_width = 100)]
#[command(after_help = "Start with:  rover learn")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Learn in simulation, from nothing
    Learn(learn::Arguments),
    /// Test what was learned in arenas never met before
    Test(test::Arguments),
    /// Grow a pattern from the four corner values, or one for each line of a table
    Perceive(perceive::Arguments),
    /// Run logged samples through the core once more
    Replay(replay::Arguments),
    /// Boot the firmware on an emulated board and let it drive through an arena
    Emulate(emulate::Arguments),
    /// Draw the paper's figures from logs, and a report with all of them
    Figures(figures::Arguments),
    /// Watch and steer a rover, or watch a log
    Monitor(monitor::Arguments),
    /// Turn the linked firmware into a file for the board's USB drive
    Uf2(uf2::Arguments),
    /// List the rovers that are connected
    Ports(ports::Arguments),
    /// Show a rover's state and what its sensors say
    Status(status::Arguments),
    /// Allow a rover's motors to run
    Arm(arm::Arguments),
    /// Stop a rover's motors and forbid them; acknowledges a fault
    Disarm(disarm::Arguments),
    /// Choose what a rover is to do, and let it
    Task(task::Arguments),
    /// Have a rover make one move
    Drive(drive::Arguments),
    /// Record all that a rover says to a log
    Record(record::Arguments),
    /// Show, copy, give or compare what a rover knows
    Knowledge(knowledge::Arguments),
    /// Tell a rover what you measured of it
    Calibrate(calibrate::Arguments),
    /// Print a script by which a shell completes commands
    Completions(completions::Arguments),
    /// Print a manual page, or write one for every command
    Man(man::Arguments),
}

/// Why a command did not do what it was asked to.
#[derive(Debug)]
pub enum Failure {
    /// What was asked cannot be asked: exit status 2.
    Usage(String),
    /// It could not be done: exit status 1.
    Failed(String),
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match arguments.command {
        Command::Learn(arguments) => learn::run(&arguments),
        Command::Test(arguments) => test::run(&arguments),
        Command::Perceive(arguments) => perceive::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Emulate(arguments) => emulate::run(&arguments),
        Command::Figures(arguments) => figures::run(&arguments),
        Command::Monitor(arguments) => monitor::run(&arguments),
        Command::Uf2(arguments) => uf2::run(&arguments),
        Command::Ports(arguments) => ports::run(&arguments),
        Command::Status(arguments) => status::run(&arguments),
        Command::Arm(arguments) => arm::run(&arguments),
        Command::Disarm(arguments) => disarm::run(&arguments),
        Command::Task(arguments) => task::run(&arguments),
        Command::Drive(arguments) => drive::run(&arguments),
        Command::Record(arguments) => record::run(&arguments),
        Command::Knowledge(arguments) => knowledge::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Man(arguments) => man::run(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Failed(message)) => {
            eprintln!("rover: {message}");
            ExitCode::from(1)
        }
        Err(Failure::Usage(message)) => {
            eprintln!("rover: {message}");
            ExitCode::from(2)
        }
    }
}

/// Writes results to stdout. A reader that has seen enough (`rover ... | head`) is no failure.
fn print(text: &str) -> Result<(), Failure> {
    use std::io::Write;
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Writes a result for machines to stdout.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    print(&text)
}

/// An estimate as text, or a dash.
fn shown(estimate: Option<rover_simulator::experiment::Estimate>, digits: usize) -> String {
    estimate.map_or("-".into(), |e| {
        format!(
            "{:.digits$} [{:.digits$}, {:.digits$}]",
            e.value, e.low, e.high
        )
    })
}

/// Reads a file of parameters; what it leaves out is as in `preset`.
fn read_parameters(
    path: Option<&std::path::Path>,
    preset: rover_shared::parameters::Parameters,
) -> Result<rover_shared::parameters::Parameters, Failure> {
    let Some(path) = path else {
        return Ok(preset);
    };
    let fail =
        |what: &dyn std::fmt::Display| Failure::Failed(format!("{}: {what}", path.display()));
    let text =
        std::fs::read_to_string(path).map_err(|error| fail(&format!("cannot be read: {error}")))?;
    rover_simulator::parameters::overlay(preset, &text).map_err(|error| fail(&error))
}
