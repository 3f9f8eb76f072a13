//! A serial port in use: what the host has to remember of both directions.

use crate::usb::controller::Pid;
use crate::usb::descriptor::SerialPort;
use crate::usb::enumeration::Request;

/// A serial port in use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    pub(super) port: SerialPort,
    pub(super) input: Pipe,
    pub(super) output: Pipe,
    /// DTR as the device was told, if it was.
    pub(super) told: Option<bool>,
    /// DTR as the device has acknowledged it.
    pub(super) dtr: bool,
    /// It is the output's turn, if both directions can go on.
    pub(super) output_next: bool,
}

/// The state of a bulk endpoint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pipe {
    pub(super) pid: Pid,
    pub(super) halt: Halt,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Halt {
    No,
    /// The device has said STALL; it is to be asked to forget that.
    Halted,
    /// It did not.
    ForGood,
}

impl Pipe {
    /// At the start of a connection.
    pub(super) const NEW: Self = Self {
        pid: Pid::Data0,
        halt: Halt::No,
    };
}

impl Connection {
    /// Just begun.
    pub(super) const fn new(port: SerialPort) -> Self {
        Self {
            port,
            input: Pipe::NEW,
            output: Pipe::NEW,
            told: None,
            dtr: false,
            output_next: false,
        }
    }

    /// What to ask the device, if anything.
    pub(super) fn request(&self, dtr: bool) -> Option<Request> {
        let pipes = [
            (self.input, self.port.input.endpoint),
            (self.output, self.port.output.endpoint),
        ];
        let halted = pipes.iter().find(|(pipe, _)| pipe.halt == Halt::Halted);
        if let Some((_, endpoint)) = halted {
            return Some(Request::ClearHalt(endpoint.address()));
        }
        // A port is closed until it is opened: the device need not be told.
        (self.told.unwrap_or(false) != dtr).then_some(Request::SetControlLineState(dtr))
    }
}
