//! An electronic compass on an I2C bus: Devantech CMPS03, or as much of its successors CMPS11,
//! CMPS12 and CMPS14 as has the same registers (0 to 3; data sheets of the CMPS03, "Register
//! functions", and of its successors).
//!
//! Only the bus side is here. What the registers hold, and whether the compass answers at all, is
//! set from outside.

use emulated_rp2040::i2c::I2cDevice;

/// Its address, 7 bits.
pub const ADDRESS: u16 = 0x60;
/// Registers: version of the software, bearing as a byte, bearing in tenths
/// of a degree clockwise from north, high byte first.
pub const REGISTERS: usize = 4;

/// The compass.
#[derive(Clone, Debug, Default)]
pub struct Compass {
    /// What it measured last; `None` if it has no power or is not connected.
    measured: Option<[u8; REGISTERS]>,
    /// What the transfer under way reads: the bytes of a bearing belong together.
    latched: [u8; REGISTERS],
    /// The register that is read or written next.
    pointer: u8,
    /// The next byte written is the pointer.
    pointer_follows: bool,
}

impl Compass {
    /// Sets what the registers hold; without, it acknowledges nothing.
    pub fn set_registers(&mut self, registers: Option<[u8; REGISTERS]>) {
        self.measured = registers;
    }
}

impl I2cDevice for Compass {
    fn start(&mut self, address: u16, read: bool) -> bool {
        self.pointer_follows = !read;
        match self.measured {
            Some(registers) if address == ADDRESS => {
                self.latched = registers;
                true
            }
            _ => false,
        }
    }

    /// Commands (calibration, a new address) are acknowledged and ignored.
    fn write(&mut self, byte: u8) -> bool {
        if self.pointer_follows {
            self.pointer = byte;
            self.pointer_follows = false;
        } else {
            self.pointer = self.pointer.wrapping_add(1);
        }
        true
    }

    fn read(&mut self) -> u8 {
        let register = usize::from(self.pointer);
        self.pointer = self.pointer.wrapping_add(1);
        self.latched.get(register).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_from(compass: &mut Compass, register: u8, count: usize) -> Vec<u8> {
        assert!(compass.start(ADDRESS, false));
        assert!(compass.write(register));
        assert!(compass.start(ADDRESS, true));
        let bytes = (0..count).map(|_| compass.read()).collect();
        compass.stop();
        bytes
    }

    #[test]
    fn registers_are_read_from_the_one_that_was_named_on() {
        let mut compass = Compass::default();
        compass.set_registers(Some([14, 0x80, 0x07, 0x08]));
        assert_eq!(read_from(&mut compass, 1, 3), [0x80, 0x07, 0x08]);
        assert_eq!(read_from(&mut compass, 0, 1), [14]);
        assert_eq!(read_from(&mut compass, 3, 3), [0x08, 0, 0], "others are 0");
    }

    #[test]
    fn a_bearing_that_changes_in_between_does_not_tear() {
        let mut compass = Compass::default();
        compass.set_registers(Some([14, 0, 0x00, 0xff]));
        assert!(compass.start(ADDRESS, false));
        assert!(compass.write(2));
        assert!(compass.start(ADDRESS, true));
        assert_eq!(compass.read(), 0x00);
        compass.set_registers(Some([14, 1, 0x01, 0x00]));
        assert_eq!(compass.read(), 0xff);
    }

    #[test]
    fn nobody_else_is_answered_for_and_nothing_without_power() {
        let mut compass = Compass::default();
        assert!(!compass.start(ADDRESS, false));
        compass.set_registers(Some([0; REGISTERS]));
        assert!(!compass.start(ADDRESS + 1, false));
        assert!(compass.start(ADDRESS, false));
    }
}
