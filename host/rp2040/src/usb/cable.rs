//! Both ends of the cable in one time.

use super::controller::Controller;
use super::enumeration::Description;
use super::host::{Counters, Host};
use super::state::State;
use crate::peripheral::{Cycles, Peripheral, Write};

/// The controller and its host. All moments are in cycles of the system clock and never go back.
#[derive(Clone, Debug)]
pub struct Usb {
    controller: Controller,
    host: Host,
    attached: bool,
}

impl Default for Usb {
    fn default() -> Self {
        Self::new()
    }
}

impl Usb {
    /// After power-up, unplugged.
    pub fn new() -> Self {
        Self {
            controller: Controller::new(),
            host: Host::new(),
            attached: false,
        }
    }

    // The device's end.

    /// Resets the controller, whether with the whole chip or alone (RESETS). Its memory keeps what
    /// it holds; the host sees the pull-up go, and the connection ends.
    pub fn reset(&mut self, now: Cycles) {
        self.advance(now);
        self.controller.reset();
        self.settle(now);
    }

    /// The interrupt line USBCTRL_IRQ (number 5).
    pub fn interrupt(&self) -> bool {
        self.controller.interrupt()
    }

    /// Reads N bytes of the controller's memory at this offset from 0x50100000: 1, 2 or 4 for
    /// processor and DMA. The 4 KiB repeat.
    pub fn read_memory<const N: usize>(&mut self, offset: u32, now: Cycles) -> [u8; N] {
        self.advance(now);
        self.controller.read_dpram(offset)
    }

    /// Writes N bytes of the controller's memory. (There are no atomic aliases.)
    pub fn write_memory<const N: usize>(&mut self, offset: u32, bytes: [u8; N], now: Cycles) {
        self.advance(now);
        if self.controller.write_dpram(offset, bytes) {
            self.settle(now);
        }
    }

    // The host's end.

    /// Plugs the cable in. The host finds the device as soon as that switches its pull-up on.
    pub fn plug(&mut self, now: Cycles) {
        self.advance(now);
        self.host.plug(&self.controller, now);
        self.settle(now);
    }

    /// Pulls the cable: a packet on the way is lost as if it had never begun, bytes not yet sent are
    /// dropped and counted, bytes that have come stay to be fetched, and the port counts as closed.
    pub fn unplug(&mut self, now: Cycles) {
        self.advance(now);
        self.host.unplug(&mut self.controller, now);
    }

    /// Lets the host sleep; after 3 ms the device notices. Returns false, and does nothing, unless the
    /// serial port is in use.
    pub fn suspend(&mut self, now: Cycles) -> bool {
        self.advance(now);
        self.host.suspend(&mut self.controller, now)
    }

    /// Wakes the host; 30 ms later bytes go on. Returns false, and does nothing, unless it sleeps.
    pub fn resume(&mut self, now: Cycles) -> bool {
        self.advance(now);
        self.host.resume(&mut self.controller, now)
    }

    /// Opens or closes the port (DTR and RTS). The host sends the request when it can, at once or
    /// after enumeration; [`State`] shows when the device has acknowledged it. When a connection ends,
    /// the port is closed.
    pub fn set_dtr(&mut self, on: bool, now: Cycles) {
        self.advance(now);
        self.host.dtr = on;
        self.settle(now);
    }

    /// Whether the host asks the device for bytes; it does so from the beginning, whether the port is
    /// open or not. While it does not, the device's packet waits in its buffer.
    pub fn set_reading(&mut self, on: bool, now: Cycles) {
        self.advance(now);
        self.host.reading = on;
        self.settle(now);
    }

    /// Queues bytes for the device, and returns how many of them there was room for: none unless the
    /// serial port is in use, and never more than 4096 at a time.
    pub fn send(&mut self, bytes: &[u8], now: Cycles) -> usize {
        self.advance(now);
        let accepted = self.host.send(bytes);
        self.settle(now);
        accepted
    }

    /// Bytes queued that the device has not taken yet.
    pub fn unsent(&self) -> usize {
        self.host.sending.len()
    }

    /// Takes all bytes that have come from the device. At 65536 the host asks for no more until they
    /// are fetched.
    pub fn receive(&mut self, now: Cycles) -> Vec<u8> {
        self.advance(now);
        let bytes = std::mem::take(&mut self.host.received);
        self.settle(now);
        bytes
    }

    /// Whether bytes have come that were not taken.
    pub fn has_received(&self) -> bool {
        !self.host.received.is_empty()
    }

    /// What the host sees of the device.
    pub fn state(&self) -> State {
        self.host.state()
    }

    /// What the device has said of itself, while its serial port is in use.
    pub fn description(&self) -> Option<&Description> {
        self.host.description()
    }

    /// What has happened.
    pub fn counters(&self) -> Counters {
        self.host.counters
    }

    /// After something has changed.
    fn settle(&mut self, now: Cycles) {
        let attached = self.controller.attached();
        if attached != self.attached {
            self.attached = attached;
            if attached {
                self.host.attached(now);
            } else {
                self.host.detached();
            }
            self.controller.bus_idle(now);
        }
        self.host.schedule(&mut self.controller, now);
    }

    /// Tells the controller of the frames up to now.
    fn count_frames(&mut self, now: Cycles) {
        if let Some(frame) = self.host.frame(now) {
            self.controller.start_of_frame(frame);
        }
    }

    fn next_frame(&self) -> Option<Cycles> {
        let wanted = self.controller.wants_frames();
        if wanted { self.host.next_frame() } else { None }
    }
}

/// The registers at 0x50110000.
impl Peripheral for Usb {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        self.advance(now);
        self.count_frames(now);
        self.controller.read(offset)
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        self.advance(now);
        self.controller.write(offset, write);
        self.settle(now);
    }

    fn next_event(&self) -> Option<Cycles> {
        let all = [
            self.host.next_event(),
            self.controller.suspend_at(),
            self.next_frame(),
        ];
        all.into_iter().flatten().min()
    }

    fn advance(&mut self, now: Cycles) {
        while let Some(event) = self.next_event().filter(|event| *event <= now) {
            if self.host.next_event() == Some(event) {
                self.host.event(&mut self.controller, event);
            } else if self.controller.suspend_at() == Some(event) {
                self.controller.suspend();
            } else {
                self.count_frames(event);
            }
        }
    }
}
