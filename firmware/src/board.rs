//! The board that the firmware is built for, and its pins: gives every part of the rover those that
//! the board's description in `firmware/boards` names.

use embassy_rp::adc::Channel;
use embassy_rp::gpio::{AnyPin, Level, Output, Pull};
use embassy_rp::peripherals::{self, ADC, DMA_CH0, FLASH, I2C1, USB, WATCHDOG};
use embassy_rp::{Peri, PeripheralType, Peripherals};
use heapless::Vec;
use rover_boards::Pin;
use rover_shared::motion::Parameters;
use rover_shared::rover::Identity;
use rover_shared::sensing::ir::curve::RangeCurve;
use rover_shared::sensing::ir::{CHANNELS, Fitted};

// `BOARD`, of the board that the build's features name.
include!(concat!(env!("OUT_DIR"), "/board.rs"));

/// How the board introduces itself.
pub const IDENTITY: Identity = Identity {
    board: BOARD.name(),
    firmware: concat!("rover-firmware ", env!("CARGO_PKG_VERSION")),
};

/// The range sensors that are fitted.
pub const FITTED: Fitted = match BOARD.ranges {
    [_, Some(_), ..] => Fitted::FrontPair,
    [_, None, ..] => Fitted::FrontSingle,
};

/// How many range sensors are fitted.
pub const CONNECTED: usize = match FITTED {
    Fitted::FrontPair => 4,
    Fitted::FrontSingle => 3,
};

/// Their curve until they are calibrated.
pub const CURVE: RangeCurve = if cfg!(feature = "gp2y0a21") {
    RangeCurve::GP2Y0A21
} else {
    RangeCurve::GP2D12
};

/// The chassis, until it is calibrated.
pub const CHASSIS: Parameters = Parameters::LYNXMOTION_4WD2;

/// Everything the rover is made of.
pub struct Parts {
    /// Both sides' motors.
    pub motors: MotorPins,
    /// The range sensors.
    pub ranges: Ranges,
    /// The compass's bus.
    pub compass: CompassBus,
    /// The light, where there is one.
    pub led: Option<Output<'static>>,
    /// The host's connection.
    pub usb: Peri<'static, USB>,
    /// Where knowledge is kept.
    pub flash: Peri<'static, FLASH>,
    /// The hardware watchdog.
    pub watchdog: Peri<'static, WATCHDOG>,
}

/// The motor driver's pins, of the left and of the right side.
pub struct MotorPins {
    /// The PWM slice of both sides.
    pub slice: Taken<Slice<{ BOARD.left.slice() }>>,
    /// Its channel A.
    pub left: Taken<Gpio<{ BOARD.left.pwm }>>,
    /// Its channel B.
    pub right: Taken<Gpio<{ BOARD.right.pwm }>>,
    /// Forward and reverse.
    pub directions: [[Output<'static>; 2]; 2],
}

/// The range sensors and their converter.
pub struct Ranges {
    /// The converter.
    pub adc: Peri<'static, ADC>,
    /// The DMA channel for its results.
    pub dma: Peri<'static, DMA_CH0>,
    /// The sensors that are fitted: ahead (on the left, on the right of two), left, right. Their
    /// pins ascend, as the converter samples them.
    pub channels: Vec<Channel<'static>, CHANNELS>,
}

/// The compass's pins and their controller; concrete types, since drivers are made on them anew.
pub struct CompassBus {
    /// The controller.
    pub i2c: Peri<'static, I2C1>,
    /// Data.
    pub sda: Taken<Gpio<{ BOARD.compass.sda }>>,
    /// Clock.
    pub scl: Taken<Gpio<{ BOARD.compass.scl }>>,
}

impl Parts {
    /// Gives every part its pins; the motors are off.
    pub fn new(p: Peripherals) -> Self {
        Self {
            motors: MotorPins {
                slice: take::<Slice<{ BOARD.left.slice() }>>(),
                left: take::<Gpio<{ BOARD.left.pwm }>>(),
                right: take::<Gpio<{ BOARD.right.pwm }>>(),
                directions: [BOARD.left, BOARD.right]
                    .map(|side| [side.forward, side.reverse].map(output)),
            },
            ranges: Ranges {
                adc: p.ADC,
                dma: p.DMA_CH0,
                channels: BOARD.ranges.into_iter().flatten().map(range).collect(),
            },
            compass: CompassBus {
                i2c: p.I2C1,
                sda: take::<Gpio<{ BOARD.compass.sda }>>(),
                scl: take::<Gpio<{ BOARD.compass.scl }>>(),
            },
            led: BOARD.led.map(output),
            usb: p.USB,
            flash: p.FLASH,
            watchdog: p.WATCHDOG,
        }
    }
}

/// An output, low at first.
fn output(pin: Pin) -> Output<'static> {
    // SAFETY: as in `take`.
    Output::new(unsafe { AnyPin::steal(pin) }, Level::Low)
}

/// A range sensor's input, without pulls: the resistor outside tells an open cable, see README.md.
fn range(pin: Pin) -> Channel<'static> {
    match pin {
        26 => Channel::new_pin(take::<Gpio<26>>(), Pull::None),
        27 => Channel::new_pin(take::<Gpio<27>>(), Pull::None),
        28 => Channel::new_pin(take::<Gpio<28>>(), Pull::None),
        // 29: `Board::check` lets no other pass.
        _ => Channel::new_pin(take::<Gpio<29>>(), Pull::None),
    }
}

