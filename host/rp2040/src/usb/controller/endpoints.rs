//! What the device answers when the host addresses it (RP2040 datasheet 4.1.2.6).

use super::device::Controller;
use crate::usb::dpram::{
    AVAILABLE, Direction, Endpoint, EndpointControl, FULL, LAST, LENGTH, PID, RESET_SELECT, STALL,
};
use crate::usb::registers as r;

/// What a data packet says of its place in the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::usb) enum Pid {
    /// DATA0.
    Data0,
    /// DATA1.
    Data1,
}

impl Pid {
    /// The next packet's.
    pub(in crate::usb) const fn toggled(self) -> Self {
        match self {
            Self::Data0 => Self::Data1,
            Self::Data1 => Self::Data0,
        }
    }

    const fn of(half: u32) -> Self {
        if half & PID != 0 {
            Self::Data1
        } else {
            Self::Data0
        }
    }
}

/// What the device does when the host addresses an endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::usb) enum Answer {
    /// No answer: another address, endpoint disabled, controller off.
    Silence,
    /// NAK: not now.
    Nak,
    /// STALL: never.
    Stall,
    /// Gives or takes data of up to this many bytes.
    Ready(usize),
}

/// What the host gets when it asks for data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::usb) enum Reply {
    /// Data, which the host acknowledges.
    Data(Pid, Vec<u8>),
    /// None: [`Answer`] says why, and is not `Ready`.
    None(Answer),
}

impl Controller {
    /// Takes a SETUP packet; false if it is for another address.
    pub(in crate::usb) fn setup(&mut self, address: u8, packet: [u8; 8]) -> bool {
        let hears = self.hears(address);
        if hears {
            self.dpram.store(0, &packet);
            self.stored[r::EP_STALL_ARM as usize / 4] = 0;
            self.status |= r::SETUP_REC;
        }
        hears
    }

    /// What the device would answer now; nothing changes.
    pub(in crate::usb) fn answer(&self, address: u8, endpoint: Endpoint) -> Answer {
        let control = self.endpoint_control(endpoint);
        if !self.hears(address) || !control.enabled {
            return Answer::Silence;
        }
        if self.is_set(r::EP_ABORT, endpoint.mask()) {
            return Answer::Nak;
        }
        let armed = !endpoint.is_control() || self.is_set(r::EP_STALL_ARM, endpoint.mask());
        if self.dpram.buffer_control(endpoint) & STALL != 0 && armed {
            return Answer::Stall;
        }
        let (_, half) = self.half(endpoint, control);
        let full = half & FULL != 0;
        let usable = half & AVAILABLE != 0 && full == (endpoint.direction == Direction::In);
        if usable {
            Answer::Ready((half & LENGTH) as usize)
        } else {
            Answer::Nak
        }
    }

    /// The host wanted to use this endpoint and was told that it cannot.
    pub(in crate::usb) fn refused(&mut self, endpoint: Endpoint, answer: Answer) {
        let control = self.endpoint_control(endpoint);
        let tell = match answer {
            Answer::Nak => control.on_nak,
            Answer::Stall => control.on_stall,
            Answer::Silence | Answer::Ready(_) => false,
        };
        if tell {
            self.stall_nak |= endpoint.mask();
        }
    }

    /// The host asks for data, and acknowledges what it gets.
    pub(in crate::usb) fn give(&mut self, address: u8, endpoint: Endpoint) -> Reply {
        let answer = self.answer(address, endpoint);
        let Answer::Ready(length) = answer else {
            self.refused(endpoint, answer);
            return Reply::None(answer);
        };
        let control = self.endpoint_control(endpoint);
        let (second, half) = self.half(endpoint, control);
        let bytes = self.dpram.load(control.buffer(second), length);
        self.status |= r::ACK_REC;
        self.done(endpoint, control, half & !FULL & !AVAILABLE);
        Reply::Data(Pid::of(half), bytes)
    }

    /// The host sends data. `Ready` means that they were acknowledged.
    pub(in crate::usb) fn take(
        &mut self,
        address: u8,
        endpoint: Endpoint,
        pid: Pid,
        data: &[u8],
    ) -> Answer {
        let answer = self.answer(address, endpoint);
        let Answer::Ready(room) = answer else {
            self.refused(endpoint, answer);
            return answer;
        };
        let control = self.endpoint_control(endpoint);
        let (second, half) = self.half(endpoint, control);
        if pid != Pid::of(half) {
            // A repetition for all that the device knows: acknowledged and forgotten (USB 2.0,
            // 8.6.4).
            self.status |= r::DATA_SEQ_ERROR;
            return answer;
        }
        let length = data.len().min(room);
        if length < data.len() {
            self.status |= r::RX_OVERFLOW;
        }
        self.dpram.store(control.buffer(second), &data[..length]);
        let half = half & !LENGTH & !AVAILABLE | FULL | length as u32;
        self.done(endpoint, control, half);
        answer
    }

    /// STATUS phase: gives the buffer back to the processor.
    fn done(&mut self, endpoint: Endpoint, control: EndpointControl, half: u32) {
        let word = self.dpram.buffer_control(endpoint);
        let (second, _) = self.half(endpoint, control);
        let word = if second {
            word & 0xffff | half << 16
        } else {
            word & !0xffff | half & !RESET_SELECT
        };
        self.dpram
            .set_buffer_control(endpoint, word & !RESET_SELECT);
        if half & LAST != 0 {
            self.status |= r::TRANS_COMPLETE;
        }
        let mask = endpoint.mask();
        if control.each_buffer || control.each_pair && second {
            self.buff_status |= mask;
        }
        self.should_handle = self.should_handle & !mask | if second { mask } else { 0 };
        self.second &= !mask;
        if control.double_buffered && !second {
            self.second |= mask;
        }
    }

    fn hears(&self, address: u8) -> bool {
        self.attached() && self.stored(r::ADDR_ENDP) & 0x7f == u32::from(address)
    }

    fn endpoint_control(&self, endpoint: Endpoint) -> EndpointControl {
        if endpoint.is_control() {
            EndpointControl::of_endpoint_0(self.stored(r::SIE_CTRL))
        } else {
            self.dpram.endpoint_control(endpoint)
        }
    }

    /// Whether it is the second buffer's turn, and the half of the buffer control word for it.
    fn half(&self, endpoint: Endpoint, control: EndpointControl) -> (bool, u32) {
        let word = self.dpram.buffer_control(endpoint);
        let second = control.double_buffered
            && word & RESET_SELECT == 0
            && self.second & endpoint.mask() != 0;
        (second, if second { word >> 16 } else { word & 0xffff })
    }
}
