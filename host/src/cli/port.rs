//! Which rover is meant, for all commands that talk to one.

use super::Failure;
use crate::link::serial::SerialPort;
use crate::link::{Client, Port};

#[derive(Debug, clap::Args)]
pub struct PortArguments {
    /// The rover's port, if it is not to be found by itself: any serial port or pseudo-terminal
    #[arg(long, value_name = "PATH")]
    port: Option<String>,
}

impl PortArguments {
    /// The port, opened.
    pub fn open(&self) -> Result<Box<dyn Port>, Failure> {
        Ok(Box::new(match &self.port {
            Some(path) => SerialPort::at(path)?,
            None => SerialPort::of_only_rover()?,
        }))
    }

    /// The rover there, introduced.
    pub fn connect(&self) -> Result<Client, Failure> {
        Ok(Client::open(self.open()?)?)
    }
}
