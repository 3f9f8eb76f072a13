//! The DMA controller (RP2040 datasheet 2.5).
//!
//! The controller decides what is to be moved, and the bus moves it: [`Dma::next_transfer`] gives
//! the next transfer that may be made, the bus makes it, and [`Dma::completed`] takes the outcome.
//! Between the two the bus may access the controller's own registers, as channels that reprogram
//! other channels do.
//!
//! ```
//! # use emulated_rp2040::dma::{Dma, Outcome, Size};
//! # fn read(_: u32, _: Size) -> Option<u32> { Some(0) }
//! # fn write(_: u32, _: Size, _: u32) -> Option<()> { Some(()) }
//! # let (mut dma, requests, now) = (Dma::new(), 0, 0);
//! if !dma.is_idle() {
//!     while let Some(transfer) = dma.next_transfer(requests, now) {
//!         let outcome = match read(transfer.from, transfer.size) {
//!             None => Outcome::ReadError,
//!             Some(data) => match write(transfer.to, transfer.size, transfer.swapped(data)) {
//!                 None => Outcome::WriteError,
//!                 Some(()) => Outcome::Moved(data),
//!             },
//!         };
//!         dma.completed(transfer, outcome);
//!     }
//! }
//! ```
//!
//! The hardware makes one transfer in a cycle at best, so that the bus should not ask more often
//! than once a cycle. Here a transfer is over when it has begun: there is nothing in flight, aborts
//! are immediate and raise no interrupt (they can in hardware, erratum RP2040-E13), and the FIFOs
//! between the controller's stages are always empty.
//!
//! Peripherals with FIFOs ask for transfers for as long as there is something to be moved: their
//! requests are levels, a bit each in what [`Dma::next_transfer`] is given. The wraps of PWM
//! counters are moments, and each is good for one transfer: [`Dma::request_once`]. The pacing
//! timers are the controller's own.

mod channel;
mod controller;
mod registers;
mod sniffer;
#[cfg(test)]
mod tests;
mod timer;
mod transfer;

pub use controller::Dma;
pub use registers::{CHANNELS, IRQS, treq};
pub use transfer::{Outcome, Size, Transfer};
