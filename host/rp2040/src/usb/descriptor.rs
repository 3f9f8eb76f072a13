//! What a device says of itself (USB 2.0 9.6; CDC 1.2 5.2, PSTN 1.2 5.3): descriptors, checked.

use super::dpram::{Direction, Endpoint};

/// Types of descriptors.
pub(super) const DEVICE: u8 = 1;
pub(super) const CONFIGURATION: u8 = 2;
pub(super) const STRING: u8 = 3;
const INTERFACE: u8 = 4;
const ENDPOINT: u8 = 5;
const CLASS_INTERFACE: u8 = 0x24;

/// Classes, subclass and functional descriptor of a serial port.
const COMMUNICATIONS: u8 = 0x02;
const ABSTRACT_CONTROL: u8 = 0x02;
const CDC_DATA: u8 = 0x0a;
const UNION: u8 = 0x06;

/// Transfer types of endpoints.
const BULK: u8 = 2;
const INTERRUPT: u8 = 3;

/// Why a descriptor is of no use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DescriptorError {
    /// Fewer bytes than it has to have.
    #[error("it has {got} bytes and should have at least {expected}")]
    Short {
        /// What came.
        got: usize,
        /// What is needed.
        expected: usize,
    },
    /// Another descriptor than was asked for.
    #[error("it is of type {got}, but type {expected} was asked for")]
    Type {
        /// What came.
        got: u8,
        /// What was asked for.
        expected: u8,
    },
    /// Its length, or that of a descriptor within the configuration, is not the number of bytes that
    /// are there.
    #[error("it says that it has {said} bytes, but there are {got}")]
    Length {
        /// What it says.
        said: usize,
        /// What is there.
        got: usize,
    },
    /// A packet size that no full-speed endpoint may have.
    #[error("endpoint {endpoint:#04x} has packets of {size} bytes; 8, 16, 32 and 64 are allowed")]
    PacketSize {
        /// The endpoint's address.
        endpoint: u8,
        /// What it says.
        size: u16,
    },
    /// No CDC-ACM function.
    #[error("it has no CDC-ACM interface (class 2, subclass 2), so it is no serial port")]
    NoSerialPort,
    /// A CDC-ACM function without its data.
    #[error("its CDC data interface lacks a bulk endpoint for {0}")]
    NoBulk(Direction),
    /// A string that is no UTF-16.
    #[error("it is no UTF-16 text")]
    Text,
}

/// What the device descriptor says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Device {
    pub(super) vendor: u16,
    pub(super) product: u16,
    pub(super) release: u16,
    pub(super) control_packet: usize,
    /// The indices of the strings, in the order of [`Text`](super::Text); 0 is none.
    pub(super) strings: [u8; 3],
}

/// A bulk endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bulk {
    pub(super) endpoint: Endpoint,
    /// Bytes in a full packet.
    pub(super) packet: usize,
}

/// The serial port of a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SerialPort {
    /// The value for SET_CONFIGURATION.
    pub(super) configuration: u8,
    /// The interface that class requests go to.
    pub(super) control_interface: u8,
    /// Where the device reports line states, if it does.
    pub(super) notifications: Option<Endpoint>,
    pub(super) input: Bulk,
    pub(super) output: Bulk,
}

/// Checks type and length.
fn check(bytes: &[u8], kind: u8, least: usize) -> Result<(), DescriptorError> {
    let short = |got| DescriptorError::Short {
        got,
        expected: least,
    };
    let [said, got, ..] = *bytes else {
        return Err(short(bytes.len()));
    };
    let (said, expected) = (usize::from(said), kind);
    if got != expected {
        Err(DescriptorError::Type { got, expected })
    } else if said > bytes.len() {
        let got = bytes.len();
        Err(DescriptorError::Length { said, got })
    } else if said < least {
        Err(short(said))
    } else {
        Ok(())
    }
}

fn half(bytes: &[u8], at: usize) -> u16 {
    let byte = |i| bytes.get(i).copied().unwrap_or_default();
    u16::from_le_bytes([byte(at), byte(at + 1)])
}

fn packet(endpoint: u8, size: u16) -> Result<usize, DescriptorError> {
    match size {
        8 | 16 | 32 | 64 => Ok(size.into()),
        _ => Err(DescriptorError::PacketSize { endpoint, size }),
    }
}

