//! Turing Rover's simulator: the world of section III-A, learning and testing in it, and what to
//! compare with.
//!
//! Nothing here decides what a robot perceives, does or learns: that is `rover_shared`, the same
//! core as the firmware's.
//!
//! | module | holds |
//! |---|---|
//! | [`arena`] | walls, obstacles, robots, sensors; random arenas and arena files |
//! | [`experiment`] | trials, learning sessions, tests, measures |
//! | [`baseline`] | controllers to compare with |
//! | [`reference`](mod@reference) | eq. (1) to the letter, in f64 |
//! | [`parameters`] | parameter files |

pub mod arena;
pub mod baseline;
mod chance;
pub mod experiment;
pub mod parameters;
pub mod reference;
