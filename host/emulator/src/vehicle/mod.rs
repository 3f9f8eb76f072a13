//! The physical rover around the board: range sensors, compass, motors and a body in an arena.
//!
//! Plain data in, plain data out; nothing here knows of an emulator or of the firmware. The levels
//! of the motor driver's pins go in, time passes, and what the board's inputs see comes out. All
//! chance is drawn from one seed and from the time, so that a run repeats however often it is
//! observed, and in slices of whatever length.
//!
//! | file | holds |
//! |---|---|
//! | `motors` | motor driver, motors, wheels: [`DriveModel`] |
//! | `body` | the disc that the wheels move, and what stops it |
//! | `infrared` | GP2D12 and GP2Y0A21: [`Characteristic`] |
//! | `compass` | CMPS03: [`CompassModel`] |
//! | `noise` | chance that does not depend on when anybody looks |
//! | `fault` | what can go wrong with a rover, its board and its cable too: [`Fault`] |
//! | `schedule` | when it does: [`Schedule`] |
//!
//! [`Vehicle::set_faults`] turns each fault of the vehicle into a `Defect` of the part that has it:
//! `infrared::Defect`, `compass::Defect`, or `motors::Defects`. That part does the rest. Faults of the
//! board and of the cable are injected elsewhere; the [crate's documentation](crate#faults) says
//! where, and how to add one.

mod body;
mod compass;
mod fault;
mod infrared;
mod motors;
mod noise;
mod schedule;

pub use compass::{CompassAnswer, CompassModel};
pub use fault::{Channel, Fault, POSSIBLE, Side, UnknownFault};
pub use infrared::{Characteristic, SensorModel, SensorType};
pub use motors::{DriveModel, MotorModel, SidePins};
pub use schedule::{
    Changes, GRAMMAR, Moment, RunProgress, Schedule, ScheduleError, ScheduledFault,
};

use body::Body;
use compass::Compass;
use infrared::Infrared;
use motors::{Defects, Motors};
use rover_shared::sensing::ir::CHANNELS;
use rover_shared::sensing::ir::curve::RangeCurve;
use rover_shared::time::{Duration, Instant};
use rover_simulator::arena::{Pose, Robot, RobotModel, Scenario, World};

/// How a vehicle is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// Its range sensors.
    pub sensors: SensorModel,
    /// Its compass.
    pub compass: CompassModel,
    /// Its motors.
    pub drive: DriveModel,
    /// Distance between the lines on which the two sides roll, as turns on the spot see it, in
    /// cm: with four wheels that skid it is larger than the one between the wheels.
    pub track_cm: f64,
}

impl Build {
    /// The paper's rover (IV-A), a few per cent off the firmware's estimates in everything.
    pub const ROVER: Self = Self {
        sensors: SensorModel::ROVER,
        compass: CompassModel::ROVER,
        drive: DriveModel::ROVER,
        track_cm: 33.0,
    };
}

/// Step of all that moves.
const STEP: Duration = Duration::from_millis(1);

/// A rover in its arena, without its board.
#[derive(Clone, Debug)]
pub struct Vehicle {
    /// Sees what the body's pose lets it see.
    eyes: Robot,
    body: Body,
    motors: Motors,
    characteristic: Characteristic,
    curve: RangeCurve,
    sensors: Vec<Infrared>,
    compass: Compass,
    defects: Defects,
    faults: Vec<Fault>,
    /// Whole steps so far.
    steps: u64,
    /// Time that is no whole step yet.
    rest: Duration,
    /// Distances that the sensors see from where the body stands, as far as they were asked for.
    seen: [Option<f64>; CHANNELS],
}

impl Vehicle {
    /// A vehicle at rest at the start of a scenario. Its body and the places and fields of its
    /// sensors are those of the rover that the scenario has, or, if it has another robot, of
    /// [`RobotModel::rover`] with fields of 10 degrees.
    pub fn new(scenario: &Scenario, build: &Build, seed: u64) -> Self {
        let mut scenario = scenario.clone();
        if scenario.robot.sensors.len() != CHANNELS {
            scenario.robot = RobotModel::rover(10.0);
        }
        let radius_cm = scenario.robot.contact_radius_cm;
        let world = scenario.world.clone();
        let body = Body::new(world, scenario.start, radius_cm, build.track_cm);
        let eyes = Robot::new(&scenario);
        let characteristic = Characteristic::of(build.sensors.kind);
        let sensors = (0..CHANNELS)
            .map(|channel| {
                let volts = characteristic.volts(eyes.distance_cm(channel, SIGHT_CM));
                Infrared::new(build.sensors, channel, seed, volts)
            })
            .collect();
        Self {
            compass: Compass::new(build.compass, seed, body.heading_rad()),
            motors: Motors::new(build.drive, seed),
            eyes,
            body,
            characteristic,
            curve: build.sensors.kind.curve(),
            sensors,
            defects: Defects::default(),
            faults: Vec::new(),
            steps: 0,
            rest: Duration::ZERO,
            seen: [None; CHANNELS],
        }
    }

