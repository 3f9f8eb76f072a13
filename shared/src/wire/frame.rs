//! Frames: from a message to bytes and back. The layout is described in [`super`].
//!
//! ```
//! use rover_shared::wire::frame::{Decoder, Encoder, MAX_FRAME};
//! use rover_shared::wire::message::Command;
//!
//! let (mut encoder, mut buffer) = (Encoder::new(), [0; MAX_FRAME]);
//! let frame = encoder.encode(&Command::Arm, &mut buffer).expect("it fits");
//!
//! let mut decoder = Decoder::new();
//! let noise = [1, 2, 3, 0]; // what came before ends with the next 0
//! let results = noise.iter().chain(frame).filter_map(|&byte| decoder.push::<Command>(byte));
//! let messages: Vec<_> = results.filter_map(|result| result.ok()).map(|f| f.message).collect();
//! assert_eq!(messages, [Command::Arm]);
//! assert_eq!(decoder.counters().dropped(), 1);
//! ```

use postcard::ser_flavors::crc::CrcModifier;
use postcard::ser_flavors::{Cobs, Slice};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Mismatch, PROTOCOL_VERSION, compatible};
use crate::checksum::CRC32;

/// Longest frame before stuffing, in bytes: the largest message of the contract (an action
/// record with every number at its longest) takes 269.
pub const MAX_PLAIN: usize = 288;
/// Longest frame on the wire, in bytes: stuffing adds one byte for each 254 begun, and the 0.
pub const MAX_FRAME: usize = MAX_PLAIN + MAX_PLAIN.div_ceil(254) + 1;

const HEADER: usize = 3;
const CHECKSUM: usize = 4;

/// Packs messages, and numbers them.
#[derive(Clone, Debug, Default)]
pub struct Encoder {
    next: u16,
}

/// The message does not fit into the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong;

impl Encoder {
    /// An encoder whose first frame has number 0.
    pub const fn new() -> Self {
        Self { next: 0 }
    }

    /// The number of the frame packed next.
    pub const fn next_sequence(&self) -> u16 {
        self.next
    }

    /// Packs one message; returns the frame, its 0 included. [`MAX_FRAME`] bytes hold any message.
    ///
    /// # Errors
    /// The buffer is too short; the number is not used up.
    pub fn encode<'a, T: Serialize>(
        &mut self,
        message: &T,
        buffer: &'a mut [u8],
    ) -> Result<&'a [u8], TooLong> {
        let frame = encode_as(PROTOCOL_VERSION, self.next, message, buffer)?;
        self.next = self.next.wrapping_add(1);
        Ok(frame)
    }
}

fn encode_as<'a, T: Serialize>(
    version: u8,
    sequence: u16,
    message: &T,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], TooLong> {
    let stuffed = Cobs::try_new(Slice::new(buffer)).map_err(|_| TooLong)?;
    let checked = CrcModifier::new(stuffed, CRC32.digest());
    // Bytes and byte arrays are the only things that postcard writes as they are.
    let plain = (version, sequence.to_le_bytes(), message);
    let frame = postcard::serialize_with_flavor(&plain, checked).map_err(|_| TooLong)?;
    Ok(frame)
}

/// A message that arrived whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame<T> {
    /// Its number.
    pub sequence: u16,
    /// Frames lost since the one before: the gap of the numbers; 0 for the first frame, and for
    /// number 0, with which a sender restarts.
    pub lost: u16,
    /// The message.
    pub message: T,
}

/// Why a frame was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The 0 came in the middle of a stuffed block.
    Cobs,
    /// Longer than [`MAX_PLAIN`].
    Overlong,
    /// Too short to hold header, message and checksum.
    Truncated,
    /// The checksum does not match.
    Crc,
    /// Whole, but of another protocol version.
    Version(Mismatch),
    /// Whole, but not a message of the contract.
    Message,
}

/// How many frames were dropped, by reason; they stop at the largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct FrameCounters {
    /// [`FrameError::Cobs`].
    pub cobs: u32,
    /// [`FrameError::Overlong`].
    pub overlong: u32,
    /// [`FrameError::Truncated`].
    pub truncated: u32,
    /// [`FrameError::Crc`].
    pub crc: u32,
    /// [`FrameError::Version`].
    pub version: u32,
    /// [`FrameError::Message`].
    pub message: u32,
    /// Frames that never arrived, by the gaps of the sequence numbers.
    pub lost: u32,
}

impl FrameCounters {
    /// All frames that arrived and were dropped.
    pub const fn dropped(&self) -> u32 {
        self.cobs
            .saturating_add(self.overlong)
            .saturating_add(self.truncated)
            .saturating_add(self.crc)
            .saturating_add(self.version)
            .saturating_add(self.message)
    }