/// A pin or a PWM slice, for the one who uses it.
pub type Taken<N> = Peri<'static, <N as Numbered>::Peripheral>;

/// Takes a pin or a PWM slice by its number.
fn take<N: Numbered>() -> Taken<N> {
    // SAFETY: only `Parts::new` takes anything, once, since it consumes the only `Peripherals`, of
    // which it leaves pins and slices alone; and `Board::check` has found no pin with two signals.
    unsafe { N::steal() }
}

/// A pin or PWM slice whose number selects its type, so that embassy-rp's drivers take only those
/// that the chip connects with them.
pub trait Numbered {
    /// Its type.
    type Peripheral: PeripheralType;

    /// Makes it from nothing.
    ///
    /// # Safety
    /// Nobody else uses it.
    unsafe fn steal() -> Peri<'static, Self::Peripheral>;
}

/// A pin.
pub struct Gpio<const N: Pin>;

/// A PWM slice.
pub struct Slice<const N: u8>;

macro_rules! numbered {
    ($kind:ident: $($number:literal $name:ident),+) => { $(
        impl Numbered for $kind<$number> {
            type Peripheral = peripherals::$name;

            unsafe fn steal() -> Peri<'static, Self::Peripheral> {
                // SAFETY: the caller's promise is the same.
                unsafe { peripherals::$name::steal() }
            }
        }
    )+ };
}

numbered!(Gpio: 0 PIN_0, 1 PIN_1, 2 PIN_2, 3 PIN_3, 4 PIN_4, 5 PIN_5, 6 PIN_6, 7 PIN_7, 8 PIN_8,
    9 PIN_9, 10 PIN_10, 11 PIN_11, 12 PIN_12, 13 PIN_13, 14 PIN_14, 15 PIN_15, 16 PIN_16, 17 PIN_17,
    18 PIN_18, 19 PIN_19, 20 PIN_20, 21 PIN_21, 22 PIN_22, 23 PIN_23, 24 PIN_24, 25 PIN_25,
    26 PIN_26, 27 PIN_27, 28 PIN_28, 29 PIN_29);
numbered!(Slice: 0 PWM_SLICE0, 1 PWM_SLICE1, 2 PWM_SLICE2, 3 PWM_SLICE3, 4 PWM_SLICE4,
    5 PWM_SLICE5, 6 PWM_SLICE6, 7 PWM_SLICE7);
