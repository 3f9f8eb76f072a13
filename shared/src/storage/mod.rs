//! Bytes kept in NOR flash, whole or not at all: two slots, written in turn.
//!
//! ```text
//! slot      page 0: header                                            pages 1 to n: content
//! header    magic "TRVS" | sequence u32 | length u32 | fingerprint u32 | CRC-32 of these 16 bytes
//! ```
//!
//! (All little-endian; the rest of page 0 stays erased. The
//! [`fingerprint`](crate::checksum::fingerprint) is the content's.) Of the slots whose header and
//! content are valid, the one with the higher sequence number counts. A write goes to the other
//! slot: erase as many sectors as needed, program the content, read it back, and only then program
//! the header, read back too. So a power cut leaves an invalid slot, and the previous one
//! untouched.
//!
//! **Wear**: a sector endures 100,000 erasures (W25Q16JV data sheet), each write erases the sectors of
//! one of the two slots once, and the sequence number counts the writes: after [`MOST_WRITES`] the
//! slots are read-only. Writing the present content again does nothing.
//!
//! A [`Write`] executes one flash operation per [`step`](Write::step), because on the board each
//! stops the program for 0.4 ms (a page) to 400 ms (a sector at its worst).

mod flash;
mod slots;
mod write;

pub use flash::{Flash, LONGEST_ERASURE, PAGE, SECTOR};
pub use slots::{Content, MOST_WRITES, Record, Slots};
pub use write::{Progress, Write, WriteError};

#[cfg(test)]
mod tests;
