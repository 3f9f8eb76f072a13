//! Knowledge over the wire, in checked chunks.
//!
//! The sender cuts with [`chunk_at`]. The receiver's [`Transfer`] checks order and checksum; the
//! receiver itself stores the bytes. A repeated chunk (its acknowledgement was lost) is harmless.

use crc::{Digest, NoTable};
use heapless::Vec;

use super::message::{CHUNK_BYTES, Chunk};
use crate::checksum::digest;
use crate::contract::Refusal;

/// The chunk of `knowledge`, whose [`fingerprint`](crate::checksum::fingerprint) this is, that
/// starts at `offset`; empty exactly at the end.
///
/// # Errors
/// [`Refusal::OutOfRange`] if the offset lies beyond the end, [`Refusal::TooLong`] for more than
/// 4 GB.
pub fn chunk_at(knowledge: &[u8], fingerprint: u32, offset: u32) -> Result<Chunk, Refusal> {
    let total = u32::try_from(knowledge.len()).map_err(|_| Refusal::TooLong)?;
    let rest = knowledge
        .get(offset as usize..)
        .ok_or(Refusal::OutOfRange)?;
    let data = rest.get(..CHUNK_BYTES).unwrap_or(rest);
    Ok(Chunk {
        total,
        fingerprint,
        offset,
        data: Vec::from_slice(data).map_err(|_| Refusal::TooLong)?,
    })
}

/// What to do with an accepted chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Keep the bytes at the chunk's offset, and await more.
    Stored,
    /// As the chunk before; keep nothing.
    Repeated,
    /// Keep the bytes: this was the last chunk, and the checksum of the whole is right.
    Complete,
}

/// The receiving end of one transfer after another.
#[derive(Clone)]
pub struct Transfer {
    capacity: u32,
    total: u32,
    fingerprint: u32,
    /// Offset of the chunk awaited, and of the one before.
    next: u32,
    previous: u32,
    digest: Digest<'static, u32, NoTable>,
}

impl Transfer {
    /// A receiver with room for `capacity` bytes.
    pub fn new(capacity: u32) -> Self {
        Self {
            capacity,
            total: 0,
            fingerprint: 0,
            next: 0,
            previous: 0,
            digest: digest(),
        }
    }

    /// Checks a chunk. Offset 0 starts a new transfer, whatever came before.
    ///
    /// # Errors
    /// [`Refusal::TooLong`] beyond the capacity, [`Refusal::ChunkOutOfOrder`] for a chunk that
    /// does not continue the transfer, [`Refusal::BadChecksum`] if the whole is damaged; after
    /// either the next chunk must be at offset 0.
    pub fn accept(&mut self, chunk: &Chunk) -> Result<Progress, Refusal> {
        let length = chunk.data.len() as u32;
        if chunk.total > self.capacity {
            return Err(Refusal::TooLong);
        }
        if chunk.offset == 0 {
            *self = Self {
                total: chunk.total,
                fingerprint: chunk.fingerprint,
                ..Self::new(self.capacity)
            };
        }
        let same = chunk.total == self.total && chunk.fingerprint == self.fingerprint && length > 0;
        if same
            && chunk.offset == self.previous
            && chunk.offset.checked_add(length) == Some(self.next)
        {
            return Ok(Progress::Repeated);
        }
        let end = chunk
            .offset
            .checked_add(length)
            .filter(|end| *end <= self.total);
        let (true, Some(end)) = (same && chunk.offset == self.next, end) else {
            self.abandon();
            return Err(Refusal::ChunkOutOfOrder);
        };
        self.digest.update(&chunk.data);
        (self.previous, self.next) = (self.next, end);
        if end < self.total {
            return Ok(Progress::Stored);
        }
        if self.digest.clone().finalize() == self.fingerprint {
            Ok(Progress::Complete)
        } else {
            self.abandon();
            Err(Refusal::BadChecksum)
        }
    }

