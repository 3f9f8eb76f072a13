//! Bytes kept in NOR flash, whole or not at all: two slots, written in turn.
//!
//! ```text
//! slot      page 0: header                                            pages 1 to n: content
//! header    magic "TRVS" | sequence u32 | length u32 | fingerprint u32 | CRC-32 of these 16 bytes
//! ```
//!
//! (All little-endian; the rest of page 0 stays erased. The [`fingerprint`] is the content's.) The content is the one of the slot with
//! a right header, a right content, and the higher sequence number. A write always goes to the
//! other slot: erase as many sectors as it needs, program the content, read it back, and only then
//! program the header, read back too. So whatever a power cut leaves half-done is in a slot that
//! has no right header or no right content, and the slot before it was not touched.
//!
//! **Wear**: sectors stand 100,000 erasures (W25Q16JV data sheet), each write erases a sector of one
//! of the two slots once, and the sequence number counts the writes: after [`MOST_WRITES`] the slots
//! are closed to writing and can still be read. Writing what is there already does nothing.
//!
//! A [`Write`] goes on by one operation of the flash a [`step`](Write::step), because on the board
//! each stops the program from 0.4 ms (a page) to 400 ms (a sector at its worst).

mod flash;
mod slots;
mod write;

pub use flash::{Flash, PAGE, SECTOR};
pub use slots::{Content, MOST_WRITES, Record, Slots};
pub use write::{Progress, Write, WriteError};

#[cfg(test)]
mod tests;
