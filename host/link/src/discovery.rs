//! Which serial ports are rovers.

use rover_shared::wire::usb;
use serde::Serialize;
use serialport::{SerialPortInfo, SerialPortType};

use crate::port::PortError;

/// A serial port of this machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Found {
    /// Where to open it.
    pub path: String,
    /// Whether it says that it is a rover.
    pub rover: bool,
    /// What it is at the USB; `None` for other ports.
    pub usb: Option<UsbNames>,
}

/// How a USB device describes itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct UsbNames {
    /// Number of the vendor.
    pub vendor: u16,
    /// Number of the product.
    pub product: u16,
    /// Its serial number, by which it is found again.
    pub serial_number: Option<String>,
    /// Who made it.
    pub manufacturer_name: Option<String>,
    /// What it is.
    pub product_name: Option<String>,
}

/// All serial ports, rovers first.
///
/// # Errors
/// [`PortError::NoList`].
pub fn ports() -> Result<Vec<Found>, PortError> {
    // The library assumes that there is one.
    if cfg!(target_os = "linux") && !std::path::Path::new("/sys/class/tty").is_dir() {
        return Err(PortError::NoList("there is no /sys/class/tty".into()));
    }
    let listed =
        serialport::available_ports().map_err(|error| PortError::NoList(error.to_string()))?;
    Ok(sorted(listed))
}

fn sorted(listed: Vec<SerialPortInfo>) -> Vec<Found> {
    let mut found: Vec<Found> = listed.into_iter().map(Found::from).collect();
    found.sort_by(|a, b| (!a.rover, &a.path).cmp(&(!b.rover, &b.path)));
    found.dedup_by(|a, b| a.path == b.path);
    // macOS lists each port twice: as one that waits for a carrier (tty), which a rover never
    // gives, and as one that does not (cu).
    found.retain(|port| !port.path.starts_with("/dev/tty."));
    found
}

/// The one rover that is connected.
///
/// # Errors
/// There is none, or more than one.
pub fn only_rover() -> Result<Found, PortError> {
    only(ports()?)
}

fn only(mut found: Vec<Found>) -> Result<Found, PortError> {
    found.retain(|port| port.rover);
    match found.len() {
        0 => Err(PortError::NoRover),
        1 => Ok(found.swap_remove(0)),
        _ => {
            let named = |port: &Found| match port.serial_number() {
                Some(number) => format!("{} with number {number}", port.path),
                None => port.path.clone(),
            };
            let rovers: Vec<_> = found.iter().map(named).collect();
            Err(PortError::Several(rovers.join(", ")))
        }
    }
}

/// Where the rover with this serial number is now.
///
/// # Errors
/// It is not connected.
pub fn rover_with(serial_number: &str) -> Result<Found, PortError> {
    let mut found = ports()?;
    found.retain(|port| port.rover && port.serial_number() == Some(serial_number));
    found
        .pop()
        .ok_or_else(|| PortError::Away(serial_number.into()))
}

impl Found {
    /// The serial number, if it is a USB device that has one.
    pub fn serial_number(&self) -> Option<&str> {
        self.usb.as_ref()?.serial_number.as_deref()
    }
}

impl From<SerialPortInfo> for Found {
    fn from(info: SerialPortInfo) -> Self {
        let usb = match info.port_type {
            SerialPortType::UsbPort(usb) => Some(UsbNames {
                vendor: usb.vid,
                product: usb.pid,
                serial_number: usb.serial_number,
                manufacturer_name: usb.manufacturer,
                product_name: usb.product,
            }),
            _ => None,
        };
        Self {
            path: info.port_name,
            rover: usb.as_ref().is_some_and(UsbNames::is_rover),
            usb,
        }
    }
}

impl UsbNames {
    /// The numbers are shared by everybody who tests, so the name must match too. Windows does not
    /// tell the name: there the numbers are enough.
    fn is_rover(&self) -> bool {
        let numbers = (self.vendor, self.product) == (usb::VENDOR, usb::PRODUCT);
        let named = match &self.product_name {
            Some(name) => cfg!(windows) || name.replace('_', " ") == usb::PRODUCT_NAME,
            None => cfg!(windows),
        };
        numbers && named
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serialport::UsbPortInfo;

    fn usb(path: &str, pid: u16, name: &str) -> SerialPortInfo {
        SerialPortInfo {
            port_name: path.into(),
            port_type: SerialPortType::UsbPort(UsbPortInfo {
                vid: usb::VENDOR,
                pid,
                serial_number: Some(format!("serial of {path}")),
                manufacturer: Some("Turing Rover".into()),
                product: Some(name.into()),
            }),
        }
    }

    #[test]
    fn rovers_are_told_by_numbers_and_name() {
        let plain = SerialPortInfo {
            port_name: "/dev/ttyS0".into(),
            port_type: SerialPortType::Unknown,
        };
        let found = sorted(vec![
            plain,
            usb("/dev/ttyACM0", 2, usb::PRODUCT_NAME),
            usb("/dev/ttyACM1", usb::PRODUCT, "another device in testing"),
            usb("/dev/ttyACM2", usb::PRODUCT, usb::PRODUCT_NAME),
        ]);
        let rovers: Vec<_> = found.iter().filter(|port| port.rover).collect();
        if cfg!(not(windows)) {
            assert_eq!(rovers.len(), 1);
        }
        assert_eq!(found[0].path, "/dev/ttyACM2");
        assert_eq!(found[0].serial_number(), Some("serial of /dev/ttyACM2"));
    }

    #[test]
    fn none_or_several_are_told() {
        assert_eq!(only(Vec::new()), Err(PortError::NoRover));
        let one = || Found::from(usb("/dev/a", usb::PRODUCT, usb::PRODUCT_NAME));
        assert_eq!(only(vec![one()]), Ok(one()));
        let two = Found::from(usb("/dev/b", usb::PRODUCT, usb::PRODUCT_NAME));
        let several = only(vec![one(), two]).unwrap_err().to_string();
        assert!(
            several.contains("/dev/a with number serial of /dev/a, /dev/b with"),
            "{several}"
        );
    }
}
