//! A rover without its board, for tests: the firmware's loop around a model of the vehicle, in
//! this process and thousands of times faster than real time.
//!
//! ```text
//!   test ──────────── commands, faults ──────────┐
//!                                                ▼
//!   Client ◄──► BoardlessPort ◄─ bytes ─► BoardlessRover ◄── pins, counts, bearing ──► Vehicle
//! ```
//!
//! A test drives the rover by [commands](BoardlessRover::command), or through a
//! [`Client`](rover_link::Client) at its [port](BoardlessPort), whose time is the rover's.
//!
//! What the board itself can do wrong, such as a task that hangs, a full queue, or a power cut in
//! the middle of a write, is not here but in `rover_emulator`.

mod port;
mod rover;

pub use port::BoardlessPort;
pub use rover::{BoardlessRover, COEFFICIENTS};
