//! The USB cable, and the port at the host's end of it.

use emulated_rp2040::machine::Machine;
use emulated_rp2040::usb::State;

use crate::garbled::Garbler;
use crate::vehicle::Fault;

/// What is wrong with the cable and the host's end at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Defects {
    deaf: bool,
    garbage_in: bool,
    garbage_out: bool,
    truncated_in: bool,
    truncated_out: bool,
}

/// Milliseconds between two bursts of garbage.
const BURST_EVERY: u32 = 7;
/// Bytes to the host that wait to be read, at most; the oldest go, as gaps of the frames' numbers
/// tell.
const ROOM: usize = 1 << 20;

/// A cable between the board and a port of the host.
#[derive(Clone, Debug)]
pub struct Cable {
    /// A program has the port open.
    open: bool,
    defects: Defects,
    garbler_in: Garbler,
    garbler_out: Garbler,
    /// Bytes for the board that the USB host has no room for yet.
    outgoing: Vec<u8>,
    incoming: Vec<u8>,
    slices: u32,
    was_found: bool,
}

impl Cable {
    /// A cable that is plugged in, to a port that no program has open.
    pub fn new(machine: &mut Machine, seed: u64) -> Self {
        let now = machine.now();
        machine.usb_mut().plug(now);
        Self {
            open: false,
            defects: Defects::default(),
            garbler_in: Garbler::new(seed, 1),
            garbler_out: Garbler::new(seed, 2),
            outgoing: Vec::new(),
            incoming: Vec::new(),
            slices: 0,
            was_found: false,
        }
    }

    /// Opens or closes the port. What is on its way is dropped.
    pub fn set_open(&mut self, machine: &mut Machine, open: bool) {
        self.open = open;
        self.outgoing.clear();
        self.incoming.clear();
        let now = machine.now();
        machine.usb_mut().set_dtr(open, now);
    }

    /// Whether a program has the port open.
    pub const fn is_open(&self) -> bool {
        self.open
    }

    /// Whether the port is open and the board knows that it is.
    pub fn connected(&self, machine: &Machine) -> bool {
        self.open && machine.usb().state() == State::Configured { dtr: true }
    }

    /// Whether the cable is in and the board was found.
    pub fn found(&self, machine: &Machine) -> bool {
        matches!(machine.usb().state(), State::Configured { .. })
    }

    /// Whether the board was there and is not any more.
    fn left(&mut self, machine: &Machine) -> bool {
        let found = self.found(machine);
        std::mem::replace(&mut self.was_found, found) && !found
    }

    /// Queues bytes for the board.
    pub fn send(&mut self, bytes: &[u8]) {
        if self.defects.truncated_in {
            self.outgoing.extend(self.garbler_in.truncate(bytes));
        } else {
            self.outgoing.extend_from_slice(bytes);
        }
    }

    /// Bytes that the board has not taken.
    pub fn unsent(&self, machine: &Machine) -> usize {
        self.outgoing.len() + machine.usb().unsent()
    }

    /// Moves what has come into `buffer`, as much as there is room for; returns how many bytes.
    pub fn receive(&mut self, buffer: &mut [u8]) -> usize {
        let length = buffer.len().min(self.incoming.len());
        for (to, from) in buffer.iter_mut().zip(self.incoming.drain(..length)) {
            *to = from;
        }
        length
    }

    /// Begins or ends a fault of the cable or of the host's end; others do not concern it.
    pub fn set_fault(&mut self, machine: &mut Machine, fault: Fault, on: bool) {
        let now = machine.now();
        let usb = machine.usb_mut();
        match fault {
            Fault::UsbUnplugged if on => {
                usb.unplug(now);
                // The host's driver closes a port whose device is gone.
                self.open = false;
            }
            Fault::UsbUnplugged => usb.plug(now),
            Fault::UsbDeaf => {
                self.defects.deaf = on;
                usb.set_reading(!on, now);
            }
            Fault::UsbGarbageIn => self.defects.garbage_in = on,
            Fault::UsbGarbageOut => self.defects.garbage_out = on,
            Fault::UsbTruncatedIn => self.defects.truncated_in = on,
            Fault::UsbTruncatedOut => self.defects.truncated_out = on,
            _ => {}
        }
    }

    /// Carries bytes, once a slice; returns what the board sent, before any damage.
    pub fn carry(&mut self, machine: &mut Machine) -> Vec<u8> {
        self.slices = self.slices.wrapping_add(1);
        // The host's driver closes a port whose device has left.
        self.open &= !self.left(machine);
        let now = machine.now();
        let burst = self.slices.is_multiple_of(BURST_EVERY);
        if self.defects.garbage_in && burst {
            self.outgoing.extend(self.garbler_in.burst());
        }
        if !self.outgoing.is_empty() {
            let accepted = machine.usb_mut().send(&self.outgoing, now);
            self.outgoing.drain(..accepted);
        }
        if self.defects.garbage_out && burst && self.open {
            let noise = self.garbler_out.burst();
            self.keep(&noise);
        }
        if self.defects.deaf || !machine.usb().has_received() {
            return Vec::new();
        }
        let bytes = machine.usb_mut().receive(now);
        if self.open && self.defects.truncated_out {
            let kept = self.garbler_out.truncate(&bytes);
            self.keep(&kept);
        } else if self.open {
            self.keep(&bytes);
        }
        bytes
    }

    /// Keeps bytes for the program that has the port open; the oldest go if it never reads.
    fn keep(&mut self, bytes: &[u8]) {
        self.incoming.extend_from_slice(bytes);
        let excess = self.incoming.len().saturating_sub(ROOM);
        self.incoming.drain(..excess);
    }
}
