//! An emulated rover in a room of 5 m, with a host at its port.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::LazyLock;

use emulated_rp2040::elf::Image;
use rover_emulator::vehicle::{Schedule, ScheduledFault};
use rover_emulator::{EmulatedPort, Emulation, SLICE};
use rover_link::{Client, LinkError};
use rover_shared::contract::{Counters, Fault, Mode, Outcome, Refusal, State, Task};
use rover_shared::time::{Duration, Instant};
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::{ActionRecord, Command, Event, EventKind, Report, Status};
use rover_simulator::arena::{ArenaSource, Pose, Scenario};
use rover_simulator::experiment::{Stream, generator};

use super::thumb;

/// The firmware as it is flashed.
pub static FIRMWARE: LazyLock<Image> = LazyLock::new(|| {
    let path = thumb::build("rover-firmware", "firmware", "");
    let file = std::fs::read(path).expect("the firmware was built");
    Image::parse(&file).expect("the firmware is an ELF file")
});

pub const fn ms(ms: u32) -> Duration {
    Duration::from_millis(ms)
}

/// A scenario in the empty middle of the room of 5 m, pointing along its free diagonal.
pub fn room() -> Scenario {
    let arenas = ArenaSource::named("rover-5m").expect("an arena that is known");
    let mut scenario = arenas.scenario(&mut generator(1, Stream::Learning));
    scenario.start = Pose {
        x_cm: 330.0,
        y_cm: 120.0,
        heading: Microdegrees::from_degrees(90),
    };
    scenario
}

pub struct Bench {
    pub rover: Rc<RefCell<Emulation>>,
    pub client: Client,
    pub heard: Vec<Report>,
}

impl Bench {
    /// A rover whose sensors have settled, and that was introduced. Times of faults count from
    /// power-up.
    pub fn new(faults: &[&str]) -> Self {
        Self::in_scenario(&room(), faults)
    }

    pub fn in_scenario(scenario: &Scenario, faults: &[&str]) -> Self {
        let faults = faults.iter().map(|fault| fault.parse().expect(fault));
        let schedule = Schedule::new(faults.collect::<Vec<ScheduledFault>>());
        let rover = Emulation::new(&FIRMWARE, scenario, schedule, 1).expect("fits");
        let rover = Rc::new(RefCell::new(rover));
        let port = EmulatedPort::open(Rc::clone(&rover)).expect("the board appears");
        let client = Client::open(Box::new(port)).expect("the rover answers");
        let mut bench = Self {
            rover,
            client,
            heard: Vec::new(),
        };
        bench.wait(ms(1_000));
        bench.done(Command::SetSeed(7));
        bench
    }

    /// One that drives by itself and has begun its first move.
    pub fn driving(mode: Mode, faults: &[&str]) -> Self {
        let mut bench = Self::new(faults);
        bench.drive(mode);
        bench
    }

    pub fn drive(&mut self, mode: Mode) {
        self.done(Command::SetTask(Task::FollowDirection));
        self.done(Command::SetDirection(Microdegrees::from_degrees(90)));
        self.done(Command::Arm);
        self.done(Command::SetMode(mode));
        assert!(self.driven_within(ms(1_000)), "nothing moves");
    }

    pub fn done(&mut self, command: Command) {
        self.client
            .ask(&command)
            .unwrap_or_else(|error| panic!("{command:?}: {error}"));
    }

    pub fn refused(&mut self, command: Command) -> Refusal {
        match self.client.ask(&command) {
            Err(LinkError::Refused { refusal, .. }) => refusal,
            other => panic!("{command:?} is to be refused: {other:?}"),
        }
    }

    pub fn status(&mut self) -> Status {
        self.client.status().expect("the rover answers")
    }

    pub fn count(&mut self, fault: Fault) -> u32 {
        let Counters(counters) = self.status().counters;
        counters[fault as usize]
    }

    pub fn now(&self) -> Instant {
        self.rover.borrow().now()
    }

