//! Board, vehicle and USB cable in one time: the real firmware drives in the arena.
//!
//! ```text
//!  Machine ──pins──► Vehicle ──counts, bearing──► Machine        1 ms after 1 ms
//!     ▲ │
//!     │ └──bytes──► Cable ──bytes──► a port's program
//!     └────bytes─────  ▲
//!                   faults, by their Schedule
//! ```
//!
//! Everything is repeatable: the same program, arena, seed, faults and bytes from the host give the
//! same run, to the last bit.
//!
//! | file | holds |
//! |---|---|
//! | `wiring` | which pin is wired to what |
//! | `cable` | USB cable and the host's port |
//! | `noise` | what a bad cable does to bytes |
//! | `tasks` | where the firmware's tasks are, to hang them |
//! | `track` | where the vehicle was |
//! | `report` | what was measured: times, loads, sizes |

mod cable;
mod noise;
mod report;
mod tasks;
mod track;
pub mod wiring;

use rover_shared::time::{Duration, Instant};
use rover_shared::wire::frame::Decoder;
use rover_shared::wire::message::Report;

use crate::cmps03::Compass;
use crate::vehicle::{
    Build, CompassAnswer, Fault, Moment, RunProgress, Schedule, ScheduledFault, Vehicle,
};
use cable::Cable;
use emulated_rp2040::elf::Image;
use emulated_rp2040::i2c::LineFault;
use emulated_rp2040::machine::{Machine, OutsideFlash};
use emulated_rp2040::peripheral::{CYCLES_PER_MICROSECOND, Cycles};
use rover_simulator::arena::{Pose, Scenario};
use tasks::Tasks;
use track::Track;
use wiring::{UnknownBoard, Wiring};

pub use report::{EmulationReport, Meter, Sizes, Span};

/// How often board and vehicle see each other.
pub const SLICE: Duration = Duration::from_millis(1);
/// How long the power is away if the fault does not say.
const POWER_AWAY: Duration = Duration::from_millis(100);