/// The packet size of the control pipe, of the first 8 bytes of a device descriptor.
pub(super) fn control_packet(bytes: &[u8]) -> Result<usize, DescriptorError> {
    let (got, expected) = (bytes.len(), 8);
    match *bytes {
        [_, DEVICE, _, _, _, _, _, size, ..] => packet(0, size.into()),
        [_, got, ..] if got != DEVICE => Err(DescriptorError::Type {
            got,
            expected: DEVICE,
        }),
        _ => Err(DescriptorError::Short { got, expected }),
    }
}

/// Reads a device descriptor.
pub(super) fn device(bytes: &[u8]) -> Result<Device, DescriptorError> {
    check(bytes, DEVICE, 18)?;
    Ok(Device {
        vendor: half(bytes, 8),
        product: half(bytes, 10),
        release: half(bytes, 12),
        control_packet: control_packet(bytes)?,
        strings: [bytes[14], bytes[15], bytes[16]],
    })
}

/// How long a configuration is with all that belongs to it, of its first 9 bytes.
pub(super) fn configuration_length(bytes: &[u8]) -> Result<u16, DescriptorError> {
    check(bytes, CONFIGURATION, 9)?;
    let total = half(bytes, 2);
    if total < 9 {
        let (got, expected) = (total.into(), 9);
        return Err(DescriptorError::Short { got, expected });
    }
    Ok(total)
}

/// The languages of a device's strings: the first.
pub(super) fn language(bytes: &[u8]) -> Result<u16, DescriptorError> {
    check(bytes, STRING, 4)?;
    Ok(half(bytes, 2))
}

/// Reads a string descriptor.
pub(super) fn string(bytes: &[u8]) -> Result<String, DescriptorError> {
    check(bytes, STRING, 2)?;
    let (units, rest) = bytes[2..usize::from(bytes[0])].as_chunks();
    let units: Vec<u16> = units.iter().map(|unit| u16::from_le_bytes(*unit)).collect();
    match String::from_utf16(&units) {
        Ok(text) if rest.is_empty() => Ok(text),
        _ => Err(DescriptorError::Text),
    }
}

/// An endpoint of an interface.
struct Described {
    interface: u8,
    kind: u8,
    endpoint: Endpoint,
    size: u16,
}

