//! The subsystem resets (RP2040 datasheet 2.14): which peripherals are held in reset.

use super::peripheral::{Cycles, Peripheral, Write};

const RESET: u32 = 0x0;
const WDSEL: u32 = 0x4;
const RESET_DONE: u32 = 0x8;

/// One bit a peripheral.
pub mod subsystem {
    /// ADC.
    pub const ADC: u32 = 1 << 0;
    /// Bus priorities.
    pub const BUSCTRL: u32 = 1 << 1;
    /// DMA controller.
    pub const DMA: u32 = 1 << 2;
    /// I2C0.
    pub const I2C0: u32 = 1 << 3;
    /// I2C1.
    pub const I2C1: u32 = 1 << 4;
    /// Pins: function select.
    pub const IO_BANK0: u32 = 1 << 5;
    /// Pins of the flash.
    pub const IO_QSPI: u32 = 1 << 6;
    /// Pins: pads.
    pub const PADS_BANK0: u32 = 1 << 8;
    /// Pads of the flash.
    pub const PADS_QSPI: u32 = 1 << 9;
    /// The system clock's PLL.
    pub const PLL_SYS: u32 = 1 << 12;
    /// USB's and the ADC's PLL.
    pub const PLL_USB: u32 = 1 << 13;
    /// PWM.
    pub const PWM: u32 = 1 << 14;
    /// System configuration.
    pub const SYSCFG: u32 = 1 << 18;
    /// System information.
    pub const SYSINFO: u32 = 1 << 19;
    /// Test bench manager.
    pub const TBMAN: u32 = 1 << 20;
    /// Timer.
    pub const TIMER: u32 = 1 << 21;
    /// USB controller.
    pub const USBCTRL: u32 = 1 << 24;
    /// All there are.
    pub const ALL: u32 = 0x01ff_ffff;
}

/// What the boot ROM takes out of reset before it starts the program.
const USED_BY_BOOT_ROM: u32 = subsystem::IO_QSPI | subsystem::PADS_QSPI;

/// The registers.
#[derive(Clone, Debug)]
pub struct Resets {
    held: u32,
    watchdog: u32,
    /// Put into reset or taken out of it since it was last asked.
    switched: u32,
}

impl Resets {
    /// Everything in reset but what the boot ROM uses.
    pub const fn new() -> Self {
        Self {
            held: subsystem::ALL & !USED_BY_BOOT_ROM,
            watchdog: 0,
            switched: 0,
        }
    }

    /// Which subsystems are in reset.
    pub const fn held(&self) -> u32 {
        self.held
    }

    /// Which the watchdog is to put through reset.
    pub const fn selected_for_watchdog(&self) -> u32 {
        self.watchdog
    }

    /// Which were put into reset, or taken out of it, since this was last asked: they start anew.
    pub fn take_switched(&mut self) -> u32 {
        std::mem::take(&mut self.switched)
    }
}

impl Peripheral for Resets {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            RESET => self.held,
            WDSEL => self.watchdog,
            RESET_DONE => !self.held & subsystem::ALL,
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        match offset {
            RESET => {
                let held = write.onto(self.held) & subsystem::ALL;
                self.switched |= held ^ self.held;
                self.held = held;
            }
            WDSEL => self.watchdog = write.onto(self.watchdog) & subsystem::ALL,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peripheral::Alias;

    #[test]
    fn subsystems_go_into_reset_and_come_out() {
        let mut resets = Resets::new();
        assert_eq!(resets.held() & subsystem::IO_QSPI, 0);
        let set = |alias| Write {
            value: subsystem::TIMER | subsystem::PWM,
            alias,
        };
        resets.write(RESET, set(Alias::Clear), 0);
        assert_eq!(
            resets.read(RESET_DONE, 0),
            subsystem::TIMER | subsystem::PWM | USED_BY_BOOT_ROM
        );
        assert_eq!(resets.take_switched(), subsystem::TIMER | subsystem::PWM);
        assert_eq!(resets.take_switched(), 0);
        resets.write(RESET, set(Alias::Set), 0);
        resets.write(RESET, set(Alias::Set), 0);
        assert_eq!(resets.take_switched(), subsystem::TIMER | subsystem::PWM);
        assert_eq!(resets.read(RESET_DONE, 0), USED_BY_BOOT_ROM);
    }
}
