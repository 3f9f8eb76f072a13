//! The command line of `rover`: one file a subcommand.
//!
//! To add a command:
//! 1. a file with `pub struct Arguments`, which derives `clap::Args` and whose doc comments are the
//!    help, and `pub fn run(arguments: &Arguments) -> Result<(), Failure>`;
//! 2. a `mod` line below;
//! 3. a line in `commands!`: its help in one sentence, its name, its arguments, its function.
//!
//! | file | holds what commands share |
//! |---|---|
//! | `output`, `input`, `parse` | failures and printing; files that are read; values with units |
//! | `port`, `emulated`, `pseudo_terminal` | which rover is meant, a real or an emulated one |
//! | `steering`, `watch`, `interrupt` | setting a rover to work, watching it, Ctrl-C |
//! | `simulated` | tasks of rovers in simulated arenas |
//!
//! Results go to stdout, progress and explanations to stderr. Exit status: 0 done, 1 failed,
//! 2 wrong usage. With `--json` a result is one JSON value. Values of the wire's contract have
//! there the names that logs have (`"Disarmed"`), and in text those of [`rover_link::names`].

mod arm;
mod calibrate;
mod completions;
mod disarm;
mod drive;
mod emulate;
mod emulated;
mod figures;
mod input;
mod interrupt;
mod knowledge;
mod learn;
mod man;
mod monitor;
mod output;
mod parse;
mod perceive;
mod port;
mod ports;
#[cfg(unix)]
mod pseudo_terminal;
mod record;
mod replay;
mod simulated;
mod status;
mod steering;
mod task;
mod test;
mod uf2;
mod watch;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use output::Failure;
use port::PortAndFormat;

/// A rover that perceives by growing Turing patterns.
#[derive(Debug, Parser)]
#[command(name = "rover", version, max_term_width = 100)]
#[command(after_help = "Start with:  rover learn")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

macro_rules! commands {
    ($($(#[$help:meta])* $name:ident($arguments:ty) => $run:path $(, $program:expr)?;)*) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($(#[$help])* $name($arguments),)*
        }

        fn run(command: &Command) -> Result<(), Failure> {
            match command {
                $(Command::$name(arguments) => $run(arguments $(, $program)?),)*
            }
        }
    };
}

commands! {
    /// Learn in simulation, from nothing
    Learn(learn::Arguments) => learn::run;
    /// Test what was learned in arenas never met before
    Test(test::Arguments) => test::run;
    /// Grow a pattern from the four corner values, or one for each line of a table
    Perceive(perceive::Arguments) => perceive::run;
    /// Run logged samples through the core once more
    Replay(replay::Arguments) => replay::run;
    /// Boot the firmware on an emulated board and let it drive through an arena
    Emulate(emulate::Arguments) => emulate::run;
    /// Draw the paper's figures from logs, and a report with all of them
    Figures(figures::Arguments) => figures::run;
    /// Watch and steer a rover, or watch a log
    Monitor(monitor::Arguments) => monitor::run;
    /// Turn the linked firmware into a file for the board's USB drive
    Uf2(uf2::Arguments) => uf2::run;
    /// List the rovers that are connected
    Ports(ports::Arguments) => ports::run;
    /// Show a rover's state and its sensors' readings
    Status(PortAndFormat) => status::run;
    /// Allow a rover's motors to run
    Arm(PortAndFormat) => arm::run;
    /// Stop a rover's motors and forbid them; acknowledges a fault
    Disarm(PortAndFormat) => disarm::run;
    /// Choose a rover's task, and let it drive
    Task(task::Arguments) => task::run;
    /// Have a rover make one move
    Drive(drive::Arguments) => drive::run;
    /// Record all reports of a rover to a log
    Record(record::Arguments) => record::run;
    /// Show, copy, send or compare a rover's knowledge
    Knowledge(knowledge::Arguments) => knowledge::run;
    /// Set what you measured of a rover: compass, speed, range sensors
    Calibrate(calibrate::Arguments) => calibrate::run;
    /// Print a script by which a shell completes commands
    Completions(completions::Arguments) => completions::run, Arguments::command();
    /// Print a manual page, or write one for every command
    Man(man::Arguments) => man::run, Arguments::command();
}

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    let (message, status) = match run(&Arguments::parse().command) {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Failed(message)) => (message, 1),
        Err(Failure::Usage(message)) => (message, 2),
    };
    eprintln!("rover: {message}");
    ExitCode::from(status)
}
