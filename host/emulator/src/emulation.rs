//! Board, vehicle and USB cable in one time: the real firmware drives in the arena.

use emulated_rp2040::elf::Image;
use emulated_rp2040::i2c::LineFault;
use emulated_rp2040::machine::{Machine, OutsideFlash};
use emulated_rp2040::peripheral::CYCLES_PER_MICROSECOND;
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::frame::Decoder;
use rover_shared::wire::message::Report;
use rover_simulator::arena::{Pose, Scenario};

use crate::cable::Cable;
use crate::cmps03::Compass;
use crate::tasks::Tasks;
use crate::track::Track;
use crate::vehicle::{
    Build, CompassAnswer, Fault, Moment, RunProgress, Schedule, ScheduledFault, Vehicle,
};
use crate::whereabouts::whereabouts;
use crate::wiring::{UnknownBoard, Wiring};

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
    /// Decodes what the board sends, to count its actions.
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

    /// The board, to inspect or to damage it.
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

    /// Orders power cuts in the middle of flash operations: no slice ends there, so that the flash
    /// has to cut the power itself.
    fn order_cuts_of_operations(&mut self) {
        for (number, lasts) in self.schedule.take_cuts_of_operations() {
            // Operations already done cannot be cut any more.
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

    /// Whether any current flows through the motors now.
    pub fn motors_driven(&self) -> bool {
        self.wiring.motors_driven(&self.machine)
    }

    /// Where the vehicle was at a moment of the board's clock; `None` if that is too long ago or
    /// still to come. The clock begins anew with every reset of the board.
    pub fn pose_at(&self, board_time: Instant) -> Option<Pose> {
        self.track.pose_at(board_time)
    }

    /// Faults that have not begun yet.
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

    /// What the board is doing, in words: why nothing happens.
    pub fn whereabouts(&self) -> String {
        whereabouts(&self.machine, &self.schedule.active())
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

    /// Whether the port is open and the board knows that it is.
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

    /// Moves what the board has sent into `buffer`; returns how many bytes.
    pub fn receive(&mut self, buffer: &mut [u8]) -> usize {
        self.cable.receive(buffer)
    }

    // Time.

    /// Runs for a span, in whole slices.
    pub fn run(&mut self, span: Duration) {
        let until = self.now().after(span);
        while self.now() < until {
            self.slice();
        }
    }

    /// Runs until `done`, for `span` at most; returns whether it was reached.
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

    /// Runs for one slice: the order is that of the crate's documentation.
    fn slice(&mut self) {
        self.apply_faults();
        self.tasks.keep(&mut self.machine);
        self.vehicle
            .advance(SLICE, self.wiring.motor_pins(&self.machine));
        self.sense();
        self.progress.time = self.progress.time.after(SLICE);
        self.machine
            .run_until(self.progress.time.0 * CYCLES_PER_MICROSECOND);
        self.note_power_cut();
        for byte in self.cable.carry(&mut self.machine) {
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

    /// Puts what the vehicle's sensors say on the board's inputs.
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
            self.set_fault(fault, true, lasts);
        }
        for fault in changes.ended {
            self.set_fault(fault, false, None);
        }
    }

    /// Begins or ends a fault at the part that it concerns: where each one is injected.
    fn set_fault(&mut self, fault: Fault, on: bool, lasts: Option<Duration>) {
        let machine = &mut self.machine;
        match fault {
            Fault::IrOpen(_)
            | Fault::IrShorted(_)
            | Fault::IrFrozen(_)
            | Fault::IrNoisy(_)
            | Fault::CompassSilent
            | Fault::CompassStuck
            | Fault::CompassGarbage
            | Fault::CompassRotated
            | Fault::MotorDead(_)
            | Fault::WheelsSlipping(_) => self.vehicle.set_faults(&self.schedule.active()),
            Fault::UsbUnplugged
            | Fault::UsbDeaf
            | Fault::UsbGarbageIn
            | Fault::UsbGarbageOut
            | Fault::UsbTruncatedIn
            | Fault::UsbTruncatedOut => self.cable.set_fault(machine, fault, on),
            Fault::TaskHang(of) => self.tasks.hang(machine, of, on),
            Fault::ControlOverrun => self.tasks.overrun(machine, on),
            Fault::FlashSlow => machine.set_flash_slow(on),
            // These two are momentary: they begin and never end.
            Fault::PowerCut => {
                machine.power_off();
                self.power_back = Some(self.now().after(lasts.unwrap_or(POWER_AWAY)));
            }
            Fault::BrownOut => machine.brown_out(),
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
}
