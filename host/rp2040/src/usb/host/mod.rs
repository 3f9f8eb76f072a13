//! The computer at the other end of the cable: it finds the device, takes its serial port into use,
//! and carries bytes both ways.
//!
//! It works by events: one for each transaction that comes to something. What a real host does all
//! the time, to ask an endpoint again that has said NAK, is not played: a device that has nothing to
//! say costs nothing. As soon as its buffer is available, the next transaction is with it.

mod asked;
mod connection;
mod counters;
mod phase;
mod phases;
mod requests;
mod transactions;

pub use counters::Counters;
pub(super) use phases::Host;
