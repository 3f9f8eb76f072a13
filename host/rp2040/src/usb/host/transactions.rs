//! Which transaction comes next on the bus, and what becomes of it.

use super::asked::Outcome;
use super::connection::{Connection, Halt, Pipe};
use super::phase::Phase;
use super::phases::{Host, RECEIVE_CAPACITY};
use crate::peripheral::Cycles;
use crate::usb::bus::{self, Transaction};
use crate::usb::controller::{Answer, Controller, Pid, Reply};
use crate::usb::descriptor::Bulk;
use crate::usb::dpram::Endpoint;
use crate::usb::transfer::Step;

impl Host {
    pub(super) fn running(&self) -> bool {
        self.timer.is_none() && matches!(self.phase, Phase::Enumeration | Phase::Configured)
    }

    /// Begins the next transaction, if there is one that would come to something.
    pub(in crate::usb) fn schedule(&mut self, controller: &mut Controller, now: Cycles) {
        if self.pending.is_none() && self.running() {
            self.ask(now);
            if let Some((transaction, bytes)) = self.choose(controller) {
                let start = now.max(self.free_at);
                let ends = bus::end(start, self.first_frame, bytes);
                self.pending = Some((ends, transaction));
            }
        }
    }

    /// The next transaction, and the bytes of data in it.
    fn choose(&mut self, controller: &mut Controller) -> Option<(Transaction, usize)> {
        self.choose_control(controller)
            .or_else(|| self.choose_bulk(controller))
    }

    fn choose_control(&mut self, controller: &mut Controller) -> Option<(Transaction, usize)> {
        let transaction = match self.asked.as_ref()?.transfer.step() {
            Step::Setup(packet) => return Some((Transaction::Setup(packet), 8)),
            Step::In => Transaction::In(Endpoint::CONTROL_IN),
            Step::Out(pid, bytes) => Transaction::Out(Endpoint::CONTROL_OUT, pid, bytes),
        };
        match self.answer(controller, transaction.endpoint()) {
            Answer::Nak => None,
            Answer::Ready(length) => Some(transaction.with(length)),
            Answer::Silence | Answer::Stall => Some(transaction.with(0)),
        }
    }

    fn choose_bulk(&mut self, controller: &mut Controller) -> Option<(Transaction, usize)> {
        let connection = self.connection?;
        let input = self.wants_input(&connection).then(|| {
            let endpoint = connection.port.input.endpoint;
            Transaction::In(endpoint)
        });
        let output = (connection.output.halt == Halt::No && !self.sending.is_empty()).then(|| {
            let Bulk { endpoint, packet } = connection.port.output;
            let bytes = self.sending.iter().take(packet).copied().collect();
            Transaction::Out(endpoint, connection.output.pid, bytes)
        });
        let notification = connection.port.notifications.map(Transaction::In);
        let wanted = if connection.output_next {
            [output, input, notification]
        } else {
            [input, output, notification]
        };
        for transaction in wanted.into_iter().flatten() {
            match self.answer(controller, transaction.endpoint()) {
                Answer::Ready(length) => return Some(transaction.with(length)),
                Answer::Stall => return Some(transaction.with(0)),
                Answer::Nak | Answer::Silence => {}
            }
        }
        None
    }

    fn wants_input(&self, connection: &Connection) -> bool {
        let room = RECEIVE_CAPACITY - self.received.len();
        self.reading && connection.input.halt == Halt::No && room >= connection.port.input.packet
    }

    fn answer(&self, controller: &mut Controller, endpoint: Endpoint) -> Answer {
        let answer = controller.answer(self.enumeration.address(), endpoint);
        if answer == Answer::Nak {
            controller.refused(endpoint, answer);
        }
        answer
    }

    /// A transaction has come to its end.
    pub(super) fn carry_out(
        &mut self,
        controller: &mut Controller,
        transaction: Transaction,
        now: Cycles,
    ) {
        let address = self.enumeration.address();
        match transaction {
            Transaction::Setup(packet) => {
                if !controller.setup(address, packet) {
                    self.request_ends(controller, Outcome::NoAnswer, now);
                } else if let Some(asked) = &mut self.asked {
                    asked.transfer.set_up();
                }
            }
            Transaction::In(endpoint) => match controller.give(address, endpoint) {
                Reply::Data(pid, bytes) if endpoint.is_control() => {
                    let progress = self.asked.as_mut().map(|a| a.transfer.came(pid, &bytes));
                    self.progress(controller, progress, now);
                }
                Reply::Data(pid, bytes) => self.came(endpoint, pid, &bytes),
                Reply::None(answer) => self.came_to_nothing(controller, endpoint, answer, now),
            },
            Transaction::Out(endpoint, pid, bytes) => {
                match controller.take(address, endpoint, pid, &bytes) {
                    Answer::Ready(_) if endpoint.is_control() => {
                        let progress = self.asked.as_mut().map(|a| a.transfer.went());
                        self.progress(controller, progress, now);
                    }
                    Answer::Ready(_) => self.went(bytes.len()),
                    answer => self.came_to_nothing(controller, endpoint, answer, now),
                }
            }
        }
    }

    /// Data have come from a bulk or interrupt endpoint.
    fn came(&mut self, endpoint: Endpoint, pid: Pid, bytes: &[u8]) {
        let Some(connection) = &mut self.connection else {
            return;
        };
        if connection.port.input.endpoint != endpoint {
            self.counters.notifications += 1;
            return;
        }
        connection.output_next = true;
        if pid != connection.input.pid {
            self.counters.repeated += 1;
            return;
        }
        connection.input.pid = pid.toggled();
        if bytes.len() > connection.port.input.packet {
            self.counters.oversized += 1;
            return;
        }
        self.received.extend(bytes);
        self.counters.packets_in += 1;
        self.counters.bytes_in += bytes.len() as u64;
    }

    /// Data have gone to the bulk endpoint.
    fn went(&mut self, length: usize) {
        if let Some(connection) = &mut self.connection {
            connection.output_next = false;
            connection.output.pid = connection.output.pid.toggled();
        }
        self.sending.drain(..length.min(self.sending.len()));
        self.counters.packets_out += 1;
        self.counters.bytes_out += length as u64;
    }

    fn came_to_nothing(
        &mut self,
        controller: &mut Controller,
        endpoint: Endpoint,
        answer: Answer,
        now: Cycles,
    ) {
        match answer {
            Answer::Silence if endpoint.is_control() => {
                self.request_ends(controller, Outcome::NoAnswer, now);
            }
            Answer::Stall if endpoint.is_control() => {
                self.request_ends(controller, Outcome::Refused, now);
            }
            Answer::Stall => {
                self.counters.stalls += 1;
                if let Some(pipe) = self.pipe(endpoint.address()) {
                    pipe.halt = Halt::Halted;
                }
            }
            // The device has taken its buffer back in the meantime.
            Answer::Nak | Answer::Silence | Answer::Ready(_) => {}
        }
    }

    pub(super) fn pipe(&mut self, address: u8) -> Option<&mut Pipe> {
        let connection = self.connection.as_mut()?;
        if address == connection.port.input.endpoint.address() {
            Some(&mut connection.input)
        } else if address == connection.port.output.endpoint.address() {
            Some(&mut connection.output)
        } else {
            None
        }
    }
}
