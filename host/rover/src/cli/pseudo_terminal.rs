//! A pseudo-terminal that serves an emulated rover as a serial port does a real one.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::time::Duration;

use serialport::{SerialPort as _, TTYPort};

use rover_emulator::Emulation;

/// How long a host that has the port open may read nothing. Then bytes are lost, as on a cable with
/// a slow host, and the frames' numbers have gaps.
const PATIENCE: Duration = Duration::from_millis(20);
/// Bytes carried at a time.
const CHUNK: usize = 4_096;

/// A pseudo-terminal.
pub struct PseudoTerminal {
    port: TTYPort,
    path: String,
    /// A program has the other end open.
    open: bool,
}

impl PseudoTerminal {
    /// A new one, not open yet.
    ///
    /// # Errors
    /// The system has none.
    pub fn new() -> io::Result<Self> {
        let (mut port, other) = TTYPort::pair()?;
        port.set_timeout(PATIENCE)?;
        let path = other.name().ok_or(ErrorKind::NotFound)?;
        Ok(Self {
            port,
            path,
            open: false,
        })
    }

    /// The path of the other end.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Carries waiting bytes both ways.
    pub fn carry(&mut self, rover: &mut Emulation) {
        self.port_to_rover(rover);
        self.rover_to_port(rover);
    }

    fn port_to_rover(&mut self, rover: &mut Emulation) {
        let mut buffer = [0; CHUNK];
        match self.read(&mut buffer) {
            Ok(length) => {
                self.set_open(rover, true);
                rover.send(&buffer[..length]);
            }
            // The other end is closed: only reading tells.
            Err(_) => self.set_open(rover, false),
        }
    }

    /// Reads what is there, without waiting.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.port.set_timeout(Duration::ZERO)?;
        let read = self.port.read(buffer);
        self.port.set_timeout(PATIENCE)?;
        match read {
            Err(error) if error.kind() == ErrorKind::TimedOut => Ok(0),
            read => read,
        }
    }

    fn set_open(&mut self, rover: &mut Emulation, open: bool) {
        // A board that was reset has to be told again.
        if self.open != open || (open && rover.port_exists() && !rover.is_open()) {
            self.open = open;
            rover.set_open(open);
        }
    }

    fn rover_to_port(&mut self, rover: &mut Emulation) {
        let mut buffer = [0; CHUNK];
        loop {
            let length = rover.receive(&mut buffer);
            if length == 0 || !self.open {
                return;
            }
            // What is not read in time is lost.
            if self.port.write_all(&buffer[..length]).is_err() {
                return;
            }
        }
    }
}
