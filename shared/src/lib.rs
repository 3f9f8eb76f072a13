//! The core of Turing Rover: percept in, action out, learning inside.
//!
//! A robot's sensor readings pass through learned staircases ([`sensing`]) into the corners of a
//! two-layer 4x4 reaction-diffusion cellular network ([`perception`]); the Turing pattern it
//! settles into is bound to a movement ([`action`]); differences of [`reward`] shape both ends, by
//! a [`learning`] rule. [`controller`] closes the loop. The architecture is that of Arena, Fortuna,
//! Lombardo and Patane, "Perception for action: dynamic spatiotemporal patterns applied on a roving
//! robot" (2008), called "the paper" throughout; section and equation numbers are the paper's.
//!
//! The crate does no input or output, reads no clock, keeps no global state and calculates in
//! integers, so that the same samples give the same bits on the microcontroller and on the host. A
//! driver (firmware, simulator, replay) owns the world and calls
//! [`Controller::step`](controller::Controller::step):
//!
//! ```
//! use rover_shared::controller::Controller;
//! use rover_shared::knowledge::Knowledge;
//! use rover_shared::learning::{Mode, paper_rule::PaperRule};
//! use rover_shared::parameters::{Coefficients, Parameters};
//! use rover_shared::random::Generator;
//! use rover_shared::reward::AimAtTarget;
//! use rover_shared::sensing::Sample;
//! use rover_shared::units::{Microdegrees, Micrometres};
//!
//! // A tiny world: an open field, in which the robot turns on the spot and the target lies at 0.
//! let sample = |heading| Sample {
//!     front: Micrometres::from_cm(500),
//!     left: Micrometres::from_cm(500),
//!     right: Micrometres::from_cm(500),
//!     heading,
//!     target_bearing: Some(Microdegrees(0)),
//! };
//! let coefficients = Coefficients::new(&Parameters::PAPER)?;
//! let mut knowledge = Knowledge::new(&coefficients.learning);
//!
//! // Heading error in degrees after 15 actions, averaged over 100 starts.
//! let mut error = |mode| {
//!     let rng = Generator::new(7);
//!     let mut controller = Controller::new(&coefficients, PaperRule, &mut knowledge, rng, mode);
//!     let mut total = 0;
//!     for start in 0..100 {
//!         let mut heading = Microdegrees::wrapped(start * 37_000_000);
//!         for _ in 0..15 {
//!             let record = controller.step(&sample(heading), &AimAtTarget);
//!             heading = heading.turned(record.action.phase);
//!         }
//!         controller.conclude(&sample(heading), &AimAtTarget);
//!         total += heading.0.abs() / Microdegrees::PER_DEGREE;
//!     }
//!     total / 100
//! };
//! let before = error(Mode::Run);
//! error(Mode::Learn);
//! let after = error(Mode::Run);
//! assert!(after < before / 2, "{after} instead of {before} degrees");
//! # Ok::<(), rover_shared::range_check::ParameterError>(())
//! ```
//!
//! `examples/` shows the lattice alone (`perceive`) and another learning rule (`custom_rule`).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod action;
pub mod calibration;
pub mod checksum;
pub mod contract;
pub mod controller;
pub mod knowledge;
pub mod last_words;
pub mod learning;
pub mod math;
pub mod motion;
pub mod parameters;
pub mod perception;
pub mod random;
pub mod range_check;
pub mod reward;
pub mod rover;
pub mod sensing;
mod series;
pub mod storage;
pub mod supervisor;
pub mod time;
pub mod units;
pub mod wire;
