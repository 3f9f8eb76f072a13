//! `rover knowledge`

use std::fmt::Display;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use rover_shared::checksum::fingerprint;
use rover_shared::parameters::Parameters;
use rover_shared::wire::message::Command;
use serde_json::json;

use super::input;
use super::output::Failure;
use super::port::PortAndFormat;
use rover_log::files::write_whole;
use rover_log::knowledge::difference::Difference;
use rover_log::knowledge::from_bytes;
use rover_log::knowledge::summary::{Summary, describe};
use rover_simulator::experiment::Known;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Show the rover's knowledge, or a file's
    Show {
        /// A file instead of the rover
        file: Option<PathBuf>,
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Copy the rover's knowledge into a file
    Pull {
        /// Where to write it
        file: PathBuf,
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Send a file's knowledge to the rover, which has to be disarmed
    Push {
        /// The knowledge to send
        file: PathBuf,
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Compare a file with another, or with the rover
    Diff {
        /// The first
        first: PathBuf,
        /// The second [default: the rover]
        second: Option<PathBuf>,
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Write the rover's knowledge to its flash; it does so by itself when disarmed
    Store {
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Empty the rover's knowledge; its flash keeps the old until something is learned
    New {
        #[command(flatten)]
        common: PortAndFormat,
    },
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.action {
        Action::Show { file, common } => show(file.as_deref(), common),
        Action::Pull { file, common } => pull(file, common),
        Action::Push { file, common } => push(file, common),
        Action::Diff {
            first,
            second,
            common,
        } => diff(first, second.as_deref(), common),
        Action::Store { common } => order(common, &Command::StoreKnowledge, "is being stored"),
        Action::New { common } => order(common, &Command::NewKnowledge, "is empty now"),
    }
}

/// Knowledge with the bytes it came in.
struct Held {
    bytes: Vec<u8>,
    known: Box<Known>,
    parameters: Parameters,
}

impl Held {
    /// Knowledge from the file, or whatever else, of this name.
    fn new(bytes: Vec<u8>, name: &dyn Display) -> Result<Self, Failure> {
        let (known, parameters) = from_bytes(&bytes).map_err(|error| Failure::of(name, error))?;
        Ok(Self {
            bytes,
            known,
            parameters,
        })
    }

    fn read(file: &Path) -> Result<Self, Failure> {
        Self::new(input::read(file)?, &file.display())
    }

    fn of_rover(common: &PortAndFormat) -> Result<Self, Failure> {
        let mut client = common.port.connect()?;
        let bytes = with_bar(|progress| client.pull_knowledge(progress))?;
        Self::new(bytes, &"the rover's knowledge")
    }

    fn summary(&self) -> Summary {
        Summary::new(&self.known, &self.bytes)
    }
}

/// A transfer with a progress bar: bytes done, and all of them.
fn with_bar<T, E>(transfer: impl FnOnce(&mut dyn FnMut(u32, u32)) -> Result<T, E>) -> Result<T, E> {
    let style = ProgressStyle::with_template("{bar:40} {bytes} of {total_bytes}");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(1).with_style(style);
    let done = transfer(&mut |done, total| {
        bar.set_length(total.into());
        bar.set_position(done.into());
    })?;
    bar.finish_and_clear();
    Ok(done)
}

fn show(file: Option<&Path>, common: &PortAndFormat) -> Result<(), Failure> {
    let held = match file {
        Some(file) => Held::read(file)?,
        None => Held::of_rover(common)?,
    };
    let text = describe(&held.known, &held.bytes, &held.parameters);
    common.answer(&held.summary(), text)
}

fn pull(file: &Path, common: &PortAndFormat) -> Result<(), Failure> {
    let held = Held::of_rover(common)?;
    write_whole(file, &held.bytes)?;
    let (file, length) = (file.display().to_string(), held.bytes.len());
    let print_of = format!("{:08x}", fingerprint(&held.bytes));
    let value = json!({ "file": file, "bytes": length, "fingerprint": print_of });
    common.answer(
        &value,
        format_args!("{file}: knowledge {print_of}, {length} bytes"),
    )
}

fn push(file: &Path, common: &PortAndFormat) -> Result<(), Failure> {
    // A file that holds no knowledge is refused before the rover is asked.
    let held = Held::read(file)?;
    let mut client = common.port.connect()?;
    with_bar(|progress| client.push_knowledge(&held.bytes, progress))?;
    let (length, print_of) = (
        held.bytes.len(),
        format!("{:08x}", fingerprint(&held.bytes)),
    );
    let value = json!({ "bytes": length, "fingerprint": print_of, "verified": true });
    let text = format!("the rover has knowledge {print_of}: stored in its flash and read back");
    common.answer(&value, text)
}

fn diff(first: &Path, second: Option<&Path>, common: &PortAndFormat) -> Result<(), Failure> {
    let first = Held::read(first)?;
    let second = match second {
        Some(file) => Held::read(file)?,
        None => Held::of_rover(common)?,
    };
    let same = first.parameters == second.parameters;
    let difference = Difference::between(&first.summary(), &second.summary(), same);
    common.answer(&difference, &difference)
}

fn order(common: &PortAndFormat, command: &Command, done: &str) -> Result<(), Failure> {
    common.port.connect()?.ask(command)?;
    common.answer(
        &json!({ "done": true }),
        format_args!("the rover's knowledge {done}"),
    )
}
