//! Whole knowledge from the rover and to it.

use rover_shared::checksum::fingerprint;
use rover_shared::rover::MOST_BYTES;
use rover_shared::time::Duration;
use rover_shared::wire::message::{CHUNK_BYTES, Command, EventKind, Report};
use rover_shared::wire::transfer::{Progress, Transfer, chunk_at};

use crate::client::Client;
use crate::error::LinkError;

/// A full pattern vector takes 12 sectors, and the slowest flash 400 ms for each.
const STORED_WITHIN: Duration = Duration::from_millis(10_000);
/// How often a transfer is begun: learning between two chunks changes what is transferred.
const ATTEMPTS: u32 = 3;

impl Client {
    /// The rover's knowledge, in its form as bytes. `progress` is told how many bytes of how many
    /// have come.
    ///
    /// # Errors
    /// It is refused (while the rover drives), or the connection fails.
    pub fn pull_knowledge(
        &mut self,
        mut progress: impl FnMut(u32, u32),
    ) -> Result<Vec<u8>, LinkError> {
        for _ in 0..ATTEMPTS {
            if let Some(bytes) = self.pull_once(&mut progress)? {
                return Ok(bytes);
            }
        }
        Err(LinkError::Transfer("it changed all the time"))
    }

    fn pull_once(
        &mut self,
        progress: &mut impl FnMut(u32, u32),
    ) -> Result<Option<Vec<u8>>, LinkError> {
        let mut transfer = Transfer::new(MOST_BYTES as u32);
        let mut bytes = Vec::new();
        loop {
            let offset = bytes.len() as u32;
            let pull = Command::PullKnowledge { offset };
            let chunk = self.ask_for(&pull, |report| match report {
                Report::Knowledge(chunk) if chunk.offset == offset => Some(chunk),
                _ => None,
            })?;
            match transfer.accept(&chunk) {
                Ok(Progress::Repeated) | Err(_) => return Ok(None),
                Ok(stored) => {
                    bytes.extend_from_slice(&chunk.data);
                    progress(bytes.len() as u32, chunk.total);
                    if stored == Progress::Complete {
                        return Ok(Some(bytes));
                    }
                }
            }
        }
    }

    /// Gives the rover this knowledge, waits until it is in its flash, and reads it back to see
    /// that it is. `progress` is told how many bytes of how many have gone.
    ///
    /// # Errors
    /// It is refused (while armed; or other parameters), the connection fails, or the rover holds
    /// something else than was sent.
    pub fn push_knowledge(
        &mut self,
        bytes: &[u8],
        mut progress: impl FnMut(u32, u32),
    ) -> Result<(), LinkError> {
        let print = fingerprint(bytes);
        let too_long = |_| LinkError::Transfer("it is too long");
        let total = bytes.len() as u32;
        for offset in (0..total).step_by(CHUNK_BYTES) {
            let chunk = chunk_at(bytes, print, offset).map_err(too_long)?;
            let sent = offset + chunk.data.len() as u32;
            match self.ask(&Command::PushKnowledge(chunk)) {
                // The last chunk's acknowledgement was lost: reading back will tell.
                Err(LinkError::Silent(_)) if sent == total => {}
                done => done?,
            }
            progress(sent, total);
        }
        self.await_stored(print)?;
        let back = self.pull_knowledge(|_, _| {})?;
        if back == bytes {
            Ok(())
        } else {
            Err(LinkError::Transfer(
                "what was read back is not what was sent",
            ))
        }
    }

    /// Waits until the rover says that this knowledge is in its flash. What else it says stays to
    /// be read.
    fn await_stored(&mut self, print: u32) -> Result<(), LinkError> {
        let until = self.now().after(STORED_WITHIN);
        let mut others = Vec::new();
        let mut stored = Err(LinkError::Transfer("it was not stored in its flash"));
        while self.now() < until {
            let Some(received) = self.next(until.since(self.now()))? else {
                break;
            };
            let found = matches!(
                &received.report,
                Report::Event(event)
                    if event.kind == EventKind::KnowledgeStored { fingerprint: print }
            );
            others.push(received);
            if found {
                stored = Ok(());
                break;
            }
        }
        self.put_back(others);
        stored
    }
}
