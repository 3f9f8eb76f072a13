//! What can be seen of the machine, and what is connected to it.
//!
//! Whatever is changed from outside may concern the core at once: the machine looks after everything
//! before it goes on.

use super::load::Load;
use super::state::{Machine, OutsideRam, WiringError};
use crate::adc::Adc;
use crate::boot_rom;
use crate::bus::{Boot, FLASH};
use crate::cpu::{Core, PC};
use crate::i2c::{I2c, I2cDevice};
use crate::incident::Incidents;
use crate::memory::RAM;
use crate::peripheral::Cycles;
use crate::peripherals::{Peripherals, Unmodelled};
use crate::pins::Output;
use crate::pins::PINS;
use crate::probe::{Call, Probe, ProbeId, Probes};
use crate::usb::Usb;

impl Machine {
    /// What the chip drives a pin of bank 0 to.
    ///
    /// # Panics
    /// There is no such pin: see [`PINS`].
    pub fn output(&self, pin: usize) -> Output {
        self.bus.peripherals.output(pin)
    }

    /// Holds a pin of bank 0 at a level from outside, as a closed button does, or releases it to the
    /// chip's pulls.
    ///
    /// # Panics
    /// There is no such pin: see [`PINS`].
    pub fn set_input(&mut self, pin: usize, level: Option<bool>) {
        self.peripherals_mut().outside[pin] = level;
        self.bus.peripherals.pins_changed(self.bus.now);
    }

    /// The converter, to set its inputs.
    pub fn adc_mut(&mut self) -> &mut Adc {
        &mut self.peripherals_mut().adc
    }

    /// Wires a device to two pins, SDA and SCL of an I2C controller (2.19.2): of I2C0 these are 0 and
    /// 1, 4 and 5, ..., of I2C1 2 and 3, 6 and 7, .... Several devices may share a bus. The program
    /// reaches them while it has given both pins the function I2C.
    ///
    /// ```
    /// # use emulated_rp2040::{Machine, elf::Image, i2c::I2cDevice};
    /// #[derive(Clone, Debug)]
    /// struct Thermometer;
    ///
    /// impl I2cDevice for Thermometer {
    ///     fn start(&mut self, address: u16, _read: bool) -> bool {
    ///         address == 0x48
    ///     }
    ///     fn write(&mut self, _byte: u8) -> bool {
    ///         true
    ///     }
    ///     fn read(&mut self) -> u8 {
    ///         21
    ///     }
    /// }
    ///
    /// let mut machine = Machine::new(&Image::default(), 0)?;
    /// machine.attach_i2c([4, 5], Thermometer)?;
    /// assert!(machine.attach_i2c([5, 4], Thermometer).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The pins are not SDA and SCL of one controller, or its devices are wired to other pins.
    pub fn attach_i2c(
        &mut self,
        [data, clock]: [usize; 2],
        device: impl I2cDevice,
    ) -> Result<(), WiringError> {
        let controller = data / 2 % 2;
        let one_bus = data % 2 == 0 && clock % 2 == 1 && clock / 2 % 2 == controller;
        if !one_bus || data.max(clock) >= PINS {
            return Err(WiringError::NotABus { data, clock });
        }
        let wired = self.peripherals_mut().i2c_pins[controller].get_or_insert([data, clock]);
        if *wired != [data, clock] {
            let [data, clock] = *wired;
            return Err(WiringError::Taken {
                controller,
                data,
                clock,
            });
        }
        self.i2c_mut(controller).attach(device);
        self.bus.peripherals.pins_changed(self.bus.now);
        Ok(())
    }

    /// An I2C controller, 0 or 1, with its bus: to reach the devices on it, or to break it.
    ///
    /// # Panics
    /// There is no such controller.
    pub fn i2c_mut(&mut self, number: usize) -> &mut I2c {
        &mut self.peripherals_mut().i2c[number]
    }

    /// USB: the cable and the host at its end.
    pub fn usb(&self) -> &Usb {
        &self.bus.peripherals.usb
    }

    /// USB, to change something there. Its functions want the time, [`Machine::now`].
    pub fn usb_mut(&mut self) -> &mut Usb {
        &mut self.peripherals_mut().usb
    }

    pub(super) fn peripherals_mut(&mut self) -> &mut Peripherals {
        self.bus.look();
        &mut self.bus.peripherals
    }

    /// The processor.
    pub fn core(&self) -> &Core {
        &self.core
    }

    /// The processor, for a debugger to change its registers.
    pub fn core_mut(&mut self) -> &mut Core {
        self.bus.look();
        &mut self.core
    }

    /// Microseconds that the timer has counted since its last reset, once its tick is set up.
    pub fn timer_us(&self) -> u64 {
        self.bus.peripherals.timer.count(self.bus.now)
    }