    fn count(&mut self, error: FrameError) {
        let counter = match error {
            FrameError::Cobs => &mut self.cobs,
            FrameError::Overlong => &mut self.overlong,
            FrameError::Truncated => &mut self.truncated,
            FrameError::Crc => &mut self.crc,
            FrameError::Version(_) => &mut self.version,
            FrameError::Message => &mut self.message,
        };
        *counter = counter.saturating_add(1);
    }
}

/// Finds frames in a stream of bytes, whatever the bytes are.
///
/// The stuffing is undone as bytes come in, so that one buffer of [`MAX_PLAIN`] bytes is all the
/// memory there is. (This is a decoder of our own for that reason; the tests hold it against
/// postcard's encoder.)
#[derive(Clone, Debug)]
pub struct Decoder {
    plain: [u8; MAX_PLAIN],
    /// Bytes of `plain` in use.
    length: usize,
    /// Bytes left of the stuffed block, its code byte not counted.
    block: u8,
    /// Whether a 0 stands between the block and the next one.
    zero_follows: bool,
    /// Whether any byte came since the last 0.
    begun: bool,
    overlong: bool,
    expected: Option<u16>,
    counters: FrameCounters,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder at the start of a frame.
    pub const fn new() -> Self {
        Self {
            plain: [0; MAX_PLAIN],
            length: 0,
            block: 0,
            zero_follows: false,
            begun: false,
            overlong: false,
            expected: None,
            counters: FrameCounters {
                cobs: 0,
                overlong: 0,
                truncated: 0,
                crc: 0,
                version: 0,
                message: 0,
                lost: 0,
            },
        }
    }

    /// What was dropped so far.
    pub const fn counters(&self) -> &FrameCounters {
        &self.counters
    }

    /// Decodes the next byte; returns a message or an error when it ends a frame, else `None`.
    pub fn push<T: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<Frame<T>, FrameError>> {
        if byte != 0 {
            self.unstuff(byte);
            return None;
        }
        let result = self.begun.then(|| self.finish());
        self.length = 0;
        self.block = 0;
        self.zero_follows = false;
        self.begun = false;
        self.overlong = false;
        if let Some(Err(error)) = &result {
            self.counters.count(*error);
        }
        result
    }

    /// Decodes COBS: a code byte n means that n - 1 bytes follow, and then a 0 unless n is 255.
    fn unstuff(&mut self, byte: u8) {
        self.begun = true;
        if self.block > 0 {
            self.block -= 1;
            self.store(byte);
            return;
        }
        if self.zero_follows {
            self.store(0);
        }
        self.block = byte - 1;
        self.zero_follows = byte != u8::MAX;
    }

    fn store(&mut self, byte: u8) {
        match self.plain.get_mut(self.length) {
            Some(place) => {
                *place = byte;
                self.length += 1;
            }
            None => self.overlong = true,
        }
    }

    fn finish<T: DeserializeOwned>(&mut self) -> Result<Frame<T>, FrameError> {
        if self.overlong {
            return Err(FrameError::Overlong);
        }
        if self.block > 0 {
            return Err(FrameError::Cobs);
        }
        let plain = self.plain.get(..self.length).unwrap_or(&[]);
        let (content, checksum) = plain
            .split_last_chunk::<CHECKSUM>()
            .ok_or(FrameError::Truncated)?;
        let (header, message) = content
            .split_first_chunk::<HEADER>()
            .ok_or(FrameError::Truncated)?;
        if CRC32.checksum(content) != u32::from_le_bytes(*checksum) {
            return Err(FrameError::Crc);
        }
        let [version, low, high] = *header;
        if version != PROTOCOL_VERSION {
            // The schema is not known yet: only the version can differ here.
            let mismatch = compatible(version, super::SCHEMA_HASH);
            return Err(mismatch.map_or_else(FrameError::Version, |()| FrameError::Message));
        }
        let sequence = u16::from_le_bytes([low, high]);
        // Number 0: the sender has restarted, or the number has wrapped.
        let expected = self.expected.filter(|_| sequence != 0).unwrap_or(sequence);
        let lost = sequence.wrapping_sub(expected);
        self.expected = Some(sequence.wrapping_add(1));
        self.counters.lost = self.counters.lost.saturating_add(u32::from(lost));
        match postcard::take_from_bytes(message) {
            Ok((message, [])) => Ok(Frame {
                sequence,
                lost,
                message,
            }),
            _ => Err(FrameError::Message),
        }
    }
}