    /// Adds faults, their times from now.
    pub fn fault(&mut self, fault: &str) {
        let now = self.now().0 as f64 / 1e6;
        let (when, what) = fault.split_once(':').expect("AT:WHAT");
        let (at, lasts) = when.split_once('+').unwrap_or((when, ""));
        let at: f64 = at.parse().expect("seconds");
        let plus = if lasts.is_empty() { "" } else { "+" };
        let fault = format!("{}{plus}{lasts}:{what}", now + at);
        let fault = fault
            .parse()
            .unwrap_or_else(|error| panic!("{fault}: {error}"));
        self.rover.borrow_mut().add_faults(&[fault]);
    }

    /// Lets time pass without anybody reading.
    pub fn run(&mut self, span: Duration) {
        self.rover.borrow_mut().run(span);
    }

    /// Listens for a span; what was said is kept.
    pub fn wait(&mut self, span: Duration) {
        let until = self.client.now().after(span);
        while self.client.now() < until {
            let left = until.since(self.client.now());
            match self.client.next(left) {
                Ok(Some(received)) => self.heard.push(received.report),
                Ok(None) => {}
                Err(error) => panic!("the connection failed: {error}"),
            }
        }
    }

    /// Connects again after the board or the cable was away.
    pub fn reconnect(&mut self) {
        self.client
            .reconnect(ms(10_000), &|| false)
            .expect("the rover comes back");
    }

    pub fn driven_within(&mut self, span: Duration) -> bool {
        let mut rover = self.rover.borrow_mut();
        rover.run_until(span, Emulation::motors_driven)
    }

    /// How long from now the motors are driven for the last time within a span: the time within
    /// which they stopped for good.
    pub fn driven_last(&mut self, span: Duration) -> Duration {
        let mut rover = self.rover.borrow_mut();
        let began = rover.now();
        let mut last = Duration::ZERO;
        while rover.now().since(began) < span {
            if rover.motors_driven() {
                last = rover.now().since(began);
            }
            rover.run(SLICE);
        }
        last
    }

    /// Asserts that the motors stop within `promise` and stay off for `span`.
    pub fn stops_within(&mut self, promise: Duration, span: Duration) {
        let last = self.driven_last(span);
        assert!(
            last <= promise,
            "the motors were driven for {} ms after, promised are {} ms",
            last.0 / 1_000,
            promise.0 / 1_000
        );
    }

    /// The events heard since the last call.
    pub fn events(&mut self) -> Vec<EventKind> {
        let heard = std::mem::take(&mut self.heard);
        let kind = |report: Report| match report {
            Report::Event(Event { kind, .. }) => Some(kind),
            _ => None,
        };
        heard.into_iter().filter_map(kind).collect()
    }

    /// The actions heard since the last call.
    pub fn actions(&mut self) -> Vec<ActionRecord> {
        let heard = std::mem::take(&mut self.heard);
        let action = |report: Report| match report {
            Report::Action(action) => Some(action),
            _ => None,
        };
        heard.into_iter().filter_map(action).collect()
    }

    /// How the actions heard since the last call ended.
    pub fn outcomes(&mut self) -> Vec<Outcome> {
        let actions = self.actions().into_iter();
        actions.map(|action| action.outcome).collect()
    }

    /// A move for a host that drives, with heartbeats.
    pub fn host_drives(&mut self, turn_deg: i32, advance_cm: u32) {
        self.done(Command::Arm);
        self.client.send_heartbeats(true).expect("heard");
        self.done(Command::SetMode(Mode::Host));
        self.done(Command::Drive {
            turn: Microdegrees::from_degrees(turn_deg),
            advance: Micrometres::from_cm(advance_cm),
        });
        assert!(self.driven_within(ms(1_000)), "nothing moves");
    }

    pub fn disarmed(&mut self) {
        assert_eq!(self.status().state, State::Disarmed);
        assert!(!self.rover.borrow().motors_driven());
    }
}
