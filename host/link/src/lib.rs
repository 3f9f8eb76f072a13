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
//! | `serial` | serial ports, which come back after the cable was pulled |
//! | `discovery` | which serial ports are rovers |
//! | `loopback` | a rover in this process, for tests |
//! | `client` | the conversation: [`Client`] |
//! | `error` | what can go wrong with it |
//! | `inbox` | reports that wait to be read, and what was lost |
//! | `knowledge` | whole knowledge from the rover and to it |
//! | `names` | the contract's values as words |
//! | `text` | quantities as text |
//! | `refusal` | why a rover refused, as a sentence with the next step |
//!
//! A port has its own time ([`Port::now`]). On a serial port it is the wall clock's. On an
//! emulated board waiting for bytes *is* what lets the emulation go on, so that everything a
//! program does with an emulated rover can be repeated. Nobody here looks at another clock.

mod client;
#[cfg(feature = "serial")]
pub mod discovery;
mod error;
mod inbox;
mod knowledge;
pub mod loopback;
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
