//! The one buffer for knowledge as bytes: to send, receive or store it.

use super::rule::{RoverKnowledge, Rule};
use crate::checksum::fingerprint;
use crate::contract::Refusal;
use crate::parameters::Parameters;
use crate::wire::message::Chunk;
use crate::wire::transfer::{Progress, Transfer, chunk_at};

/// Most bytes of knowledge: a full pattern vector.
pub const MOST_BYTES: usize = RoverKnowledge::max_size();

/// The buffer and its content.
pub struct Staging {
    bytes: [u8; MOST_BYTES],
    content: Content,
}

enum Content {
    /// Nothing of use.
    Nothing,
    /// The knowledge in use, as it is at this moment.
    Current { length: usize, fingerprint: u32 },
    /// A transfer from a host.
    Incoming(Transfer),
}

impl Staging {
    /// An empty buffer: all zeros, so that a static occupies none of the board's flash.
    pub const EMPTY: Self = Self {
        bytes: [0; MOST_BYTES],
        content: Content::Nothing,
    };

    /// Returns the knowledge in use as bytes, and their fingerprint; rewritten only after a change.
    pub fn current(&mut self, knowledge: &RoverKnowledge, parameters: &Parameters) -> (&[u8], u32) {
        let (length, fingerprint) = match self.content {
            Content::Current {
                length,
                fingerprint,
            } => (length, fingerprint),
            _ => self.fill(knowledge, parameters),
        };
        (self.bytes.get(..length).unwrap_or_default(), fingerprint)
    }

    /// Returns the bytes last returned by [`current`](Self::current); empty after a change.
    pub fn staged(&self) -> &[u8] {
        match self.content {
            Content::Current { length, .. } => self.bytes.get(..length).unwrap_or_default(),
            _ => &[],
        }
    }

    /// Invalidates the bytes: the knowledge has changed.
    pub fn changed(&mut self) {
        if matches!(self.content, Content::Current { .. }) {
            self.content = Content::Nothing;
        }
    }

    /// Returns the chunk of the current knowledge that starts at `offset`.
    ///
    /// # Errors
    /// [`Refusal::OutOfRange`].
    pub fn chunk(
        &mut self,
        knowledge: &RoverKnowledge,
        parameters: &Parameters,
        offset: u32,
    ) -> Result<Chunk, Refusal> {
        let (bytes, fingerprint) = self.current(knowledge, parameters);
        chunk_at(bytes, fingerprint, offset)
    }

    /// Stores a chunk from the host; returns the whole after the last one.
    ///
    /// # Errors
    /// As [`Transfer::accept`].
    pub fn accept(&mut self, chunk: &Chunk) -> Result<Option<&[u8]>, Refusal> {
        if !matches!(self.content, Content::Incoming(_)) {
            self.content = Content::Incoming(Transfer::new(MOST_BYTES as u32));
        }
        let Content::Incoming(transfer) = &mut self.content else {
            return Ok(None);
        };
        let progress = transfer.accept(chunk)?;
        if progress == Progress::Repeated {
            return Ok(None);
        }
        let start = chunk.offset as usize;
        // The transfer has refused chunks that end beyond its capacity.
        let place = self.bytes.get_mut(start..start + chunk.data.len());
        place.ok_or(Refusal::TooLong)?.copy_from_slice(&chunk.data);
        Ok(match progress {
            Progress::Complete => self.bytes.get(..chunk.total as usize),
            Progress::Stored | Progress::Repeated => None,
        })
    }

    /// Ends the transfer.
    pub fn received(&mut self) {
        self.content = Content::Nothing;
    }

    /// Returns the whole buffer, to read stored knowledge into.
    pub fn room(&mut self) -> &mut [u8] {
        self.content = Content::Nothing;
        &mut self.bytes
    }

    fn fill(&mut self, knowledge: &RoverKnowledge, parameters: &Parameters) -> (usize, u32) {
        let mut length = 0;
        let written = knowledge.write::<Rule, ()>(parameters, |piece| {
            let end = length + piece.len();
            self.bytes
                .get_mut(length..end)
                .ok_or(())?
                .copy_from_slice(piece);
            length = end;
            Ok(())
        });
        debug_assert_eq!(written, Ok(()), "the buffer holds the longest knowledge");
        let fingerprint = fingerprint(self.bytes.get(..length).unwrap_or_default());
        self.content = Content::Current {
            length,
            fingerprint,
        };
        (length, fingerprint)
    }
}
