//! Transactions and the time that they take on a full-speed bus.

use super::controller::Pid;
use super::dpram::Endpoint;
use crate::peripheral::{CYCLES_PER_MICROSECOND, Cycles};

/// A frame: 1 ms.
pub(super) const FRAME: Cycles = 1_000 * CYCLES_PER_MICROSECOND;
/// 12 Mbit/s: three bytes in 2 us.
const CYCLES_PER_THREE_BYTES: Cycles = 2 * CYCLES_PER_MICROSECOND;
/// Bytes' time that a transaction takes besides its data: synchronisation, packet identifiers,
/// address, checksums and turn-around of a bulk transaction (USB 2.0 5.8.4).
const OVERHEAD: usize = 13;
/// The packet at the start of a frame: 35 bits, and a pause.
const START_OF_FRAME: Cycles = 4 * CYCLES_PER_MICROSECOND;

/// What a host does on the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Transaction {
    /// Begins a control transfer.
    Setup([u8; 8]),
    /// Asks for data.
    In(Endpoint),
    /// Sends data.
    Out(Endpoint, Pid, Vec<u8>),
}

impl Transaction {
    /// Whom it is with.
    pub(super) fn endpoint(&self) -> Endpoint {
        match self {
            Self::Setup(_) => Endpoint::CONTROL_OUT,
            Self::In(endpoint) | Self::Out(endpoint, ..) => *endpoint,
        }
    }

    /// With the bytes of data in it, of which `length` come if it is to bring some.
    pub(super) fn with(self, length: usize) -> (Self, usize) {
        let bytes = match &self {
            Self::Setup(packet) => packet.len(),
            Self::In(_) => length,
            Self::Out(_, _, bytes) => bytes.len(),
        };
        (self, bytes)
    }
}

/// When a transaction with this much data ends that can begin at `start`: it lies within a frame.
pub(super) fn end(start: Cycles, first_frame: Cycles, bytes: usize) -> Cycles {
    let lasts = (bytes + OVERHEAD) as Cycles * CYCLES_PER_THREE_BYTES / 3;
    let frame = start - start.saturating_sub(first_frame) % FRAME;
    let end = start.max(frame + START_OF_FRAME) + lasts;
    // One that is longer than a frame, which no descriptor allows, may run over.
    if end <= frame + FRAME || lasts > FRAME - START_OF_FRAME {
        end
    } else {
        frame + FRAME + START_OF_FRAME + lasts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_holds_as_many_packets_as_the_standard_says() {
        // Table 5-9 of USB 2.0: bytes of data, and transactions with them in a frame.
        for (bytes, count) in [(8, 71), (16, 51), (32, 33), (64, 19)] {
            let mut time = 1_000_000;
            let first_frame = time;
            let mut transactions = 0;
            loop {
                time = end(time, first_frame, bytes);
                if time > first_frame + FRAME {
                    break;
                }
                transactions += 1;
            }
            assert_eq!(transactions, count, "{bytes} bytes");
            let lasts = (bytes as Cycles + 13) * 250 / 3;
            assert_eq!(time, first_frame + FRAME + START_OF_FRAME + lasts);
        }
    }

    #[test]
    fn an_endless_packet_ends() {
        assert_eq!(end(FRAME, 0, 3000), FRAME + 500 + 3013 * 250 / 3);
    }
}
