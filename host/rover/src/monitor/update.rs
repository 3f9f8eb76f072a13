//! How each event changes what is shown.

use std::time::Duration;

use rover_shared::contract::{ChannelHealth, Counters, Refusal, State, Task};
use rover_shared::sensing::Sample;
use rover_shared::sensing::ir::FRONT_RIGHT;
use rover_shared::wire::message::{ActionRecord, Command, EventKind, Hello, Report, Status};

use super::feed::{Connection, FeedEvent, Origin};
use super::model::{Action, Dashboard, HISTORY, Knowledge, Moment, Readings, Session, Why};
use crate::lines::{self, Kind};
use rover_link::names;
use rover_log::Entry;
use rover_simulator::experiment::{Ending, TaskKind};

/// How long the readings of a status take precedence over those of an action, microseconds.
const LATELY: u64 = 3_000_000;

impl Dashboard {
    /// Takes an event that came at `now` of the feed's clock.
    pub fn take(&mut self, now: Duration, event: &FeedEvent) {
        self.now = now;
        match event {
            FeedEvent::Connection(connection) => self.connect(connection),
            FeedEvent::Report(report) => {
                self.heard = Some(now);
                self.report(report);
            }
            FeedEvent::Answer { command, result } => {
                self.heard = Some(now);
                self.answer(command, *result);
            }
            FeedEvent::Unanswered { command, reason } => {
                let text = format!("{}: {reason}", names::command(command));
                self.note(Kind::Trouble, text);
            }
            FeedEvent::Frames(counters) => self.frames = *counters,
            FeedEvent::Begin(origin) => self.begin(origin.as_ref()),
            FeedEvent::Knowledge(bytes) => self.learn_all(bytes),
            FeedEvent::Gap(reason) => {
                self.note(Kind::Trouble, format!("a gap: {reason}"));
                (self.state, self.motors_enabled) = (None, None);
            }
            FeedEvent::Logged(entry) => self.logged(entry),
            FeedEvent::Playback(playback) => self.playback = Some(*playback),
        }
    }

    fn connect(&mut self, connection: &Connection) {
        match connection {
            Connection::Open(port) => self.note(Kind::Fact, format!("connected to {port}")),
            Connection::Lost(reason) => {
                self.note(Kind::Trouble, format!("connection lost: {reason}"));
                // What it does meanwhile is not known.
                (self.state, self.motors_enabled) = (None, None);
            }
            _ => {}
        }
        self.connection = connection.clone();
    }

    fn report(&mut self, report: &Report) {
        match report {
            Report::Hello(hello) => self.hello(hello),
            Report::Status(status) => self.status(status),
            Report::Action(record) => self.acted(record),
            Report::Event(event) => {
                self.set_time(event.time.0);
                self.event(event.kind);
            }
            Report::Fault(fault) => {
                self.set_time(fault.time.0);
                if let Some(counter) = self.counters.0.get_mut(fault.fault as usize) {
                    *counter = fault.count;
                }
                // A fault that repeats takes one line.
                let begin = lines::fault_begin(fault);
                let last = self.notes.back();
                if last.is_some_and(|last| last.line.text.starts_with(&begin)) {
                    self.notes.pop_back();
                }
            }
            Report::Ack(_) | Report::Knowledge(_) | Report::LastWords(_) => {}
        }
        if let Some(line) = lines::line(report) {
            self.note_line(line);
        }
    }

    fn hello(&mut self, hello: &Hello) {
        // What was counted before may have been another rover's, or before a reset.
        self.counters = Counters::default();
        (self.state, self.motors_enabled) = (None, None);
        match (hello.knowledge, &self.knowledge) {
            (None, _) => self.knowledge = Knowledge::Unknown(Why::None),
            // Unless it is exactly what was read, it may have learned in the meantime.
            (Some(theirs), Knowledge::Known(mirror))
                if !(mirror.is_exact() && mirror.can_be(theirs)) =>
            {
                self.knowledge = Knowledge::Unknown(Why::Replaced);
            }
            (Some(_), Knowledge::Unknown(Why::None)) => self.knowledge = Knowledge::default(),
            _ => {}
        }
        self.rover = Some(hello.clone());
    }

    fn status(&mut self, status: &Status) {
        self.set_time(status.time.0);
        self.state = Some(status.state);
        self.motors_enabled = Some(status.motors_enabled);
        self.task = Some(status.task);
        self.direction = Some(status.direction);
        self.ranges = Some(status.ranges);
        self.compass = Some(status.compass);
        self.counters = status.counters;
        let [front_left, front_right, ..] = status.distances;
        let fitted = status.ranges[FRONT_RIGHT] != ChannelHealth::NotFitted;
        self.readings = Some(Readings {
            time: Some(status.time.0),
            front: if fitted {
                front_left.min(front_right)
            } else {
                front_left
            },
            distances: status.distances.map(Some),
            counts: Some(status.counts),
            heading: status.heading,
        });
    }

    fn event(&mut self, kind: EventKind) {
        match kind {
            EventKind::State(state) => {
                self.state = Some(state);
                if !matches!(state, State::Driving(_)) {
                    self.motors_enabled = Some(false);
                }
            }
            EventKind::MoveEnded(_) => {}
            EventKind::Direction(direction) => self.direction = Some(direction),
            EventKind::KnowledgeStored { fingerprint } => self.check_knowledge(fingerprint),
            EventKind::Range { channel, health } => {
                let ranges = self.ranges.get_or_insert([ChannelHealth::Unknown; 4]);
                if let Some(place) = ranges.get_mut(usize::from(channel)) {
                    *place = health;
                }
            }
            EventKind::Compass(health) => self.compass = Some(health),
            EventKind::Session {
                mode,
                seed,
                knowledge,
            } => {
                self.check_knowledge(knowledge);
                self.session = Some(Session {
                    mode: Some(mode),
                    seed,
                    knowledge,
                });
            }
        }
    }

