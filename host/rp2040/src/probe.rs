//! Measures how many cycles calls of a function take.
//!
//! A call begins when the core is about to execute the function's first instruction. It ends when
//! the core is at the address that was in LR then, with the stack pointer where it was, in the same
//! exception or none: the calling convention (AAPCS) sees to both. Exceptions taken meanwhile are
//! told apart.

use super::cpu::{Core, LR, SP};
use super::peripheral::Cycles;

/// Calls that are kept; later ones are only counted.
const KEPT: usize = 1 << 16;

/// A call that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// When it began.
    pub from: Cycles,
    /// When it returned.
    pub to: Cycles,
    /// Cycles of exceptions in between.
    pub interrupted: Cycles,
}

impl Call {
    /// Cycles that the function took, with all that it called, without exceptions.
    pub const fn cycles(self) -> Cycles {
        self.to - self.from - self.interrupted
    }
}

/// A call that has not returned.
#[derive(Clone, Copy, Debug)]
struct Open {
    from: Cycles,
    interrupted: Cycles,
    return_address: u32,
    stack: u32,
    exception: u32,
}

/// What is known of one function's calls. Of calls within calls the outermost counts.
#[derive(Clone, Debug)]
pub struct Probe {
    function: u32,
    open: Option<Open>,
    calls: Vec<Call>,
    count: u64,
}

impl Probe {
    /// The first calls since they were last taken, 65536 at most.
    pub fn calls(&self) -> &[Call] {
        &self.calls
    }

    /// How many there were in all.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// An instruction or exception entry in this exception took these cycles; the core has not begun
    /// the next one.
    #[inline]
    fn observe(&mut self, core: &Core, exception: u32, cycles: Cycles, now: Cycles) {
        if let Some(open) = &mut self.open {
            let registers = core.registers();
            if exception != open.exception {
                open.interrupted += cycles;
            }
            if core.pc() == open.return_address
                && registers.get(SP) == open.stack
                && registers.ipsr() == open.exception
            {
                let call = Call {
                    from: open.from,
                    to: now,
                    interrupted: open.interrupted,
                };
                self.open = None;
                self.count += 1;
                if self.calls.len() < KEPT {
                    self.calls.push(call);
                }
            }
        }
        if core.pc() == self.function && self.open.is_none() {
            let registers = core.registers();
            self.open = Some(Open {
                from: now,
                interrupted: 0,
                return_address: registers.get(LR) & !1,
                stack: registers.get(SP),
                exception: registers.ipsr(),
            });
        }
    }
}

/// Names a probe of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProbeId(usize);

/// A machine's probes.
#[derive(Clone, Debug, Default)]
pub(super) struct Probes(Vec<Probe>);

impl Probes {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn add(&mut self, function: u32) -> ProbeId {
        self.0.push(Probe {
            function: function & !1,
            open: None,
            calls: Vec::new(),
            count: 0,
        });
        ProbeId(self.0.len() - 1)
    }

    pub fn get(&self, id: ProbeId) -> &Probe {
        &self.0[id.0]
    }

    pub fn take_calls(&mut self, id: ProbeId) -> Vec<Call> {
        std::mem::take(&mut self.0[id.0].calls)
    }

    /// A reset: calls that are open will not return.
    pub fn abandon(&mut self) {
        for probe in &mut self.0 {
            probe.open = None;
        }
    }

    #[inline]
    pub fn observe(&mut self, core: &Core, exception: u32, cycles: Cycles, now: Cycles) {
        for probe in &mut self.0 {
            probe.observe(core, exception, cycles, now);
        }
    }
}
