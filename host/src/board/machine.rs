//! The machine: core, bus and peripherals in one time, and what resets them.
//!
//! [`Machine::run_until`] is all there is to do. While the core runs, only writes to registers and
//! events (an alarm, a conversion's end, a packet) make the machine look after the peripherals;
//! while it sleeps, time goes straight to the next event.

use super::adc::Adc;
use super::bus::{Boot, SystemBus};
use super::compass::Compass;
use super::cpu::{Activity, Core, FaultReport};
use super::elf::Image;
use super::i2c::I2c;
use super::incident::{Incident, Incidents, Kind};
use super::peripheral::Cycles;
use super::peripherals::{Peripherals, Unmodelled};
use super::pins::Output;
use super::probe::{Probe, ProbeId, Probes};
use super::psm::stage;
use super::stack::Stack;
use super::usb::Usb;
use super::vreg_and_chip_reset::ChipReset;

/// Where the boot ROM's vectors are.
const BOOT_ROM: u32 = 0;

/// A program that does not fit into the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{size} bytes at {address:#010x} lie outside the flash, 2 MB from 0x10000000")]
pub struct OutsideFlash {
    /// Where it should go.
    pub address: u32,
    /// How long it is.
    pub size: usize,
}

/// How the core spent its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Cycles in which it executed, or the boot ROM did in its place.
    pub busy: Cycles,
    /// Cycles in which it slept, or was locked up.
    pub idle: Cycles,
}

impl Load {
    /// The share of the time that it was busy, 0 to 1; 0 if no time passed.
    pub fn share(self) -> f64 {
        let all = self.busy + self.idle;
        if all == 0 {
            return 0.0;
        }
        self.busy as f64 / all as f64
    }

    /// What was added since `before`.
    pub const fn since(self, before: Self) -> Self {
        Self {
            busy: self.busy - before.busy,
            idle: self.idle - before.idle,
        }
    }
}

/// The emulated board.
#[derive(Clone, Debug)]
pub struct Machine {
    core: Core,
    bus: SystemBus,
    powered: bool,
    /// Decides what the RAM holds after power-up, and what a power cut leaves of the flash.
    seed: u64,
    power_cycles: u64,
    lines: u32,
    load: Load,
    stack: Option<Stack>,
    probes: Probes,
    incidents: Incidents,
    /// The last fault that was noted.
    fault: Option<FaultReport>,
}

impl Machine {
    /// A board with this program in its flash, powered and about to start. The seed decides all that
    /// chance decides in hardware: the ring oscillator's bits, what the RAM holds at first, what a
    /// power cut leaves.
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
            let start = address.wrapping_sub(super::bus::FLASH) as usize;
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

    // Power and resets.

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

    fn lose_power(&mut self) {
        self.powered = false;
        self.bus
            .peripherals
            .reset_chip(ChipReset::Power, self.bus.now);
        self.incidents.note(Incident {
            at: self.bus.now,
            kind: Kind::PowerLost,
        });
    }

    /// The supply dips for so short a time that the RAM keeps its contents, but low enough that the
    /// brown-out detector resets the chip.
    pub fn brown_out(&mut self) {
        if self.powered {
            let seed = self.seed ^ self.bus.now;
            self.bus.flash.lose_power(self.bus.now, seed);
            self.note_reset(Kind::BrownOut);
            self.reset_chip(ChipReset::Power);
        }
    }

    /// Pulls the RUN pin low for a moment.
    pub fn pulse_run_pin(&mut self) {
        if self.powered {
            self.note_reset(Kind::RunPin);
            self.reset_chip(ChipReset::RunPin);
        }
    }

    fn note_reset(&mut self, kind: Kind) {
        let at = self.bus.now;
        self.incidents.note(Incident { at, kind });
    }

    fn reset_chip(&mut self, reset: ChipReset) {
        self.bus.peripherals.reset_chip(reset, self.bus.now);
        self.bus.reset_flash_interface();
        self.reset_core();
    }

    fn reset_core(&mut self) {
        self.bus.boot = Boot::Pending;
        self.bus.stalled_until = self.bus.now;
        self.core.reset(&mut self.bus, BOOT_ROM);
        self.lines = 0;
        self.fault = None;
        self.probes.abandon();
        self.bus.look();
    }

