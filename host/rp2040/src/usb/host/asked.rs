//! A control transfer under way.

use crate::peripheral::Cycles;
use crate::usb::enumeration::Request;
use crate::usb::transfer::ControlTransfer;

/// How a control transfer has ended.
pub(super) enum Outcome {
    Done(Vec<u8>),
    Refused,
    NoAnswer,
    TimeOut,
    Babble(usize),
}

/// A control transfer under way.
#[derive(Clone, Debug)]
pub(super) struct Asked {
    pub(super) request: Request,
    pub(super) transfer: ControlTransfer,
    pub(super) deadline: Cycles,
}
