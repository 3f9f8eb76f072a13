//! Which rover is meant, for all commands that talk to one.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use rover_shared::time::Duration;

use super::{Failure, emulate};
use crate::link::emulated::EmulatedPort;
use crate::link::serial::SerialPort;
use crate::link::{Client, Port};

/// How long an emulated rover's sensors take to be believed, without which arming is refused.
const SETTLING: Duration = Duration::from_millis(1_000);

#[derive(Debug, clap::Args)]
pub struct PortArguments {
    /// Which rover, if it is not to be found by itself: its serial number, or any serial port or
    /// pseudo-terminal
    #[arg(long, value_name = "PATH|NUMBER")]
    port: Option<String>,
    /// Use an emulated board in an arena, which lives as long as this command [default: rover-5m]
    #[arg(long, value_name = "ARENA", conflicts_with = "port", num_args = 0..=1,
          require_equals = true, default_missing_value = "rover-5m")]
    emulate: Option<String>,
}

/// Which rover, and how to print what it says: what the subcommands of one command share.
#[derive(Debug, clap::Args)]
pub struct PortAndFormat {
    #[command(flatten)]
    pub port: PortArguments,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

impl PortArguments {
    /// The port, opened.
    pub fn open(&self) -> Result<Box<dyn Port>, Failure> {
        if let Some(arena) = &self.emulate {
            return emulated(arena);
        }
        Ok(Box::new(match &self.port {
            Some(name) => SerialPort::named(name)?,
            None => SerialPort::of_only_rover()?,
        }))
    }

    /// The rover there, introduced.
    pub fn connect(&self) -> Result<Client, Failure> {
        let mut client = Client::open(self.open()?)?;
        if self.emulate.is_some() {
            client.wait(SETTLING)?;
        }
        Ok(client)
    }
}

fn emulated(arena: &str) -> Result<Box<dyn Port>, Failure> {
    let image = emulate::read_firmware(Path::new(emulate::FIRMWARE))?;
    let rover = emulate::rover_in(&image, arena, &[], 1)?;
    Ok(Box::new(EmulatedPort::open(Rc::new(RefCell::new(rover)))?))
}