    fn reset_by_watchdog(&mut self) {
        self.note_reset(Kind::Watchdog { fault: self.fault });
        let stages = self.bus.peripherals.reset_by_watchdog(self.bus.now);
        if stages & stage::XIP != 0 {
            self.bus.reset_flash_interface();
        }
        if stages & stage::PROC0 != 0 {
            self.reset_core();
        }
    }

    // Time.

    /// Runs the board until this moment; an instruction under way then is completed. Without power
    /// only the time goes on.
    pub fn run_until(&mut self, until: Cycles) {
        while self.bus.now < until {
            if !self.powered {
                self.bus.now = until;
                return;
            }
            let horizon = self.look_after().min(until);
            if horizon <= self.bus.now {
                continue;
            }
            if self.bus.stalled_until > self.bus.now || self.bus.flash.busy() {
                self.stand_still(horizon);
            } else if self.core.sleeping() {
                self.sleep(horizon);
            } else if self.probes.is_empty() {
                self.run(horizon);
            } else {
                self.run_probed(horizon);
            }
        }
    }

    /// Lets happen what is due, and gives the moment of the next event.
    fn look_after(&mut self) -> Cycles {
        let now = self.bus.now;
        self.bus.peripherals.advance(now);
        self.bus.flash.advance(now);
        if self.bus.flash.take_power_lost() {
            self.lose_power();
            return Cycles::MAX;
        }
        self.note_faults();
        if self.bus.peripherals.watchdog.take_fired() {
            self.reset_by_watchdog();
        } else if self.core.take_reset_request() {
            self.note_reset(Kind::Requested);
            self.reset_core();
        }
        let transfers = self.bus.run_dma();
        let lines = self.bus.peripherals.interrupt_lines();
        if lines != self.lines {
            self.lines = lines;
            self.core.set_interrupt_lines(lines);
        }
        let events = [
            self.bus.peripherals.next_event(),
            self.bus.flash.next_event(),
            transfers,
        ];
        events.into_iter().flatten().min().unwrap_or(Cycles::MAX)
    }

    fn note_faults(&mut self) {
        let fault = self.core.fault();
        if fault == self.fault {
            return;
        }
        self.fault = fault;
        if let Some(fault) = fault {
            let kind = if self.core.activity() == Activity::Lockup {
                Kind::Lockup(fault)
            } else {
                Kind::HardFault(fault)
            };
            self.note_reset(kind);
        }
    }

    /// The core waits for the boot ROM.
    fn stand_still(&mut self, horizon: Cycles) {
        let now = self.bus.now;
        let end = if self.bus.flash.busy() {
            horizon
        } else {
            horizon.min(self.bus.stalled_until)
        };
        self.core.idle(end - now);
        self.load.busy += end - now;
        self.bus.now = end;
    }

    /// The core sleeps until the next event; SysTick is one that only the core knows.
    fn sleep(&mut self, horizon: Cycles) {
        let rest = horizon - self.bus.now;
        let nap = self
            .core
            .cycles_to_systick()
            .map_or(rest, |wake| rest.min(wake));
        self.core.idle(nap);
        self.load.idle += nap;
        self.bus.now += nap;
    }

    /// The core runs until it sleeps, or the machine has to look after something.
    fn run(&mut self, horizon: Cycles) {
        let from = self.bus.now;
        self.bus.horizon = horizon;
        while self.bus.now < self.bus.horizon {
            let cycles = self.core.step_inlined(&mut self.bus);
            if cycles == 0 {
                break;
            }
            self.bus.now += Cycles::from(cycles);
        }
        self.load.busy += self.bus.now - from;
        if self.core.activity() == Activity::Lockup {
            self.note_faults();
        }
    }

    /// As [`run`](Self::run), with an eye on where the core is.
    fn run_probed(&mut self, horizon: Cycles) {
        let from = self.bus.now;
        self.bus.horizon = horizon;
        while self.bus.now < self.bus.horizon {
            let exception = self.core.registers().ipsr();
            let cycles = self.core.step(&mut self.bus);
            if cycles == 0 {
                break;
            }
            let cycles = Cycles::from(cycles);
            self.bus.now += cycles;
            self.probes
                .observe(&self.core, exception, cycles, self.bus.now);
        }
        self.load.busy += self.bus.now - from;
        if self.core.activity() == Activity::Lockup {
            self.note_faults();
        }
    }

