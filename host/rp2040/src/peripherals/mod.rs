//! All register blocks: where they are, what resets them, and what they do to each other.

mod blocks;
mod pin_levels;
mod restart;

pub use blocks::{Peripherals, Unmodelled};
