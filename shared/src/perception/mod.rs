//! The perceptual core (II-B): a two-layer 4x4 RD-CNN whose steady state is the percept.
//!
//! The four sensing neurons set the corners of layer 1 ([`Corners`]), layer 2 starts from small
//! noise ([`Noise`]), and [`Lattice::settle`] lets eq. 1 run until every cell of layer 1 has
//! saturated: that Turing pattern, as a [`PatternCode`], is what the rover perceives.

mod fixed_point;
mod lattice;
mod parameters;
mod pattern;
mod spectrum;
mod tables;
mod transform;

pub use lattice::{Corners, DidNotSettle, MAX_TIME, Noise, SettleTime, Settled};
pub use parameters::{LatticeError, LatticeParameters};
pub use pattern::{PatternCode, Picture};
pub use tables::Lattice;
