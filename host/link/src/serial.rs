//! Serial ports: USB CDC-ACM, or anything else that has a path, a pseudo-terminal for example.

use std::io::{ErrorKind, Read, Write};
use std::time;

use rover_shared::time::{Duration, Instant};
use serialport::SerialPort as Device;

use crate::discovery::{Found, only_rover, ports, rover_with};
use crate::port::{Port, PortError};

/// USB knows no baud rate; a real UART would need this one.
const BAUD: u32 = 115_200;
/// How long the port may take no bytes: the firmware reads between any two control periods.
const STUCK_AFTER: time::Duration = time::Duration::from_secs(1);

/// A serial port that can be reopened after it was unplugged.
pub struct SerialPort {
    place: Place,
    /// Where it was opened last.
    path: String,
    device: Option<Box<dyn Device>>,
    began: (time::Instant, time::SystemTime),
}

/// Where to look for the port when it is opened.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Place {
    /// Always at this path.
    Path(String),
    /// Wherever the rover with this serial number is.
    Rover(String),
}

impl SerialPort {
    /// Opens the port with this path, whatever it is, or that of the rover with this serial number.
    /// After it was unplugged a rover is found again by its serial number, another port by its path.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn named(name: &str) -> Result<Self, PortError> {
        // A system that lists no ports may still have this one.
        let found = ports().unwrap_or_default();
        Self::open(place_named(name, &found))
    }

    /// Opens the port of the one rover that is connected; after it was unplugged it is found
    /// again by its serial number.
    ///
    /// # Errors
    /// There is none, more than one, or it cannot be opened.
    pub fn of_only_rover() -> Result<Self, PortError> {
        Self::open(place_of(&only_rover()?))
    }

    fn open(place: Place) -> Result<Self, PortError> {
        let mut port = Self {
            place,
            path: String::new(),
            device: None,
            began: (time::Instant::now(), time::SystemTime::now()),
        };
        port.reopen()?;
        Ok(port)
    }

    fn lost(&mut self, error: &std::io::Error) -> PortError {
        self.device = None;
        PortError::Lost(self.path.clone(), error.to_string())
    }

    fn device(&mut self) -> Result<&mut Box<dyn Device>, PortError> {
        let path = &self.path;
        let closed = || PortError::Lost(path.clone(), "closed".into());
        self.device.as_mut().ok_or_else(closed)
    }
}

fn place_named(name: &str, found: &[Found]) -> Place {
    let called = |port: &&Found| port.path == name || port.serial_number() == Some(name);
    match found.iter().filter(|port| port.rover).find(called) {
        Some(rover) => place_of(rover),
        None => Place::Path(name.into()),
    }
}

fn place_of(found: &Found) -> Place {
    match found.serial_number() {
        Some(number) if !number.is_empty() => Place::Rover(number.into()),
        _ => Place::Path(found.path.clone()),
    }
}

impl Port for SerialPort {
    fn name(&self) -> &str {
        &self.path
    }

    fn now(&self) -> Instant {
        Instant(u64::try_from(self.began.0.elapsed().as_micros()).unwrap_or(u64::MAX))
    }

