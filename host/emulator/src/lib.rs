//! The emulated rover: an emulated board that boots the firmware, wired to a model of the vehicle,
//! in one time.
//!
//! ```text
//!                       pins                       wheels
//!   ┌────────────────┐ ─────► ┌──────────────────┐ ─────► ┌───────────────────────┐
//!   │ board          │ wiring │ vehicle: motors, │        │ body in an arena      │
//!   │  runs firmware │ ◄───── │ sensors, compass │ ◄───── │ (rover-simulator)     │
//!   └───▲────────┬───┘ counts,└─────────▲────────┘ ranges,└───────────────────────┘
//!       │ bytes  ▼     registers        │          heading
//!   ┌───┴────────────┐        ┌─────────┴────────┐
//!   │ cable ◄► port  │ ◄───── │ schedule: faults │ ────► board, its tasks and its power, too
//!   └───▲────────┬───┘        └──────────────────┘
//!       │        ▼
//!   rover_link::Client
//! ```
//!
//! [`Emulation`] lets a millisecond pass at a time: first faults begin and end, then the vehicle
//! moves by the levels on the board's pins, then the board runs on what the sensors say now, then
//! the cable carries bytes. Nothing else moves time, least of all a clock of the host: the same
//! program, arena, seed, faults and bytes from the host give the same run, to the last bit.
//!
//! | module | holds |
//! |---|---|
//! | `emulation` | board, vehicle and cable together: [`Emulation`] |
//! | [`vehicle`] | range sensors, compass, motors, a body in an arena; faults and their schedule |
//! | [`wiring`] | which pin is wired to what |
//! | [`cmps03`] | the compass as a device on the I2C bus |
//! | `cable`, `garbled` | the USB cable and the host's end of it, and what a bad cable does to bytes |
//! | `port` | the board's serial port, as [`rover_link::Port`]: [`EmulatedPort`] |
//! | `tasks` | where the firmware's tasks are, to hang or to slow one |
//! | `track` | where the vehicle was |
//! | `meter` | what is measured: times, loads, sizes |
//! | [`profile`] | how long the action cycles of the program take |
//! | `whereabouts` | what the board is doing, in words |
//!
//! # Faults
//!
//! A [`Fault`](vehicle::Fault) is data: what goes wrong. A [`Schedule`](vehicle::Schedule) says when
//! (`--fault 20+3:compass-silent`). [`Emulation`] begins and ends each one at the part it concerns,
//! in `Emulation::set_fault`, the one place to look for where a fault is injected:
//!
//! | fault of | is injected in |
//! |---|---|
//! | sensors, compass, motors, wheels | [`Vehicle::set_faults`](vehicle::Vehicle::set_faults) |
//! | USB cable, the host's end of it | `Cable::set_fault` |
//! | a task of the firmware | `Tasks::hang`, `Tasks::overrun` |
//! | the supply, the flash | `Emulation::set_fault` itself, by what the board's model offers |
//!
//! Adding a fault: a variant of [`Fault`](vehicle::Fault) and its words in `vehicle/fault.rs` (a test
//! there counts them); the compiler then asks in `Emulation::set_fault` whose it is; what it does goes
//! to that part; what the rover has to do about it goes to `tests/board_faults.rs`, or to
//! `tests/bench_rover/faults.rs` if the vehicle alone is concerned.

mod cable;
pub mod cmps03;
mod emulation;
mod garbled;
mod meter;
mod port;
pub mod profile;
mod tasks;
mod track;
pub mod vehicle;
mod whereabouts;
pub mod wiring;

pub use emulation::{Emulation, SLICE};
pub use meter::{EmulationReport, Meter, Sizes, Span};
pub use port::EmulatedPort;
