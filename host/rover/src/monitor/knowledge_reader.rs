//! Reading the rover's knowledge chunk by chunk, without blocking.

use std::time::Duration;

use rover_shared::rover::MOST_BYTES;
use rover_shared::wire::message::{Chunk, Command};
use rover_shared::wire::transfer::{Progress, Transfer};

/// How long to wait for a chunk before it is requested again.
const PATIENCE: Duration = Duration::from_secs(1);
/// Requests for a chunk before the reading is aborted.
const ATTEMPTS: u8 = 5;

/// A reading, or none.
#[derive(Default)]
pub struct KnowledgeReader {
    under_way: Option<UnderWay>,
}

struct UnderWay {
    transfer: Transfer,
    bytes: Vec<u8>,
    /// When the chunk at the end of `bytes` was requested; `None` if it was not yet.
    asked: Option<Duration>,
    attempts: u8,
}

impl KnowledgeReader {
    /// Whether a reading is under way.
    pub fn is_under_way(&self) -> bool {
        self.under_way.is_some()
    }

    /// Starts to read.
    pub fn start(&mut self) {
        self.under_way = Some(UnderWay {
            transfer: Transfer::new(MOST_BYTES as u32),
            bytes: Vec::new(),
            asked: None,
            attempts: 0,
        });
    }

    /// Aborts the reading.
    pub fn abandon(&mut self) {
        self.under_way = None;
    }

    /// The next command to send at this time, if any.
    pub fn next(&mut self, now: Duration) -> Option<Command> {
        let pull = self.under_way.as_mut()?;
        let waits = |asked: Duration| now.saturating_sub(asked) < PATIENCE;
        if pull.asked.is_some_and(waits) {
            return None;
        }
        if pull.attempts == ATTEMPTS {
            self.under_way = None;
            return None;
        }
        pull.asked = Some(now);
        pull.attempts += 1;
        Some(Command::PullKnowledge {
            offset: pull.bytes.len() as u32,
        })
    }

    /// Takes a chunk; returns the whole after the last one.
    pub fn take(&mut self, chunk: &Chunk) -> Option<Vec<u8>> {
        let pull = self.under_way.as_mut()?;
        match pull.transfer.accept(chunk) {
            Ok(Progress::Repeated) => {}
            Ok(progress) => {
                // A transfer lets chunks through in order, and from 0.
                pull.bytes.truncate(chunk.offset as usize);
                pull.bytes.extend_from_slice(&chunk.data);
                pull.asked = None;
                pull.attempts = 0;
                if progress == Progress::Complete {
                    return self.under_way.take().map(|pull| pull.bytes);
                }
            }
            // The knowledge has changed meanwhile, or a chunk was damaged: from the start.
            Err(_) => {
                pull.bytes.clear();
                pull.asked = None;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover_shared::checksum::fingerprint;
    use rover_shared::wire::transfer::chunk_at;

    fn offset(command: Option<Command>) -> Option<u32> {
        match command? {
            Command::PullKnowledge { offset } => Some(offset),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn chunks_are_asked_for_in_turn_until_the_whole_is_there() {
        let knowledge: Vec<u8> = (0..300).map(|i| i as u8).collect();
        let chunk = |at| chunk_at(&knowledge, fingerprint(&knowledge), at).unwrap();
        let mut pull = KnowledgeReader::default();
        let now = Duration::ZERO;
        assert_eq!(pull.next(now), None);
        pull.start();
        assert_eq!(offset(pull.next(now)), Some(0));
        assert_eq!(pull.next(now), None, "it waits for the answer");
        assert_eq!(offset(pull.next(PATIENCE)), Some(0), "and asks again");
        assert_eq!(pull.take(&chunk(0)), None);
        assert_eq!(pull.take(&chunk(0)), None, "the repeated answer");
        assert_eq!(offset(pull.next(now)), Some(128));
        assert_eq!(pull.take(&chunk(128)), None);
        assert_eq!(offset(pull.next(now)), Some(256));
        assert_eq!(pull.take(&chunk(256)), Some(knowledge.clone()));
        assert!(!pull.is_under_way());
    }

    #[test]
    fn knowledge_that_changes_meanwhile_is_read_from_the_start() {
        let (one, other) = ([1; 300], [2; 300]);
        let mut pull = KnowledgeReader::default();
        pull.start();
        pull.next(Duration::ZERO);
        pull.take(&chunk_at(&one, fingerprint(&one), 0).unwrap());
        pull.next(Duration::ZERO);
        pull.take(&chunk_at(&other, fingerprint(&other), 128).unwrap());
        assert_eq!(offset(pull.next(Duration::ZERO)), Some(0));
    }

    #[test]
    fn requests_are_not_repeated_for_ever() {
        let mut pull = KnowledgeReader::default();
        pull.start();
        let asked = (0..100).filter(|&s| pull.next(Duration::from_secs(s)).is_some());
        assert_eq!(asked.count(), usize::from(ATTEMPTS));
        assert!(!pull.is_under_way());
    }
}
