//! The port of an emulated rover. Its time is the board's: it passes while the host waits.

use std::cell::RefCell;
use std::rc::Rc;

use rover_link::{Port, PortError};
use rover_shared::time::{Duration, Instant};

use crate::emulation::{Emulation, SLICE};

/// How long a board has to appear on the bus and to see that its port was opened: starting up and
/// being enumerated take some 0.6 s.
const APPEARS_WITHIN: Duration = Duration::from_millis(3_000);
/// How long the port stays closed before it is opened again, so that the board notices: it looks
/// every 40 ms.
const CLOSED_FOR: Duration = Duration::from_millis(100);
/// How long the board may leave bytes unread.
const TAKEN_WITHIN: Duration = Duration::from_millis(2_000);

/// The port of an emulated rover that its owner holds too.
pub struct EmulatedPort {
    rover: Rc<RefCell<Emulation>>,
    opened: Instant,
}

impl EmulatedPort {
    /// Opens the port of a rover; waits for it to start up.
    ///
    /// # Errors
    /// The board does not appear on the bus.
    pub fn open(rover: Rc<RefCell<Emulation>>) -> Result<Self, PortError> {
        let opened = rover.borrow().now();
        let mut port = Self { rover, opened };
        port.reopen()?;
        Ok(port)
    }

    fn lost(&self, why: &str) -> PortError {
        PortError::Lost(self.name().into(), why.into())
    }
}

impl Port for EmulatedPort {
    fn name(&self) -> &str {
        "emulated board"
    }

    fn now(&self) -> Instant {
        Instant(0).after(self.rover.borrow().now().since(self.opened))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        let mut rover = self.rover.borrow_mut();
        if !rover.connected() {
            return Err(self.lost("the board has left the bus"));
        }
        rover.send(bytes);
        let taken = |rover: &Emulation| rover.unsent() == 0 || !rover.connected();
        if !rover.run_until(TAKEN_WITHIN, taken) {
            return Err(PortError::Stuck(self.name().into()));
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> Result<usize, PortError> {
        let mut rover = self.rover.borrow_mut();
        let until = rover.now().after(patience);
        loop {
            let length = rover.receive(buffer);
            if length > 0 {
                return Ok(length);
            }
            if !rover.connected() {
                return Err(self.lost("the board has left the bus"));
            }
            if rover.now() >= until {
                return Ok(0);
            }
            rover.run(SLICE);
        }
    }

    fn wait(&mut self, span: Duration) {
        self.rover.borrow_mut().run(span);
    }

    fn reopen(&mut self) -> Result<(), PortError> {
        let mut rover = self.rover.borrow_mut();
        rover.set_open(false);
        rover.run(CLOSED_FOR);
        if !rover.run_until(APPEARS_WITHIN, Emulation::port_exists) {
            return Err(PortError::Missing(self.name().into()));
        }
        rover.set_open(true);
        if !rover.run_until(APPEARS_WITHIN, Emulation::connected) {
            return Err(self.lost("the board does not answer on the bus"));
        }
        Ok(())
    }
}