    // What is connected to the board. Whatever changes there may concern the core at once.

    /// What the chip drives a pin to.
    ///
    /// # Panics
    /// There are pins 0 to 29 only.
    pub fn output(&self, pin: usize) -> Output {
        self.bus.peripherals.output(pin)
    }

    /// Holds a pin at a level from outside, or leaves it to the chip's pulls.
    ///
    /// # Panics
    /// There are pins 0 to 29 only.
    pub fn set_input(&mut self, pin: usize, level: Option<bool>) {
        self.peripherals_mut().outside[pin] = level;
        self.bus.peripherals.pins_changed(self.bus.now);
    }

    /// The converter, to set its inputs.
    pub fn adc_mut(&mut self) -> &mut Adc {
        &mut self.peripherals_mut().adc
    }

    /// The compass and the bus that it is on (I2C1), to turn the one and break the other.
    pub fn compass_bus_mut(&mut self) -> &mut I2c<Compass> {
        &mut self.peripherals_mut().i2c1
    }

    /// USB: the cable and the host at its end.
    pub fn usb(&self) -> &Usb {
        &self.bus.peripherals.usb
    }

    /// USB, to change something there. Its functions want the time, [`Machine::now`].
    pub fn usb_mut(&mut self) -> &mut Usb {
        &mut self.peripherals_mut().usb
    }

    fn peripherals_mut(&mut self) -> &mut Peripherals {
        self.bus.look();
        &mut self.bus.peripherals
    }

    // What can be seen of it.

    /// The processor.
    pub fn core(&self) -> &Core {
        &self.core
    }

    /// The processor, for a debugger to change its registers.
    pub fn core_mut(&mut self) -> &mut Core {
        self.bus.look();
        &mut self.core
    }

    /// Lets the code outside of interrupts hang from now on: it waits for ever, in the boot ROM,
    /// while interrupts are served as before. Gives false, and does nothing, while the core is in an
    /// interrupt or without power.
    pub fn hang(&mut self) -> bool {
        let handling = self.core.registers().handler_mode();
        if handling || !self.powered {
            return false;
        }
        let rest = super::boot_rom::rest_address();
        self.core_mut().registers_mut().set(super::cpu::PC, rest);
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
        let (memory, start) = if address >= super::memory::RAM {
            (self.bus.memory.ram(), super::memory::RAM)
        } else {
            (self.bus.flash.bytes(), super::bus::FLASH)
        };
        let offset = address.wrapping_sub(start) as usize;
        memory.get(offset..offset.checked_add(size)?)
    }

    /// Changes bytes of the RAM as a debugger does.
    ///
    /// # Errors
    /// They do not lie in the RAM.
    pub fn write_ram(&mut self, address: u32, bytes: &[u8]) -> Result<(), OutsideRam> {
        let offset = address.wrapping_sub(super::memory::RAM) as usize;
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

    /// The flash's bytes, for another board's knowledge, or to spoil them.
    pub fn flash_mut(&mut self) -> &mut [u8] {
        self.bus.flash.bytes_mut()
    }

    /// Operations that the flash has carried out.
    pub fn flash_operations(&self) -> u64 {
        self.bus.flash.operations()
    }

    /// Cuts the power during the flash operation with this number, counted as
    /// [`flash_operations`](Self::flash_operations) does, at a moment within it that the seed
    /// decides, as it decides what is left.
    pub fn cut_power_at(&mut self, operation: u64, seed: u64) {
        self.bus.flash.cut_power_at(operation, seed);
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

    /// The first access to a peripheral that is not emulated, if there was any.
    pub fn unmodelled(&self) -> Option<Unmodelled> {
        self.bus.peripherals.unmodelled()
    }

    /// Measures the calls of the function at this address from now on. While there are probes the
    /// board runs slower.
    pub fn add_probe(&mut self, function: u32) -> ProbeId {
        self.probes.add(function)
    }

    /// What a probe has measured.
    pub fn probe(&self, id: ProbeId) -> &Probe {
        self.probes.get(id)
    }

    /// Takes all probes away.
    pub fn remove_probes(&mut self) {
        self.probes = Probes::default();
    }
}

/// Bytes that are not in the RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{address:#010x} does not lie in the RAM, or not all bytes from there on")]
pub struct OutsideRam {
    /// Where they should go.
    pub address: u32,
}
