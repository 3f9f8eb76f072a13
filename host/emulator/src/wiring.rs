//! What is wired to which pin: the table of `firmware/README.md` from the other side.

use rover_shared::sensing::ir::CHANNELS;

use crate::vehicle::SidePins;
use emulated_rp2040::elf::Image;
use emulated_rp2040::machine::Machine;
use emulated_rp2040::pins::Output;

/// Pins of one side's motor driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Side {
    pwm: usize,
    forward: usize,
    reverse: usize,
}

/// SDA and SCL of the bus that the compass is on.
pub const COMPASS_PINS: [usize; 2] = [6, 7];
/// The controller that these pins are of.
pub const COMPASS_CONTROLLER: usize = 1;

const LEFT: Side = Side {
    pwm: 0,
    forward: 2,
    reverse: 3,
};
const RIGHT: Side = Side {
    pwm: 1,
    forward: 4,
    reverse: 5,
};

/// Which boards there are, as far as their wiring differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wiring {
    /// Four range sensors on ADC channels 0 to 3.
    FourAdc,
    /// A Raspberry Pi Pico: one sensor ahead, three in all.
    Pico,
}

impl Wiring {
    /// The wiring that a firmware was built for, by the name it calls its board.
    pub fn of(image: &Image) -> Self {
        const PICO: &[u8] = b"raspberry-pi-pico";
        let names = |bytes: &[u8]| bytes.windows(PICO.len()).any(|window| window == PICO);
        if image.segments.iter().any(|segment| names(&segment.bytes)) {
            Self::Pico
        } else {
            Self::FourAdc
        }
    }

    /// The range sensor on each ADC channel, as an index of the core's arrays of four.
    pub const fn sensors(self) -> &'static [usize] {
        match self {
            Self::FourAdc => &[0, 1, 2, 3],
            Self::Pico => &[0, 2, 3],
        }
    }

    /// Puts the sensors' counts on the converter's inputs.
    pub fn connect(self, machine: &mut Machine, counts: [u16; CHANNELS]) {
        for (channel, sensor) in self.sensors().iter().enumerate() {
            machine.adc_mut().set_input(channel, counts[*sensor]);
        }
    }
}

/// What the motor drivers see, left and right.
pub fn motor_pins(machine: &Machine) -> [SidePins; 2] {
    let high = |pin| machine.output(pin) == Output::Level(true);
    [LEFT, RIGHT].map(|side| SidePins {
        duty: machine.output(side.pwm).duty(),
        forward: high(side.forward),
        reverse: high(side.reverse),
    })
}

/// Whether any current can flow through a motor: the PWM pin of a side is high at times while its
/// direction pins differ.
pub fn motors_driven(machine: &Machine) -> bool {
    motor_pins(machine)
        .iter()
        .any(|pins| pins.duty > 0.0 && pins.forward != pins.reverse)
}