    /// The rover's knowledge has this fingerprint now.
    fn check_knowledge(&mut self, fingerprint: u32) {
        if self.mirror().is_some_and(|m| !m.can_be(fingerprint)) {
            self.knowledge = Knowledge::Unknown(Why::Replaced);
        }
        if let Some(rover) = &mut self.rover {
            rover.knowledge = Some(fingerprint);
        }
        if let Knowledge::Unknown(why @ Why::None) = &mut self.knowledge {
            *why = Why::NotRead;
        }
    }

    fn answer(&mut self, command: &Command, result: Result<(), Refusal>) {
        // Not what the dashboard requests by itself.
        if matches!(
            command,
            Command::ReadStatus | Command::PullKnowledge { .. } | Command::Ping
        ) {
            return;
        }
        match result {
            Ok(()) => {
                self.refused = None;
                match command {
                    Command::SetDirection(direction) => self.direction = Some(*direction),
                    Command::SetTask(task) => self.task = Some(*task),
                    Command::NewKnowledge => self.knowledge = Knowledge::Unknown(Why::Replaced),
                    _ => {}
                }
                self.note(Kind::Fact, format!("done: {}", names::command(command)));
            }
            Err(refusal) => {
                self.refused = Some((command.clone(), refusal));
                self.note(Kind::Trouble, lines::refused(command, refusal));
            }
        }
    }

    fn acted(&mut self, record: &ActionRecord) {
        self.set_time(record.time.0);
        self.ranges = Some(record.ranges);
        self.compass = Some(record.compass);
        self.counters = record.counters;
        self.read(Some(record.time.0), Some(record.counts), &record.sample);
        self.stepped(Action {
            sample: record.sample,
            step: record.step,
            outcome: Some(record.outcome),
        });
    }

    /// Takes the readings that an action began with, unless a recent status holds more.
    fn read(&mut self, time: Option<u64>, counts: Option<[u16; 4]>, sample: &Sample) {
        let lately = self.readings.filter(|readings| {
            let (then, now) = (readings.time.unwrap_or(0), time.unwrap_or(0));
            readings.distances.iter().all(Option::is_some) && now < then.saturating_add(LATELY)
        });
        if lately.is_none() {
            self.readings = Some(Readings {
                time,
                front: sample.front,
                distances: [None, None, Some(sample.left), Some(sample.right)],
                counts,
                heading: Some(sample.heading),
            });
        }
    }

    fn logged(&mut self, entry: &Entry) {
        match entry {
            Entry::Step(step) => {
                self.trial = Some(step.trial);
                self.aim(step.task);
                self.read(None, None, &step.sample);
                self.stepped(Action {
                    sample: step.sample,
                    step: step.record,
                    outcome: None,
                });
            }
            Entry::End(end) => {
                if let (Some(learned), Knowledge::Known(mirror)) =
                    (&end.learned, &mut self.knowledge)
                    && mirror.learn(learned).is_err()
                {
                    self.knowledge = Knowledge::Unknown(Why::Missed);
                }
                let how = match end.ending {
                    Ending::Reached => "the target was reached",
                    Ending::OutOfSteps => "all actions were used up",
                };
                self.note(Kind::Fact, format!("trial {} ended: {how}", end.trial));
            }
        }
    }

    fn aim(&mut self, task: TaskKind) {
        (self.task, self.direction) = match task {
            TaskKind::AimAtTarget => (Some(Task::AimAtTarget), None),
            TaskKind::FollowDirection { direction_udeg } => {
                (Some(Task::FollowDirection), Some(direction_udeg))
            }
        };
    }

    fn stepped(&mut self, action: Action) {
        let step = &action.step;
        let before = self.action.map(|before| before.step.step);
        // A smaller number is that of other knowledge, and tells nothing about what was missed.
        let missed = before.map_or(0, |b| step.step.saturating_sub(b).saturating_sub(1));
        if missed > 0 {
            self.missed = self.missed.saturating_add(missed);
            self.remember(None);
        }
        if let Knowledge::Known(mirror) = &mut self.knowledge {
            let why = if step.step > mirror.steps() {
                Why::Missed
            } else {
                Why::Replaced
            };
            if mirror.follow(step).is_err() {
                self.knowledge = Knowledge::Unknown(why);
            }
        }
        self.remember(Some(Moment {
            phase: step.action.phase,
            reward: step.sensed.map(|sensed| sensed.reward.total()),
        }));
        self.action = Some(action);
    }

    fn remember(&mut self, moment: Option<Moment>) {
        if self.history.len() == HISTORY {
            self.history.pop_front();
        }
        self.history.push_back(moment);
    }

    fn begin(&mut self, origin: Option<&Origin>) {
        *self = Self {
            connection: std::mem::take(&mut self.connection),
            playback: self.playback,
            noted: self.noted,
            now: self.now,
            ..Self::default()
        };
        if let Some(Origin { seed, knowledge }) = origin {
            self.learn_all(knowledge);
            self.session = Some(Session {
                mode: None,
                seed: *seed,
                knowledge: rover_shared::checksum::fingerprint(knowledge),
            });
        }
    }
}
