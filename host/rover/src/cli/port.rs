//! Which rover is meant, for all commands that talk to one.

use std::cell::RefCell;
use std::fmt::Display;
use std::path::Path;
use std::rc::Rc;

use serde::Serialize;

use super::emulated::{self, FIRMWARE, SETTLING, read_firmware, rover_in};
use super::output::{self, Failure};
use rover_emulator::EmulatedPort;
use rover_link::serial::SerialPort;
use rover_link::{Client, Port};
use rover_log::recorder::Truth;

/// What an emulation knows beside the rover's own reports; `None` for a real rover.
pub type Surroundings = Option<Box<dyn Truth>>;

#[derive(Debug, clap::Args)]
pub struct PortArguments {
    /// Which rover [default: the only one connected]: its serial number, or any serial port or
    /// pseudo-terminal
    #[arg(long, value_name = "PATH|NUMBER")]
    port: Option<String>,
    /// Use an emulated board in an arena, which lives as long as this command [default: rover-5m]
    #[arg(long, value_name = "ARENA", conflicts_with = "port", num_args = 0..=1,
          require_equals = true, default_missing_value = "rover-5m")]
    emulate: Option<String>,
}

/// Which rover, and how to print the result.
#[derive(Debug, clap::Args)]
pub struct PortAndFormat {
    #[command(flatten)]
    pub port: PortArguments,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

impl PortAndFormat {
    /// Prints a result.
    pub fn answer(&self, value: &impl Serialize, lines: impl Display) -> Result<(), Failure> {
        output::answer(self.json, value, lines)
    }
}

impl PortArguments {
    /// The port, opened.
    pub fn open(&self) -> Result<Box<dyn Port>, Failure> {
        Ok(self.open_with_truth()?.0)
    }

    fn open_with_truth(&self) -> Result<(Box<dyn Port>, Surroundings), Failure> {
        if let Some(arena) = &self.emulate {
            let image = read_firmware(Path::new(FIRMWARE))?;
            let rover = Rc::new(RefCell::new(rover_in(&image, arena, &[], 1)?));
            let port = EmulatedPort::open(Rc::clone(&rover))?;
            return Ok((Box::new(port), Some(emulated::truth(&rover))));
        }
        let port = match &self.port {
            Some(name) => SerialPort::named(name)?,
            None => SerialPort::of_only_rover()?,
        };
        Ok((Box::new(port), None))
    }

    /// A client that has exchanged hellos with the rover.
    pub fn connect(&self) -> Result<Client, Failure> {
        Ok(self.connect_with_truth()?.0)
    }

    /// The same, and for an emulated rover what its surroundings know.
    pub fn connect_with_truth(&self) -> Result<(Client, Surroundings), Failure> {
        let (port, truth) = self.open_with_truth()?;
        let mut client = Client::open(port)?;
        if self.emulate.is_some() {
            client.wait(SETTLING)?;
        }
        Ok((client, truth))
    }
}
