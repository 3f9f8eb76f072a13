//! The host: its state, and the phases from the plugging in of a cable to a port in use.

use std::collections::VecDeque;

use super::asked::{Asked, Outcome};
use super::connection::Connection;
use super::counters::Counters;
use super::phase::Phase;
use crate::peripheral::{CYCLES_PER_MICROSECOND, Cycles};
use crate::usb::bus::{self, Transaction};
use crate::usb::controller::Controller;
use crate::usb::enumeration::{Description, Enumeration};
use crate::usb::state::State;

const MILLISECOND: Cycles = 1_000 * CYCLES_PER_MICROSECOND;
/// How long a connection has to last before it is believed (USB 2.0 7.1.7.3, TATTDB).
const DEBOUNCE: Cycles = 100 * MILLISECOND;
/// Reset of a root port (7.1.7.5, TDRSTR).
const RESET: Cycles = 50 * MILLISECOND;
/// Time for the device to recover from reset and from resume (7.1.7.5, TRSTRCY; 7.1.7.7, TRSMRCY).
const RECOVERY: Cycles = 10 * MILLISECOND;
/// Resume signalling (7.1.7.7, TDRSMDN).
const RESUME: Cycles = 20 * MILLISECOND;
/// Time for the device to get used to its address (9.2.6.3).
pub(super) const NEW_ADDRESS: Cycles = 2 * MILLISECOND;
/// The most that any request may take (9.2.6.1).
pub(super) const REQUEST_LIMIT: Cycles = 5_000 * MILLISECOND;
/// Attempts at enumeration. Linux makes four.
pub(super) const ATTEMPTS: u32 = 3;

/// Bytes that wait to be sent, at most.
pub(in crate::usb) const SEND_CAPACITY: usize = 4096;
/// Bytes that wait to be fetched, at most; the host does not ask for more than it has room for.
pub(in crate::usb) const RECEIVE_CAPACITY: usize = 65_536;

/// The host.
#[derive(Clone, Debug)]
pub(in crate::usb) struct Host {
    pub(super) phase: Phase,
    /// When the phase ends, or its pause.
    pub(super) timer: Option<Cycles>,
    pub(super) failed_attempts: u32,
    pub(super) enumeration: Enumeration,
    pub(super) asked: Option<Asked>,
    pub(super) connection: Option<Connection>,
    /// The transaction on the bus, and when it ends.
    pub(super) pending: Option<(Cycles, Transaction)>,
    /// When the last one ended.
    pub(super) free_at: Cycles,
    /// When frame 0 began.
    pub(super) first_frame: Cycles,
    pub(super) frames_seen: u64,
    pub(in crate::usb) dtr: bool,
    pub(in crate::usb) reading: bool,
    pub(in crate::usb) sending: VecDeque<u8>,
    pub(in crate::usb) received: Vec<u8>,
    pub(in crate::usb) counters: Counters,
}

impl Host {
    /// Unplugged.
    pub(in crate::usb) fn new() -> Self {
        Self {
            phase: Phase::Unplugged,
            timer: None,
            failed_attempts: 0,
            enumeration: Enumeration::new(),
            asked: None,
            connection: None,
            pending: None,
            free_at: 0,
            first_frame: 0,
            frames_seen: 0,
            dtr: false,
            reading: true,
            sending: VecDeque::new(),
            received: Vec::new(),
            counters: Counters::default(),
        }
    }

    // What the user does.

    pub(in crate::usb) fn plug(&mut self, controller: &Controller, now: Cycles) {
        if self.phase == Phase::Unplugged {
            self.phase = Phase::NoDevice;
            if controller.attached() {
                self.attached(now);
            }
        }
    }

    pub(in crate::usb) fn unplug(&mut self, controller: &mut Controller, now: Cycles) {
        if self.phase != Phase::Unplugged {
            self.disconnect(Phase::Unplugged);
            controller.bus_idle(now);
        }
    }

    pub(in crate::usb) fn suspend(&mut self, controller: &mut Controller, now: Cycles) -> bool {
        let can = self.phase == Phase::Configured && self.timer.is_none();
        if can {
            self.phase = Phase::Suspended;
            self.pending = None;
            controller.bus_idle(now);
        }
        can
    }

    pub(in crate::usb) fn resume(&mut self, controller: &mut Controller, now: Cycles) -> bool {
        let can = self.phase == Phase::Suspended;
        if can {
            self.phase = Phase::Resuming;
            self.timer = Some(now + RESUME);
            controller.bus_resume();
        }
        can
    }