    fn abandon(&mut self) {
        *self = Self::new(self.capacity);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checksum::fingerprint;
    use proptest::prelude::*;
    use std::vec::Vec as StdVec;

    fn receive(transfer: &mut Transfer, chunk: &Chunk, into: &mut StdVec<u8>) -> Progress {
        let progress = transfer.accept(chunk).expect("chunks come in order");
        if progress != Progress::Repeated {
            into.truncate(chunk.offset as usize);
            into.extend_from_slice(&chunk.data);
        }
        progress
    }

    proptest! {
        #[test]
        fn what_is_sent_arrives_even_with_repeats(
            knowledge in prop::collection::vec(any::<u8>(), 1..1_000),
            repeats in prop::collection::vec(any::<bool>(), 8),
        ) {
            let mut transfer = Transfer::new(1_000);
            let mut received = StdVec::new();
            let mut last = Progress::Stored;
            for (i, offset) in (0..knowledge.len() as u32).step_by(CHUNK_BYTES).enumerate() {
                let chunk = chunk_at(&knowledge, fingerprint(&knowledge), offset).unwrap();
                prop_assert_eq!(last, Progress::Stored);
                last = receive(&mut transfer, &chunk, &mut received);
                if repeats[i] && offset > 0 {
                    prop_assert_eq!(receive(&mut transfer, &chunk, &mut received), Progress::Repeated);
                }
            }
            prop_assert_eq!(last, Progress::Complete);
            prop_assert_eq!(received, knowledge);
        }

        #[test]
        fn a_flipped_bit_never_completes(
            knowledge in prop::collection::vec(any::<u8>(), 1..600),
            place in any::<prop::sample::Index>(),
            bit in 0u8..8,
        ) {
            let place = place.index(knowledge.len());
            let mut transfer = Transfer::new(1_000);
            let mut result = Ok(Progress::Stored);
            for offset in (0..knowledge.len() as u32).step_by(CHUNK_BYTES) {
                let mut chunk = chunk_at(&knowledge, fingerprint(&knowledge), offset).unwrap();
                if let Some(byte) = place.checked_sub(offset as usize)
                    .and_then(|i| chunk.data.get_mut(i)) {
                    *byte ^= 1u8 << bit;
                }
                result = transfer.accept(&chunk);
            }
            prop_assert_eq!(result, Err(Refusal::BadChecksum));
        }

        #[test]
        fn no_sequence_of_chunks_panics(
            chunks in prop::collection::vec(
                (any::<u32>(), any::<u32>(), any::<u32>(), prop::collection::vec(any::<u8>(), 0..CHUNK_BYTES)), 0..20),
            small in any::<bool>(),
        ) {
            let mut transfer = Transfer::new(if small { 300 } else { u32::MAX });
            for (total, fingerprint, offset, data) in chunks {
                let (total, offset) = if small { (total % 400, offset % 400) } else { (total, offset) };
                let data = Vec::from_slice(&data).unwrap();
                let _ = transfer.accept(&Chunk { total, fingerprint, offset, data });
            }
        }
    }

    #[test]
    fn gaps_excess_and_mixtures_are_refused() {
        let knowledge = [7; 300];
        let chunk = |offset| chunk_at(&knowledge, fingerprint(&knowledge), offset).unwrap();
        let mut transfer = Transfer::new(300);
        assert_eq!(transfer.accept(&chunk(0)), Ok(Progress::Stored));
        assert_eq!(transfer.accept(&chunk(256)), Err(Refusal::ChunkOutOfOrder));
        assert_eq!(
            transfer.accept(&chunk(128)),
            Err(Refusal::ChunkOutOfOrder),
            "after a gap"
        );
        assert_eq!(transfer.accept(&chunk(0)), Ok(Progress::Stored));
        let other = Chunk {
            fingerprint: 1,
            ..chunk(128)
        };
        assert_eq!(transfer.accept(&other), Err(Refusal::ChunkOutOfOrder));
        assert_eq!(Transfer::new(299).accept(&chunk(0)), Err(Refusal::TooLong));
        assert_eq!(chunk_at(&knowledge, 0, 301), Err(Refusal::OutOfRange));
        assert_eq!(chunk_at(&knowledge, 0, 300).map(|c| c.data.len()), Ok(0));
    }
}