    /// Moves on by a span with these levels on the left and the right side's pins. Motors, body
    /// and sensors change in steps of a millisecond; what is left of a span counts towards the
    /// next.
    pub fn advance(&mut self, span: Duration, pins: [SidePins; 2]) {
        self.rest = self.rest.plus(span);
        while self.rest >= STEP {
            self.rest = self.rest.minus(STEP);
            self.step(pins);
        }
    }

    fn step(&mut self, pins: [SidePins; 2]) {
        self.steps += 1;
        let speeds = self.motors.step(self.steps, pins, self.defects);
        if speeds != [0.0; 2] {
            self.body.roll(speeds, STEP.0 as f64 / 1e6);
            self.seen = [None; CHANNELS];
        }
        self.compass.step(self.body.heading_rad());
        let now = self.time().0;
        for channel in 0..CHANNELS {
            if self.sensors[channel].due(now) {
                let distance = self.look(channel);
                let volts = self.characteristic.volts(distance);
                self.sensors[channel].measure(volts);
            }
        }
    }

    /// The distance that a sensor sees.
    fn look(&mut self, channel: usize) -> f64 {
        if let Some(distance) = self.seen[channel] {
            return distance;
        }
        self.eyes.place(self.body.pose());
        let distance = self.eyes.distance_cm(channel, SIGHT_CM);
        self.seen[channel] = Some(distance);
        distance
    }

    /// Time since the vehicle was put there, in whole steps.
    pub fn time(&self) -> Instant {
        Instant(self.steps * STEP.0)
    }

    /// Where the vehicle really is.
    pub fn pose(&self) -> Pose {
        self.body.pose()
    }

    /// Lifts the vehicle and puts it somewhere else.
    pub fn put(&mut self, pose: Pose) {
        self.body.put(pose);
        self.seen = [None; CHANNELS];
    }

    /// The firmware's curve for the make of its range sensors.
    pub fn curve(&self) -> RangeCurve {
        self.curve
    }

    /// Its arena.
    pub fn world(&self) -> &World {
        self.eyes.world()
    }

    /// Its body and sensors, as the simulator has them.
    pub fn model(&self) -> &RobotModel {
        self.eyes.model()
    }

    /// Whether its body touches a wall or an obstacle.
    pub fn touching(&self) -> bool {
        self.body.touching()
    }

    /// Whether its wheels stand.
    pub fn at_rest(&self) -> bool {
        self.motors.at_rest()
    }

    /// True distances that the range sensors would see now, at most 150 cm.
    pub fn distances_cm(&mut self) -> [f64; CHANNELS] {
        std::array::from_fn(|channel| self.look(channel))
    }

    /// ADC counts of the four channels, front left, front right, left, right, of the converter's
    /// `n`-th sweep within this millisecond (`n` matters for the noise only).
    pub fn counts(&self, n: u32) -> [u16; CHANNELS] {
        let now = self.time().0;
        std::array::from_fn(|channel| self.sensors[channel].counts(now, n))
    }

    /// Volts on the four pins, without the ripple and the converter's noise.
    pub fn volts(&self) -> [f64; CHANNELS] {
        std::array::from_fn(|channel| self.sensors[channel].pin_volts())
    }

    /// What the compass answers on its bus.
    pub fn compass(&self) -> CompassAnswer {
        self.compass.answer()
    }

    /// The faults that hold from now on, in place of those before. Those that are not of the
    /// vehicle are ignored.
    pub fn set_faults(&mut self, faults: &[Fault]) {
        if self.faults == faults {
            return;
        }
        self.faults = faults.to_vec();
        let mut ir = [infrared::Defect::None; CHANNELS];
        let mut compass = compass::Defect::None;
        self.defects = Defects::default();
        let include = |defects: &mut [bool; 2], side: &Side| {
            for (defect, included) in defects.iter_mut().zip(side.includes()) {
                *defect |= included;
            }
        };
        for fault in faults {
            match fault {
                Fault::IrOpen(channel) => ir[channel.index()] = infrared::Defect::Open,
                Fault::IrShorted(channel) => ir[channel.index()] = infrared::Defect::Shorted,
                Fault::IrFrozen(channel) => ir[channel.index()] = infrared::Defect::Frozen,
                Fault::IrNoisy(channel) => ir[channel.index()] = infrared::Defect::Noisy,
                Fault::CompassSilent => compass = compass::Defect::Silent,
                Fault::CompassStuck => compass = compass::Defect::Stuck,
                Fault::CompassGarbage => compass = compass::Defect::Garbage,
                Fault::CompassRotated => compass = compass::Defect::Rotated,
                Fault::MotorDead(side) => include(&mut self.defects.dead, side),
                Fault::WheelsSlipping(side) => include(&mut self.defects.slipping, side),
                _ => {}
            }
        }
        let now = self.time().0;
        for (sensor, defect) in self.sensors.iter_mut().zip(ir) {
            sensor.set_defect(defect, now);
        }
        self.compass.set_defect(compass);
    }
}

/// Farther than any sensor sees.
const SIGHT_CM: f64 = 150.0;

#[cfg(test)]
mod tests;
