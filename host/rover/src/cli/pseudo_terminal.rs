//! A pseudo-terminal at which an emulated rover can be found, as if it were on a serial port.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::time::Duration;

use serialport::{SerialPort as _, TTYPort};

use rover_emulator::Emulation;

/// How long a host that has the port open may take no bytes. Then they are lost, as on a cable whose
/// host is too slow; the gaps of the frames' numbers tell.
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
    /// A new one, which nobody has open.
    ///
    /// # Errors
    /// The system gives none.
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

    /// Carries what has come, both ways.
    pub fn carry(&mut self, rover: &mut Emulation) {
        self.hear(rover);
        self.say(rover);
    }

    fn hear(&mut self, rover: &mut Emulation) {
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

    fn say(&mut self, rover: &mut Emulation) {
        let mut buffer = [0; CHUNK];
        loop {
            let length = rover.receive(&mut buffer);
            if length == 0 || !self.open {
                return;
            }
            // What is not taken in time is lost.
            if self.port.write_all(&buffer[..length]).is_err() {
                return;
            }
        }
    }
}
