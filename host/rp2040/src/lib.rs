//! An emulated RP2040 with 2 MB of flash: it boots the same ELF file as the chip, in a time of its own
//! that is the same in every run.
//!
//! ```
//! use emulated_rp2040::elf::Image;
//! use emulated_rp2040::peripheral::CYCLES_PER_MICROSECOND;
//! use emulated_rp2040::pins::Output;
//! use emulated_rp2040::rtt::Reader;
//! use emulated_rp2040::Machine;
//!
//! const MS: u64 = 1_000 * CYCLES_PER_MICROSECOND;
//!
//! // `blink/` of this crate's repository: an Embassy program with an LED and a button.
//! let image = Image::parse(&std::fs::read("tests/data/blink.elf")?)?;
//! let mut machine = Machine::new(&image, 0)?;
//! let mut rtt = Reader::new(&image);
//!
//! machine.run_until(400 * MS);
//! assert_eq!(machine.output(25), Output::Level(true));
//! assert_eq!(rtt.lines(&mut machine), ["LED on"]);
//!
//! // The button connects GPIO 15 with ground.
//! machine.set_input(15, Some(false));
//! machine.run_until(460 * MS);
//! assert_eq!(machine.output(25), Output::Level(false));
//! assert_eq!(rtt.lines(&mut machine), ["every 50 ms", "LED off"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`machine`] | [`Machine`]: chip, flash, what is wired to the pins; time, power, faults to inject |
//! | [`elf`], [`uf2`] | programs as they are loaded, and as the boot ROM's drive takes them |
//! | [`pins`], [`adc`], [`i2c`], [`usb`] | what is connected to the chip: levels, voltages, devices, a host |
//! | [`rtt`], `defmt` | what the program logs: text, and with the feature `defmt` its frames |
//! | [`probe`], [`incident`] | cycles of function calls; faults, resets, power cuts |
//! | [`cpu`] | the Cortex-M0+ alone, stepped on a [`cpu::Bus`] |
//! | [`bare`] | the smallest machine around it: flash, RAM and semihosting |
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
//! The README has the table of what is modelled and what is not. [`peripheral`] is what a block of
//! registers is to the bus: where to begin with one that is missing. There are no threads, files or
//! clocks in the crate: it builds for `wasm32-unknown-unknown`.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod adc;
pub mod bare;
pub mod binary_info;
mod boot_rom;
mod boot_services;
pub mod bus;
mod clocks;
pub mod cpu;
#[cfg(feature = "defmt")]
pub mod defmt;
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
mod psm;
pub mod pwm;
mod resets;
mod rosc;
pub mod rtt;
mod sio;
mod ssi;
mod stack;
mod sysinfo;
mod timer;
pub mod uf2;
pub mod usb;
mod vreg_and_chip_reset;
mod watchdog;
mod xip;
mod xosc;

pub use incident::{Incident, Incidents};
pub use machine::Machine;
