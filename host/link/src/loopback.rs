//! A rover in this process: the core with a simple body in an empty square room, and its end of
//! the wire. With it everything that talks to a rover can be tested without a board, and without
//! its time: a simulated minute takes milliseconds.
//!
//! What only the firmware has is left out: sensors' noise and health, bounded queues, flash that
//! takes time. The emulated board has all that.

mod body;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use rover_shared::contract::{ChannelHealth, CompassHealth, ResetReason};
use rover_shared::knowledge::Knowledge;
use rover_shared::motion::{Motion, Parameters as Chassis, WheelCommand};
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::rover::{Identity, Observation, PERIOD, Rover, Staging};
use rover_shared::sensing::ir::curve::RangeCurve;
use rover_shared::sensing::ir::{AdcCount, CHANNELS, IrReading};
use rover_shared::supervisor::{Input, Loop, Supervisor};
use rover_shared::time::{Duration, Instant};
use rover_shared::units::Micrometres;
use rover_shared::wire::frame::{Decoder, Encoder, FrameError, MAX_FRAME};
use rover_shared::wire::message::{Ack, Command, Report};

use self::body::Body;
use super::{Port, PortError};

static COEFFICIENTS: Coefficients = match Coefficients::new(&Parameters::ROVER) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the rover's parameters are valid"),
};

const IDENTITY: Identity = Identity {
    board: "loopback",
    firmware: env!("CARGO_PKG_VERSION"),
};
const LOOPS: [Loop; 5] = [
    Loop::Sense,
    Loop::Control,
    Loop::Drive,
    Loop::Link,
    Loop::Store,
];

/// Where the range sensors look, in degrees to the left: front left, front right, left, right.
const BEAMS: [f64; CHANNELS] = [0.0, 0.0, 45.0, -45.0];

/// A rover, its body and its end of the wire.
pub struct Loopback {
    rover: Rover<'static>,
    supervisor: Supervisor,
    now: Instant,
    body: Body,
    applied: WheelCommand,
    /// Health of the compass, as a test wants it.
    pub compass: CompassHealth,
    /// Reports that are lost on the way: this many of those sent next.
    pub lose: u32,
    stored: Vec<u8>,
    decoder: Decoder,
    encoder: Encoder,
    open: bool,
    sent: VecDeque<u8>,
}

impl Loopback {
    /// A rover that was just switched on and knows nothing.
    ///
    /// Its memory is never given back, as on the board: a rover holds on to it for ever.
    pub fn new(seed: u64) -> Self {
        let mut loopback = Self {
            rover: new_rover(seed),
            supervisor: Supervisor::new(Instant(0), ResetReason::PowerOn),
            now: Instant(0),
            body: Body::default(),
            applied: WheelCommand::STOP,
            compass: CompassHealth::Good,
            lose: 0,
            stored: Vec::new(),
            decoder: Decoder::new(),
            encoder: Encoder::new(),
            open: false,
            sent: VecDeque::new(),
        };
        loopback.start();
        loopback
    }

    /// The time since it was first switched on.
    pub fn now(&self) -> Instant {
        self.now
    }

    /// What lies in its flash; empty if nothing was stored.
    pub fn stored(&self) -> &[u8] {
        &self.stored
    }

    /// Switches it off and on; it knows what is in its flash. The connection is closed.
    pub fn reset(&mut self, reason: ResetReason, seed: u64) {
        self.close();
        self.rover = new_rover(seed);
        self.supervisor = Supervisor::new(self.now, reason);
        self.applied = WheelCommand::STOP;
        self.start();
    }

    fn start(&mut self) {
        let stored = std::mem::take(&mut self.stored);
        let loaded = self.rover.load(|room| {
            room.get_mut(..stored.len())?.copy_from_slice(&stored);
            (!stored.is_empty()).then_some(stored.len())
        });
        self.stored = stored;
        if loaded.is_err() {
            self.rover.begin();
        }
        self.rover.announce(&mut (self.now, &mut self.supervisor));
        // The sensors have been read before any host can speak.
        self.run(Duration(PERIOD.0 * 10));
    }

    /// The host opens the port (DTR).
    pub fn open(&mut self) {
        self.open = true;
        self.decoder = Decoder::new();
        self.encoder = Encoder::new();
        self.sent.clear();
        self.sent.push_back(0);
        let hello = self.rover.hello(&mut (self.now, &mut self.supervisor));
        self.say(&hello);
    }

    /// The host closes the port, or the cable is pulled.
    pub fn close(&mut self) {
        self.open = false;
        self.sent.clear();
        self.rover.closed();
    }

