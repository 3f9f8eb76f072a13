//! The wire between rover and host: what a frame is, byte by byte.
//!
//! [`message`] defines the messages; this module and [`frame`] how they are packed. The transport
//! (USB CDC-ACM, a pipe, a test's byte queue) only carries bytes.
//!
//! # The frame
//!
//! ```text
//! before stuffing   | version u8 | sequence u16 LE | message, postcard | crc u32 LE |
//!                   0            1                 3                   n            n+4
//! on the wire       COBS(all of the above), then one byte 0
//! ```
//!
//! * **version**: [`PROTOCOL_VERSION`]. This header and the checksum are the same in all
//!   versions, so that a frame of another version is recognised and refused with a sentence
//!   instead of being read wrongly.
//! * **sequence**: counts the frames of one direction from 0, wrapping; a gap counts the lost
//!   ones. An acknowledgement quotes the command's.
//! * **message**: a [`Command`](message::Command) from the host or a [`Report`](message::Report)
//!   from the rover, in [postcard](https://postcard.jamesmunns.com/wire-format) format: integers
//!   wider than 8 bits as varints (7 bits a byte, low first; signed ones zigzag), enums as the
//!   position of the variant, structs and arrays without any frame, `Option` as 0 or 1, strings
//!   and lists with their length before them.
//! * **crc**: CRC-32/ISO-HDLC over everything before it.
//! * **COBS** replaces every 0, so that 0 only ever ends a frame: a receiver that lost its place
//!   waits for the next 0. It adds one byte, and one more for each 254 bytes without a 0. Empty
//!   frames (0 after 0) are ignored; a sender starts with a 0 to end what noise came before.
//!
//! Example, the host's `Arm` as frame number 2:
//!
//! ```text
//! version sequence message crc               stuffed                           end
//! 02      02 00    03      43 92 c0 11  ->   03 02 02 06 03 43 92 c0 11        00
//! ```

pub mod frame;
pub mod message;
pub mod transfer;
pub mod usb;

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};

/// Version of the protocol; goes up with every change of [`message`] or [`crate::contract`].
pub const PROTOCOL_VERSION: u8 = 2;

/// CRC-32 of the text of `message.rs` and `contract.rs` without comments, white space and attributes
/// for JSON Schemas, calculated by the compiler.
///
/// It needs no derive and no bookkeeping, and cannot be forgotten: whatever changes the meaning
/// of a byte changes these texts. (Types of other files that messages contain are pinned by the
/// golden frames in the tests.)
pub const SCHEMA_HASH: u32 = schema_hash(&[
    include_str!("message.rs").as_bytes(),
    include_str!("../contract.rs").as_bytes(),
]);

/// How a line begins that only says how a type is described in JSON.
const SCHEMA_ATTRIBUTE: &[u8] = b"#[cfg_attr(feature = \"schema\"";

const fn starts_with(text: &[u8], at: usize, start: &[u8]) -> bool {
    let mut i = 0;
    while i < start.len() {
        if at + i >= text.len() || text[at + i] != start[i] {
            return false;
        }
        i += 1;
    }
    true
}

const fn schema_hash(texts: &[&[u8]]) -> u32 {
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    let mut t = 0;
    while t < texts.len() {
        let (text, mut in_comment, mut i) = (texts[t], false, 0);
        while i < text.len() {
            let byte = text[i];
            if starts_with(text, i, b"//") || starts_with(text, i, SCHEMA_ATTRIBUTE) {
                in_comment = true;
            } else if byte == b'\n' {
                in_comment = false;
            }
            if !in_comment && !byte.is_ascii_whitespace() {
                digest.update(&[byte]);
            }
            i += 1;
        }
        t += 1;
    }
    digest.finalize()
}

/// Why two sides are incompatible; the text includes the remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mismatch {
    /// The other side uses a newer version.
    TheyAreNewer {
        /// Their version.
        theirs: u8,
    },
    /// The other side uses an older version.
    TheyAreOlder {
        /// Their version.
        theirs: u8,
    },
    /// Same version, but built from different sources.
    Schema {
        /// Their hash.
        theirs: u32,
    },
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ours = PROTOCOL_VERSION;
        match self {
            Self::TheyAreNewer { theirs } => write!(
                f,
                "the other side speaks protocol {theirs}, this one {ours}: update this side"
            ),
            Self::TheyAreOlder { theirs } => write!(
                f,
                "the other side speaks protocol {theirs}, this one {ours}: update the other side"
            ),
            Self::Schema { theirs } => write!(
                f,
                "both sides speak protocol {ours}, but from different sources (schema {theirs:08x} \
                 there, {SCHEMA_HASH:08x} here): build firmware and host program from the same \
                 revision"
            ),
        }
    }
}

impl core::error::Error for Mismatch {}

/// Checks the version and schema of the other side.
///
/// # Errors
/// The difference, with a sentence on what to update.
pub const fn compatible(version: u8, schema: u32) -> Result<(), Mismatch> {
    if version > PROTOCOL_VERSION {
        Err(Mismatch::TheyAreNewer { theirs: version })
    } else if version < PROTOCOL_VERSION {
        Err(Mismatch::TheyAreOlder { theirs: version })
    } else if schema != SCHEMA_HASH {
        Err(Mismatch::Schema { theirs: schema })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
