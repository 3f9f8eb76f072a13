//! The USB device controller: its registers as the processor sees them, and what it answers on the
//! bus (RP2040 datasheet 4.1.2.6 and 4.1.4).
//!
//! A transaction takes effect as a whole when it ends. Buses have no errors here: no CRC, bit
//! stuffing or time-out error ever occurs, and errata RP2040-E2, E5 and E15, which need them or a
//! busy bus, do not either. Isochronous endpoints and the controller's host mode are missing.

mod device;
mod endpoints;

pub(super) use device::Controller;
pub(super) use endpoints::{Answer, Pid, Reply};
