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

mod write;

pub use write::{Progress, Write, WriteError};

use crate::time::Duration;
use crate::wire::CRC32;
use crate::wire::transfer::{digest, fingerprint};

/// Bytes that are erased together.
pub const SECTOR: u32 = 4_096;
/// How long the erasure of a sector takes at worst (W25Q16JV data sheet, 9.6, tSE).
pub const LONGEST_ERASURE: Duration = Duration::from_millis(400);
/// Bytes that are programmed together.
pub const PAGE: usize = 256;
/// Writes until the flash may be worn out: 100,000 erasures of either slot.
pub const MOST_WRITES: u32 = 200_000;

const MAGIC: [u8; 4] = *b"TRVS";
const HEADER: usize = 20;

/// A NOR flash: erasing sets all bits of a sector, programming clears bits of a page.
pub trait Flash {
    /// Why an operation failed.
    type Error;

    /// Reads from `offset` bytes after the flash's start.
    ///
    /// # Errors
    /// The flash's.
    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), Self::Error>;

    /// Erases the sector that starts at `offset`.
    ///
    /// # Errors
    /// The flash's.
    fn erase(&mut self, offset: u32) -> Result<(), Self::Error>;

    /// Programs the page that starts at `offset`, and was erased.
    ///
    /// # Errors
    /// The flash's.
    fn program(&mut self, offset: u32, page: &[u8; PAGE]) -> Result<(), Self::Error>;
}

/// What is known of a slot's content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    slot: u8,
    sequence: u32,
    length: u32,
    checksum: u32,
}

impl Record {
    /// Length of the content in bytes.
    pub const fn length(&self) -> usize {
        self.length as usize
    }

    /// The content's [`fingerprint`].
    pub const fn fingerprint(&self) -> u32 {
        self.checksum
    }

    /// How often the slots were written up to this record.
    pub const fn writes(&self) -> u32 {
        self.sequence
    }
}

/// What two slots hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Nothing was ever written: both headers are erased.
    Blank,
    /// Something was written, and neither slot is whole.
    Damaged,
    /// The newest whole content.
    Whole(Record),
}

/// Two slots that follow each other in the flash.
#[derive(Clone, Copy, Debug)]
pub struct Slots {
    start: u32,
    sectors: u32,
    content: Content,
}

impl Slots {
    /// Slots that have not been looked at, from `start` on (a multiple of [`SECTOR`]), each with
    /// this many sectors.
    pub const fn new(start: u32, sectors: u32) -> Self {
        assert!(
            start.is_multiple_of(SECTOR) && sectors > 0,
            "slots are made of sectors"
        );
        Self {
            start,
            sectors,
            content: Content::Damaged,
        }
    }

    /// Looks at both slots.
    ///
    /// # Errors
    /// The flash's.
    pub fn open<F: Flash>(&mut self, flash: &mut F) -> Result<Content, F::Error> {
        self.content = match (self.look(flash, 0)?, self.look(flash, 1)?) {
            (Look::Whole(a), Look::Whole(b)) if a.sequence < b.sequence => Content::Whole(b),
            (Look::Whole(record), _) | (_, Look::Whole(record)) => Content::Whole(record),
            (Look::Blank, Look::Blank) => Content::Blank,
            _ => Content::Damaged,
        };
        Ok(self.content)
    }

    /// What [`open`](Self::open) found, or was written since.
    pub const fn content(&self) -> Content {
        self.content
    }

    /// How many bytes a slot takes.
    pub const fn capacity(&self) -> usize {
        (self.sectors * SECTOR) as usize - PAGE
    }

    /// Reads the newest content into `buffer`; `None` if there is none or it is longer.
    ///
    /// # Errors
    /// The flash's.
    pub fn read<'b, F: Flash>(
        &self,
        flash: &mut F,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, F::Error> {
        let Content::Whole(record) = self.content else {
            return Ok(None);
        };
        let Some(bytes) = buffer.get_mut(..record.length()) else {
            return Ok(None);
        };
        flash.read(self.page(record.slot, 1), bytes)?;
        let whole = fingerprint(bytes) == record.checksum;
        Ok(if whole { Some(bytes) } else { None })
    }

    /// Takes the record of a write that is [`Progress::Done`].
    pub fn written(&mut self, record: Record) {
        self.content = Content::Whole(record);
    }

    fn look<F: Flash>(&self, flash: &mut F, slot: u8) -> Result<Look, F::Error> {
        let mut header = [0; HEADER];
        flash.read(self.page(slot, 0), &mut header)?;
        if header == [0xFF; HEADER] {
            return Ok(Look::Blank);
        }
        let Some(record) = Record::decode(slot, &header) else {
            return Ok(Look::Damaged);
        };
        if record.length() > self.capacity() {
            return Ok(Look::Damaged);
        }
        let whole = self.checksum(flash, &record)? == record.checksum;
        Ok(if whole {
            Look::Whole(record)
        } else {
            Look::Damaged
        })
    }

    /// Fingerprint of what stands where the record's content should.
    fn checksum<F: Flash>(&self, flash: &mut F, record: &Record) -> Result<u32, F::Error> {
        let mut digest = digest();
        let mut page = [0; PAGE];
        let (mut offset, mut left) = (self.page(record.slot, 1), record.length());
        while left > 0 {
            let piece = page.get_mut(..left.min(PAGE)).unwrap_or_default();
            flash.read(offset, piece)?;
            digest.update(piece);
            offset += PAGE as u32;
            left -= piece.len();
        }
        Ok(digest.finalize())
    }

    /// Offset of a slot's page.
    const fn page(&self, slot: u8, page: u32) -> u32 {
        self.start + slot as u32 * self.sectors * SECTOR + page * PAGE as u32
    }
}

enum Look {
    Blank,
    Damaged,
    Whole(Record),
}

impl Record {
    fn encode(&self) -> [u8; HEADER] {
        let mut header = [0; HEADER];
        let fields = [self.sequence, self.length, self.checksum].map(u32::to_le_bytes);
        let (content, sum) = header.split_at_mut(HEADER - 4);
        let words = [&MAGIC].into_iter().chain(&fields);
        for (place, word) in content.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(word);
        }
        sum.copy_from_slice(&CRC32.checksum(content).to_le_bytes());
        header
    }

    fn decode(slot: u8, header: &[u8; HEADER]) -> Option<Self> {
        let (content, sum) = header.split_last_chunk::<4>()?;
        let content = content.strip_prefix(&MAGIC)?;
        let word = |i: usize| Some(u32::from_le_bytes(*content.get(4 * i..)?.first_chunk()?));
        let record = Self {
            slot,
            sequence: word(0)?,
            length: word(1)?,
            checksum: word(2)?,
        };
        (record.encode().last_chunk() == Some(sum)).then_some(record)
    }
}

#[cfg(test)]
mod tests;
