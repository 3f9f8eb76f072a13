//! The two lines of an I2C bus, what can be wrong with them, and the devices on it.

use std::any::Any;
use std::fmt::Debug;

/// A device on the bus. It is cloned with the machine that it is attached to.
///
/// ```
/// use emulated_rp2040::i2c::I2cDevice;
///
/// /// A memory of 256 bytes at address 0x50: the first byte written is where the next one goes.
/// #[derive(Clone, Debug)]
/// struct Eeprom {
///     bytes: [u8; 256],
///     at: u8,
///     addressing: bool,
/// }
///
/// impl I2cDevice for Eeprom {
///     fn start(&mut self, address: u16, read: bool) -> bool {
///         self.addressing = !read;
///         address == 0x50
///     }
///
///     fn write(&mut self, byte: u8) -> bool {
///         if std::mem::take(&mut self.addressing) {
///             self.at = byte;
///         } else {
///             self.bytes[usize::from(self.at)] = byte;
///             self.at = self.at.wrapping_add(1);
///         }
///         true
///     }
///
///     fn read(&mut self) -> u8 {
///         let byte = self.bytes[usize::from(self.at)];
///         self.at = self.at.wrapping_add(1);
///         byte
///     }
/// }
/// ```
pub trait I2cDevice: Boxed + Any + Debug + Send {
    /// START, also a repeated one, and an address of 7 or 10 bits: whether it is acknowledged.
    /// Devices are asked in the order in which they were attached, up to the first that
    /// acknowledges.
    fn start(&mut self, address: u16, read: bool) -> bool;

    /// The next byte from the master: whether it is acknowledged.
    fn write(&mut self, byte: u8) -> bool;

    /// The next byte to the master.
    fn read(&mut self) -> u8;

    /// STOP, to whichever device it is addressed.
    fn stop(&mut self) {}
}

/// What [`Clone`] makes of a device.
pub trait Boxed {
    /// A copy of it.
    fn boxed(&self) -> Box<dyn I2cDevice>;
}

impl<D: I2cDevice + Clone> Boxed for D {
    fn boxed(&self) -> Box<dyn I2cDevice> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn I2cDevice> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
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
    /// Both pulled up by their resistors.
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
    /// SDA is stuck low.
    DataLow,
    /// A device lost count of the clock and holds SDA low until it has seen this many pulses more;
    /// then all is well again.
    DataLowFor {
        /// Pulses of SCL: nine are enough for any device in the middle of a byte.
        pulses: u8,
    },
    /// SCL is stuck low.
    ClockLow,
    /// The next device that acknowledges its address then stretches SCL for ever.
    Stretch,
}

/// The bus.
#[derive(Clone, Debug)]
pub struct Bus {
    devices: Vec<Box<dyn I2cDevice>>,
    /// The controller's lines lead to the devices.
    connected: bool,
    /// The device that acknowledged the last address.
    addressed: Option<usize>,
    fault: LineFault,
    /// A device holds SCL low.
    stretching: bool,
    /// What pins that are not the controller's drive the lines to.
    driven: Lines,
    /// They have let SCL rise: a pulse is over when it falls.
    pulse_begun: bool,
}

impl Bus {
    pub const fn new() -> Self {
        Self {
            devices: Vec::new(),
            connected: true,
            addressed: None,
            fault: LineFault::None,
            stretching: false,
            driven: Lines::HIGH,
            pulse_begun: false,
        }
    }

    pub fn set_connected(&mut self, connected: bool) {
        self.connected = connected;
    }

    pub fn set_fault(&mut self, fault: LineFault) {
        self.fault = fault;
        self.stretching = false;
    }

    pub const fn fault(&self) -> LineFault {
        self.fault
    }

    /// Whether anything but the controller holds SDA low.
    pub const fn data_is_held(&self) -> bool {
        matches!(
            self.fault,
            LineFault::DataLow | LineFault::DataLowFor { .. }
        ) || !self.driven.data
    }

    /// Whether anything but the controller holds SCL low.
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
            self.stop();
        }
    }

    pub fn attach(&mut self, device: Box<dyn I2cDevice>) {
        self.devices.push(device);
    }

    /// The first device of a type.
    pub fn device<D: I2cDevice>(&self) -> Option<&D> {
        let mut devices = self.devices.iter().map(|device| &**device as &dyn Any);
        devices.find_map(|device| device.downcast_ref())
    }

    pub fn device_mut<D: I2cDevice>(&mut self) -> Option<&mut D> {
        let mut devices = self.devices.iter_mut();
        devices.find_map(|device| (&mut **device as &mut dyn Any).downcast_mut())
    }

    /// The address was sent: whether a device acknowledges it.
    pub fn start(&mut self, address: u16, read: bool) -> bool {
        let mut devices = self.devices.iter_mut().filter(|_| self.connected);
        self.addressed = devices.position(|device| device.start(address, read));
        let acknowledged = self.addressed.is_some();
        self.stretching |= acknowledged && self.fault == LineFault::Stretch;
        acknowledged
    }

    /// A byte to the device that was addressed: whether it acknowledges it.
    pub fn write(&mut self, byte: u8) -> bool {
        self.addressed().is_some_and(|device| device.write(byte))
    }

    /// A byte from the device that was addressed; without one the line stays high.
    pub fn read(&mut self) -> u8 {
        self.addressed().map_or(0xff, |device| device.read())
    }

    pub fn stop(&mut self) {
        for device in &mut self.devices {
            device.stop();
        }
        self.addressed = None;
    }

    fn addressed(&mut self) -> Option<&mut Box<dyn I2cDevice>> {
        self.devices.get_mut(self.addressed?)
    }
}
