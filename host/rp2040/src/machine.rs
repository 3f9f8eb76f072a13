//! The machine: core, bus and peripherals in one time, and what resets them.
//!
//! [`Machine::run_until`] is all there is to do. While the core runs, only writes to registers and
//! events (an alarm, a conversion's end, a packet) make the machine look after the peripherals;
//! while it sleeps, time goes straight to the next event.

mod access;
mod power;
#[cfg(test)]
mod tests;

use super::bus::SystemBus;
use super::cpu::{Activity, Core, FaultReport};
use super::elf::Image;
use super::incident::{Incidents, Kind};
use super::peripheral::Cycles;
use super::probe::Probes;
use super::stack::Stack;

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
    /// Ticks of the reference clock that SysTick was told of.
    reference_ticks: u64,
    load: Load,
    stack: Option<Stack>,
    probes: Probes,
    incidents: Incidents,
    /// The last fault that was noted.
    fault: Option<FaultReport>,
}

/// Bytes that are not in the RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{address:#010x} does not lie in the RAM, or not all bytes from there on")]
pub struct OutsideRam {
    /// Where they should go.
    pub address: u32,
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
            self.note(Kind::Requested);
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
            self.count_reference_ticks(),
        ];
        events.into_iter().flatten().min().unwrap_or(Cycles::MAX)
    }

    /// SysTick may count the watchdog's tick instead of the core's cycles. It is told of it at events
    /// and gives its own; between them its counter seems to stand.
    fn count_reference_ticks(&mut self) -> Option<Cycles> {
        let tick = self.bus.peripherals.watchdog.tick();
        let ticks = tick.ticks_in(self.bus.now);
        let passed = ticks.saturating_sub(self.reference_ticks);
        self.reference_ticks = ticks;
        self.core.tick_reference(passed);
        tick.time_of(ticks + self.core.reference_ticks_to_systick()?)
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
            self.note(kind);
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

    /// The core, which is awake, runs until it sleeps, or the machine has to look after something.
    fn run(&mut self, horizon: Cycles) {
        let from = self.bus.now;
        self.bus.horizon = horizon;
        while self.bus.now < self.bus.horizon {
            let cycles = self.core.step_awake(&mut self.bus);
            if cycles == 0 {
                break;
            }
            self.bus.now += Cycles::from(cycles);
            if !self.core.is_plain() {
                continue;
            }
            // Here the time is spent, so that nothing is looked at again that has to show itself.
            while self.bus.now < self.bus.horizon && !self.core.has_attention() {
                self.bus.now += Cycles::from(self.core.step_plain(&mut self.bus));
            }
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
}
