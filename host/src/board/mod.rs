//! The emulated board: a Cortex-M0+ of our own and what it is connected to.
//!
//! [`cpu`] is the processor core, without a clock or memory of its own: it is stepped on a
//! [`cpu::Bus`]. [`elf`] reads what is to be run. [`bare`] is the smallest machine that runs it:
//! flash, RAM and semihosting.
//!
//! [`peripheral`] says what a block of registers is to the bus. [`usb`] is the one with a cable: the
//! device controller and the computer at the other end.

pub mod bare;
pub mod cpu;
pub mod elf;
pub mod peripheral;
pub mod usb;
