//! The two lines of an I2C bus, what can be wrong with them, and the devices on it.

/// A device on the bus, or several of them.
pub trait I2cDevice {
    /// START, also a repeated one, and an address of 7 or 10 bits: whether it is acknowledged.
    fn start(&mut self, address: u16, read: bool) -> bool;

    /// The next byte from the master: whether it is acknowledged.
    fn write(&mut self, byte: u8) -> bool;

    /// The next byte to the master.
    fn read(&mut self) -> u8;

    /// STOP.
    fn stop(&mut self);
}

/// Nobody.
impl I2cDevice for () {
    fn start(&mut self, _address: u16, _read: bool) -> bool {
        false
    }

    fn write(&mut self, _byte: u8) -> bool {
        false
    }

    fn read(&mut self) -> u8 {
        // Nobody pulls the line down.
        0xff
    }

    fn stop(&mut self) {}
}

/// Two levels, of the clock and of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lines {
    /// SCL.
    pub clock: bool,
    /// SDA.
    pub data: bool,
}

impl Lines {
    /// Pulled up by the resistors, and down by nobody.
    pub const HIGH: Self = Self {
        clock: true,
        data: true,
    };
}

/// What is wrong with the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineFault {
    /// Nothing.
    #[default]
    None,
    /// SDA is low for good.
    DataLow,
    /// A device lost count of the clock and holds SDA low until it has seen this many pulses more;
    /// then all is well again.
    DataLowFor {
        /// Pulses of SCL: nine are enough for any device in the middle of a byte.
        pulses: u8,
    },
    /// SCL is low for good.
    ClockLow,
    /// The next device that acknowledges its address then holds SCL low for good.
    Stretch,
}

/// The bus.
#[derive(Clone, Debug)]
pub struct Bus<D> {
    pub device: D,
    fault: LineFault,
    /// A device holds SCL low.
    stretching: bool,
    /// What pins that are not the controller's drive the lines to.
    driven: Lines,
    /// They have let SCL rise: a pulse is over when it falls.
    pulse_begun: bool,
}

impl<D: I2cDevice> Bus<D> {
    pub const fn new(device: D) -> Self {
        Self {
            device,
            fault: LineFault::None,
            stretching: false,
            driven: Lines::HIGH,
            pulse_begun: false,
        }
    }

    pub fn set_fault(&mut self, fault: LineFault) {
        self.fault = fault;
        self.stretching = false;
    }

    pub const fn fault(&self) -> LineFault {
        self.fault
    }

    /// Whether somebody else than the controller holds SDA low.
    pub const fn data_is_held(&self) -> bool {
        matches!(
            self.fault,
            LineFault::DataLow | LineFault::DataLowFor { .. }
        ) || !self.driven.data
    }

    /// Whether somebody else than the controller holds SCL low.
    pub const fn clock_is_held(&self) -> bool {
        matches!(self.fault, LineFault::ClockLow) || self.stretching || !self.driven.clock
    }

    pub const fn lines(&self) -> Lines {
        Lines {
            clock: !self.clock_is_held(),
            data: !self.data_is_held(),
        }
    }

    /// Pulses of SCL were made.
    pub fn clock(&mut self, count: u8) {
        if let LineFault::DataLowFor { pulses } = &mut self.fault {
            *pulses = pulses.saturating_sub(count);
            if *pulses == 0 {
                self.fault = LineFault::None;
            }
        }
    }

    /// Pins that are not the controller's changed. Of what they send, STOP is all that devices are
    /// told of.
    pub fn pins(&mut self, driven: Lines) {
        let before = self.lines();
        self.driven = driven;
        let after = self.lines();
        if before.clock && !after.clock && self.pulse_begun {
            self.clock(1);
            self.pulse_begun = false;
        }
        self.pulse_begun |= !before.clock && after.clock;
        if before.clock && after.clock && !before.data && after.data {
            self.device.stop();
        }
    }

    /// The address was sent: whether it is acknowledged.
    pub fn start(&mut self, address: u16, read: bool) -> bool {
        let acknowledged = self.device.start(address, read);
        self.stretching |= acknowledged && self.fault == LineFault::Stretch;
        acknowledged
    }
}
