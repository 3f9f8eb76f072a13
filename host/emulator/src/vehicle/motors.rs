//! Gear motors behind a motor driver: what its pins say, and how fast the wheels run.

use rover_shared::motion::WheelCommand;

use super::noise::{Noise, Use};

/// The three pins of the motor driver that belong to one side of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct SidePins {
    /// Share of the PWM's period for which its pin is high, 0 to 1.
    pub duty: f64,
    /// The pin that says forwards.
    pub forward: bool,
    /// The pin that says backwards.
    pub reverse: bool,
}

/// What a bridge does to a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bridge {
    /// Nothing: its outputs are open.
    Coast,
    /// Shorts it.
    Brake,
    /// Puts this share of the supply's voltage on it, on average.
    Drive(f64),
}

impl SidePins {
    /// Pins that are not driven, as during a reset: resistors hold them low.
    pub const RELEASED: Self = Self {
        duty: 0.0,
        forward: false,
        reverse: false,
    };

    /// What the firmware's pins are at a wheel command, left and right.
    pub fn of(command: WheelCommand) -> [Self; 2] {
        [command.left(), command.right()].map(|duty| Self {
            duty: f64::from(duty.unsigned_abs()) / f64::from(WheelCommand::FULL),
            forward: duty > 0,
            reverse: duty < 0,
        })
    }

    /// The truth table of a TB6612FNG out of standby (its data sheet, "H-SW control function").
    /// While the PWM is low it shorts the motor, so that the voltage is proportional to the duty.
    fn bridge(self) -> Bridge {
        match (self.forward, self.reverse) {
            (false, false) => Bridge::Coast,
            (true, true) => Bridge::Brake,
            _ if self.duty <= 0.0 => Bridge::Brake,
            (true, false) => Bridge::Drive(self.duty.min(1.0)),
            (false, true) => Bridge::Drive(-self.duty.min(1.0)),
        }
    }
}

/// The motors of one side, with gears and wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorModel {
    /// Duty below which running wheels come to rest, straight ahead; speed grows in proportion
    /// above it. 0 to 1.
    pub dead_band: f64,
    /// Duty beyond the dead band that wheels at rest need to begin to turn.
    pub breakaway: f64,
    /// Speed gained per duty above the dead band, 0 to 1, in cm/s.
    pub gain_cm_s: f64,
    /// Share of its way that a wheel loses by slipping, on average.
    pub slip: f64,
}

/// All motors of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveModel {
    /// Left and right.
    pub sides: [MotorModel; 2],
    /// Added to the dead band when turning on the spot, where four wheels have to skid sideways;
    /// in proportion in a bend.
    pub scrub: f64,
    /// Time constant in which driven wheels approach their speed, in seconds.
    pub lag_s: f64,
    /// Time constant of the speed-dependent friction of shorted motors.
    pub brake_s: f64,
    /// Time constant of the speed-dependent friction of coasting wheels.
    pub coast_s: f64,
    /// Deceleration of wheels that are not driven by dry friction, in cm/s^2: what brings them to
    /// rest.
    pub dry_cm_s2: f64,
    /// Standard deviation of the slip, as a share of the way.
    pub slip_spread: f64,
}

impl DriveModel {
    /// A chassis like the one that `rover_shared::motion::Parameters::LYNXMOTION_4WD2` estimates,
    /// and not quite that: the left side is 2 % faster and the right one 4 % slower than the
    /// estimate of 15 cm/s at a duty of 0.45, and their dead bands lie on both sides of 0.18. A
    /// turn on the spot breaks away at 0.27, just below the estimate of 0.28.
    pub const ROVER: Self = Self {
        sides: [
            MotorModel {
                dead_band: 0.178,
                breakaway: 0.025,
                gain_cm_s: 56.4,
                slip: 0.02,
            },
            MotorModel {
                dead_band: 0.184,
                breakaway: 0.025,
                gain_cm_s: 54.2,
                slip: 0.02,
            },
        ],
        scrub: 0.06,
        lag_s: 0.05,
        brake_s: 0.025,
        coast_s: 0.12,
        dry_cm_s2: 60.0,
        slip_spread: 0.015,
    };
}

/// What is wrong with the motors, side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Defects {
    /// The motor gets no current.
    pub(super) dead: [bool; 2],
    /// The wheels find no hold.
    pub(super) slipping: [bool; 2],
}

/// The motors at work. One step is a millisecond.
#[derive(Clone, Debug)]
pub(super) struct Motors {
    model: DriveModel,
    /// Speeds of the wheels' rims, in cm/s.
    speed: [f64; 2],
    /// Slip at present.
    slip: [f64; 2],
    noise: [Noise; 2],
    /// Share of the way to its goal that a driven wheel's speed goes in a step.
    driven: f64,
}

