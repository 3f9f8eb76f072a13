//! The motor driver: applies wheel commands, and stops the motors from any context.

use embassy_rp::gpio::Output;
use embassy_rp::pac;
use embassy_rp::pwm::{self, Pwm};
use rover_shared::motion::WheelCommand;

use crate::board::{BOARD, MotorPins};

/// The PWM slice of both sides: one register holds both duties, so one write stops both.
const SLICE: usize = BOARD.left.slice() as usize;

/// 125 MHz / 6,250 = 20 kHz: above hearing, below the 100 kHz a TB6612FNG stands. (For an L298N,
/// whose switching losses grow above some kHz, 20 kHz still is within its 40 kHz.)
const PWM_TOP: u16 = 6_249;

/// Both sides' motors.
pub struct Motors {
    pwm: Pwm<'static>,
    config: pwm::Config,
    /// Forward and reverse, of the left and of the right side.
    directions: [[Output<'static>; 2]; 2],
}

impl Motors {
    /// Motors at rest.
    pub fn new(pins: MotorPins) -> Self {
        let mut config = pwm::Config::default();
        config.top = PWM_TOP;
        Self {
            pwm: Pwm::new_output_ab(pins.slice, pins.left, pins.right, config.clone()),
            config,
            directions: pins.directions,
        }
    }

    /// Applies a command.
    pub fn apply(&mut self, command: WheelCommand) {
        let duties = [command.left(), command.right()];
        for (pins, duty) in self.directions.iter_mut().zip(duties) {
            let [forward, reverse] = pins;
            forward.set_level((duty > 0).into());
            reverse.set_level((duty < 0).into());
        }
        let [left, right] = duties.map(compare);
        self.config.compare_a = left;
        self.config.compare_b = right;
        self.pwm.set_config(&self.config);
    }
}

/// The compare value for a duty in per mille.
fn compare(duty: i16) -> u16 {
    let full = u32::from(PWM_TOP) + 1;
    (u32::from(duty.unsigned_abs()) * full / WheelCommand::FULL.unsigned_abs() as u32) as u16
}

/// Sets both duties to 0, from any context: one write to one register, effective when the counter next
/// wraps, 50 us later at most.
pub fn off() {
    let duties = pac::PWM.ch(SLICE).cc();
    duties.write_value(pac::pwm::regs::ChCc(0));
}

/// The emergency stop: forces the PWM pins low whatever their peripheral does. Only a reset ends it.
pub fn cut_off() {
    off();
    for side in [BOARD.left, BOARD.right] {
        let ctrl = pac::IO_BANK0.gpio(usize::from(side.pwm)).ctrl();
        ctrl.modify(|w| w.set_outover(pac::io::vals::Outover::LOW));
    }
}
