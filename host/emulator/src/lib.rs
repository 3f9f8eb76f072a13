//! The emulated rover: an emulated board that boots the firmware, wired to a model of the vehicle,
//! in one time.
//!
//! | module | holds |
//! |---|---|
//! | [`vehicle`] | range sensors, compass, motors, a body in an arena; faults |
//! | [`cmps03`] | the compass as a device on the I2C bus |
//! | [`emulation`] | board, vehicle and USB cable together: [`emulation::Emulation`] |
//! | [`port`] | the board's serial port, as [`rover_link::Port`] |
//! | [`profile`] | how long the action cycles of the program take |

pub mod cmps03;
pub mod emulation;
pub mod port;
pub mod profile;
pub mod vehicle;