/// Length of a step in seconds.
const STEP: f64 = 0.001;
/// A wheel this slow, in cm/s, that is not driven stands.
const REST: f64 = 0.02;
/// Steps between changes of the slip, and the share of it that is kept: half a second's memory.
const SLIP_STEPS: u64 = 20;
const SLIP_MEMORY: f64 = 0.96;

impl Motors {
    pub(super) fn new(model: DriveModel, seed: u64) -> Self {
        Self {
            speed: [0.0; 2],
            slip: model.sides.map(|side| side.slip),
            noise: [0, 1].map(|side| Noise::new(seed, Use::Slip, side)),
            driven: 1.0 - libm::exp(-STEP / model.lag_s),
            model,
        }
    }

    /// Whether all wheels stand.
    pub(super) fn at_rest(&self) -> bool {
        self.speed == [0.0; 2]
    }

    /// Makes the `now`-th step; returns the speeds over ground of both sides in cm/s.
    pub(super) fn step(&mut self, now: u64, pins: [SidePins; 2], defects: Defects) -> [f64; 2] {
        let mut bridges = pins.map(SidePins::bridge);
        for (bridge, dead) in bridges.iter_mut().zip(defects.dead) {
            if dead {
                *bridge = Bridge::Coast;
            }
        }
        let band = self.model.scrub * turning(bridges);
        for (side, bridge) in bridges.into_iter().enumerate() {
            self.speed[side] = self.next(side, bridge, band);
        }
        if self.at_rest() {
            return [0.0; 2];
        }
        if now.is_multiple_of(SLIP_STEPS) {
            self.change_slip(now);
        }
        [0, 1].map(|side| {
            if defects.slipping[side] {
                0.0
            } else {
                self.speed[side] * (1.0 - self.slip[side])
            }
        })
    }

    /// The speed of a side after a step; `scrub` is added to its dead band.
    fn next(&self, side: usize, bridge: Bridge, scrub: f64) -> f64 {
        let MotorModel {
            dead_band,
            breakaway,
            gain_cm_s,
            ..
        } = self.model.sides[side];
        let speed = self.speed[side];
        let duty = match bridge {
            Bridge::Coast => return self.slowed(speed, self.model.coast_s),
            Bridge::Brake => return self.slowed(speed, self.model.brake_s),
            Bridge::Drive(duty) => duty,
        };
        let held = if speed == 0.0 { breakaway } else { 0.0 };
        let band = dead_band + scrub;
        if duty.abs() <= band + held && speed == 0.0 {
            return 0.0;
        }
        let goal = duty.signum() * gain_cm_s * (duty.abs() - band).max(0.0);
        let next = speed + (goal - speed) * self.driven;
        if goal == 0.0 { toward_rest(next) } else { next }
    }

    /// The speed of wheels that are not driven after a step.
    fn slowed(&self, speed: f64, time_constant: f64) -> f64 {
        let loss = (speed.abs() / time_constant + self.model.dry_cm_s2) * STEP;
        toward_rest(speed - speed.signum() * loss.min(speed.abs()))
    }

    fn change_slip(&mut self, now: u64) {
        let fresh = self.model.slip_spread * (1.0 - SLIP_MEMORY * SLIP_MEMORY).sqrt();
        for side in 0..2 {
            let mean = self.model.sides[side].slip;
            let drawn = self.noise[side].normal(now / SLIP_STEPS);
            let next = mean + SLIP_MEMORY * (self.slip[side] - mean) + fresh * drawn;
            self.slip[side] = next.clamp(0.0, 1.0);
        }
    }
}

fn toward_rest(speed: f64) -> f64 {
    if speed.abs() < REST { 0.0 } else { speed }
}

