//! A Cortex-M0+ (ARMv6-M with the unprivileged/privileged and vector table offset extensions, a
//! single-cycle multiplier, 32 interrupts, no debug, no memory protection), executed instruction
//! by instruction.
//!
//! Section numbers are those of the ARMv6-M Architecture Reference Manual, cycles those of the
//! Cortex-M0+ Technical Reference Manual (r0p1) for memory without wait states.
//!
//! The core has no clock: [`Core::step`] executes one instruction or takes one exception and says
//! how many cycles that took. While the core is [`sleeping`](Core::sleeping), time passes by
//! [`Core::idle`], as much at once as its owner likes, so that a machine can go straight to its
//! next event:
//!
//! ```
//! # use emulated_rp2040::cpu::{Bus, Core};
//! fn run<B: Bus>(core: &mut Core, bus: &mut B, next_event: u64, now: &mut u64) {
//!     while *now < next_event {
//!         *now += u64::from(core.step(bus));
//!         if core.sleeping() {
//!             let rest = next_event.saturating_sub(*now);
//!             let nap = core.cycles_to_systick().map_or(rest, |wake| rest.min(wake));
//!             core.idle(nap);
//!             *now += nap;
//!         }
//!     }
//! }
//! ```
//!
//! What the manual leaves open: UNPREDICTABLE forms of instructions do what their pseudocode does,
//! or fault; UNPREDICTABLE exception returns fault; UNKNOWN values stay as they were.

mod arithmetic;
mod branch;
mod bus;
mod core;
mod data_processing;
mod decode;
mod exceptions;
mod execute;
mod fault;
mod load_store;
mod miscellaneous;
mod nvic;
mod registers;
mod system;
mod systick;

pub use bus::{Bus, BusFault};
pub use core::{Activity, Core};
pub use fault::{FaultCause, FaultReport};
pub use nvic::exception;
pub use registers::{Flags, LR, PC, Registers, SP};