    /// Lets the core go on at another address, as after a wild jump.
    pub fn jump(&mut self, address: u32) {
        self.core_mut().registers_mut().set(PC, address);
    }

    /// Lets the code outside of interrupts hang from now on: it waits for ever, in the boot ROM,
    /// while interrupts are served as before. Returns false, and does nothing, while the core is in an
    /// interrupt or without power.
    pub fn hang(&mut self) -> bool {
        let handling = self.core.registers().handler_mode();
        if handling || !self.powered {
            return false;
        }
        let rest = boot_rom::rest_address();
        self.core_mut().registers_mut().set(PC, rest);
        true
    }

    /// Lets the core stand still for some time, and interrupts wait, as if something took much longer
    /// than it should with interrupts masked.
    pub fn stall(&mut self, time: Cycles) {
        self.bus.stalled_until = self.bus.stalled_until.max(self.bus.now) + time;
        self.bus.look();
    }

    /// What the boot ROM came to.
    pub fn boot(&self) -> Boot {
        self.bus.boot
    }

    /// Bytes at an address of RAM or flash; `None` elsewhere.
    pub fn read(&self, address: u32, size: usize) -> Option<&[u8]> {
        let (memory, start) = if address >= RAM {
            (self.bus.memory.ram(), RAM)
        } else {
            (self.bus.flash.bytes(), FLASH)
        };
        let offset = address.wrapping_sub(start) as usize;
        memory.get(offset..offset.checked_add(size)?)
    }

    /// Changes bytes of the RAM as a debugger does.
    ///
    /// # Errors
    /// They do not lie in the RAM.
    pub fn write_ram(&mut self, address: u32, bytes: &[u8]) -> Result<(), OutsideRam> {
        let offset = address.wrapping_sub(RAM) as usize;
        let cells = offset
            .checked_add(bytes.len())
            .and_then(|end| self.bus.memory.ram_mut().get_mut(offset..end));
        cells.ok_or(OutsideRam { address })?.copy_from_slice(bytes);
        Ok(())
    }

    /// The flash's bytes.
    pub fn flash(&self) -> &[u8] {
        self.bus.flash.bytes()
    }

    /// The flash's bytes, for a programmer to change.
    pub fn flash_mut(&mut self) -> &mut [u8] {
        self.bus.flash.bytes_mut()
    }

    /// Operations that the flash has carried out, those that a power cut ended half done included.
    pub fn flash_operations(&self) -> u64 {
        self.bus.flash.operations()
    }

    /// Whether the flash is erasing or programming.
    pub fn flash_busy(&self) -> bool {
        self.bus.flash.busy()
    }

    /// Cuts the power during the flash operation with this number, counted as
    /// [`flash_operations`](Self::flash_operations) does, at a moment within it that the seed
    /// decides, as it decides what is left. One more order cuts it once more.
    pub fn cut_power_at(&mut self, operation: u64, seed: u64) {
        self.bus.flash.cut_power_at(operation, seed);
    }

    /// Whether the flash is as slow as its data sheet allows.
    pub fn set_flash_slow(&mut self, slow: bool) {
        self.bus.flash.set_slow(slow);
    }

    /// How the core spent its time since the machine was made, time without power left out.
    pub const fn load(&self) -> Load {
        self.load
    }

    /// The most bytes that were on the stack since power-up; `None` if the program does not say
    /// where its stack is.
    pub fn stack_high_water(&self) -> Option<u32> {
        Some(self.stack?.high_water(&self.bus.memory))
    }

    /// Bytes that the stack may have; `None` if the program does not say.
    pub fn stack_size(&self) -> Option<u32> {
        Some(self.stack?.size())
    }

    /// Faults, resets and power cuts.
    pub const fn incidents(&self) -> &Incidents {
        &self.incidents
    }

    /// The first access to a peripheral that is not emulated; `None` if there was none.
    pub fn unmodelled(&self) -> Option<Unmodelled> {
        self.bus.peripherals.unmodelled()
    }

    /// Measures the calls of the function at this address from now on. While there are probes the
    /// machine runs slower.
    pub fn add_probe(&mut self, function: u32) -> ProbeId {
        self.probes.add(function)
    }

    /// What a probe has measured.
    pub fn probe(&self, id: ProbeId) -> &Probe {
        self.probes.get(id)
    }

    /// What a probe has measured since this was last asked; a call that is under way comes next time.
    pub fn take_calls(&mut self, id: ProbeId) -> Vec<Call> {
        self.probes.take_calls(id)
    }

    /// Takes all probes away.
    pub fn remove_probes(&mut self) {
        self.probes = Probes::default();
    }
}
