//! The port of a boardless rover.

use std::cell::RefCell;
use std::rc::Rc;

use rover_link::{Port, PortError};
use rover_shared::rover::PERIOD;
use rover_shared::time::{Duration, Instant};

use crate::rover::BoardlessRover;

const NAME: &str = "boardless";

/// A port to a rover that the test holds too. Time passes while the host waits for bytes.
pub struct BoardlessPort {
    rover: Rc<RefCell<BoardlessRover>>,
    plugged: Rc<RefCell<bool>>,
    open: bool,
}

impl BoardlessPort {
    /// A port to this rover, opened.
    pub fn new(rover: Rc<RefCell<BoardlessRover>>) -> Self {
        rover.borrow_mut().open();
        Self {
            rover,
            plugged: Rc::new(RefCell::new(true)),
            open: true,
        }
    }

    /// The cable: set to false it is unplugged.
    pub fn cable(&self) -> Rc<RefCell<bool>> {
        self.plugged.clone()
    }

    fn check(&mut self) -> Result<(), PortError> {
        if self.open && !*self.plugged.borrow() {
            self.open = false;
            self.rover.borrow_mut().close();
        }
        let lost = || PortError::Lost(NAME.into(), "unplugged".into());
        self.open.then_some(()).ok_or_else(lost)
    }
}

impl Port for BoardlessPort {
    fn name(&self) -> &str {
        NAME
    }

    fn now(&self) -> Instant {
        self.rover.borrow().now()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        self.check()?;
        self.rover.borrow_mut().receive(bytes);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> Result<usize, PortError> {
        let until = self.now().after(patience);
        loop {
            self.check()?;
            let mut rover = self.rover.borrow_mut();
            let length = rover.take_sent(buffer);
            if length > 0 || rover.now() >= until {
                return Ok(length);
            }
            rover.run(PERIOD);
        }
    }

    fn wait(&mut self, span: Duration) {
        self.rover.borrow_mut().run(span);
    }

    fn reopen(&mut self) -> Result<(), PortError> {
        let mut rover = self.rover.borrow_mut();
        rover.close();
        self.open = *self.plugged.borrow();
        if !self.open {
            return Err(PortError::Missing(NAME.into()));
        }
        rover.open();
        Ok(())
    }
}
