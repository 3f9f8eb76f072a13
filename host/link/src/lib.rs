//! A rover at the end of a port.
//!
//! ```text
//!   bytes          frames                              commands, reports
//!   [Port]  ◄───►  [Client]  ◄──────────────────────►  cli, recorder, monitor
//!                  hello, acknowledgements, time-outs, retries, heartbeats, counters
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `port` | what a port is: [`Port`], and what can go wrong with one |
//! | `serial` | serial ports, which reopen after the cable was pulled |
//! | `discovery` | which serial ports are rovers |
//! | `client` | the conversation: [`Client`] |
//! | `error` | what can go wrong with it: [`LinkError`] |
//! | `inbox` | reports that wait to be read, and what was lost: [`Received`], [`Counters`] |
//! | `knowledge` | whole knowledge from the rover and to it |
//! | [`names`] | the contract's values as words |
//! | [`text`] | quantities as text |
//! | `refusal` | why a rover refused, as a sentence with the next step |
//!
//! A port has its own time ([`Port::now`]), the only one that is used here. On a serial port it is
//! the wall clock's. On an emulated board waiting for bytes *is* what lets the emulation go on, so
//! that everything a program does with an emulated rover can be repeated.
//!
//! Serial ports need the feature `serial`; without it the crate has no dependency on an operating
//! system.

mod client;
#[cfg(feature = "serial")]
pub mod discovery;
mod error;
mod inbox;
mod knowledge;
pub mod names;
mod port;
mod refusal;
#[cfg(feature = "serial")]
pub mod serial;
pub mod text;

pub use client::{ANSWER_WITHIN, Client, Sent, attempts};
pub use error::LinkError;
pub use inbox::{Counters, Received};
pub use port::{Port, PortError};
pub use refusal::{explain, explain_by_keys};
