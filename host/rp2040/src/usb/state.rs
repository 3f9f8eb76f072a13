//! How far host and device have got.

use super::enumeration::EnumerationError;

/// What the host sees of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The cable is not plugged in.
    Unplugged,
    /// The cable is plugged in, but the device has not switched its pull-up on.
    NoDevice,
    /// The host enumerates the device.
    Enumerating,
    /// The device's serial port is in use.
    Configured {
        /// Whether the device has acknowledged that the port is open (DTR).
        dtr: bool,
    },
    /// The same, but the host sleeps.
    Suspended,
    /// The host has given up. A new try needs a new connection.
    Failed(EnumerationError),
}
