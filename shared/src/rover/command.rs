//! The host's commands.

use heapless::String;

use super::Rover;
use super::observation::Observation;
use super::state::{Activity, Conversation};
use super::supervision::{Supervision, must_be_disarmed, must_not_drive};
use crate::contract::{Calibration, Mode, Refusal, State, Task};
use crate::motion::StartError;
use crate::sensing::ir::AdcCount;
use crate::supervisor::Input;
use crate::time::Instant;
use crate::units::{Microdegrees, Micrometres};
use crate::wire::SCHEMA_HASH;
use crate::wire::message::{Command, Hello, NAME_BYTES, Report, Status};

impl Rover<'_> {
    /// Executes a command. Returns the result to acknowledge, and the report asked for.
    pub fn handle(
        &mut self,
        now: Instant,
        command: &Command,
        seen: &Observation,
        watch: &mut impl Supervision,
    ) -> (Result<(), Refusal>, Option<Report>) {
        match self.answer(now, command, seen, watch) {
            Ok(report) => (Ok(()), report),
            // A host of another contract should still learn which rover this is.
            Err(Refusal::SchemaMismatch) => (Err(Refusal::SchemaMismatch), Some(self.hello(watch))),
            Err(refusal) => (Err(refusal), None),
        }
    }

    /// Whether a host of the same contract is connected: only then can it decode reports.
    pub fn talks(&self) -> bool {
        self.conversation == Conversation::Open
    }

    /// The host has closed the connection.
    pub fn closed(&mut self) {
        self.conversation = Conversation::Closed;
    }

    /// The rover's identity and how it started.
    pub fn hello(&mut self, watch: &mut impl Supervision) -> Report {
        let name = |text: &str| {
            let mut name = String::<NAME_BYTES>::new();
            // A name that is too long is cut off.
            for character in text.chars() {
                if name.push(character).is_err() {
                    break;
                }
            }
            name
        };
        Report::Hello(Hello {
            schema: SCHEMA_HASH,
            board: name(self.identity.board),
            firmware: name(self.identity.firmware),
            reset: watch.view().reset,
            seed: self.seed,
            knowledge: self.valid.then(|| self.current().1),
        })
    }

    fn answer(
        &mut self,
        now: Instant,
        command: &Command,
        seen: &Observation,
        watch: &mut impl Supervision,
    ) -> Result<Option<Report>, Refusal> {
        match command {
            Command::Hello { schema } => return self.open(*schema, watch).map(Some),
            // Stopping needs no hello.
            Command::Disarm => return watch.handle(Input::Disarm).map(|()| None),
            _ => {}
        }
        match self.conversation {
            Conversation::Open => {}
            Conversation::Closed => return Err(Refusal::NoHello),
            Conversation::Mismatch => return Err(Refusal::SchemaMismatch),
        }
        match command {
            Command::Hello { .. } | Command::Disarm | Command::Ping => {}
            Command::Heartbeat => watch.handle(Input::Heartbeat)?,
            Command::Arm => watch.handle(Input::Arm)?,
            Command::SetMode(mode) => watch.handle(Input::SetMode(*mode))?,
            Command::SetTask(task) => self.set_task(*task)?,
            Command::SetDirection(direction) => self.set_direction(*direction)?,
            Command::Drive { turn, advance } => self.drive_host(*turn, *advance, watch)?,
            Command::SetSeed(seed) => self.set_seed(*seed, watch)?,
            Command::Calibrate(calibration) => self.calibrate(calibration, watch)?,
            Command::ReadStatus => return Ok(Some(self.status(now, seen, watch))),
            Command::PullKnowledge { offset } => return self.pull(*offset, watch).map(Some),
            Command::PushKnowledge(chunk) => self.push(chunk, watch)?,
            Command::StoreKnowledge => self.save_knowledge(watch)?,
            Command::NewKnowledge => {
                must_be_disarmed(watch)?;
                self.must_not_save()?;
                self.begin();
                self.announce(watch);
            }
        }
        Ok(None)
    }

    fn open(&mut self, schema: u32, watch: &mut impl Supervision) -> Result<Report, Refusal> {
        let matches = schema == SCHEMA_HASH;
        self.conversation = if matches {
            Conversation::Open
        } else {
            Conversation::Mismatch
        };
        watch.handle(Input::Hello { matches })?;
        if matches {
            Ok(self.hello(watch))
        } else {
            Err(Refusal::SchemaMismatch)
        }
    }

    fn set_task(&mut self, task: Task) -> Result<(), Refusal> {
        if task == Task::AimAtTarget {
            // This rover senses no target.
            return Err(Refusal::Unsupported);
        }
        self.task = task;
        Ok(())
    }

    fn set_direction(&mut self, direction: Microdegrees) -> Result<(), Refusal> {
        if Microdegrees::wrapped(direction.0.into()) != direction {
            return Err(Refusal::OutOfRange);
        }
        self.redirected |= direction != self.direction;
        self.direction = direction;
        Ok(())
    }

    fn set_seed(&mut self, seed: u64, watch: &mut impl Supervision) -> Result<(), Refusal> {
        // A session has one seed, or it could not be replayed.
        must_not_drive(watch)?;
        self.seed = seed;
        self.chosen = true;
        Ok(())
    }

    fn drive_host(
        &mut self,
        turn: Microdegrees,
        advance: Micrometres,
        watch: &mut impl Supervision,
    ) -> Result<(), Refusal> {
        if watch.view().state != State::Driving(Mode::Host) {
            return Err(Refusal::NotHostDriven);
        }
        self.motion
            .start(turn, advance)
            .map_err(|error| match error {
                StartError::UnderWay => Refusal::MoveUnderWay,
                StartError::OutOfRange => Refusal::OutOfRange,
            })?;
        self.activity = Activity::Driven;
        Ok(())
    }

    fn calibrate(
        &mut self,
        calibration: &Calibration,
        watch: &mut impl Supervision,
    ) -> Result<(), Refusal> {
        must_be_disarmed(watch)?;
        self.calibrations.apply(calibration)?;
        self.adjust_motion();
        self.saving.calibrations = true;
        Ok(())
    }

    pub(super) fn adjust_motion(&mut self) {
        let motion = self.calibrations.motion;
        let (duty, speed, dead_band) = (motion.cruise, motion.cruise_speed, motion.dead_band);
        // Calibrations only take numbers that fit.
        let adjusted = self.motion.calibrate_speed(duty, speed, dead_band);
        debug_assert_eq!(adjusted, Ok(()));
    }

    fn status(&mut self, now: Instant, seen: &Observation, watch: &mut impl Supervision) -> Report {
        let view = watch.view();
        Report::Status(Status {
            time: now,
            state: view.state,
            motors_enabled: view.motors_enabled,
            task: self.task,
            direction: self.direction,
            steps: self.steps,
            counts: seen.ir.counts.map(AdcCount::get),
            distances: seen.ir.distances,
            heading: seen.heading,
            ranges: seen.ir.health,
            compass: seen.compass,
            counters: view.counters,
        })
    }
}
