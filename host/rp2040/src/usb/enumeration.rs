//! Enumeration: the requests that a host makes after a bus reset, what it reads from the replies,
//! and when it stops (USB 2.0 9.1.2 and 9.4; PSTN 1.2 6.3).

use std::fmt;

use super::descriptor::{self, DescriptorError, Device, SerialPort};

/// The address that the only device on the bus gets.
const ADDRESS: u8 = 1;

/// A request of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// GET_DESCRIPTOR, the device's first packet, before it has an address.
    FirstPacket,
    /// SET_ADDRESS.
    SetAddress,
    /// GET_DESCRIPTOR, device.
    Device,
    /// GET_DESCRIPTOR, configuration, without what belongs to it.
    ConfigurationHead,
    /// GET_DESCRIPTOR, configuration: all of it, this many bytes.
    Configuration(u16),
    /// GET_DESCRIPTOR, the languages of strings.
    Languages,
    /// GET_DESCRIPTOR, a string.
    String(Text),
    /// SET_CONFIGURATION.
    SetConfiguration,
    /// SET_LINE_CODING: 115200 baud, 8 bits, no parity, 1 stop bit.
    SetLineCoding,
    /// SET_CONTROL_LINE_STATE: DTR and RTS, on or off.
    SetControlLineState(bool),
    /// CLEAR_FEATURE, ENDPOINT_HALT, of the endpoint of this address.
    ClearHalt(u8),
}

/// Which of a device's strings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Text {
    /// Who made it.
    Manufacturer,
    /// What it is.
    Product,
    /// Which it is.
    SerialNumber,
}

impl Text {
    const ALL: [Self; 3] = [Self::Manufacturer, Self::Product, Self::SerialNumber];
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Manufacturer => "manufacturer",
            Self::Product => "product",
            Self::SerialNumber => "serial number",
        })
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FirstPacket => f.write_str("GET_DESCRIPTOR (device, first packet)"),
            Self::SetAddress => f.write_str("SET_ADDRESS"),
            Self::Device => f.write_str("GET_DESCRIPTOR (device)"),
            Self::ConfigurationHead => f.write_str("GET_DESCRIPTOR (configuration, head)"),
            Self::Configuration(length) => {
                write!(f, "GET_DESCRIPTOR (configuration, {length} bytes)")
            }
            Self::Languages => f.write_str("GET_DESCRIPTOR (languages)"),
            Self::String(text) => write!(f, "GET_DESCRIPTOR (string, {text})"),
            Self::SetConfiguration => f.write_str("SET_CONFIGURATION"),
            Self::SetLineCoding => f.write_str("SET_LINE_CODING"),
            Self::SetControlLineState(on) => {
                write!(f, "SET_CONTROL_LINE_STATE (DTR {})", u8::from(*on))
            }
            Self::ClearHalt(endpoint) => write!(f, "CLEAR_FEATURE (halt of {endpoint:#04x})"),
        }
    }
}

/// Why enumeration failed, at the last attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EnumerationError {
    /// The device does not answer at its address.
    #[error("the device does not answer to {0}: its USB controller is off or has another address")]
    NoAnswer(Request),
    /// The request did not come to its end.
    #[error("the device did not carry out {0} within 5 s: its USB driver does not run")]
    TimeOut(Request),
    /// STALL, to a request that every device has to know.
    #[error("the device refuses {0}: its USB driver has to support it")]
    Refused(Request),
    /// A packet longer than the device itself allows.
    #[error("the device's reply to {0} has a packet of {1} bytes, longer than it may be")]
    Babble(Request, usize),
    /// A reply that is of no use.
    #[error("the device's reply to {0} is not usable: {1}")]
    Descriptor(Request, #[source] DescriptorError),
}

/// What a device has said of itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// Vendor (idVendor).
    pub vendor: u16,
    /// Product (idProduct).
    pub product: u16,
    /// Release, binary-coded decimal (bcdDevice).
    pub release: u16,
    /// Who made it.
    pub manufacturer_name: Option<String>,
    /// What it is.
    pub product_name: Option<String>,
    /// Which it is.
    pub serial_number: Option<String>,
}

/// Enumeration, from a bus reset on: without input or output, request by request.
#[derive(Clone, Debug)]
pub(super) struct Enumeration {
    request: Request,
    address: u8,
    control_packet: usize,
    device: Option<Device>,
    port: Option<SerialPort>,
    language: u16,
    description: Description,
}

impl Enumeration {
    /// At its first request.
    pub(super) fn new() -> Self {
        Self {
            request: Request::FirstPacket,
            address: 0,
            // What every full-speed device can receive; what it sends is counted.
            control_packet: 64,
            device: None,
            port: None,
            language: 0,
            description: Description::default(),
        }
    }

