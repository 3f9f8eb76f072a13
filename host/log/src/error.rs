//! Why a file cannot be read.

use crate::format::{FORMAT, OLDEST};

/// Why a file is not a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It is not MCAP.
    #[error("not an MCAP file")]
    NotMcap,
    /// It is MCAP, but was not written by this program.
    #[error("an MCAP file, but not a log of a Turing rover: {0} is missing")]
    Foreign(&'static str),
    /// It is of another version.
    #[error("a log of format {0}, expected {OLDEST} to {FORMAT}: use the version that wrote it")]
    Format(String),
    /// It is a recording that begins in the middle of a drive.
    #[error(
        "a recording in which no session's starting knowledge is known: record from before the \
         rover begins to drive"
    )]
    NoStart,
    /// The record at this byte has a wrong checksum, or claims to hold more than it does.
    #[error("damaged at byte {0}")]
    Damaged(usize),
    /// The checksum over all records is wrong.
    #[error("damaged: the checksum of the file does not match")]
    Checksum,
    /// The records are compressed in a way that is not known.
    #[error("compressed with {0}, expected zstd, lz4 or no compression")]
    Compression(String),
    /// A message is not what its channel holds.
    #[error("message {0} is not valid: {1}")]
    Message(usize, serde_json::Error),
}
