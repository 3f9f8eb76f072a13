//! The emulated board: a Cortex-M0+ of our own and what it is connected to.
//!
//! [`cpu`] is the processor core, without a clock or memory of its own: it is stepped on a
//! [`cpu::Bus`]. [`elf`] reads what is to be run. [`machine`] is an RP2040 with 2 MB of flash, on
//! which the firmware runs unmodified; [`bare`] is the smallest machine that runs a program: flash,
//! RAM and semihosting.
//!
//! ```text
//!  machine ── time, power, resets, probes
//!    ├ cpu            fetches, loads, stores     ┌ memory: ROM, RAM
//!    └ bus ───────────────────────────────────►  ├ flash, behind ssi and xip
//!        └ boot_services: the ROM's functions    ├ sio
//!                                                └ peripherals: registers by address
//!                                                     timer, watchdog, gpio, ...
//! ```
//!
//! What is missing: the second core, UART, SPI, PIO and RTC, wait states and the flash cache. What
//! takes the clock to stop or change (dormant and deep sleep) has no effect.
//!
//! [`peripheral`] says what a block of registers is to the bus. [`usb`] is the one with a cable: the
//! device controller and the computer at the other end.

pub mod adc;
pub mod bare;
pub mod binary_info;
mod boot_rom;
mod boot_services;
pub mod bus;
mod clocks;
pub mod cpu;
pub mod dma;
mod dma_transfers;
pub mod elf;
mod flash;
mod gpio;
pub mod i2c;
pub mod incident;
mod latches;
pub mod machine;
mod memory;
mod pads;
pub mod peripheral;
pub mod peripherals;
pub mod pins;
mod pll;
pub mod probe;
pub mod profile;
mod psm;
pub mod pwm;
mod resets;
mod rosc;
#[cfg(feature = "defmt")]
pub mod rtt;
mod sio;
mod ssi;
mod stack;
mod sysinfo;
mod timer;
pub mod usb;
mod vreg_and_chip_reset;
mod watchdog;
mod xip;
mod xosc;

pub use incident::{Incident, Incidents};
pub use machine::Machine;