    /// What to ask now.
    pub(super) fn request(&self) -> Request {
        self.request
    }

    /// The address to ask at.
    pub(super) fn address(&self) -> u8 {
        self.address
    }

    /// Bytes in a full packet of the control pipe.
    pub(super) fn control_packet(&self) -> usize {
        self.control_packet
    }

    /// What is known by now.
    pub(super) fn description(&self) -> &Description {
        &self.description
    }

    /// The serial port, once the configuration was read.
    pub(super) fn port(&self) -> Option<SerialPort> {
        self.port
    }

    /// SETUP packet and data of a request.
    pub(super) fn packet(&self, request: Request) -> ([u8; 8], Vec<u8>) {
        let interface = self.port.map_or(0, |port| port.control_interface.into());
        let configuration = self.port.map_or(0, |port| port.configuration.into());
        let text = |text| {
            self.device
                .map_or(0, |device| device.strings[text as usize])
        };
        let descriptor = |kind: u8, index: u8| u16::from_be_bytes([kind, index]);
        let configurations = descriptor(descriptor::CONFIGURATION, 0);
        // 115200 baud; the device ignores all of it, as no wire carries these bits.
        const LINE_CODING: [u8; 7] = [0, 0xc2, 1, 0, 0, 0, 8];
        // Request type and request, value, index, length.
        let (head, value, index, length) = match request {
            Request::FirstPacket => ([0x80, 6], descriptor(descriptor::DEVICE, 0), 0, 64),
            Request::SetAddress => ([0x00, 5], ADDRESS.into(), 0, 0),
            Request::Device => ([0x80, 6], descriptor(descriptor::DEVICE, 0), 0, 18),
            Request::ConfigurationHead => ([0x80, 6], configurations, 0, 9),
            Request::Configuration(length) => ([0x80, 6], configurations, 0, length),
            Request::Languages => ([0x80, 6], descriptor(descriptor::STRING, 0), 0, 255),
            Request::String(which) => {
                let value = descriptor(descriptor::STRING, text(which));
                ([0x80, 6], value, self.language, 255)
            }
            Request::SetConfiguration => ([0x00, 9], configuration, 0, 0),
            Request::SetLineCoding => ([0x21, 0x20], 0, interface, LINE_CODING.len() as u16),
            Request::SetControlLineState(on) => {
                // RTS and DTR.
                ([0x21, 0x22], if on { 3 } else { 0 }, interface, 0)
            }
            Request::ClearHalt(endpoint) => ([0x02, 1], 0, endpoint.into(), 0),
        };
        let [value, index, length] = [value, index, length].map(u16::to_le_bytes);
        let mut setup = [0; 8];
        for (place, half) in setup.chunks_mut(2).zip([head, value, index, length]) {
            place.copy_from_slice(&half);
        }
        let data = if request == Request::SetLineCoding {
            LINE_CODING.to_vec()
        } else {
            Vec::new()
        };
        (setup, data)
    }

    /// Takes the reply to the request. Returns true when there is nothing more to ask.
    pub(super) fn take(&mut self, reply: &[u8]) -> Result<bool, EnumerationError> {
        let bad = |error| EnumerationError::Descriptor(self.request, error);
        let next = match self.request {
            Request::FirstPacket => {
                self.control_packet = descriptor::control_packet(reply).map_err(bad)?;
                Some(Request::SetAddress)
            }
            Request::SetAddress => {
                self.address = ADDRESS;
                Some(Request::Device)
            }
            Request::Device => {
                let device = descriptor::device(reply).map_err(bad)?;
                self.description.vendor = device.vendor;
                self.description.product = device.product;
                self.description.release = device.release;
                self.control_packet = device.control_packet;
                self.device = Some(device);
                Some(Request::ConfigurationHead)
            }
            Request::ConfigurationHead => {
                let length = descriptor::configuration_length(reply).map_err(bad)?;
                Some(Request::Configuration(length))
            }
            Request::Configuration(_) => {
                self.port = Some(descriptor::serial_port(reply).map_err(bad)?);
                Some(Request::Languages)
            }
            Request::Languages => {
                self.language = descriptor::language(reply).map_err(bad)?;
                Some(self.string_from(0))
            }
            Request::String(which) => {
                let text = descriptor::string(reply).map_err(bad)?;
                *self.string_mut(which) = Some(text);
                Some(self.string_from(which as usize + 1))
            }
            Request::SetConfiguration => Some(Request::SetLineCoding),
            Request::SetLineCoding | Request::SetControlLineState(_) | Request::ClearHalt(_) => {
                None
            }
        };
        Ok(self.go_on(next))
    }

