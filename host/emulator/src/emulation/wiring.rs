//! What is wired to which pin, by the descriptions of `firmware/boards`.

use emulated_rp2040::binary_info::pico_board;
use emulated_rp2040::elf::Image;
use emulated_rp2040::machine::Machine;
use emulated_rp2040::pins::Output;
use rover_boards::Board;
use rover_shared::sensing::ir::CHANNELS;

use crate::cmps03::Compass;
use crate::vehicle::SidePins;

/// An image for a board whose wiring is not known: its name, if the image says one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownBoard(pub Option<String>);

impl std::fmt::Display for UnknownBoard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.0 {
            Some(name) => write!(f, "the firmware is for the board {name:?}")?,
            None => write!(f, "the firmware does not say which board it is for")?,
        }
        let known: Vec<_> = rover_boards::ALL.iter().map(|board| board.name()).collect();
        write!(f, ", and the emulator knows only {}; ", known.join(", "))?;
        write!(f, "`cargo fw` builds it anew")
    }
}

impl std::error::Error for UnknownBoard {}

/// How a board is wired to the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring(&'static Board);

impl Wiring {
    /// The wiring of the board that a firmware was built for.
    ///
    /// # Errors
    /// The image does not name its board, or one that is not known.
    pub fn of(image: &Image) -> Result<Self, UnknownBoard> {
        let name = pico_board(image);
        let board = rover_boards::ALL
            .iter()
            .find(|board| name == Some(board.name()));
        let board = board.ok_or_else(|| UnknownBoard(name.map(str::to_owned)))?;
        Ok(Self(board))
    }

    /// Connects a compass to its bus.
    pub fn connect_compass(self, machine: &mut Machine) {
        let pins = [self.0.compass.sda, self.0.compass.scl].map(usize::from);
        machine.attach_i2c(pins, Compass::default());
    }

    /// The number of the I2C controller that the compass is on.
    pub const fn compass_controller(self) -> usize {
        self.0.compass.controller() as usize
    }

    /// Puts the range sensors' counts on the converter's inputs.
    pub fn set_ranges(self, machine: &mut Machine, counts: [u16; CHANNELS]) {
        for (pin, count) in self.0.ranges.into_iter().zip(counts) {
            if let Some(pin) = pin {
                machine.adc_mut().set_input(Board::adc_channel(pin), count);
            }
        }
    }

    /// What the motor drivers see, left and right.
    pub fn motor_pins(self, machine: &Machine) -> [SidePins; 2] {
        let output = |pin| machine.output(usize::from(pin));
        let high = |pin| output(pin) == Output::Level(true);
        [self.0.left, self.0.right].map(|side| SidePins {
            duty: output(side.pwm).duty(),
            forward: high(side.forward),
            reverse: high(side.reverse),
        })
    }

    /// Whether any current can flow through a motor: the PWM pin of a side is high at times while its
    /// direction pins differ.
    pub fn motors_driven(self, machine: &Machine) -> bool {
        self.motor_pins(machine)
            .iter()
            .any(|pins| pins.duty > 0.0 && pins.forward != pins.reverse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_of_no_known_board_is_refused_with_the_known_ones() {
        let refused = Wiring::of(&Image::default()).expect_err("no board");
        assert_eq!(refused, UnknownBoard(None));
        for text in [refused, UnknownBoard(Some("toaster".into()))].map(|error| error.to_string()) {
            for board in rover_boards::ALL {
                assert!(text.contains(board.name()), "{text}");
            }
            assert!(
                text.contains("toaster") || text.contains("does not say"),
                "{text}"
            );
        }
    }
}