    fn epoch(&self) -> Option<time::SystemTime> {
        Some(self.began.1)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        let device = self.device()?;
        let sent = device
            .set_timeout(STUCK_AFTER)
            .map_err(std::io::Error::from)
            .and_then(|()| device.write_all(bytes));
        match sent {
            Ok(()) => Ok(()),
            Err(error) if error.kind() == ErrorKind::TimedOut => {
                Err(PortError::Stuck(self.path.clone()))
            }
            Err(error) => Err(self.lost(&error)),
        }
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> Result<usize, PortError> {
        let device = self.device()?;
        let read = device
            .set_timeout(time::Duration::from_micros(patience.0))
            .map_err(std::io::Error::from)
            .and_then(|()| device.read(buffer));
        match read {
            // A terminal that is not there any more is always ready to be read, and empty.
            Ok(0) if !buffer.is_empty() => Err(self.lost(&ErrorKind::UnexpectedEof.into())),
            Ok(length) => Ok(length),
            Err(error) if error.kind() == ErrorKind::TimedOut => Ok(0),
            Err(error) if error.kind() == ErrorKind::Interrupted => Ok(0),
            Err(error) => Err(self.lost(&error)),
        }
    }

    fn wait(&mut self, span: Duration) {
        std::thread::sleep(time::Duration::from_micros(span.0));
    }

    fn reopen(&mut self) -> Result<(), PortError> {
        // Closed first: it drops DTR, and it cannot be open twice.
        self.device = None;
        self.path = match &self.place {
            Place::Path(path) => path.clone(),
            Place::Rover(number) => rover_with(number)?.path,
        };
        let builder = serialport::new(&self.path, BAUD)
            .timeout(STUCK_AFTER)
            .dtr_on_open(true);
        let device = builder
            .open()
            .map_err(|error| opening(&self.path, &error))?;
        self.device = Some(device);
        Ok(())
    }
}

fn opening(path: &str, error: &serialport::Error) -> PortError {
    let path = path.to_owned();
    match error.kind {
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => PortError::Permission(path),
        serialport::ErrorKind::Io(ErrorKind::NotFound) => PortError::Missing(path),
        serialport::ErrorKind::NoDevice => PortError::Busy(path),
        _ => PortError::Open(path, error.description.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_cannot_be_opened_says_why() {
        let error = SerialPort::named("/dev/no-such-port").err();
        if cfg!(unix) {
            assert_eq!(error, Some(PortError::Missing("/dev/no-such-port".into())));
        }
        let file = tempfile::NamedTempFile::new().unwrap();
        let path = file.path().display().to_string();
        assert!(
            matches!(
                SerialPort::named(&path).err(),
                Some(PortError::Open(..) | PortError::Missing(_))
            ),
            "a file is no port"
        );
    }

    #[test]
    fn what_the_system_says_becomes_a_sentence_with_the_next_step() {
        let error = |kind| serialport::Error::new(kind, "as the system says it");
        let text = |kind| opening("/dev/ttyACM0", &error(kind)).to_string();
        let denied = text(serialport::ErrorKind::Io(ErrorKind::PermissionDenied));
        assert!(
            denied.contains("host/udev/60-turing-rover.rules"),
            "{denied}"
        );
        assert!(text(serialport::ErrorKind::NoDevice).contains("another program"));
        assert!(text(serialport::ErrorKind::Unknown).contains("as the system says it"));
    }

    #[test]
    fn the_rule_that_the_error_names_is_in_the_repository_and_fits() {
        let rule = include_str!("../../udev/60-turing-rover.rules");
        use rover_shared::wire::usb;
        for part in [
            format!("idVendor}}==\"{:04x}\"", usb::VENDOR),
            format!("idProduct}}==\"{:04x}\"", usb::PRODUCT),
            format!("product}}==\"{}\"", usb::PRODUCT_NAME),
        ] {
            assert!(rule.contains(&part), "{part}");
        }
    }

    #[test]
    fn a_rover_is_found_again_by_its_number_and_another_port_by_its_path() {
        let port = |path: &str, rover, number: &str| Found {
            path: path.into(),
            rover,
            usb: Some(crate::discovery::UsbNames {
                vendor: 1,
                product: 2,
                serial_number: Some(number.into()),
                manufacturer_name: None,
                product_name: None,
            }),
        };
        let found = [
            port("/dev/ttyACM3", true, "E66"),
            port("/dev/ttyACM4", true, "E67"),
            port("/dev/ttyACM5", false, "E68"),
            port("/dev/ttyACM6", true, ""),
        ];
        let place = |name| place_named(name, &found);
        let path = |path: &str| Place::Path(path.into());
        assert_eq!(place("/dev/ttyACM4"), Place::Rover("E67".into()));
        assert_eq!(place("E67"), Place::Rover("E67".into()));
        // No rover, one without a number, and one that is not listed.
        assert_eq!(place("/dev/ttyACM5"), path("/dev/ttyACM5"));
        assert_eq!(place("/dev/ttyACM6"), path("/dev/ttyACM6"));
        assert_eq!(place("/dev/pts/1"), path("/dev/pts/1"));
    }
}
