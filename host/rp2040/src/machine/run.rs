//! Lets time pass: the core runs, sleeps or waits until the next event.

use super::state::Machine;
use crate::cpu::Activity;
use crate::incident::Kind;
use crate::peripheral::Cycles;

impl Machine {
    /// Runs the machine until this moment; an instruction under way then is completed. Without power
    /// only the time goes on.
    pub fn run_until(&mut self, until: Cycles) {
        while self.bus.now < until {
            self.run_to_event(until);
        }
    }

    /// Runs the machine until something may have changed outside of the core, and at most until this
    /// moment: a register was written, or a peripheral did something by itself. Reading the pins
    /// after each such stretch shows every change of them when it happens.
    pub fn run_to_event(&mut self, until: Cycles) {
        if !self.powered {
            self.bus.now = self.bus.now.max(until);
            return;
        }
        let horizon = self.look_after().min(until);
        if horizon <= self.bus.now {
            return;
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

    /// Does what is due, and returns the moment of the next event.
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

    /// SysTick may count the watchdog's tick instead of the core's cycles. It is advanced at events
    /// and reports its next one; in between its counter seems to stand.
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
    // Inlined into its caller, the loop was measured to be a tenth slower.
    #[inline(never)]
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
    #[inline(never)]
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
