//! `rover knowledge`

use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use rover_shared::checksum::fingerprint;
use rover_shared::parameters::Parameters;
use rover_shared::wire::message::Command;
use serde_json::json;

use super::port::PortAndFormat;
use super::{Failure, print, print_json};
use rover_link::Client;
use rover_log::files::write_whole;
use rover_log::knowledge::difference::Difference;
use rover_log::knowledge::summary::{Summary, describe};
use rover_log::knowledge::{FileError, from_bytes};
use rover_simulator::experiment::Known;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Show what the rover knows, or a file of knowledge holds
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
    /// Give the rover the knowledge of a file; it has to be disarmed
    Push {
        /// What it is to know
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
    /// Have the rover write what it learned to its flash; it does so by itself when disarmed
    Store {
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Have the rover forget everything; its flash keeps the old until something is learned
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
    fn summary(&self) -> Summary {
        Summary::new(&self.known, &self.bytes)
    }
}

fn read(file: &Path) -> Result<Held, Failure> {
    let path = file.display().to_string();
    let bytes = std::fs::read(file).map_err(|error| FileError::Io {
        path: path.clone(),
        error,
    })?;
    let (known, parameters) =
        from_bytes(&bytes).map_err(|error| FileError::Knowledge { path, error })?;
    Ok(Held {
        bytes,
        known,
        parameters,
    })
}

fn of_rover(common: &PortAndFormat) -> Result<Held, Failure> {
    let bytes = pull_with_progress(&mut common.port.connect()?)?;
    let (known, parameters) = from_bytes(&bytes).map_err(|error| {
        Failure::Failed(format!("what the rover knows cannot be read: {error}"))
    })?;
    Ok(Held {
        bytes,
        known,
        parameters,
    })
}

fn pull_with_progress(client: &mut Client) -> Result<Vec<u8>, Failure> {
    let bar = bar();
    let bytes = client.pull_knowledge(|done, total| {
        bar.set_length(total.into());
        bar.set_position(done.into());
    })?;
    bar.finish_and_clear();
    Ok(bytes)
}

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {bytes} of {total_bytes}");
    ProgressBar::new(1).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn show(file: Option<&Path>, common: &PortAndFormat) -> Result<(), Failure> {
    let held = match file {
        Some(file) => read(file)?,
        None => of_rover(common)?,
    };
    if common.json {
        return print_json(&held.summary());
    }
    print(&describe(&held.known, &held.bytes, &held.parameters))
}

fn pull(file: &Path, common: &PortAndFormat) -> Result<(), Failure> {
    let held = of_rover(common)?;
    write_whole(file, &held.bytes)?;
    let print_of = fingerprint(&held.bytes);
    if common.json {
        let file = file.display().to_string();
        return print_json(&json!({
            "file": file, "bytes": held.bytes.len(), "fingerprint": format!("{print_of:08x}"),
        }));
    }
    print(&format!(
        "{}: knowledge {print_of:08x}, {} bytes\n",
        file.display(),
        held.bytes.len()
    ))
}

fn push(file: &Path, common: &PortAndFormat) -> Result<(), Failure> {
    // A file that is no knowledge is found out before the rover is troubled.
    let held = read(file)?;
    let mut client = common.port.connect()?;
    let bar = bar();
    client.push_knowledge(&held.bytes, |done, total| {
        bar.set_length(total.into());
        bar.set_position(done.into());
    })?;
    bar.finish_and_clear();
    let print_of = fingerprint(&held.bytes);
    if common.json {
        return print_json(&json!({
            "bytes": held.bytes.len(),
            "fingerprint": format!("{print_of:08x}"),
            "verified": true,
        }));
    }
    print(&format!(
        "the rover knows {print_of:08x} now: stored in its flash, read back and compared\n"
    ))
}

fn diff(first: &Path, second: Option<&Path>, common: &PortAndFormat) -> Result<(), Failure> {
    let first = read(first)?;
    let second = match second {
        Some(file) => read(file)?,
        None => of_rover(common)?,
    };
    let same = first.parameters == second.parameters;
    let difference = Difference::between(&first.summary(), &second.summary(), same);
    if common.json {
        return print_json(&difference);
    }
    print(&difference.to_string())
}

fn order(common: &PortAndFormat, command: &Command, done: &str) -> Result<(), Failure> {
    common.port.connect()?.ask(command)?;
    if common.json {
        return print_json(&json!({ "done": true }));
    }
    print(&format!("the rover's knowledge {done}\n"))
}
