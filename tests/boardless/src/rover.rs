//! The rover: core, vehicle, and the rover's end of the wire.
//!
//! The firmware's tasks only carry samples to `rover_shared` and commands back. Here the same is
//! done by the very `Rover`, `Supervisor`, `IrArray`, `Compass` and `Motion` that run on the board,
//! called in the order and with the periods of `firmware/src`:
//!
//! | at | does | as in |
//! |---|---|---|
//! | 0 ms | control steps on what was sensed in the period before; its command is applied | `control.rs`, `drive.rs` |
//! | 0 ms | what is to be saved is kept, at once | `store.rs` |
//! | 3 ms | five sweeps of the converter and the compass's answer become an observation | `sense.rs` |
//! | 10, 20 ms | the supervisor is polled, and switches the motors off | `guard.rs` |

use std::collections::VecDeque;

use rover_emulator::vehicle::{Build, CompassAnswer, CompassModel, Fault, SidePins, Vehicle};
use rover_shared::checksum::fingerprint;
use rover_shared::contract::{CompassHealth, Mode, Refusal, ResetReason, State, Task};
use rover_shared::knowledge::Knowledge;
use rover_shared::motion::{Motion, Parameters as Chassis, WheelCommand};
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::rover::{Identity, Observation, PERIOD, Rover, Save, Staging};
use rover_shared::sensing::compass::{Compass, Retry};
use rover_shared::sensing::ir::{Fitted, IrArray, medians};
use rover_shared::supervisor::{Input, Loop, Supervisor};
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::SCHEMA_HASH;
use rover_shared::wire::frame::{Decoder, Encoder, FrameError, MAX_FRAME};
use rover_shared::wire::message::{Ack, Command, Report};
use rover_simulator::arena::{Pose, RobotModel, Scenario, World, degrees};

/// What the rover computes with.
pub static COEFFICIENTS: Coefficients = match Coefficients::new(&Parameters::ROVER) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the rover's parameters are valid"),
};

const IDENTITY: Identity = Identity {
    board: "boardless",
    firmware: env!("CARGO_PKG_VERSION"),
};

/// How long the sensors take to be believed. No host is there before: a board takes longer to be
/// enumerated.
const SETTLING: Duration = Duration::from_millis(400);
/// When in a period the sensors have been read: 2 ms of conversions, 1 ms of the bus.
const SENSED: Duration = Duration::from_millis(3);
/// Sweeps over all channels of which the medians are taken.
const SWEEPS: usize = 5;

/// A rover whose board is a host program.
pub struct BoardlessRover {
    rover: Rover<'static>,
    supervisor: Supervisor,
    ir: IrArray,
    compass: Compass,
    retry: Retry,
    latest: Observation,
    pins: [SidePins; 2],
    /// Whether the last command that was let through drives the wheels.
    driven: bool,
    vehicle: Vehicle,
    /// The knowledge in its flash.
    stored: Vec<u8>,
    /// Frames that are lost on their way to the host: this many of those sent next.
    pub lose: u32,
    /// A host has the port open.
    open: bool,
    decoder: Decoder,
    encoder: Encoder,
    sent: VecDeque<u8>,
}

impl BoardlessRover {
    /// A rover that knows nothing, switched on in a vehicle. `seed`: of its generator.
    ///
    /// What it knows lies in memory that is never freed, as on the board.
    pub fn new(vehicle: Vehicle, seed: u64) -> Self {
        Self::start(vehicle, Vec::new(), ResetReason::PowerOn, seed)
    }

    /// The same in the middle of an empty room of 3 m, with a compass that does not err.
    pub fn in_empty_room(seed: u64) -> Self {
        let scenario = Scenario {
            world: World::new(300.0, 300.0, Vec::new()).into(),
            robot: RobotModel::rover(10.0),
            start: Pose {
                x_cm: 150.0,
                y_cm: 150.0,
                heading: degrees(0.0),
            },
            goal: None,
        };
        let compass = CompassModel {
            noise_deg: 0.0,
            iron_deg: 0.0,
            ..CompassModel::ROVER
        };
        let build = Build {
            compass,
            ..Build::ROVER
        };
        Self::new(Vehicle::new(&scenario, &build, seed), seed)
    }

    /// Resets the board: the rover knows what is in its flash. The connection is closed, and the
    /// clock goes on.
    pub fn reset(&mut self, reason: ResetReason, seed: u64) {
        let stored = std::mem::take(&mut self.stored);
        *self = Self::start(self.vehicle.clone(), stored, reason, seed);
    }

