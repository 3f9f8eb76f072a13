//! USB: the device controller (RP2040 datasheet 4.1), and a host at the end of the cable that takes
//! the program's serial port (CDC-ACM) into use.
//!
//! ```text
//!  program ──registers, memory──► controller ◄──transactions── host ◄──bytes── user
//!                                                19 packets       DTR, cable
//!                                                in a frame
//! ```
//!
//! All is done in the machine's time and is repeatable. [`Usb`] is both ends: a
//! [`Peripheral`](crate::peripheral::Peripheral) with memory at one, and at the other the user's hand
//! on the cable and the program that has the port open. While no buffer is available and nothing is
//! to be sent, nothing happens and nothing is scheduled.
//!
//! The device cannot see the cable being pulled: VBUS is wired to none of its pins, and the program
//! has to set the override bits (USB_PWR) itself. All it sees is that its transfers do not end, and
//! after 3 ms, that the bus is suspended.

mod bus;
mod cable;
mod controller;
mod descriptor;
mod dpram;
mod enumeration;
mod host;
mod registers;
mod state;
#[cfg(test)]
mod tests;
mod transfer;

pub use cable::Usb;
pub use descriptor::DescriptorError;
pub use dpram::Direction;
pub use enumeration::{Description, EnumerationError, Request, Text};
pub use host::Counters;
pub use state::State;
