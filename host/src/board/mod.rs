//! The emulated board: a Cortex-M0+ of our own and what it is connected to.
//!
//! [`cpu`] is the processor core, without a clock or memory of its own: it is stepped on a
//! [`cpu::Bus`]. [`elf`] reads what is to be run. [`bare`] is the smallest machine that runs it:
//! flash, RAM and semihosting.

pub mod adc;
pub mod bare;
pub mod compass;
pub mod cpu;
pub mod dma;
pub mod elf;
pub mod i2c;
pub mod peripheral;
pub mod pwm;
