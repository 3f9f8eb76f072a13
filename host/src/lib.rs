//! The host companion of Turing Rover: the simulator, experiments, and replay of logs.
//!
//! Everything here drives the same core as the firmware, `rover_shared`; nothing here decides what
//! a robot perceives, does or learns. See `ARCHITECTURE.md` for how data flows.

pub mod arena;
pub mod baseline;
pub mod board;
pub mod cli;
pub mod drive_report;
pub mod emulation;
pub mod experiment;
pub mod figure;
pub mod files;
pub mod knowledge;
pub mod link;
pub mod log;
pub mod monitor;
pub mod parameters;
pub mod recorder;
pub mod reference;
pub mod replay;
pub mod report;
pub mod vehicle;
pub mod words;
