//! The computer at the other end of the cable: it finds the device, takes its serial port into use,
//! and carries bytes both ways.
//!
//! It works by events: one for each transaction that comes to something. What a real host does all
//! the time, to ask an endpoint again that has said NAK, is not played: a device that has nothing to
//! say costs nothing. As soon as its buffer is available, the next transaction is with it.

use std::collections::VecDeque;

use super::State;
use super::bus::{self, Transaction};
use super::controller::{Answer, Controller, Pid, Reply};
use super::descriptor::{Bulk, SerialPort};
use super::dpram::Endpoint;
use super::enumeration::{Description, Enumeration, EnumerationError, Request};
use super::transfer::{ControlTransfer, Progress, Step};
use crate::board::peripheral::{CYCLES_PER_MICROSECOND, Cycles};

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
const NEW_ADDRESS: Cycles = 2 * MILLISECOND;
/// The most that any request may take (9.2.6.1).
const REQUEST_LIMIT: Cycles = 5_000 * MILLISECOND;
/// How often a host tries to get to know a device. Linux tries four times.
const ATTEMPTS: u32 = 3;

/// Bytes that wait to be sent, at most.
pub(super) const SEND_CAPACITY: usize = 4096;
/// Bytes that wait to be fetched, at most; the host does not ask for more than it has room for.
pub(super) const RECEIVE_CAPACITY: usize = 65_536;

/// What has happened since the machine was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Times that a device was taken into use.
    pub connections: u64,
    /// Attempts to do so that failed.
    pub failed_attempts: u64,
    /// Requests to a device in use that failed.
    pub failed_requests: u64,
    /// Packets of the serial port that came from the device.
    pub packets_in: u64,
    /// Bytes in them.
    pub bytes_in: u64,
    /// Packets of the serial port that went to the device.
    pub packets_out: u64,
    /// Bytes in them.
    pub bytes_out: u64,
    /// Packets that came again: acknowledged and dropped.
    pub repeated: u64,
    /// Packets larger than the device's descriptors allow: dropped.
    pub oversized: u64,
    /// Times that the device refused data for good (STALL).
    pub stalls: u64,
    /// Notifications of the serial port: taken and ignored.
    pub notifications: u64,
    /// Bytes that were to be sent when the connection ended.
    pub unsent: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Unplugged,
    NoDevice,
    Debounce,
    Reset,
    Recovery,
    Enumeration,
    Configured,
    Suspended,
    Resuming,
    Failed(EnumerationError),
}

/// A serial port in use.
#[derive(Clone, Copy, Debug)]
struct Connection {
    port: SerialPort,
    input: Pipe,
    output: Pipe,
    /// DTR as the device was told, if it was.
    told: Option<bool>,
    /// DTR as the device has acknowledged it.
    dtr: bool,
    /// It is the output's turn, if both directions can go on.
    output_next: bool,
}

/// The state of a bulk endpoint.
#[derive(Clone, Copy, Debug)]
struct Pipe {
    pid: Pid,
    halt: Halt,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Halt {
    No,
    /// The device has said STALL; it is to be asked to forget that.
    Halted,
    /// It did not.
    ForGood,
}

impl Pipe {
    const NEW: Self = Self {
        pid: Pid::Data0,
        halt: Halt::No,
    };
}

/// How a control transfer has ended.
enum Outcome {
    Done(Vec<u8>),
    Refused,
    NoAnswer,
    TimeOut,
    Babble(usize),
}

#[derive(Clone, Debug)]
struct Asked {
    request: Request,
    transfer: ControlTransfer,
    deadline: Cycles,
}

/// The host.
#[derive(Clone, Debug)]
pub(super) struct Host {
    phase: Phase,
    /// When the phase ends, or its pause.
    timer: Option<Cycles>,
    failed_attempts: u32,
    enumeration: Enumeration,
    asked: Option<Asked>,
    connection: Option<Connection>,
    /// The transaction on the bus, and when it ends.
    pending: Option<(Cycles, Transaction)>,
    /// When the last one ended.
    free_at: Cycles,
    /// When frame 0 began.
    first_frame: Cycles,
    frames_seen: u64,
    dtr: bool,
    reading: bool,
    sending: VecDeque<u8>,
    received: Vec<u8>,
    counters: Counters,
}

impl Host {
    /// Unplugged.
    pub(super) fn new() -> Self {
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

    pub(super) fn plug(&mut self, controller: &Controller, now: Cycles) {
        if self.phase == Phase::Unplugged {
            self.phase = Phase::NoDevice;
            if controller.attached() {
                self.attached(now);
            }
        }
    }

    pub(super) fn unplug(&mut self, controller: &mut Controller, now: Cycles) {
        if self.phase != Phase::Unplugged {
            self.disconnect(Phase::Unplugged);
            controller.bus_idle(now);
        }
    }

    pub(super) fn suspend(&mut self, controller: &mut Controller, now: Cycles) -> bool {
        let can = self.phase == Phase::Configured && self.timer.is_none();
        if can {
            self.phase = Phase::Suspended;
            self.pending = None;
            controller.bus_idle(now);
        }
        can
    }

    pub(super) fn resume(&mut self, controller: &mut Controller, now: Cycles) -> bool {
        let can = self.phase == Phase::Suspended;
        if can {
            self.phase = Phase::Resuming;
            self.timer = Some(now + RESUME);
            controller.bus_resume();
        }
        can
    }

    pub(super) fn set_dtr(&mut self, on: bool) {
        self.dtr = on;
    }

    pub(super) fn set_reading(&mut self, on: bool) {
        self.reading = on;
    }

    pub(super) fn send(&mut self, bytes: &[u8]) -> usize {
        if self.connection.is_none() {
            return 0;
        }
        let room = SEND_CAPACITY - self.sending.len();
        let accepted = bytes.len().min(room);
        self.sending.extend(&bytes[..accepted]);
        accepted
    }

    pub(super) fn unsent(&self) -> usize {
        self.sending.len()
    }

    pub(super) fn receive(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.received)
    }

