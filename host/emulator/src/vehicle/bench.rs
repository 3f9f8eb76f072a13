//! The bench rover: the firmware's loop without the board.
//!
//! The firmware's tasks only carry samples to `rover_shared` and commands back. Here the same is
//! done around a [`Vehicle`], in process and thousands of times faster than real time: the very
//! `Rover`, `Supervisor`, `IrArray`, `Compass` and `Motion` that run on the board, called in the
//! order and with the periods of `firmware/src`:
//!
//! | at | does | as in |
//! |---|---|---|
//! | 0 ms | control steps on what was sensed in the period before; its command is applied | `control.rs`, `drive.rs` |
//! | 3 ms | five sweeps of the converter and the compass's answer become an observation | `sense.rs` |
//! | 0, 10 ms | the supervisor is polled, and switches the motors off | `guard.rs` |
//!
//! What the board itself can do wrong, such as a task that hangs or a power cut, is not here but in
//! the emulation.

use rover_shared::contract::{CompassHealth, Mode, Refusal, ResetReason, State, Task};
use rover_shared::knowledge::Knowledge;
use rover_shared::learning::paper_rule::MotorWeights;
use rover_shared::motion::{Motion, Parameters as Chassis, WheelCommand};
use rover_shared::parameters::Coefficients;
use rover_shared::rover::{Identity, Observation, PERIOD, Rover, Staging};
use rover_shared::sensing::compass::{Compass, Retry};
use rover_shared::sensing::ir::{Fitted, IrArray, medians};
use rover_shared::supervisor::{Input, Loop, Supervisor};
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::SCHEMA_HASH;
use rover_shared::wire::message::{Command, Report};

use super::{CompassAnswer, Fault, SidePins, Vehicle};

/// What a bench rover keeps its knowledge in.
pub struct Memory {
    knowledge: Box<Knowledge<MotorWeights>>,
    staging: Box<Staging>,
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            knowledge: Box::new(Knowledge::EMPTY),
            staging: Box::new(Staging::EMPTY),
        }
    }
}

/// Who the bench rover says it is.
const IDENTITY: Identity = Identity {
    board: "bench",
    firmware: concat!("bench ", env!("CARGO_PKG_VERSION")),
};

/// When in a period the sensors have been read: 2 ms of conversions, 1 ms of the bus.
const SENSED: Duration = Duration::from_millis(3);
/// Sweeps over all channels of which the medians are taken.
const SWEEPS: usize = 5;

/// A rover whose board is a host program.
pub struct BenchRover<'m> {
    rover: Rover<'m>,
    supervisor: Supervisor,
    ir: IrArray,
    compass: Compass,
    retry: Retry,
    latest: Observation,
    pins: [SidePins; 2],
    /// Whether the last command that was let through drives the wheels.
    driven: bool,
    vehicle: Vehicle,
}

impl<'m> BenchRover<'m> {
    /// A rover with untrained knowledge, switched on in a vehicle. `seed`: of its generator.
    ///
    /// # Errors
    /// The parameters of `chassis` do not fit together.
    pub fn new(
        coefficients: &'m Coefficients,
        memory: &'m mut Memory,
        chassis: Chassis,
        vehicle: Vehicle,
        seed: u64,
    ) -> Result<Self, rover_shared::motion::ParameterError> {
        let curve = vehicle.curve();
        let Memory { knowledge, staging } = memory;
        let motion = Motion::new(chassis)?;
        let make = (curve, motion);
        let mut bench = Self {
            rover: Rover::new(coefficients, knowledge, staging, make, IDENTITY, seed),
            supervisor: Supervisor::new(vehicle.time(), ResetReason::PowerOn),
            ir: IrArray::new(Fitted::FrontPair, curve),
            compass: Compass::new(Default::default()),
            retry: Retry::new(),
            latest: Observation::NOTHING,
            pins: [SidePins::RELEASED; 2],
            driven: false,
            vehicle,
        };
        bench.rover.begin();
        let now = bench.now();
        bench.rover.announce(&mut (now, &mut bench.supervisor));
        Ok(bench)
    }

    /// Says hello, waits until the sensors are believed, arms, and lets the controller drive.
    ///
    /// # Errors
    /// What the rover refuses.
    pub fn start(&mut self, mode: Mode, task: Task) -> Result<(), Refusal> {
        self.command(&Command::Hello {
            schema: SCHEMA_HASH,
        })?;
        self.run(Duration::from_millis(400), &mut |_| {});
        self.command(&Command::SetTask(task))?;
        self.command(&Command::Arm)?;
        self.command(&Command::SetMode(mode))?;
        Ok(())
    }

    /// Hands the rover a command; gives the report it asked for.
    ///
    /// # Errors
    /// What the rover refuses.
    pub fn command(&mut self, command: &Command) -> Result<Option<Report>, Refusal> {
        let now = self.now();
        let mut watch = (now, &mut self.supervisor);
        let (result, report) = self.rover.handle(now, command, &self.latest, &mut watch);
        self.guard();
        result.map(|()| report)
    }

    /// Lets at least this much time go by, in whole control periods.
    pub fn run(&mut self, span: Duration, report: &mut impl FnMut(Report)) {
        let end = self.now().after(span);
        while self.now() < end {
            self.period(report);
        }
    }

    /// One control period.
    pub fn period(&mut self, report: &mut impl FnMut(Report)) {
        for of in [Loop::Sense, Loop::Control, Loop::Link, Loop::Store] {
            self.tell(Input::Alive(of));
        }
        let now = self.now();
        let talks = self.rover.talks();
        let mut watch = (now, &mut self.supervisor);
        let mut report = |told| {
            if talks {
                report(told);
            }
        };
        let command = self.rover.step(now, &self.latest, &mut watch, &mut report);
        self.apply(command);
        self.vehicle.advance(SENSED, self.pins);
        self.sense();
        let half = Duration(PERIOD.0 / 2);
        self.vehicle.advance(half.minus(SENSED), self.pins);
        self.guard();
        self.vehicle.advance(half, self.pins);
        self.guard();
    }

    /// Time since the rover was switched on.
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

    /// What watches over it.
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
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

    /// The faults that hold from now on, in place of those before; those of the vehicle only.
    pub fn set_faults(&mut self, faults: &[Fault]) {
        self.vehicle.set_faults(faults);
    }

    fn tell(&mut self, input: Input) {
        // Only tells; nothing to refuse.
        let _ = self.supervisor.handle(self.now(), input);
    }

    /// As the guard does every 10 ms, and whenever somebody has spoken to the supervisor: the PWM
    /// to 0, the direction pins as they are.
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
}
