//! How far the host has got with a device.

use crate::usb::enumeration::EnumerationError;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    Unplugged,
    NoDevice,
    Debounce,
    Reset,
    Recovery,
    Enumeration,
    Configured,
    Suspended,
    Resuming,
    Failed(EnumerationError),
}