    pub(super) fn state(&self) -> State {
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

    pub(super) fn description(&self) -> Option<&Description> {
        self.connection.map(|_| self.enumeration.description())
    }

    pub(super) fn counters(&self) -> Counters {
        self.counters
    }

    // What the device's pull-up does.

    pub(super) fn attached(&mut self, now: Cycles) {
        if self.phase == Phase::NoDevice {
            self.phase = Phase::Debounce;
            self.timer = Some(now + DEBOUNCE);
            self.failed_attempts = 0;
        }
    }

    pub(super) fn detached(&mut self) {
        if self.phase != Phase::Unplugged {
            self.disconnect(Phase::NoDevice);
        }
    }

    /// Whoever had opened the port has to open it again.
    fn disconnect(&mut self, phase: Phase) {
        self.stop();
        self.phase = phase;
        self.dtr = false;
    }

    fn stop(&mut self) {
        self.timer = None;
        self.asked = None;
        self.pending = None;
        self.connection = None;
        self.counters.unsent += self.sending.len() as u64;
        self.sending.clear();
    }

    // Time.

    /// When something happens by itself.
    pub(super) fn next_event(&self) -> Option<Cycles> {
        let ends = self.pending.as_ref().map(|(ends, _)| *ends);
        let limit = match &self.asked {
            Some(asked) if self.running() => Some(asked.deadline),
            _ => None,
        };
        [ends, self.timer, limit].into_iter().flatten().min()
    }

    /// Lets happen what happens at that time.
    pub(super) fn event(&mut self, controller: &mut Controller, now: Cycles) {
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
    pub(super) fn frame(&mut self, now: Cycles) -> Option<u32> {
        self.sends_frames().then(|| {
            self.frames_seen = now.saturating_sub(self.first_frame) / bus::FRAME;
            (self.frames_seen & 0x7ff) as u32
        })
    }

    /// When the next frame begins that nobody has looked at yet.
    pub(super) fn next_frame(&self) -> Option<Cycles> {
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

    fn reset(&mut self, controller: &mut Controller, now: Cycles) {
        self.stop();
        self.phase = Phase::Reset;
        self.timer = Some(now + RESET);
        controller.bus_reset();
    }

    // Transactions.

    fn running(&self) -> bool {
        self.timer.is_none() && matches!(self.phase, Phase::Enumeration | Phase::Configured)
    }

    /// Begins the next transaction, if there is one that would come to something.
    pub(super) fn schedule(&mut self, controller: &mut Controller, now: Cycles) {
        if self.pending.is_none() && self.running() {
            self.ask(now);
            if let Some((transaction, bytes)) = self.choose(controller) {
                let start = now.max(self.free_at);
                let ends = bus::end(start, self.first_frame, bytes);
                self.pending = Some((ends, transaction));
            }
        }
    }

    /// Begins the next control transfer, if none is under way.
    fn ask(&mut self, now: Cycles) {
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
    fn carry_out(&mut self, controller: &mut Controller, transaction: Transaction, now: Cycles) {
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

    fn pipe(&mut self, address: u8) -> Option<&mut Pipe> {
        let connection = self.connection.as_mut()?;
        if address == connection.port.input.endpoint.address() {
            Some(&mut connection.input)
        } else if address == connection.port.output.endpoint.address() {
            Some(&mut connection.output)
        } else {
            None
        }
    }

    // Requests.

    fn progress(&mut self, controller: &mut Controller, progress: Option<Progress>, now: Cycles) {
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

    fn request_ends(&mut self, controller: &mut Controller, outcome: Outcome, now: Cycles) {
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
        self.connection = self.enumeration.port().map(|port| Connection {
            port,
            input: Pipe::NEW,
            output: Pipe::NEW,
            told: None,
            dtr: false,
            output_next: false,
        });
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

    /// Whether bytes have come.
    pub fn has_received(&self) -> bool {
        !self.received.is_empty()
    }

impl Connection {
    /// What to ask the device, if anything.
    fn request(&self, dtr: bool) -> Option<Request> {
        let pipes = [
            (self.input, self.port.input.endpoint),
            (self.output, self.port.output.endpoint),
        ];
        let halted = pipes.iter().find(|(pipe, _)| pipe.halt == Halt::Halted);
        if let Some((_, endpoint)) = halted {
            return Some(Request::ClearHalt(endpoint.address()));
        }
        // A port is closed until it is opened: nobody need be told.
        (self.told.unwrap_or(false) != dtr).then_some(Request::SetControlLineState(dtr))
    }
}