    pub(in crate::usb) fn send(&mut self, bytes: &[u8]) -> usize {
        if self.connection.is_none() {
            return 0;
        }
        let room = SEND_CAPACITY - self.sending.len();
        let accepted = bytes.len().min(room);
        self.sending.extend(&bytes[..accepted]);
        accepted
    }

    pub(in crate::usb) fn state(&self) -> State {
        match self.phase {
            Phase::Unplugged => State::Unplugged,
            Phase::NoDevice => State::NoDevice,
            Phase::Debounce | Phase::Reset | Phase::Recovery | Phase::Enumeration => {
                State::Enumerating
            }
            Phase::Configured => State::Configured {
                dtr: self.connection.is_some_and(|connection| connection.dtr),
            },
            Phase::Suspended | Phase::Resuming => State::Suspended,
            Phase::Failed(error) => State::Failed(error),
        }
    }

    pub(in crate::usb) fn description(&self) -> Option<&Description> {
        self.connection.map(|_| self.enumeration.description())
    }

    // What the device's pull-up does.

    pub(in crate::usb) fn attached(&mut self, now: Cycles) {
        if self.phase == Phase::NoDevice {
            self.phase = Phase::Debounce;
            self.timer = Some(now + DEBOUNCE);
            self.failed_attempts = 0;
        }
    }

    pub(in crate::usb) fn detached(&mut self) {
        if self.phase != Phase::Unplugged {
            self.disconnect(Phase::NoDevice);
        }
    }

    /// The port counts as closed.
    fn disconnect(&mut self, phase: Phase) {
        self.stop();
        self.phase = phase;
        self.dtr = false;
    }

    pub(super) fn stop(&mut self) {
        self.timer = None;
        self.asked = None;
        self.pending = None;
        self.connection = None;
        self.counters.unsent += self.sending.len() as u64;
        self.sending.clear();
    }

    // Time.

    /// When something happens by itself.
    pub(in crate::usb) fn next_event(&self) -> Option<Cycles> {
        let ends = self.pending.as_ref().map(|(ends, _)| *ends);
        let limit = match &self.asked {
            Some(asked) if self.running() => Some(asked.deadline),
            _ => None,
        };
        [ends, self.timer, limit].into_iter().flatten().min()
    }

    /// Does what is due at that time.
    pub(in crate::usb) fn event(&mut self, controller: &mut Controller, now: Cycles) {
        let ended = self.pending.take_if(|(ends, _)| *ends <= now);
        if let Some((_, transaction)) = ended {
            self.free_at = now;
            self.carry_out(controller, transaction, now);
        } else if self.timer.is_some_and(|timer| timer <= now) {
            self.timer = None;
            self.phase_ends(controller, now);
        } else if self.running() && self.asked.as_ref().is_some_and(|a| a.deadline <= now) {
            self.pending = None;
            self.request_ends(controller, Outcome::TimeOut, now);
        }
        self.schedule(controller, now);
    }

    /// Frame number on the bus, if there are frames.
    pub(in crate::usb) fn frame(&mut self, now: Cycles) -> Option<u32> {
        self.sends_frames().then(|| {
            self.frames_seen = now.saturating_sub(self.first_frame) / bus::FRAME;
            (self.frames_seen & 0x7ff) as u32
        })
    }

    /// When the next frame begins that was not counted yet.
    pub(in crate::usb) fn next_frame(&self) -> Option<Cycles> {
        self.sends_frames()
            .then(|| self.first_frame + (self.frames_seen + 1) * bus::FRAME)
    }

    fn sends_frames(&self) -> bool {
        matches!(
            self.phase,
            Phase::Recovery | Phase::Enumeration | Phase::Configured
        )
    }

    fn frames_begin(&mut self, controller: &mut Controller, now: Cycles) {
        controller.bus_active();
        self.first_frame = now;
        self.frames_seen = 0;
        self.timer = Some(now + RECOVERY);
    }

    fn phase_ends(&mut self, controller: &mut Controller, now: Cycles) {
        match self.phase {
            Phase::Debounce => self.reset(controller, now),
            Phase::Reset => {
                self.phase = Phase::Recovery;
                self.frames_begin(controller, now);
            }
            Phase::Recovery => {
                self.phase = Phase::Enumeration;
                self.enumeration = Enumeration::new();
            }
            Phase::Resuming => {
                self.phase = Phase::Configured;
                self.frames_begin(controller, now);
                if let Some(asked) = &mut self.asked {
                    asked.deadline = now + REQUEST_LIMIT;
                }
            }
            // A pause is over, or nothing was to end.
            _ => {}
        }
    }

    pub(super) fn reset(&mut self, controller: &mut Controller, now: Cycles) {
        self.stop();
        self.phase = Phase::Reset;
        self.timer = Some(now + RESET);
        controller.bus_reset();
    }
}
