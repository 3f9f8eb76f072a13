//! What the machine consists of, and how it is made.

use super::load::Load;
use crate::bus::{FLASH, SystemBus};
use crate::cpu::{Core, FaultReport};
use crate::elf::Image;
use crate::incident::Incidents;
use crate::peripheral::Cycles;
use crate::probe::Probes;
use crate::stack::Stack;

/// A program that does not fit into the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{size} bytes at {address:#010x} lie outside the flash, 2 MB from 0x10000000")]
pub struct OutsideFlash {
    /// Where it should go.
    pub address: u32,
    /// How long it is.
    pub size: usize,
}

/// Bytes that are not in the RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{address:#010x} does not lie in the RAM, or not all bytes from there on")]
pub struct OutsideRam {
    /// Where they should go.
    pub address: u32,
}

/// A device that cannot be wired to these pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WiringError {
    /// They are not the two lines of one controller.
    #[error("GPIO {data} and {clock} are not SDA and SCL of one I2C controller")]
    NotABus {
        /// What was to be SDA.
        data: usize,
        /// What was to be SCL.
        clock: usize,
    },
    /// Other pins of this controller have devices on them.
    #[error("the devices of I2C{controller} are wired to GPIO {data} and {clock}")]
    Taken {
        /// The controller.
        controller: usize,
        /// Its SDA.
        data: usize,
        /// Its SCL.
        clock: usize,
    },
}

/// An RP2040 with its flash, what is wired to it, and its time.
#[derive(Clone, Debug)]
pub struct Machine {
    pub(super) core: Core,
    pub(super) bus: SystemBus,
    pub(super) powered: bool,
    /// Decides what the RAM holds after power-up, and what a power cut leaves of the flash.
    pub(super) seed: u64,
    pub(super) power_cycles: u64,
    pub(super) lines: u32,
    /// Ticks of the reference clock that SysTick has counted.
    pub(super) reference_ticks: u64,
    pub(super) load: Load,
    pub(super) stack: Option<Stack>,
    pub(super) probes: Probes,
    pub(super) incidents: Incidents,
    /// The last fault that was noted.
    pub(super) fault: Option<FaultReport>,
}

impl Machine {
    /// A machine with this program in its flash, powered and about to start. The seed decides all
    /// that chance decides in hardware: the ring oscillator's bits, what the RAM holds at first, the
    /// flash's unique number, what a power cut leaves.
    ///
    /// # Errors
    /// The program lies outside the flash.
    pub fn new(image: &Image, seed: u64) -> Result<Self, OutsideFlash> {
        let mut machine = Self {
            core: Core::new(),
            bus: SystemBus::new(seed),
            powered: false,
            seed,
            power_cycles: 0,
            lines: 0,
            reference_ticks: 0,
            load: Load::default(),
            stack: Stack::of(image),
            probes: Probes::default(),
            incidents: Incidents::default(),
            fault: None,
        };
        machine.write_flash(image)?;
        machine.power_on();
        Ok(machine)
    }

    /// Writes a program into the flash as a programmer does; what it does not cover stays.
    ///
    /// # Errors
    /// The program lies outside the flash; what comes before that is written.
    pub fn write_flash(&mut self, image: &Image) -> Result<(), OutsideFlash> {
        for segment in &image.segments {
            let (address, size) = (segment.address, segment.bytes.len());
            let start = address.wrapping_sub(FLASH) as usize;
            let cells = start
                .checked_add(size)
                .and_then(|end| self.bus.flash.bytes_mut().get_mut(start..end));
            cells
                .ok_or(OutsideFlash { address, size })?
                .copy_from_slice(&segment.bytes);
        }
        Ok(())
    }

    /// Cycles of the system clock since the machine was made, power cuts included.
    pub fn now(&self) -> Cycles {
        self.bus.now
    }
}