/// Finds the serial port in a whole configuration. Interfaces count in their first alternate
/// setting, the only one that needs no further request.
pub(super) fn serial_port(bytes: &[u8]) -> Result<SerialPort, DescriptorError> {
    let (said, got) = (configuration_length(bytes)?.into(), bytes.len());
    if said != got {
        return Err(DescriptorError::Length { said, got });
    }
    // The interfaces of the port, the one that a union names or else the first for CDC data, and the
    // interface that is being described.
    let (mut control, mut union, mut data, mut current) = (None, None, None, None);
    let mut endpoints = Vec::new();
    let mut rest = bytes;
    while let [length, ..] = *rest {
        let (said, got) = (usize::from(length), rest.len());
        let part = rest.get(..said).filter(|part| part.len() >= 2);
        let part = part.ok_or(DescriptorError::Length { said, got })?;
        rest = &rest[said..];
        match *part {
            [_, INTERFACE, number, alternate, _, class, subclass, ..] => {
                current = (alternate == 0).then_some(number);
                match (class, subclass) {
                    (COMMUNICATIONS, ABSTRACT_CONTROL) => control = control.or(current),
                    (CDC_DATA, _) => data = data.or(current),
                    _ => {}
                }
            }
            [_, CLASS_INTERFACE, UNION, main, subordinate, ..] if control == Some(main) => {
                union = Some(subordinate);
            }
            [_, ENDPOINT, address, attributes, low, high, ..] => {
                endpoints.extend(current.map(|interface| Described {
                    interface,
                    kind: attributes & 3,
                    endpoint: Endpoint::at(address),
                    size: u16::from_le_bytes([low, high]),
                }));
            }
            _ => {}
        }
    }
    let control = control.ok_or(DescriptorError::NoSerialPort)?;
    let find = |interface, kind, direction| {
        let mut of_interface = endpoints.iter().filter(|e| interface == Some(e.interface));
        of_interface.find(|e| e.kind == kind && e.endpoint.direction == direction)
    };
    let bulk = |direction| {
        let found = find(union.or(data), BULK, direction);
        let found = found.ok_or(DescriptorError::NoBulk(direction))?;
        let endpoint = found.endpoint;
        let packet = packet(endpoint.address(), found.size)?;
        Ok(Bulk { endpoint, packet })
    };
    Ok(SerialPort {
        configuration: bytes[5],
        control_interface: control,
        notifications: find(Some(control), INTERRUPT, Direction::In).map(|found| found.endpoint),
        input: bulk(Direction::In)?,
        output: bulk(Direction::Out)?,
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A device descriptor with three strings.
    pub(in super::super) const A_DEVICE: [u8; 18] = [
        18, 1, 0x10, 0x02, 0xef, 2, 1, 64, 0x09, 0x12, 0x01, 0x00, 0x10, 0x00, 1, 2, 3, 1,
    ];

    /// A CDC-ACM function with an association, as composite devices have it.
    pub(in super::super) const A_SERIAL_PORT: [u8; 70] = [
        9, 2, 70, 0, 2, 1, 0, 0x80, 250, // configuration
        8, 11, 0, 2, 2, 2, 0, 0, // association
        9, 4, 0, 0, 1, 2, 2, 0, 0, // communications interface
        5, 0x24, 0, 0x10, 0x01, 4, 0x24, 2, 2, 5, 0x24, 6, 0, 1, // header, ACM, union
        7, 5, 0x81, 3, 8, 0, 255, // notifications
        9, 4, 1, 0, 2, 0x0a, 0, 0, 0, // data interface
        7, 5, 0x01, 2, 64, 0, 0, 7, 5, 0x82, 2, 64, 0, 0,
    ];

    fn changed(at: usize, value: u8) -> Vec<u8> {
        let mut bytes = A_SERIAL_PORT.to_vec();
        bytes[at] = value;
        bytes
    }

    #[test]
    fn the_serial_port_is_found() {
        let port = serial_port(&A_SERIAL_PORT).expect("a serial port");
        let bulk = |number, direction| Bulk {
            endpoint: Endpoint::new(number, direction),
            packet: 64,
        };
        let expected = SerialPort {
            configuration: 1,
            control_interface: 0,
            notifications: Some(Endpoint::new(1, Direction::In)),
            input: bulk(2, Direction::In),
            output: bulk(1, Direction::Out),
        };
        assert_eq!(port, expected);
        // Without a union the first data interface is taken.
        assert_eq!(serial_port(&changed(37, 0x7)), Ok(expected));
    }

    #[test]
    fn a_device_and_its_strings_are_read() {
        let device = device(&A_DEVICE).expect("a device");
        assert_eq!((device.vendor, device.product), (0x1209, 1));
        assert_eq!(device.control_packet, 64);
        assert_eq!(string(&[6, 3, b'o', 0, 0xe9, 0]), Ok("oé".into()));
        assert_eq!(language(&[4, 3, 9, 4]), Ok(0x409));
    }

    #[test]
    fn broken_descriptors_are_told_apart() {
        let short = |got, expected| DescriptorError::Short { got, expected };
        assert_eq!(device(&A_DEVICE[..1]), Err(short(1, 18)));
        let length = DescriptorError::Length { said: 18, got: 17 };
        assert_eq!(device(&A_DEVICE[..17]), Err(length));
        let kind = DescriptorError::Type {
            got: 2,
            expected: 1,
        };
        assert_eq!(device(&A_SERIAL_PORT), Err(kind));
        let length = DescriptorError::Length { said: 71, got: 70 };
        assert_eq!(serial_port(&changed(2, 71)), Err(length));
        assert_eq!(configuration_length(&changed(2, 3)), Err(short(3, 9)));
        let length = DescriptorError::Length { said: 8, got: 7 };
        assert_eq!(serial_port(&changed(63, 8)), Err(length));
        assert!(serial_port(&changed(63, 0)).is_err(), "no endless loop");
        let none = Err(DescriptorError::NoSerialPort);
        assert_eq!(serial_port(&changed(22, 3)), none);
        let input = Err(DescriptorError::NoBulk(Direction::In));
        assert_eq!(serial_port(&changed(66, 3)), input);
        let size = DescriptorError::PacketSize {
            endpoint: 0x82,
            size: 63,
        };
        assert_eq!(serial_port(&changed(67, 63)), Err(size));
        assert_eq!(string(&[4, 3, 0, 0xd8]), Err(DescriptorError::Text));
        assert_eq!(string(&[3, 3, 1]), Err(DescriptorError::Text));
    }
}
