//! What the host asks of the device by control transfers, and what follows from the answers.

use super::asked::{Asked, Outcome};
use super::connection::{Connection, Halt, Pipe};
use super::phase::Phase;
use super::phases::{ATTEMPTS, Host, NEW_ADDRESS, REQUEST_LIMIT};
use crate::peripheral::Cycles;
use crate::usb::controller::Controller;
use crate::usb::enumeration::{EnumerationError, Request};
use crate::usb::transfer::{ControlTransfer, Progress};

impl Host {
    /// Begins the next control transfer, if none is under way.
    pub(super) fn ask(&mut self, now: Cycles) {
        if self.asked.is_some() {
            return;
        }
        let request = match (&self.connection, self.phase) {
            (_, Phase::Enumeration) => Some(self.enumeration.request()),
            (Some(connection), _) => connection.request(self.dtr),
            _ => None,
        };
        if let Some(request) = request {
            let (setup, data) = self.enumeration.packet(request);
            let packet = self.enumeration.control_packet();
            self.asked = Some(Asked {
                request,
                transfer: ControlTransfer::new(setup, data, packet),
                deadline: now + REQUEST_LIMIT,
            });
        }
    }

    pub(super) fn progress(
        &mut self,
        controller: &mut Controller,
        progress: Option<Progress>,
        now: Cycles,
    ) {
        match progress {
            Some(Progress::Done(data)) => {
                self.request_ends(controller, Outcome::Done(data), now);
            }
            Some(Progress::Babble(size)) => {
                self.request_ends(controller, Outcome::Babble(size), now);
            }
            Some(Progress::Repeated) => self.counters.repeated += 1,
            Some(Progress::Going) | None => {}
        }
    }

    pub(super) fn request_ends(
        &mut self,
        controller: &mut Controller,
        outcome: Outcome,
        now: Cycles,
    ) {
        let Some(Asked { request, .. }) = self.asked.take() else {
            return;
        };
        if self.phase != Phase::Enumeration {
            return self.class_request_ends(request, matches!(outcome, Outcome::Done(_)));
        }
        let done = match outcome {
            Outcome::Done(data) => self.enumeration.take(&data),
            Outcome::Refused => self.enumeration.refused(),
            Outcome::NoAnswer => Err(EnumerationError::NoAnswer(request)),
            Outcome::TimeOut => Err(EnumerationError::TimeOut(request)),
            Outcome::Babble(size) => Err(EnumerationError::Babble(request, size)),
        };
        match done {
            Ok(true) => self.configured(),
            Ok(false) if request == Request::SetAddress => self.timer = Some(now + NEW_ADDRESS),
            Ok(false) => {}
            Err(error) => self.attempt_failed(controller, error, now),
        }
    }

    fn configured(&mut self) {
        self.phase = Phase::Configured;
        self.counters.connections += 1;
        self.connection = self.enumeration.port().map(Connection::new);
    }

    fn attempt_failed(
        &mut self,
        controller: &mut Controller,
        error: EnumerationError,
        now: Cycles,
    ) {
        self.counters.failed_attempts += 1;
        self.failed_attempts += 1;
        if self.failed_attempts < ATTEMPTS {
            self.reset(controller, now);
        } else {
            self.stop();
            self.phase = Phase::Failed(error);
            controller.bus_idle(now);
        }
    }

    fn class_request_ends(&mut self, request: Request, done: bool) {
        if !done {
            self.counters.failed_requests += 1;
        }
        match request {
            Request::SetControlLineState(on) => {
                if let Some(connection) = &mut self.connection {
                    connection.told = Some(on);
                    if done {
                        connection.dtr = on;
                    }
                }
            }
            Request::ClearHalt(address) => {
                if let Some(pipe) = self.pipe(address) {
                    // Clearing a halt begins the sequence anew (USB 2.0 9.4.5).
                    *pipe = Pipe::NEW;
                    if !done {
                        pipe.halt = Halt::ForGood;
                    }
                }
            }
            _ => {}
        }
    }
}
