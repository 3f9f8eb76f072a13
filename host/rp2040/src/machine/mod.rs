//! The machine: core, bus and peripherals in one time, and what resets them.
//!
//! [`Machine::run_until`] runs it. While the core runs, only writes to registers and
//! events (an alarm, a conversion's end, a packet) make the machine look after the peripherals;
//! while it sleeps, time goes straight to the next event.

mod access;
mod load;
mod power;
mod run;
mod state;
#[cfg(test)]
mod tests;

pub use load::Load;
pub use state::{Machine, OutsideFlash, OutsideRam, WiringError};
