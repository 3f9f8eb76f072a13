//! Turing Rover's command line and dashboard.

pub mod cli;
pub mod lines;
pub mod monitor;
