//! The USB device controller: its registers as the processor sees them, and what it answers on the
//! bus (RP2040 datasheet 4.1.2.6 and 4.1.4).
//!
//! A transaction takes effect as a whole when it ends. Buses have no errors here: no CRC, bit
//! stuffing or time-out error ever occurs, and errata RP2040-E2, E5 and E15, which need them or a
//! busy bus, do not either. Isochronous endpoints and the controller's host mode are missing.

use super::dpram::{
    AVAILABLE, Direction, Dpram, Endpoint, EndpointControl, FULL, LAST, LENGTH, PID, RESET_SELECT,
    STALL,
};
use super::registers as r;
use crate::board::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Write};

/// After 3 ms without traffic a device is suspended (USB 2.0, 7.1.7.6).
const IDLE: Cycles = 3_000 * CYCLES_PER_MICROSECOND;

const REGISTERS: usize = r::INTS as usize / 4 + 1;

/// What a data packet says of its place in the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pid {
    /// DATA0.
    Data0,
    /// DATA1.
    Data1,
}

impl Pid {
    /// The next packet's.
    pub(super) const fn toggled(self) -> Self {
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
pub(super) enum Answer {
    /// Nobody is there: another address, endpoint disabled, controller off.
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
pub(super) enum Reply {
    /// Data, which the host acknowledges.
    Data(Pid, Vec<u8>),
    /// None: [`Answer`] says why, and is not `Ready`.
    None(Answer),
}

/// What is on the bus's wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Signal {
    /// Single-ended zero: no pull-up, or a reset.
    Se0 = 0,
    /// Idle.
    J = 1,
    /// Resume.
    K = 2,
}

/// The controller.
#[derive(Clone, Debug)]
pub(super) struct Controller {
    dpram: Dpram,
    /// Registers that are storage.
    stored: [u32; REGISTERS],
    /// SIE_STATUS, the bits that stay until they are written.
    status: u32,
    buff_status: u32,
    /// Of each endpoint, whether the second buffer was the one last done.
    should_handle: u32,
    /// Of each endpoint, whether the second buffer is next.
    second: u32,
    abort_done: u32,
    stall_nak: u32,
    connection_changed: bool,
    connected: bool,
    /// Frame number last seen, and whether it was since SOF_RD was read.
    frame: u32,
    new_frame: bool,
    /// What the host drives.
    driven: Option<Signal>,
    /// When the bus will have been idle for so long that it counts as suspended.
    suspend_at: Option<Cycles>,
}

impl Controller {
    /// As after power-up.
    pub(super) fn new() -> Self {
        let mut controller = Self {
            dpram: Dpram::new(),
            stored: [0; REGISTERS],
            status: 0,
            buff_status: 0,
            should_handle: 0,
            second: 0,
            abort_done: 0,
            stall_nak: 0,
            connection_changed: false,
            connected: false,
            frame: 0,
            new_frame: false,
            driven: None,
            suspend_at: None,
        };
        controller.reset();
        controller
    }

    /// Resets the registers; the memory keeps what it holds.
    pub(super) fn reset(&mut self) {
        let dpram = std::mem::replace(&mut self.dpram, Dpram::new());
        *self = Self {
            dpram,
            stored: std::array::from_fn(|i| r::initial(i as u32 * 4)),
            status: 0,
            buff_status: 0,
            should_handle: 0,
            second: 0,
            abort_done: 0,
            stall_nak: 0,
            connection_changed: false,
            connected: false,
            frame: 0,
            new_frame: false,
            driven: self.driven,
            suspend_at: None,
        };
    }

    // The processor's side.

    /// Reads memory.
    pub(super) fn read_dpram<const N: usize>(&self, offset: u32) -> [u8; N] {
        self.dpram.read(offset)
    }

    /// Writes memory. Gives true if what the device answers may have changed.
    pub(super) fn write_dpram<const N: usize>(&mut self, offset: u32, bytes: [u8; N]) -> bool {
        self.dpram.write(offset, bytes)
    }

    /// Reads a register.
    pub(super) fn read(&mut self, offset: u32) -> u32 {
        match offset {
            r::SOF_RD => {
                self.new_frame = false;
                self.frame
            }
            r::SIE_STATUS => self.sie_status(),
            r::BUFF_STATUS => self.buff_status,
            r::BUFF_CPU_SHOULD_HANDLE => self.should_handle,
            r::EP_ABORT_DONE => self.abort_done,
            r::EP_STATUS_STALL_NAK => self.stall_nak,
            r::INTR => self.raw_interrupts(),
            r::INTS => self.interrupts(),
            _ => self.stored(offset),
        }
    }

    /// Writes a register. Bits that are cleared by writing them are so through every alias.
    pub(super) fn write(&mut self, offset: u32, write: Write) {
        let bits = write.value;
        match offset {
            r::SIE_STATUS => {
                self.status &= !bits;
                self.connection_changed &= bits & r::CONNECTED == 0;
            }
            r::BUFF_STATUS => self.buff_status &= !bits,
            r::EP_ABORT_DONE => self.abort_done &= !bits,
            r::EP_STATUS_STALL_NAK => self.stall_nak &= !bits,
            _ => {
                let mask = r::stored(offset);
                if mask != 0 {
                    let word = &mut self.stored[offset as usize / 4];
                    *word = write.onto(*word) & mask;
                }
            }
        }
        if offset == r::EP_ABORT {
            // No transaction lasts here: an endpoint always is idle.
            self.abort_done |= self.stored(r::EP_ABORT);
        }
        self.look_at_connection();
    }

    /// The interrupt line (USBCTRL_IRQ).
    pub(super) fn interrupt(&self) -> bool {
        self.interrupts() != 0
    }

    fn stored(&self, offset: u32) -> u32 {
        self.stored
            .get(offset as usize / 4)
            .copied()
            .unwrap_or_default()
    }

    fn is_set(&self, offset: u32, bit: u32) -> bool {
        self.stored(offset) & bit != 0
    }

    fn interrupts(&self) -> u32 {
        self.raw_interrupts() & self.stored(r::INTE) | self.stored(r::INTF)
    }

    fn raw_interrupts(&self) -> u32 {
        let status = self.sie_status();
        let copies = r::INT_OF_STATUS
            .iter()
            .filter(|(_, bit)| status & bit != 0)
            .fold(0, |interrupts, (interrupt, _)| interrupts | interrupt);
        let others = [
            (r::INT_BUFF_STATUS, self.buff_status != 0),
            (r::INT_DEV_CONN_DIS, self.connection_changed),
            (r::INT_DEV_SOF, self.new_frame),
            (r::INT_ABORT_DONE, self.abort_done != 0),
            (r::INT_EP_STALL_NAK, self.stall_nak != 0),
        ];
        others
            .iter()
            .filter(|(_, on)| *on)
            .fold(copies, |interrupts, (interrupt, _)| interrupts | interrupt)
    }

    fn sie_status(&self) -> u32 {
        let mut status = self.status;
        if self.vbus() {
            status |= r::VBUS_DETECTED;
        }
        if self.connected {
            status |= r::CONNECTED;
        }
        let idle = if self.attached() {
            Signal::J
        } else {
            Signal::Se0
        };
        status | (self.driven.unwrap_or(idle) as u32) << r::LINE_STATE_SHIFT
    }

    /// The voltage of the bus is wired to no pin on our boards: it is what the program says it is.
    fn vbus(&self) -> bool {
        self.is_set(r::USB_PWR, r::VBUS_DETECT_OVERRIDE_EN)
            && self.is_set(r::USB_PWR, r::VBUS_DETECT)
    }

    fn look_at_connection(&mut self) {
        let connected = self.attached() && self.vbus();
        self.connection_changed |= connected != self.connected;
        self.connected = connected;
    }

    // The bus's side.

    /// Whether a host sees a device: pull-up on, connected to the pins, working.
    pub(super) fn attached(&self) -> bool {
        self.is_set(r::MAIN_CTRL, r::CONTROLLER_EN)
            && !self.is_set(r::MAIN_CTRL, r::HOST_NDEVICE)
            && self.is_set(r::USB_MUXING, r::TO_PHY)
            && self.is_set(r::SIE_CTRL, r::PULLUP_EN)
    }

    /// The host resets the bus from now on.
    pub(super) fn bus_reset(&mut self) {
        self.status |= r::BUS_RESET;
        self.driven = Some(Signal::Se0);
        self.suspend_at = None;
    }

    /// The host wakes the bus from now on.
    pub(super) fn bus_resume(&mut self) {
        self.status |= r::RESUME;
        self.driven = Some(Signal::K);
        self.suspend_at = None;
    }

    /// The host sends frames from now on.
    pub(super) fn bus_active(&mut self) {
        self.driven = None;
        self.suspend_at = None;
    }

    /// Nothing is to be heard from now on, be it that the host sleeps or that it is gone.
    pub(super) fn bus_idle(&mut self, now: Cycles) {
        self.driven = None;
        self.suspend_at = self.attached().then_some(now + IDLE);
    }

    /// When it will find the bus suspended.
    pub(super) fn suspend_at(&self) -> Option<Cycles> {
        self.suspend_at
    }

    /// The bus has been idle for long enough.
    pub(super) fn suspend(&mut self) {
        self.suspend_at = None;
        self.status |= r::SUSPENDED;
    }

    /// Whether the program wants to be told of every frame.
    pub(super) fn wants_frames(&self) -> bool {
        self.is_set(r::INTE, r::INT_DEV_SOF)
    }

    /// Start of frame.
    pub(super) fn start_of_frame(&mut self, number: u32) {
        self.new_frame |= number != self.frame;
        self.frame = number;
    }

    /// Takes a SETUP packet; false if there is nobody of that address.
    pub(super) fn setup(&mut self, address: u8, packet: [u8; 8]) -> bool {
        let hears = self.hears(address);
        if hears {
            self.dpram.store(0, &packet);
            self.stored[r::EP_STALL_ARM as usize / 4] = 0;
            self.status |= r::SETUP_REC;
        }
        hears
    }

    /// What the device would answer now; nothing changes.
    pub(super) fn answer(&self, address: u8, endpoint: Endpoint) -> Answer {
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
    pub(super) fn refused(&mut self, endpoint: Endpoint, answer: Answer) {
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
    pub(super) fn give(&mut self, address: u8, endpoint: Endpoint) -> Reply {
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
    pub(super) fn take(
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
