//! What resets do to the peripherals.

use super::blocks::Peripherals;
use crate::clocks::Clocks;
use crate::gpio::IoBank0;
use crate::pads::Pads;
use crate::peripheral::Cycles;
use crate::pll::Pll;
use crate::psm::{Psm, stage};
use crate::resets::{Resets, subsystem};
use crate::sio::Sio;
use crate::timer::Timer;
use crate::vreg_and_chip_reset::{ChipReset, VregAndChipReset};
use crate::watchdog::Watchdog;
use crate::xosc::Xosc;

impl Peripherals {
    /// Puts subsystems through reset.
    pub(super) fn reset_subsystems(&mut self, subsystems: u32, now: Cycles) {
        let tick = self.watchdog.tick();
        for bit in (0..u32::BITS)
            .map(|i| 1 << i)
            .filter(|bit| subsystems & bit != 0)
        {
            match bit {
                subsystem::ADC => self.adc.reset(),
                subsystem::DMA => self.dma.reset(),
                subsystem::I2C0 => self.i2c[0].reset(),
                subsystem::I2C1 => self.i2c[1].reset(),
                subsystem::USBCTRL => self.usb.reset(now),
                subsystem::BUSCTRL => self.busctrl.reset(),
                subsystem::IO_BANK0 => self.io_bank0 = IoBank0::new(),
                subsystem::IO_QSPI => self.io_qspi.reset(),
                subsystem::PADS_BANK0 => self.pads = Pads::new(),
                subsystem::PADS_QSPI => self.pads_qspi.reset(),
                subsystem::PLL_SYS => self.pll_sys = Pll::new(),
                subsystem::PLL_USB => self.pll_usb = Pll::new(),
                subsystem::PWM => self.pwm.reset(),
                subsystem::SYSCFG => self.syscfg.reset(),
                subsystem::TIMER => self.timer = Timer::new(tick, now),
                _ => {}
            }
        }
        self.pins_changed(now);
    }

    /// The reset that the watchdog, having fired, demands; returns which stages go through it.
    pub fn reset_by_watchdog(&mut self, now: Cycles) -> u32 {
        let stages = self.psm.restarted_by_watchdog();
        self.watchdog.restart();
        self.timer.set_tick(self.watchdog.tick(), now);
        let subsystems = self.resets.selected_for_watchdog();
        self.reset_subsystems(subsystems, now);
        if stages & stage::CLOCKS != 0 {
            self.clocks = Clocks::new();
        }
        if stages & stage::RESETS != 0 {
            self.resets = Resets::new();
            self.reset_subsystems(subsystem::ALL, now);
        }
        if stages & stage::SIO != 0 {
            self.sio = Sio::new();
        }
        self.psm = Psm::new();
        self.pins_changed(now);
        stages
    }

    /// A reset of the whole chip.
    pub fn reset_chip(&mut self, reset: ChipReset, now: Cycles) {
        self.watchdog = Watchdog::new();
        self.psm = Psm::new();
        self.resets = Resets::new();
        self.clocks = Clocks::new();
        self.xosc = Xosc::new();
        self.sio = Sio::new();
        self.vreg_and_chip_reset = VregAndChipReset::new(reset);
        self.reset_subsystems(subsystem::ALL, now);
    }
}