/// How much the two sides pull against each other: 0 straight ahead, 1 on the spot.
fn turning(bridges: [Bridge; 2]) -> f64 {
    let [left, right] = bridges.map(|bridge| match bridge {
        Bridge::Drive(duty) => duty,
        Bridge::Coast | Bridge::Brake => 0.0,
    });
    let sum = left.abs() + right.abs();
    if sum > 0.0 {
        (left - right).abs() / sum
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const NONE: Defects = Defects {
        dead: [false; 2],
        slipping: [false; 2],
    };

    fn motors() -> Motors {
        Motors::new(DriveModel::ROVER, 3)
    }

    fn run(motors: &mut Motors, from: u64, steps: u64, left: i32, right: i32) -> [f64; 2] {
        let pins = SidePins::of(WheelCommand::new(left, right));
        (from..from + steps)
            .map(|now| motors.step(now, pins, NONE))
            .last()
            .expect("some steps")
    }

    #[test]
    fn the_pins_mean_what_the_driver_makes_of_them() {
        let pins = |duty, forward, reverse| {
            SidePins {
                duty,
                forward,
                reverse,
            }
            .bridge()
        };
        assert_eq!(pins(0.5, true, false), Bridge::Drive(0.5));
        assert_eq!(pins(0.5, false, true), Bridge::Drive(-0.5));
        assert_eq!(pins(0.0, true, false), Bridge::Brake);
        assert_eq!(pins(1.0, true, true), Bridge::Brake);
        assert_eq!(pins(1.0, false, false), Bridge::Coast);
        assert_eq!(SidePins::RELEASED.bridge(), Bridge::Coast);
    }

    #[test]
    fn it_is_near_the_chassis_that_the_firmware_expects_and_not_the_same() {
        let speeds = run(&mut motors(), 0, 1_000, 450, 450);
        let expected = 15.0;
        for speed in speeds {
            let off = (speed / expected - 1.0).abs();
            assert!((0.001..0.10).contains(&off), "{speed} cm/s");
        }
        assert_ne!(speeds[0], speeds[1]);
        // The dead band, and the duty at which a turn on the spot begins.
        assert_eq!(run(&mut motors(), 0, 1_000, 170, 170), [0.0; 2]);
        assert_eq!(run(&mut motors(), 0, 1_000, -250, 250), [0.0; 2]);
        let turn = run(&mut motors(), 0, 1_000, -280, 280);
        assert!(turn[0] < -0.5 && turn[1] > 0.5, "{turn:?}");
    }

    #[test]
    fn a_dead_motor_stands_and_slipping_wheels_lead_nowhere() {
        let pins = SidePins::of(WheelCommand::new(500, 500));
        let mut motors = motors();
        let defects = Defects {
            dead: [true, false],
            slipping: [false, true],
        };
        let ground = (0..500).map(|now| motors.step(now, pins, defects)).last();
        assert_eq!(ground, Some([0.0, 0.0]));
        assert!(motors.speed[0] == 0.0 && motors.speed[1] > 10.0);
    }

    #[test]
    fn shorted_motors_stop_sooner_than_open_ones() {
        let steps_to_rest = |pins: SidePins| {
            let mut motors = motors();
            run(&mut motors, 0, 500, 450, 450);
            (500..1_500)
                .position(|now| {
                    motors.step(now, [pins; 2], NONE);
                    motors.at_rest()
                })
                .expect("comes to rest")
        };
        let brake = SidePins {
            duty: 1.0,
            forward: true,
            reverse: true,
        };
        let coasting = steps_to_rest(SidePins::RELEASED);
        assert!((80..150).contains(&coasting), "{coasting} ms");
        let braking = steps_to_rest(brake);
        assert!(braking * 2 < coasting, "{braking} ms against {coasting}");
        // The guard leaves the direction pins alone: that brakes, too.
        let guarded = SidePins {
            duty: 0.0,
            forward: true,
            reverse: false,
        };
        assert_eq!(steps_to_rest(guarded), braking);
    }

    proptest! {
        #[test]
        fn motors_at_rest_stay_at_rest_until_they_are_driven(
            seed: u64, duty in 0.0..0.17f64, forward: bool, reverse: bool, now in 0u64..1_000_000
        ) {
            let mut motors = Motors::new(DriveModel::ROVER, seed);
            let pins = SidePins { duty, forward, reverse };
            for step in now..now + 200 {
                prop_assert_eq!(motors.step(step, [pins; 2], NONE), [0.0; 2]);
            }
        }

        #[test]
        fn whatever_coasts_comes_to_rest(left in -1_000i32..=1_000, right in -1_000i32..=1_000) {
            let mut motors = motors();
            run(&mut motors, 0, 400, left, right);
            let mut before = motors.speed;
            for now in 400..1_000 {
                motors.step(now, [SidePins::RELEASED; 2], NONE);
                for (now, before) in motors.speed.iter().zip(before) {
                    prop_assert!(now.abs() <= before.abs() && now * before >= 0.0);
                }
                before = motors.speed;
            }
            prop_assert!(motors.at_rest());
        }

        #[test]
        fn no_wheel_outruns_its_duty(left in -1_000i32..=1_000, right in -1_000i32..=1_000) {
            let mut motors = motors();
            for now in 0..600 {
                run(&mut motors, now, 1, left, right);
                for (speed, duty) in motors.speed.iter().zip([left, right]) {
                    prop_assert!(speed.abs() <= 56.4 * f64::from(duty.abs()) / 1e3);
                    prop_assert!(speed * f64::from(duty) >= 0.0);
                }
            }
        }
    }
}