    fn start(vehicle: Vehicle, stored: Vec<u8>, reason: ResetReason, seed: u64) -> Self {
        let knowledge = Box::leak(Box::new(Knowledge::EMPTY));
        let staging = Box::leak(Box::new(Staging::EMPTY));
        let motion = Motion::new(Chassis::LYNXMOTION_4WD2).expect("a chassis that is known");
        let make = (vehicle.curve(), motion);
        let mut this = Self {
            rover: Rover::new(&COEFFICIENTS, knowledge, staging, make, IDENTITY, seed),
            supervisor: Supervisor::new(vehicle.time(), reason),
            ir: IrArray::new(Fitted::FrontPair, vehicle.curve()),
            compass: Compass::new(Default::default()),
            retry: Retry::new(),
            latest: Observation::NOTHING,
            pins: [SidePins::RELEASED; 2],
            driven: false,
            vehicle,
            stored,
            lose: 0,
            open: false,
            decoder: Decoder::new(),
            encoder: Encoder::new(),
            sent: VecDeque::new(),
        };
        if this.stored.is_empty() {
            this.rover.begin();
        } else {
            let load = |room: &mut [u8]| {
                room.get_mut(..this.stored.len())?
                    .copy_from_slice(&this.stored);
                Some(this.stored.len())
            };
            this.rover
                .load(load)
                .expect("it was stored by such a rover");
        }
        this.rover
            .announce(&mut (this.vehicle.time(), &mut this.supervisor));
        this.run(SETTLING);
        this
    }

    /// Says hello, arms, and lets the controller drive.
    ///
    /// # Errors
    /// What the rover refuses.
    pub fn drive(&mut self, mode: Mode, task: Task) -> Result<(), Refusal> {
        let schema = SCHEMA_HASH;
        for command in [
            Command::Hello { schema },
            Command::SetTask(task),
            Command::Arm,
            Command::SetMode(mode),
        ] {
            self.command(&command)?;
        }
        Ok(())
    }

    /// Hands the rover a command; returns the report it asked for.
    ///
    /// # Errors
    /// What the rover refuses.
    pub fn command(&mut self, command: &Command) -> Result<Option<Report>, Refusal> {
        let (result, report) = self.answer(command);
        result.map(|()| report)
    }

    fn answer(&mut self, command: &Command) -> (Result<(), Refusal>, Option<Report>) {
        let now = self.now();
        let mut watch = (now, &mut self.supervisor);
        let answer = self.rover.handle(now, command, &self.latest, &mut watch);
        self.guard();
        answer
    }

    /// Lets at least this much time pass, in whole control periods; returns what the rover
    /// reports meanwhile.
    pub fn run(&mut self, span: Duration) -> Vec<Report> {
        let end = self.now().after(span);
        let mut reports = Vec::new();
        while self.now() < end {
            reports.append(&mut self.period());
        }
        reports
    }

    /// Lets one control period pass; returns what the rover reports meanwhile.
    pub fn period(&mut self) -> Vec<Report> {
        for of in [Loop::Sense, Loop::Control, Loop::Link, Loop::Store] {
            self.tell(Input::Alive(of));
        }
        let now = self.now();
        let mut reports = Vec::new();
        let mut watch = (now, &mut self.supervisor);
        let report = &mut |report| reports.push(report);
        let command = self.rover.step(now, &self.latest, &mut watch, report);
        self.apply(command);
        reports.extend(self.save());
        if !self.rover.talks() {
            reports.clear();
        }
        reports.iter().for_each(|report| self.send(report));
        self.vehicle.advance(SENSED, self.pins);
        self.sense();
        let half = Duration(PERIOD.0 / 2);
        self.vehicle.advance(half.minus(SENSED), self.pins);
        self.guard();
        self.vehicle.advance(half, self.pins);
        self.guard();
        reports
    }

    /// Time since the rover was first switched on.
    pub fn now(&self) -> Instant {
        self.vehicle.time()
    }

    /// What the wheels move.
    pub fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// What the wheels move, to lift it and put it elsewhere.
    pub fn vehicle_mut(&mut self) -> &mut Vehicle {
        &mut self.vehicle
    }

    /// Its state.
    pub fn state(&self) -> State {
        self.supervisor.state()
    }

    /// What was sensed last.
    pub fn latest(&self) -> &Observation {
        &self.latest
    }

    /// Whether the last command that was let through drives the wheels.
    pub fn driven(&self) -> bool {
        self.driven
    }