/// Why a program cannot be emulated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotEmulated {
    /// It is for no board that is known.
    #[error(transparent)]
    Board(#[from] UnknownBoard),
    /// It does not fit into the flash.
    #[error(transparent)]
    Size(#[from] OutsideFlash),
}

/// An emulated rover.
pub struct Emulation {
    machine: Machine,
    vehicle: Vehicle,
    wiring: Wiring,
    cable: Cable,
    schedule: Schedule,
    tasks: Tasks,
    progress: RunProgress,
    /// When the power comes back.
    power_back: Option<Instant>,
    /// Power cuts in the middle of flash operations, counted from 1, and for how long.
    cuts_of_operations: Vec<(u32, Option<Duration>)>,
    /// Hears what the board says, to count its actions.
    listener: Decoder,
    /// Where the vehicle was, slice by slice, as far back as an action may take.
    track: Track,
    scenario: Scenario,
    seed: u64,
}

impl Emulation {
    /// A rover that has just been switched on at the start of a scenario, its cable plugged in.
    ///
    /// # Errors
    /// The program is for no board that is known, or does not fit into the flash.
    pub fn new(
        image: &Image,
        scenario: &Scenario,
        faults: Schedule,
        seed: u64,
    ) -> Result<Self, NotEmulated> {
        let wiring = Wiring::of(image)?;
        let mut machine = Machine::new(image, seed)?;
        wiring.connect_compass(&mut machine);
        let cable = Cable::new(&mut machine, seed);
        let mut emulation = Self {
            vehicle: Vehicle::new(scenario, &Build::ROVER, seed),
            wiring,
            cable,
            schedule: faults,
            tasks: Tasks::of(image),
            progress: RunProgress::default(),
            power_back: None,
            cuts_of_operations: Vec::new(),
            listener: Decoder::new(),
            track: Track::default(),
            scenario: scenario.clone(),
            machine,
            seed,
        };
        emulation.order_cuts_of_operations();
        emulation.sense();
        Ok(emulation)
    }

    /// Time since the board was first switched on.
    pub fn now(&self) -> Instant {
        self.progress.time
    }

    /// The board.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The board, to look into it or to spoil it.
    pub fn machine_mut(&mut self) -> &mut Machine {
        &mut self.machine
    }

    /// The vehicle.
    pub fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// The vehicle, to lift it.
    pub fn vehicle_mut(&mut self) -> &mut Vehicle {
        &mut self.vehicle
    }

    /// How far the run has come.
    pub const fn progress(&self) -> &RunProgress {
        &self.progress
    }

    /// Adds faults to those still to come.
    pub fn add_faults(&mut self, faults: &[ScheduledFault]) {
        self.schedule.extend(faults);
        self.order_cuts_of_operations();
    }

    /// No slice's end would meet the middle of an operation: the flash cuts the power itself.
    fn order_cuts_of_operations(&mut self) {
        for (number, lasts) in self.schedule.take_cuts_of_operations() {
            // What was carried out before is not to be cut any more.
            let operation = u64::from(number.saturating_sub(1));
            self.machine
                .cut_power_at(operation, self.seed ^ u64::from(number));
            self.cuts_of_operations.push((number, lasts));
        }
    }

    /// Where the rover was switched on, and what stands around it.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Whether the motors get any current now.
    pub fn motors_driven(&self) -> bool {
        self.wiring.motors_driven(&self.machine)
    }

    /// Where the vehicle was at a moment of the board's clock; `None` if that is too long ago or
    /// still to come. The clock begins anew with every reset of the board.
    pub fn pose_at(&self, board_time: Instant) -> Option<Pose> {
        self.track.pose_at(board_time)
    }

    /// Faults that have not come about yet.
    pub fn outstanding(&self) -> Vec<ScheduledFault> {
        let done = self.machine.flash_operations();
        let cuts = self.cuts_of_operations.iter().copied();
        let cuts = cuts
            .filter(|(number, _)| u64::from(*number) > done)
            .map(|(number, lasts)| ScheduledFault {
                at: Moment::FlashOperation(number),
                lasts,
                fault: Fault::PowerCut,
            });
        cuts.chain(self.schedule.waiting().iter().copied())
            .collect()
    }

    /// What the board is doing, for whoever wonders why nothing happens.
    pub fn whereabouts(&self) -> String {
        let faults = self.schedule.active();
        let mut text = self.whereabouts_of_core();
        if !faults.is_empty() {
            let faults: Vec<_> = faults.iter().map(ToString::to_string).collect();
            text.push_str(&format!("; faults at work: {}", faults.join(", ")));
        }
        text
    }

    fn whereabouts_of_core(&self) -> String {
        if !self.machine.powered() {
            return "it is without power".into();
        }
        let core = self.machine.core();
        let last = self.machine.incidents().first().last();
        let incident = last.map_or("nothing went wrong before".into(), |incident| {
            format!(
                "before, at {:.3} s: {:?}",
                (incident.at / CYCLES_PER_MICROSECOND) as f64 / 1e6,
                incident.kind
            )
        });
        format!(
            "its core is at {:#010x}, {:?}; {incident}",
            core.pc(),
            core.activity()
        )
    }

    // The port.

    /// Opens or closes the host's port.
    pub fn set_open(&mut self, open: bool) {
        self.cable.set_open(&mut self.machine, open);
    }

    /// Whether the host's port is open.
    pub const fn is_open(&self) -> bool {
        self.cable.is_open()
    }

    /// Whether the port is open and the board has heard of it.
    pub fn connected(&self) -> bool {
        self.cable.connected(&self.machine)
    }

    /// Whether there is a port to open: the cable is in, and the board answers.
    pub fn port_exists(&self) -> bool {
        self.cable.found(&self.machine)
    }

    /// Queues bytes for the board.
    pub fn send(&mut self, bytes: &[u8]) {
        self.cable.send(bytes);
    }

    /// Bytes that the board has not taken yet.
    pub fn unsent(&self) -> usize {
        self.cable.unsent(&self.machine)
    }

    /// Takes what the board has sent.
    pub fn receive(&mut self, buffer: &mut [u8]) -> usize {
        self.cable.receive(buffer)
    }

    // Time.

    /// Lets a span pass, in whole slices.
    pub fn run(&mut self, span: Duration) {
        let until = self.now().after(span);
        while self.now() < until {
            self.slice();
        }
    }

    /// Lets slices pass until something is so, for `span` at most; gives whether it is.
    pub fn run_until(&mut self, span: Duration, mut done: impl FnMut(&Self) -> bool) -> bool {
        let until = self.now().after(span);
        while !done(self) {
            if self.now() >= until {
                return false;
            }
            self.slice();
        }
        true
    }

    /// Lets one slice pass.
    pub fn slice(&mut self) {
        self.apply_faults();
        self.tasks.keep(&mut self.machine);
        self.vehicle
            .advance(SLICE, self.wiring.motor_pins(&self.machine));
        self.sense();
        self.progress.time = self.progress.time.after(SLICE);
        self.machine.run_until(cycles(self.progress.time));
        self.note_power_cut();
        let said = self.cable.carry(&mut self.machine);
        for byte in said {
            if let Some(Ok(frame)) = self.listener.push::<Report>(byte)
                && matches!(frame.message, Report::Action(_))
            {
                self.progress.actions += 1;
            }
        }
        let begun = self.machine.flash_operations() + u64::from(self.machine.flash_busy());
        self.progress.flash_operations = u32::try_from(begun).unwrap_or(u32::MAX);
        self.track
            .note(Instant(self.machine.timer_us()), self.vehicle.pose());
    }

    /// What the vehicle's sensors give to the board.
    fn sense(&mut self) {
        self.wiring
            .set_ranges(&mut self.machine, self.vehicle.counts(0));
        let now = self.machine.now();
        let (registers, fault) = match self.vehicle.compass() {
            CompassAnswer::Registers(registers) => (Some(registers), LineFault::None),
            CompassAnswer::Silent => (None, LineFault::None),
            CompassAnswer::Stuck => (None, LineFault::DataLow),
        };
        let bus = self.machine.i2c_mut(self.wiring.compass_controller());
        if let Some(compass) = bus.device_mut::<Compass>() {
            compass.set_registers(registers);
        }
        if bus.fault() != fault {
            bus.set_fault(fault, now);
        }
    }

    fn apply_faults(&mut self) {
        if self.power_back.is_some_and(|at| self.now() >= at) {
            self.power_back = None;
            self.machine.power_on();
        }
        let changes = self.schedule.update(&self.progress);
        if changes.is_empty() {
            return;
        }
        for (fault, lasts) in changes.began {
            match fault {
                Fault::PowerCut => {
                    self.machine.power_off();
                    self.power_back = Some(self.now().after(lasts.unwrap_or(POWER_AWAY)));
                }
                Fault::BrownOut => self.machine.brown_out(),
                fault => self.set_fault(fault, true),
            }
        }
        for fault in changes.ended {
            self.set_fault(fault, false);
        }
        self.vehicle.set_faults(&self.schedule.active());
    }

    fn set_fault(&mut self, fault: Fault, on: bool) {
        match fault {
            Fault::TaskHang(of) => self.tasks.hang(&mut self.machine, of, on),
            Fault::FlashSlow => self.machine.set_flash_slow(on),
            Fault::ControlOverrun => self.tasks.overrun(&mut self.machine, on),
            fault => self.cable.set_fault(&mut self.machine, fault, on),
        }
    }

    /// The power was cut in the middle of a flash operation.
    fn note_power_cut(&mut self) {
        if !self.machine.powered() && self.power_back.is_none() {
            let ended = self.machine.flash_operations();
            let lasts = self
                .cuts_of_operations
                .iter()
                .find(|(number, _)| u64::from(*number) == ended)
                .and_then(|(_, lasts)| *lasts);
            self.power_back = Some(self.now().after(lasts.unwrap_or(POWER_AWAY)));
        }
    }

    /// What decides all chance.
    pub const fn seed(&self) -> u64 {
        self.seed
    }
}

/// A moment in cycles.
fn cycles(at: Instant) -> Cycles {
    at.0 * CYCLES_PER_MICROSECOND
}
