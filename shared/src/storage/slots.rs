//! The two slots and what they hold.

use super::flash::{Flash, PAGE, SECTOR};
use crate::checksum::{CRC32, digest, fingerprint};

/// Writes until the flash may be worn out: 100,000 erasures of either slot.
pub const MOST_WRITES: u32 = 200_000;

pub(super) const MAGIC: [u8; 4] = *b"TRVS";
pub(super) const HEADER: usize = 20;

/// A slot's header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    pub(super) slot: u8,
    pub(super) sequence: u32,
    pub(super) length: u32,
    pub(super) checksum: u32,
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

    /// Number of writes up to this record.
    pub const fn writes(&self) -> u32 {
        self.sequence
    }
}

/// The content of two slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Nothing was ever written: both headers are erased.
    Blank,
    /// Something was written, and neither slot is whole.
    Damaged,
    /// The newest whole content.
    Whole(Record),
}

/// Two consecutive slots in the flash.
#[derive(Clone, Copy, Debug)]
pub struct Slots {
    start: u32,
    sectors: u32,
    pub(super) content: Content,
}

impl Slots {
    /// Unopened slots from `start` on (a multiple of [`SECTOR`]), each with this many sectors.
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

    /// Reads and checks both slots.
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

    /// The content found by [`open`](Self::open), or [written](Self::written) since.
    pub const fn content(&self) -> Content {
        self.content
    }

    /// Most bytes of content.
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

    /// Makes the record of a finished [`Write`](super::Write) the newest content.
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

    /// Returns the fingerprint of the bytes at the record's place.
    pub(super) fn checksum<F: Flash>(
        &self,
        flash: &mut F,
        record: &Record,
    ) -> Result<u32, F::Error> {
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

    /// Returns the offset of a slot's page.
    pub(super) const fn page(&self, slot: u8, page: u32) -> u32 {
        self.start + slot as u32 * self.sectors * SECTOR + page * PAGE as u32
    }
}

enum Look {
    Blank,
    Damaged,
    Whole(Record),
}

impl Record {
    pub(super) fn encode(&self) -> [u8; HEADER] {
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
