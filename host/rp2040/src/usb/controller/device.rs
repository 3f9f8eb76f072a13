//! The controller: its state, its registers, and the state of the bus.

use crate::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Write};
use crate::usb::dpram::Dpram;
use crate::usb::registers as r;

/// After 3 ms without traffic a device is suspended (USB 2.0, 7.1.7.6).
const IDLE: Cycles = 3_000 * CYCLES_PER_MICROSECOND;

const REGISTERS: usize = r::INTS as usize / 4 + 1;

/// What is on the bus's wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::usb) enum Signal {
    /// Single-ended zero: no pull-up, or a reset.
    Se0 = 0,
    /// Idle.
    J = 1,
    /// Resume.
    K = 2,
}

/// The controller.
#[derive(Clone, Debug)]
pub(in crate::usb) struct Controller {
    pub(super) dpram: Dpram,
    /// Registers that are storage.
    pub(super) stored: [u32; REGISTERS],
    /// SIE_STATUS, the bits that stay until they are written.
    pub(super) status: u32,
    pub(super) buff_status: u32,
    /// Of each endpoint, whether the second buffer was the one last done.
    pub(super) should_handle: u32,
    /// Of each endpoint, whether the second buffer is next.
    pub(super) second: u32,
    pub(super) abort_done: u32,
    pub(super) stall_nak: u32,
    pub(super) connection_changed: bool,
    pub(super) connected: bool,
    /// Frame number last seen, and whether it was since SOF_RD was read.
    pub(super) frame: u32,
    pub(super) new_frame: bool,
    /// What the host drives.
    pub(super) driven: Option<Signal>,
    /// When the bus will have been idle for so long that it counts as suspended.
    pub(super) suspend_at: Option<Cycles>,
}

impl Controller {
    /// As after power-up.
    pub(in crate::usb) fn new() -> Self {
        Self::with(Dpram::new(), None)
    }

    /// Resets the registers; the memory keeps what it holds.
    pub(in crate::usb) fn reset(&mut self) {
        let dpram = std::mem::replace(&mut self.dpram, Dpram::new());
        *self = Self::with(dpram, self.driven);
    }

    /// Registers as after a reset.
    fn with(dpram: Dpram, driven: Option<Signal>) -> Self {
        Self {
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
            driven,
            suspend_at: None,
        }
    }

    // The processor's side.

    /// Reads memory.
    pub(in crate::usb) fn read_dpram<const N: usize>(&self, offset: u32) -> [u8; N] {
        self.dpram.read(offset)
    }

    /// Writes memory. Returns true if what the device answers may have changed.
    pub(in crate::usb) fn write_dpram<const N: usize>(
        &mut self,
        offset: u32,
        bytes: [u8; N],
    ) -> bool {
        self.dpram.write(offset, bytes)
    }

    /// Reads a register.
    pub(in crate::usb) fn read(&mut self, offset: u32) -> u32 {
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
    pub(in crate::usb) fn write(&mut self, offset: u32, write: Write) {
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
    pub(in crate::usb) fn interrupt(&self) -> bool {
        self.interrupts() != 0
    }

    pub(super) fn stored(&self, offset: u32) -> u32 {
        self.stored
            .get(offset as usize / 4)
            .copied()
            .unwrap_or_default()
    }

    pub(super) fn is_set(&self, offset: u32, bit: u32) -> bool {
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

    /// VBUS is not wired to a pin: the program sets it by the override bits of USB_PWR.
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
    pub(in crate::usb) fn attached(&self) -> bool {
        self.is_set(r::MAIN_CTRL, r::CONTROLLER_EN)
            && !self.is_set(r::MAIN_CTRL, r::HOST_NDEVICE)
            && self.is_set(r::USB_MUXING, r::TO_PHY)
            && self.is_set(r::SIE_CTRL, r::PULLUP_EN)
    }

    /// The host resets the bus from now on.
    pub(in crate::usb) fn bus_reset(&mut self) {
        self.status |= r::BUS_RESET;
        self.driven = Some(Signal::Se0);
        self.suspend_at = None;
    }

    /// The host wakes the bus from now on.
    pub(in crate::usb) fn bus_resume(&mut self) {
        self.status |= r::RESUME;
        self.driven = Some(Signal::K);
        self.suspend_at = None;
    }

    /// The host sends frames from now on.
    pub(in crate::usb) fn bus_active(&mut self) {
        self.driven = None;
        self.suspend_at = None;
    }

    /// The bus is idle from now on: the host is suspended or gone.
    pub(in crate::usb) fn bus_idle(&mut self, now: Cycles) {
        self.driven = None;
        self.suspend_at = self.attached().then_some(now + IDLE);
    }

    /// When it will find the bus suspended.
    pub(in crate::usb) fn suspend_at(&self) -> Option<Cycles> {
        self.suspend_at
    }

    /// The bus has been idle for long enough.
    pub(in crate::usb) fn suspend(&mut self) {
        self.suspend_at = None;
        self.status |= r::SUSPENDED;
    }

    /// Whether the program wants to be told of every frame.
    pub(in crate::usb) fn wants_frames(&self) -> bool {
        self.is_set(r::INTE, r::INT_DEV_SOF)
    }

    /// Start of frame.
    pub(in crate::usb) fn start_of_frame(&mut self, number: u32) {
        self.new_frame |= number != self.frame;
        self.frame = number;
    }
}
