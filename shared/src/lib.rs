//! The core of Turing Rover: percept in, action out, learning inside.
//!
//! A robot's sensor readings pass through learned staircases ([`sensing`]) into the corners of a
//! two-layer 4x4 reaction-diffusion cellular network ([`perception`]); the Turing pattern it
//! settles into is bound to a movement ([`action`]); differences of [`reward`] shape both ends.
//! [`controller`] closes the loop. The architecture is that of Arena, Fortuna, Lombardo and
//! Patane, "Perception for action: dynamic spatiotemporal patterns applied on a roving robot"
//! (2008), called "the paper" throughout; section and equation numbers are the paper's.
//!
//! The crate does no input or output, reads no clock, keeps no global state and calculates in
//! integers, so that the same samples give the same bits on the microcontroller and on the host.
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