    /// Takes what the host sent.
    pub fn hear(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match self.decoder.push::<Command>(*byte) {
                Some(Ok(frame)) => self.obey(frame.sequence, &frame.message),
                Some(Err(FrameError::Version(_))) => {
                    let hello = self.rover.hello(&mut (self.now, &mut self.supervisor));
                    self.say(&hello);
                }
                Some(Err(_)) | None => {}
            }
        }
    }

    /// Moves at most `buffer`'s length of what it sent into `buffer`, and gives the length.
    pub fn take_sent(&mut self, buffer: &mut [u8]) -> usize {
        let length = buffer.len().min(self.sent.len());
        for (place, byte) in buffer.iter_mut().zip(self.sent.drain(..length)) {
            *place = byte;
        }
        length
    }

    /// Goes on for whole control periods, at least for `span`.
    pub fn run(&mut self, span: Duration) {
        let until = self.now.after(span);
        while self.now < until {
            self.step();
        }
    }

    fn step(&mut self) {
        self.now = self.now.after(PERIOD);
        self.body.move_on(self.applied);
        let seen = self.seen();
        let mut watch = (self.now, &mut self.supervisor);
        for input in LOOPS
            .map(Input::Alive)
            .into_iter()
            .chain([Input::Ranges(seen.ir.health), Input::Compass(seen.compass)])
        {
            // Only tells; nothing to refuse.
            let _ = rover_shared::rover::Supervision::handle(&mut watch, input);
        }
        let mut reports = Vec::new();
        let talks = self.rover.talks();
        let command = self.rover.step(self.now, &seen, &mut watch, &mut |report| {
            if talks {
                reports.push(report);
            }
        });
        if self.rover.take_save(&mut watch).is_some() {
            let bytes = self.rover.knowledge_bytes();
            // Empty if it was calibrations, of which nothing is kept here.
            let print = rover_shared::checksum::fingerprint(bytes);
            if !bytes.is_empty() {
                self.stored = bytes.to_vec();
            }
            reports.extend(self.rover.saved(self.now, Some(print), &mut watch));
        }
        self.applied = self.supervisor.gate(command);
        for report in reports {
            self.say(&report);
        }
    }

    fn obey(&mut self, sequence: u16, command: &Command) {
        let seen = self.seen();
        let mut watch = (self.now, &mut self.supervisor);
        let (result, report) = self.rover.handle(self.now, command, &seen, &mut watch);
        self.applied = self.supervisor.gate(self.applied);
        self.say(&Report::Ack(Ack { sequence, result }));
        if let Some(report) = report {
            self.say(&report);
        }
    }

    fn say(&mut self, report: &Report) {
        if !self.open {
            return;
        }
        let mut buffer = [0; MAX_FRAME];
        let frame = self.encoder.encode(report, &mut buffer);
        let frame = frame.expect("a test of the contract holds every report against MAX_FRAME");
        if self.lose > 0 {
            self.lose -= 1;
        } else {
            self.sent.extend(frame);
        }
    }

    fn seen(&self) -> Observation {
        let curve = self.rover.calibrations().curves;
        let counts = std::array::from_fn(|i| counts_at(&curve[i], self.body.free_cm(BEAMS[i])));
        let distances = std::array::from_fn(|i| curve[i].distance(counts[i]));
        Observation {
            time: self.now,
            ir: IrReading {
                counts,
                distances,
                health: [ChannelHealth::Good; CHANNELS],
            },
            heading: (self.compass == CompassHealth::Good).then_some(
                self.body
                    .heading
                    .turned(self.rover.calibrations().compass_offset),
            ),
            compass: self.compass,
        }
    }
}

fn new_rover(seed: u64) -> Rover<'static> {
    let knowledge = Box::leak(Box::new(Knowledge::EMPTY));
    let staging = Box::leak(Box::new(Staging::EMPTY));
    let motion = Motion::new(Chassis::LYNXMOTION_4WD2).expect("a chassis that is known");
    let make = (RangeCurve::GP2D12, motion);
    Rover::new(&COEFFICIENTS, knowledge, staging, make, IDENTITY, seed)
}

/// The counts nearest to which the curve gives this distance.
fn counts_at(curve: &RangeCurve, cm: f64) -> AdcCount {
    let wanted = Micrometres((cm.clamp(10.0, 80.0) * f64::from(Micrometres::PER_CM)) as u32);
    let (mut low, mut high) = (0u16, AdcCount::MAX);
    while low < high {
        let middle = low.midpoint(high);
        let count = AdcCount::new(middle).unwrap_or(AdcCount::ZERO);
        if curve.distance(count) > wanted {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    AdcCount::new(low).unwrap_or(AdcCount::ZERO)
}

/// The port of a rover in this process; the rover can be reached beside it.
///
/// Its time is the rover's: it passes while the host waits for bytes.
pub struct LoopbackPort {
    rover: Rc<RefCell<Loopback>>,
    /// Whether the cable is in; a test pulls it by setting false.
    plugged: Rc<RefCell<bool>>,
    open: bool,
}

impl LoopbackPort {
    /// A port to this rover, opened.
    pub fn new(rover: Rc<RefCell<Loopback>>) -> Self {
        let mut port = Self {
            rover,
            plugged: Rc::new(RefCell::new(true)),
            open: false,
        };
        // It is plugged in.
        let _ = port.reopen();
        port
    }

    /// The cable: false while it is pulled.
    pub fn cable(&self) -> Rc<RefCell<bool>> {
        self.plugged.clone()
    }

    fn alive(&mut self) -> Result<(), PortError> {
        let plugged = *self.plugged.borrow();
        if self.open && !plugged {
            self.open = false;
            self.rover.borrow_mut().close();
        }
        if self.open {
            Ok(())
        } else {
            Err(PortError::Lost(self.name().into(), "unplugged".into()))
        }
    }
}

impl Port for LoopbackPort {
    fn name(&self) -> &str {
        "loopback"
    }

    fn now(&self) -> Instant {
        self.rover.borrow().now()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        self.alive()?;
        self.rover.borrow_mut().hear(bytes);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> Result<usize, PortError> {
        let until = self.now().after(patience);
        loop {
            self.alive()?;
            let mut rover = self.rover.borrow_mut();
            let length = rover.take_sent(buffer);
            if length > 0 || rover.now() >= until {
                return Ok(length);
            }
            rover.run(PERIOD);
        }
    }

    fn wait(&mut self, span: Duration) {
        self.rover.borrow_mut().run(span);
    }

    fn reopen(&mut self) -> Result<(), PortError> {
        let mut rover = self.rover.borrow_mut();
        rover.close();
        self.open = *self.plugged.borrow();
        if !self.open {
            return Err(PortError::Missing("loopback".into()));
        }
        rover.open();
        Ok(())
    }
}