    /// The device has refused the request with STALL. Returns true when there is nothing more to ask.
    pub(super) fn refused(&mut self) -> Result<bool, EnumerationError> {
        let next = match self.request {
            // A device need not have strings, and a serial port no line coding.
            Request::Languages => Some(Request::SetConfiguration),
            Request::String(which) => Some(self.string_from(which as usize + 1)),
            Request::SetLineCoding => None,
            request => return Err(EnumerationError::Refused(request)),
        };
        Ok(self.go_on(next))
    }

    fn go_on(&mut self, next: Option<Request>) -> bool {
        if let Some(next) = next {
            self.request = next;
        }
        next.is_none()
    }

    /// The first string of [`Text::ALL`] from `first` on that the device has, or what comes after the
    /// strings.
    fn string_from(&self, first: usize) -> Request {
        let has = |text: &Text| {
            self.device
                .is_some_and(|device| device.strings[*text as usize] != 0)
        };
        let next = Text::ALL.into_iter().skip(first).find(has);
        next.map_or(Request::SetConfiguration, Request::String)
    }

    fn string_mut(&mut self, which: Text) -> &mut Option<String> {
        match which {
            Text::Manufacturer => &mut self.description.manufacturer_name,
            Text::Product => &mut self.description.product_name,
            Text::SerialNumber => &mut self.description.serial_number,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::descriptor::tests::{A_DEVICE, A_SERIAL_PORT};
    use super::*;

    /// Replies as a device with these descriptors does, up to the request given.
    fn until(end: Request) -> Enumeration {
        let mut enumeration = Enumeration::new();
        while enumeration.request() != end {
            let reply = match enumeration.request() {
                Request::FirstPacket | Request::Device => A_DEVICE.to_vec(),
                Request::ConfigurationHead => A_SERIAL_PORT[..9].to_vec(),
                Request::Configuration(length) => A_SERIAL_PORT[..length.into()].to_vec(),
                Request::Languages => vec![4, 3, 9, 4],
                Request::String(_) => vec![4, 3, b'x', 0],
                _ => vec![],
            };
            assert_eq!(enumeration.take(&reply), Ok(false));
        }
        enumeration
    }

    #[test]
    fn requests_are_made_in_order() {
        let mut enumeration = until(Request::SetLineCoding);
        assert_eq!(enumeration.take(&[]), Ok(true));
        assert_eq!(enumeration.address(), 1);
        let serial = enumeration.description().serial_number.as_deref();
        assert_eq!(serial, Some("x"));
    }

    #[test]
    fn packets_are_as_the_standard_has_them() {
        let enumeration = until(Request::SetLineCoding);
        let packet = |request| enumeration.packet(request).0;
        assert_eq!(packet(Request::Device), [0x80, 6, 0, 1, 0, 0, 18, 0]);
        assert_eq!(
            packet(Request::String(Text::Product)),
            [0x80, 6, 2, 3, 9, 4, 255, 0]
        );
        assert_eq!(packet(Request::SetConfiguration), [0, 9, 1, 0, 0, 0, 0, 0]);
        assert_eq!(
            packet(Request::ClearHalt(0x82)),
            [2, 1, 0, 0, 0x82, 0, 0, 0]
        );
        let (setup, data) = enumeration.packet(Request::SetLineCoding);
        assert_eq!(setup, [0x21, 0x20, 0, 0, 0, 0, 7, 0]);
        assert_eq!(data, [0, 0xc2, 1, 0, 0, 0, 8]);
    }

    #[test]
    fn strings_are_not_needed() {
        let mut enumeration = until(Request::String(Text::Product));
        assert_eq!(enumeration.refused(), Ok(false));
        assert_eq!(enumeration.request(), Request::String(Text::SerialNumber));
        let mut enumeration = until(Request::Languages);
        assert_eq!(enumeration.refused(), Ok(false));
        assert_eq!(enumeration.request(), Request::SetConfiguration);
        let refused = EnumerationError::Refused(Request::SetConfiguration);
        assert_eq!(enumeration.refused(), Err(refused));
    }

    #[test]
    fn errors_say_what_to_do() {
        let mut enumeration = until(Request::Device);
        let error = enumeration.take(&A_SERIAL_PORT).expect_err("no device");
        assert_eq!(
            error.to_string(),
            "the device's reply to GET_DESCRIPTOR (device) is not usable: \
             it is of type 2, but type 1 was asked for"
        );
    }
}