    /// The knowledge in its flash; empty if none was stored. (Calibrations are not kept.)
    pub fn stored(&self) -> &[u8] {
        &self.stored
    }

    /// The faults of the vehicle that hold from now on, in place of those before.
    pub fn set_faults(&mut self, faults: &[Fault]) {
        self.vehicle.set_faults(faults);
    }

    fn tell(&mut self, input: Input) {
        // Only tells; nothing to refuse.
        let _ = self.supervisor.handle(self.now(), input);
    }

    /// As the guard does every 10 ms, and whenever the supervisor was told something: the PWM to
    /// 0, the direction pins as they are.
    fn guard(&mut self) {
        self.supervisor.poll(self.now());
        if !self.supervisor.motors_enabled() {
            self.pins.iter_mut().for_each(|pins| pins.duty = 0.0);
        }
    }

    fn apply(&mut self, command: WheelCommand) {
        self.tell(Input::Alive(Loop::Drive));
        let command = self.supervisor.gate(command);
        self.pins = SidePins::of(command);
        self.driven = command.drives();
    }

    fn save(&mut self) -> Option<Report> {
        let now = self.now();
        let mut watch = (now, &mut self.supervisor);
        let save = self.rover.take_save(&mut watch)?;
        if save == Save::Knowledge {
            self.stored = self.rover.knowledge_bytes().to_vec();
        }
        let print = fingerprint(&self.stored);
        self.rover.saved(now, Some(print), &mut watch)
    }

    fn sense(&mut self) {
        let now = self.now();
        let calibrations = self.rover.calibrations();
        self.compass.set_offset(calibrations.compass_offset);
        self.ir.set_curves(calibrations.curves);
        let sweeps: [_; SWEEPS] = std::array::from_fn(|n| self.vehicle.counts(n as u32));
        match medians(&sweeps) {
            Some(counts) => {
                self.latest.ir = self.ir.push(now, counts, self.driven);
                self.latest.time = now;
            }
            None => {
                self.latest.ir.health = self.ir.health(now);
                self.tell(Input::AdcError);
            }
        }
        let answer = self.retry.due(now).then(|| self.vehicle.compass());
        match answer {
            Some(CompassAnswer::Registers([_, byte, high, low])) => {
                self.compass.push(now, [byte, high, low]);
                self.retry.answered();
            }
            Some(CompassAnswer::Silent) => self.retry.answered(),
            Some(CompassAnswer::Stuck) | None => {}
        }
        self.latest.heading = self.compass.heading(now);
        let health = self.compass.health(now);
        let never_heard = health == CompassHealth::Unknown;
        self.latest.compass = match answer {
            Some(CompassAnswer::Silent) if never_heard => CompassHealth::Silent,
            _ => health,
        };
        self.tell(Input::Ranges(self.latest.ir.health));
        self.tell(Input::Compass(self.latest.compass));
        if answer == Some(CompassAnswer::Stuck) {
            self.retry.hung(now);
            self.tell(Input::BusRecovered);
        }
    }

    // The wire.

    /// The host opens the port (DTR).
    pub fn open(&mut self) {
        self.open = true;
        self.decoder = Decoder::new();
        self.encoder = Encoder::new();
        self.sent = VecDeque::from([0]);
        self.send_hello();
    }

    /// The host closes the port, or the cable is pulled.
    pub fn close(&mut self) {
        self.open = false;
        self.sent.clear();
        self.rover.closed();
    }

    /// Takes bytes that the host sent, and answers the commands in them.
    pub fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match self.decoder.push::<Command>(*byte) {
                Some(Ok(frame)) => {
                    let (result, report) = self.answer(&frame.message);
                    let sequence = frame.sequence;
                    self.send(&Report::Ack(Ack { sequence, result }));
                    report.iter().for_each(|report| self.send(report));
                }
                Some(Err(FrameError::Version(_))) => self.send_hello(),
                Some(Err(_)) | None => {}
            }
        }
    }

    /// Moves what it has sent into `buffer`, as much as there is room for; returns the length.
    pub fn take_sent(&mut self, buffer: &mut [u8]) -> usize {
        let length = buffer.len().min(self.sent.len());
        for (place, byte) in buffer.iter_mut().zip(self.sent.drain(..length)) {
            *place = byte;
        }
        length
    }

    fn send_hello(&mut self) {
        let now = self.now();
        let hello = self.rover.hello(&mut (now, &mut self.supervisor));
        self.send(&hello);
    }

    fn send(&mut self, report: &Report) {
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
}
