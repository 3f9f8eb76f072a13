//! Reports that wait to be read, and what was lost on the way.

use std::collections::VecDeque;

use rover_shared::time::Instant;
use rover_shared::wire::frame::{Decoder, Frame, FrameError};
use rover_shared::wire::message::Report;
use serde::Serialize;

/// Most reports that wait: minutes of telemetry. A program that does not read for so long loses
/// the newest, and is told how many.
const CAPACITY: usize = 4_096;

/// A report, and how it came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Received {
    /// When it came, on the port's clock.
    pub at: Instant,
    /// The number of its frame.
    pub sequence: u16,
    /// How many frames before it are missing since the last one received here.
    pub lost: u32,
    /// What it says.
    pub report: Report,
}

/// What happened to frames since the client was made; all stop at the largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize)]
pub struct Counters {
    /// Frames that came whole.
    pub received: u64,
    /// Frames that never came, by the gaps of their numbers, the damaged ones included.
    pub lost: u64,
    /// Frames that came damaged, and were dropped.
    pub damaged: u64,
    /// Reports dropped here because they were not read.
    pub unread: u64,
    /// How often the connection was renewed.
    pub reconnected: u64,
}

/// Decodes bytes into reports, and keeps them until they are read.
#[derive(Default)]
pub(crate) struct Inbox {
    decoder: Decoder,
    /// The number of the last frame of this connection.
    last: Option<u16>,
    waiting: VecDeque<Received>,
    /// Missing before the next report that is kept.
    missing: u32,
    pub(crate) counters: Counters,
}

impl Inbox {
    /// Begins a new connection: a half frame is dropped, and numbers start anew. What waits, stays.
    pub(crate) fn restart(&mut self) {
        self.decoder = Decoder::new();
        self.last = None;
    }

    /// Takes the next byte; returns the report or the error that it completes.
    pub(crate) fn push(&mut self, at: Instant, byte: u8) -> Option<Result<Received, FrameError>> {
        match self.decoder.push::<Report>(byte)? {
            Ok(frame) => Some(Ok(self.number(at, frame))),
            Err(error) => {
                self.counters.damaged = self.counters.damaged.saturating_add(1);
                Some(Err(error))
            }
        }
    }

    fn number(&mut self, at: Instant, frame: Frame<Report>) -> Received {
        let Frame {
            sequence,
            message: report,
            ..
        } = frame;
        // A sender that starts anew says hello first; any other frame 0 comes after 65535.
        let anew = sequence == 0 && matches!(report, Report::Hello(_));
        let gap = match self.last {
            Some(last) if !anew => sequence.wrapping_sub(last).wrapping_sub(1),
            _ => 0,
        };
        self.last = Some(sequence);
        self.counters.received = self.counters.received.saturating_add(1);
        self.counters.lost = self.counters.lost.saturating_add(gap.into());
        Received {
            at,
            sequence,
            lost: gap.into(),
            report,
        }
    }

    /// Keeps a report to be read.
    pub(crate) fn keep(&mut self, mut received: Received) {
        let lost = received.lost.saturating_add(self.missing);
        if self.waiting.len() >= CAPACITY {
            self.missing = lost.saturating_add(1);
            self.counters.unread = self.counters.unread.saturating_add(1);
            return;
        }
        self.missing = 0;
        received.lost = lost;
        self.waiting.push_back(received);
    }

    /// Drops a report, but keeps count of what was lost before it.
    pub(crate) fn pass(&mut self, received: &Received) {
        self.missing = self.missing.saturating_add(received.lost);
    }

    /// The report that has waited longest.
    pub(crate) fn take(&mut self) -> Option<Received> {
        self.waiting.pop_front()
    }

    /// Puts back what was taken, before what waits, even beyond the capacity.
    pub(crate) fn put_back(&mut self, read: Vec<Received>) {
        for received in read.into_iter().rev() {
            self.waiting.push_front(received);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover_shared::contract::{Fault, FaultReport};
    use rover_shared::wire::frame::{Encoder, MAX_FRAME};

    fn fault(count: u32) -> Report {
        Report::Fault(FaultReport {
            time: Instant(0),
            fault: Fault::Blocked,
            count,
        })
    }

    fn frame(encoder: &mut Encoder, report: &Report) -> Vec<u8> {
        let mut buffer = [0; MAX_FRAME];
        encoder.encode(report, &mut buffer).unwrap().to_vec()
    }

    fn hear(inbox: &mut Inbox, bytes: &[u8]) {
        for byte in bytes {
            if let Some(Ok(received)) = inbox.push(Instant(0), *byte) {
                inbox.keep(received);
            }
        }
    }

    #[test]
    fn gaps_are_counted_even_where_the_numbers_wrap() {
        let (mut inbox, mut encoder) = (Inbox::default(), Encoder::new());
        for i in 0..70_000u32 {
            let bytes = frame(&mut encoder, &fault(i));
            // Lost: one, then the two on either side of the wrap.
            if ![10, 65_535, 65_536].contains(&i) {
                hear(&mut inbox, &bytes);
                let lost = inbox.take().expect("was just heard").lost;
                let expected = match i {
                    11 => 1,
                    65_537 => 2,
                    _ => 0,
                };
                assert_eq!(lost, expected, "frame {i}");
            }
        }
        assert_eq!((inbox.counters.received, inbox.counters.lost), (69_997, 3));
    }

    #[test]
    fn a_queue_that_nobody_reads_is_bounded_and_the_loss_is_told() {
        let (mut inbox, mut encoder) = (Inbox::default(), Encoder::new());
        for i in 0..CAPACITY as u32 + 7 {
            let bytes = frame(&mut encoder, &fault(i));
            hear(&mut inbox, &bytes);
        }
        assert_eq!(inbox.counters.unread, 7);
        for _ in 0..CAPACITY {
            assert_eq!(inbox.take().expect("waits").lost, 0);
        }
        assert_eq!(inbox.take(), None);
        let bytes = frame(&mut encoder, &fault(0));
        hear(&mut inbox, &bytes);
        assert_eq!(inbox.take().expect("waits").lost, 7);
    }

    #[test]
    fn a_damaged_frame_is_counted_and_missing() {
        let (mut inbox, mut encoder) = (Inbox::default(), Encoder::new());
        for i in 0..3 {
            let mut bytes = frame(&mut encoder, &fault(i));
            if i == 1 {
                bytes[3] ^= 1;
            }
            hear(&mut inbox, &bytes);
        }
        assert_eq!((inbox.counters.damaged, inbox.counters.lost), (1, 1));
        assert_eq!(inbox.take().map(|r| r.lost), Some(0));
        assert_eq!(inbox.take().map(|r| r.lost), Some(1));
    }
}
