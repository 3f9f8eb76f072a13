//! What the host has counted.

/// What has happened since the machine was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Times that a device was taken into use.
    pub connections: u64,
    /// Attempts to do so that failed.
    pub failed_attempts: u64,
    /// Requests to a device in use that failed.
    pub failed_requests: u64,
    /// Packets of the serial port that came from the device.
    pub packets_in: u64,
    /// Bytes in them.
    pub bytes_in: u64,
    /// Packets of the serial port that went to the device.
    pub packets_out: u64,
    /// Bytes in them.
    pub bytes_out: u64,
    /// Packets that came again: acknowledged and dropped.
    pub repeated: u64,
    /// Packets larger than the device's descriptors allow: dropped.
    pub oversized: u64,
    /// Times that the device answered data with STALL.
    pub stalls: u64,
    /// Notifications of the serial port: taken and ignored.
    pub notifications: u64,
    /// Bytes that were to be sent when the connection ended.
    pub unsent: u64,
}
