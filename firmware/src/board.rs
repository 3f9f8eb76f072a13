//! Which pin is what: the only place where pins are named. The table in `README.md` says the same,
//! and `tests/wiring.rs` compares them.
//!
//! All signals lie on GPIO 0 to 7 and 26 to 29, which the Waveshare RP2040-Zero and the Pimoroni
//! Tiny 2040 bring out; so does the Raspberry Pi Pico, but for GPIO 29 (feature `pico`).

use embassy_rp::adc::Channel;
use embassy_rp::gpio::{Level, Output, Pull};
use embassy_rp::pac;
use embassy_rp::peripherals::{ADC, DMA_CH0, FLASH, I2C1, PIN_6, PIN_7, USB, WATCHDOG};
use embassy_rp::pwm::{self, Pwm};
use embassy_rp::{Peri, Peripherals};
use rover_shared::motion::{Parameters, WheelCommand};
use rover_shared::rover::Identity;
use rover_shared::sensing::ir::Fitted;
use rover_shared::sensing::ir::curve::RangeCurve;

/// How the board calls itself.
pub const IDENTITY: Identity = Identity {
    board: if cfg!(feature = "pico") {
        "raspberry-pi-pico"
    } else {
        "rp2040-four-adc"
    },
    firmware: concat!("rover-firmware ", env!("CARGO_PKG_VERSION")),
};

/// The range sensors that can be connected.
pub const FITTED: Fitted = if cfg!(feature = "pico") {
    Fitted::FrontSingle
} else {
    Fitted::FrontPair
};

/// Their curve until they are calibrated.
pub const CURVE: RangeCurve = if cfg!(feature = "gp2y0a21") {
    RangeCurve::GP2Y0A21
} else {
    RangeCurve::GP2D12
};

/// The chassis, until it is calibrated.
pub const CHASSIS: Parameters = Parameters::LYNXMOTION_4WD2;

/// Flash of the smallest of the boards; `memory.x` divides it.
pub const FLASH_SIZE: usize = 2 * 1024 * 1024;

/// Everything the rover is made of.
pub struct Board {
    /// Both sides' motors.
    pub motors: Motors,
    /// The range sensors.
    pub ranges: Ranges,
    /// The compass's bus.
    pub compass: CompassBus,
    /// The light.
    pub led: Led,
    /// The host's connection.
    pub usb: Peri<'static, USB>,
    /// Where knowledge is kept.
    pub flash: Peri<'static, FLASH>,
    /// The hardware watchdog.
    pub watchdog: Peri<'static, WATCHDOG>,
}

/// Range sensors that are connected.
pub const CONNECTED: usize = match FITTED {
    Fitted::FrontPair => 4,
    Fitted::FrontSingle => 3,
};

/// The range sensors and their converter.
pub struct Ranges {
    /// The converter.
    pub adc: Peri<'static, ADC>,
    /// What carries its results to memory.
    pub dma: Peri<'static, DMA_CH0>,
    /// The sensors: ahead (on the left, on the right of two), left, right. Their pins ascend, for
    /// the converter goes round them in that order.
    pub channels: [Channel<'static>; CONNECTED],
}

/// The compass's pins and their controller; concrete types, since drivers come and go on them.
pub struct CompassBus {
    /// The controller.
    pub i2c: Peri<'static, I2C1>,
    /// Data.
    pub sda: Peri<'static, PIN_6>,
    /// Clock.
    pub scl: Peri<'static, PIN_7>,
}

impl Board {
    /// Hands every part its pins; the motors are off.
    pub fn new(p: Peripherals) -> Self {
        let left_pwm = p.PIN_0;
        let right_pwm = p.PIN_1;
        let left_forward = Output::new(p.PIN_2, Level::Low);
        let left_reverse = Output::new(p.PIN_3, Level::Low);
        let right_forward = Output::new(p.PIN_4, Level::Low);
        let right_reverse = Output::new(p.PIN_5, Level::Low);
        let sda = p.PIN_6;
        let scl = p.PIN_7;
        // Without pulls: an open cable is told by the resistor outside, see README.md.
        let front_left = Channel::new_pin(p.PIN_26, Pull::None);
        #[cfg(not(feature = "pico"))]
        let front_right = Channel::new_pin(p.PIN_27, Pull::None);
        #[cfg(not(feature = "pico"))]
        let left = Channel::new_pin(p.PIN_28, Pull::None);
        #[cfg(not(feature = "pico"))]
        let right = Channel::new_pin(p.PIN_29, Pull::None);
        #[cfg(feature = "pico")]
        let left = Channel::new_pin(p.PIN_27, Pull::None);
        #[cfg(feature = "pico")]
        let right = Channel::new_pin(p.PIN_28, Pull::None);
        #[cfg(feature = "pico")]
        let led = Output::new(p.PIN_25, Level::Low);

        let mut config = pwm::Config::default();
        config.top = PWM_TOP;
        Self {
            motors: Motors {
                pwm: Pwm::new_output_ab(p.PWM_SLICE0, left_pwm, right_pwm, config.clone()),
                config,
                directions: [[left_forward, left_reverse], [right_forward, right_reverse]],
            },
            ranges: Ranges {
                adc: p.ADC,
                dma: p.DMA_CH0,
                channels: [
                    front_left,
                    #[cfg(not(feature = "pico"))]
                    front_right,
                    left,
                    right,
                ],
            },
            compass: CompassBus {
                i2c: p.I2C1,
                sda,
                scl,
            },
            led: Led {
                #[cfg(feature = "pico")]
                pin: led,
            },
            usb: p.USB,
            flash: p.FLASH,
            watchdog: p.WATCHDOG,
        }
    }
}

/// The PWM slice of GPIO 0 and 1: one register holds both duties, so one write stops both sides.
const MOTOR_SLICE: usize = 0;
/// The two PWM pins.
const MOTOR_PWM_PINS: [usize; 2] = [0, 1];

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

/// Sets both duties to 0, from wherever: one write to one register, in force when the counter next
/// wraps, 50 us later at most.
pub fn motors_off() {
    pac::PWM
        .ch(MOTOR_SLICE)
        .cc()
        .write_value(pac::pwm::regs::ChCc(0));
}

/// Takes the PWM pins away from whatever drives them, for when nothing can be relied upon any more.
/// Only a reset gives them back.
pub fn motors_dead() {
    motors_off();
    for pin in MOTOR_PWM_PINS {
        let ctrl = pac::IO_BANK0.gpio(pin).ctrl();
        ctrl.modify(|w| w.set_outover(pac::io::vals::Outover::LOW));
    }
}

/// The board's light, where there is a plain one.
pub struct Led {
    #[cfg(feature = "pico")]
    pin: Output<'static>,
}

impl Led {
    /// Switches it.
    pub fn set(&mut self, on: bool) {
        #[cfg(feature = "pico")]
        self.pin.set_level(on.into());
        #[cfg(not(feature = "pico"))]
        let _ = on;
    }
}
