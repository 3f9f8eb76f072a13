//! Power and resets of the machine.

use super::state::Machine;
use crate::bus::Boot;
use crate::incident::{Incident, Kind};
use crate::psm::stage;
use crate::vreg_and_chip_reset::ChipReset;

/// Where the boot ROM's vectors are.
const BOOT_ROM: u32 = 0;

impl Machine {
    /// Whether there is power.
    pub const fn powered(&self) -> bool {
        self.powered
    }

    /// Switches the power on; the program starts. Nothing happens if it is on.
    pub fn power_on(&mut self) {
        if self.powered {
            return;
        }
        self.powered = true;
        self.power_cycles += 1;
        self.bus.memory.scramble(self.seed ^ self.power_cycles);
        if let Some(stack) = &self.stack {
            stack.paint(&mut self.bus.memory);
        }
        self.reset_chip(ChipReset::Power);
    }

    /// Cuts the power. What the flash was doing stays half done.
    pub fn power_off(&mut self) {
        if self.powered {
            let seed = self.seed ^ self.bus.now;
            self.bus.flash.lose_power(self.bus.now, seed);
            self.lose_power();
        }
    }

    pub(super) fn lose_power(&mut self) {
        self.powered = false;
        self.bus
            .peripherals
            .reset_chip(ChipReset::Power, self.bus.now);
        self.note(Kind::PowerLost);
    }

    /// The supply dips for so short a time that the RAM keeps its contents, but low enough that the
    /// brown-out detector resets the chip.
    pub fn brown_out(&mut self) {
        if self.powered {
            let seed = self.seed ^ self.bus.now;
            self.bus.flash.lose_power(self.bus.now, seed);
            self.note(Kind::BrownOut);
            self.reset_chip(ChipReset::Power);
        }
    }

    /// Pulls the RUN pin low for a moment.
    pub fn pulse_run_pin(&mut self) {
        if self.powered {
            self.note(Kind::RunPin);
            self.reset_chip(ChipReset::RunPin);
        }
    }

    pub(super) fn note(&mut self, kind: Kind) {
        let at = self.bus.now;
        self.incidents.note(Incident { at, kind });
    }

    fn reset_chip(&mut self, reset: ChipReset) {
        self.bus.peripherals.reset_chip(reset, self.bus.now);
        self.bus.reset_flash_interface();
        self.reset_core();
    }

    pub(super) fn reset_core(&mut self) {
        self.bus.boot = Boot::Pending;
        self.bus.stalled_until = self.bus.now;
        self.core.reset(&mut self.bus, BOOT_ROM);
        self.lines = 0;
        self.fault = None;
        self.probes.abandon();
        self.bus.look();
    }

    pub(super) fn reset_by_watchdog(&mut self) {
        self.note(Kind::Watchdog { fault: self.fault });
        let stages = self.bus.peripherals.reset_by_watchdog(self.bus.now);
        if stages & stage::XIP != 0 {
            self.bus.reset_flash_interface();
        }
        if stages & stage::PROC0 != 0 {
            self.reset_core();
        }
    }
}
