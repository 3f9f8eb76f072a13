//! What an emulated rover is measured by.

use std::fmt;

use emulated_rp2040::elf::Image;
use emulated_rp2040::machine::Load;
use emulated_rp2040::peripheral::{CYCLES_PER_MICROSECOND, Cycles};
use serde::Serialize;

use crate::emulation::Emulation;
use crate::profile::{NotFound, Profile};

/// Sizes of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Sizes {
    /// Bytes of the flash that it takes.
    pub flash_bytes: u32,
    /// Bytes of RAM that its variables take, without the stack.
    pub static_ram_bytes: u32,
}

impl Sizes {
    /// The sizes of a program, by its segments.
    pub fn of(image: &Image) -> Self {
        let bytes = |size: usize| size as u32;
        Self {
            flash_bytes: image.segments.iter().map(|s| bytes(s.bytes.len())).sum(),
            static_ram_bytes: image.ram_bytes,
        }
    }
}

/// How long something took that the firmware did many times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Span {
    /// How many times.
    pub times: usize,
    /// Mean cycles, without the interrupts in between.
    pub mean_cycles: f64,
    /// Most cycles.
    pub most_cycles: Cycles,
    /// Mean time in milliseconds, at 125 MHz.
    pub mean_ms: f64,
    /// Longest time in milliseconds.
    pub most_ms: f64,
}

impl Span {
    /// `None` of no times.
    fn of(cycles: impl Iterator<Item = Cycles>) -> Option<Self> {
        let cycles: Vec<Cycles> = cycles.collect();
        let most_cycles = *cycles.iter().max()?;
        let sum: Cycles = cycles.iter().sum();
        let mean_cycles = sum as f64 / cycles.len() as f64;
        let ms = |cycles: f64| cycles / (1_000 * CYCLES_PER_MICROSECOND) as f64;
        Some(Self {
            times: cycles.len(),
            mean_cycles,
            most_cycles,
            mean_ms: ms(mean_cycles),
            most_ms: ms(most_cycles as f64),
        })
    }
}

/// What was measured of a run.
///
/// Neither the flash's cache nor the waiting of the bus is emulated: code that runs from the flash
/// takes as long here as it would from RAM.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EmulationReport {
    /// Emulated seconds.
    pub seconds: f64,
    /// Actions that the board reported.
    pub actions: u32,
    /// Growing one pattern.
    pub perception: Option<Span>,
    /// All computing of one action: sense, learn, perceive, choose.
    pub action_cycle: Option<Span>,
    /// Share of the time that the core was busy.
    pub cpu_load: f64,
    /// The most bytes that were on the stack.
    pub stack_high_water_bytes: Option<u32>,
    /// Bytes that the stack may have.
    pub stack_bytes: Option<u32>,
    /// What the program takes.
    pub sizes: Sizes,
    /// Flash operations, erase or program, since power-up.
    pub flash_operations: u64,
    /// Faults, resets and power cuts of the board.
    pub incidents: u64,
}

impl fmt::Display for EmulationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut span = |name: &str, span: &Option<Span>| match span {
            Some(span) => writeln!(
                f,
                "{name:<28} {:.2} ms ({:.0} cycles), at most {:.2} ms; {} times",
                span.mean_ms, span.mean_cycles, span.most_ms, span.times
            ),
            None => writeln!(f, "{name:<28} did not happen"),
        };
        span("a perception", &self.perception)?;
        span("all computing of an action", &self.action_cycle)?;
        writeln!(
            f,
            "{:<28} {:.1} %",
            "load of the core",
            100.0 * self.cpu_load
        )?;
        if let Some((most, size)) = self.stack_high_water_bytes.zip(self.stack_bytes) {
            writeln!(f, "{:<28} {most} of {size} bytes", "stack, at most")?;
        }
        let Sizes {
            flash_bytes,
            static_ram_bytes,
        } = self.sizes;
        writeln!(f, "{:<28} {flash_bytes} bytes", "flash")?;
        writeln!(f, "{:<28} {static_ram_bytes} bytes", "static RAM")
    }
}

/// Measures a run.
#[derive(Debug)]
pub struct Meter {
    profile: Profile,
    load: Load,
    sizes: Sizes,
}

impl Meter {
    /// Begins to measure. While it does the board runs slower.
    ///
    /// # Errors
    /// The program is not the firmware.
    pub fn new(emulation: &mut Emulation, image: &Image) -> Result<Self, NotFound> {
        Ok(Self {
            profile: Profile::start(emulation.machine_mut(), image)?,
            load: emulation.machine().load(),
            sizes: Sizes::of(image),
        })
    }

    /// What was measured so far.
    pub fn report(&self, emulation: &Emulation) -> EmulationReport {
        let machine = emulation.machine();
        let cycles = self.profile.cycles(machine);
        EmulationReport {
            seconds: emulation.now().0 as f64 / 1e6,
            actions: emulation.progress().actions,
            perception: Span::of(cycles.iter().map(|cycle| cycle.perception)),
            action_cycle: Span::of(cycles.iter().map(|cycle| cycle.whole)),
            cpu_load: machine.load().since(self.load).share(),
            stack_high_water_bytes: machine.stack_high_water(),
            stack_bytes: machine.stack_size(),
            sizes: self.sizes,
            flash_operations: machine.flash_operations(),
            incidents: machine.incidents().count(),
        }
    }
}
