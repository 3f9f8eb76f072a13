//! Writing a slot, one flash operation at a time.

use super::flash::{Flash, PAGE, SECTOR};
use super::slots::{Content, HEADER, MOST_WRITES, Record, Slots};
use crate::checksum::fingerprint;

/// A write under way. Dropping it leaves the previous content in force.
#[derive(Clone, Copy, Debug)]
pub struct Write {
    slots: Slots,
    record: Record,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Compare,
    /// Sectors erased so far.
    Erase(u32),
    /// Pages of the content programmed so far.
    Program(u32),
    Verify,
    Commit,
    VerifyHeader,
}

/// Progress of a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Call again.
    UnderWay,
    /// The content is in the flash; pass the record to [`Slots::written`].
    Done(Record),
}

/// Why nothing was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteError<E> {
    /// The content is longer than a slot.
    TooLong,
    /// The slots were written [`MOST_WRITES`] times.
    WornOut,
    /// The flash does not hold what was programmed.
    ReadBack,
    /// The flash reported an error.
    Flash(E),
}

impl<E> From<E> for WriteError<E> {
    fn from(error: E) -> Self {
        Self::Flash(error)
    }
}

impl Slots {
    /// Begins to write `content`, which must be the same at every step.
    ///
    /// # Errors
    /// [`WriteError::TooLong`] and [`WriteError::WornOut`].
    pub fn write<E>(&self, content: &[u8]) -> Result<Write, WriteError<E>> {
        if content.len() > self.capacity() {
            return Err(WriteError::TooLong);
        }
        let (slot, sequence) = match self.content {
            Content::Whole(newest) => (1 - newest.slot, newest.sequence.saturating_add(1)),
            Content::Blank | Content::Damaged => (0, 1),
        };
        if sequence > MOST_WRITES {
            return Err(WriteError::WornOut);
        }
        let (length, checksum) = (content.len() as u32, fingerprint(content));
        let record = Record {
            slot,
            sequence,
            length,
            checksum,
        };
        Ok(Write {
            slots: *self,
            record,
            stage: Stage::Compare,
        })
    }
}

impl Write {
    /// Executes the next flash operation.
    ///
    /// # Errors
    /// The write has failed and the previous content is in force; drop the write.
    pub fn step<F: Flash>(
        &mut self,
        flash: &mut F,
        content: &[u8],
    ) -> Result<Progress, WriteError<F::Error>> {
        let page = |number| self.slots.page(self.record.slot, number);
        self.stage = match self.stage {
            Stage::Compare => match self.unchanged(flash, content)? {
                Some(record) => return Ok(Progress::Done(record)),
                None => Stage::Erase(0),
            },
            // The header's sector goes first: from then on the slot has no right header.
            Stage::Erase(done) => {
                flash.erase(page(0) + done * SECTOR)?;
                let needed = (PAGE as u32 + self.record.length).div_ceil(SECTOR);
                if done + 1 < needed {
                    Stage::Erase(done + 1)
                } else {
                    Stage::Program(0)
                }
            }
            Stage::Program(done) => match content.chunks(PAGE).nth(done as usize) {
                Some(piece) => {
                    flash.program(page(done + 1), &padded(piece))?;
                    Stage::Program(done + 1)
                }
                None => Stage::Verify,
            },
            Stage::Verify if self.slots.checksum(flash, &self.record)? != self.record.checksum => {
                return Err(WriteError::ReadBack);
            }
            Stage::Verify => Stage::Commit,
            Stage::Commit => {
                flash.program(page(0), &padded(&self.record.encode()))?;
                Stage::VerifyHeader
            }
            Stage::VerifyHeader => {
                let mut header = [0; HEADER];
                flash.read(page(0), &mut header)?;
                return if header == self.record.encode() {
                    Ok(Progress::Done(self.record))
                } else {
                    Err(WriteError::ReadBack)
                };
            }
        };
        Ok(Progress::UnderWay)
    }

    /// Returns the newest record if it already holds this content.
    fn unchanged<F: Flash>(
        &self,
        flash: &mut F,
        content: &[u8],
    ) -> Result<Option<Record>, F::Error> {
        let Content::Whole(newest) = self.slots.content else {
            return Ok(None);
        };
        if (newest.length, newest.checksum) != (self.record.length, self.record.checksum) {
            return Ok(None);
        }
        let same = equal(flash, self.slots.page(newest.slot, 1), content)?;
        Ok(same.then_some(newest))
    }
}

/// Pads to a page; the rest stays erased.
fn padded(piece: &[u8]) -> [u8; PAGE] {
    let mut page = [0xFF; PAGE];
    for (place, byte) in page.iter_mut().zip(piece) {
        *place = *byte;
    }
    page
}

fn equal<F: Flash>(flash: &mut F, mut offset: u32, content: &[u8]) -> Result<bool, F::Error> {
    let mut page = [0; PAGE];
    for piece in content.chunks(PAGE) {
        let found = page.get_mut(..piece.len()).unwrap_or_default();
        flash.read(offset, found)?;
        if found != piece {
            return Ok(false);
        }
        offset += PAGE as u32;
    }
    Ok(true)
}
