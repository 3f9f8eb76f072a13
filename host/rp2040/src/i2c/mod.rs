//! An I2C controller as the bus master (RP2040 datasheet 4.3), and the bus at its pins.
//!
//! Transfers take place byte by byte, in the time that the SCL counts make of it (4.3.14.1): a byte
//! and its acknowledgement are nine periods of (HCNT + SPKLEN + 7) + (LCNT + 1) cycles, a START or
//! STOP condition takes as much as the counts leave for it, and rise times are none. An entry
//! leaves the transmit FIFO when its byte begins.
//!
//! Not modelled: being a slave, START bytes, a second master. With SDA held low the master loses
//! the arbitration at the first 1 that it sends, and a STOP condition waits until SDA can rise.

mod bus;
mod controller;
mod master;
mod registers;
mod settings;
mod step;
#[cfg(test)]
mod tests;

pub use bus::{I2cDevice, LineFault, Lines};
pub use controller::I2c;
pub use registers::{FIFO_DEPTH, IRQS};
