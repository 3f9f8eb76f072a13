//! Sessions: what logs of simulations and recordings of rovers have in common.
//!
//! A session is all that the controller did from one seed: it can be replayed from the knowledge
//! it started from. A simulation's log holds one. In a recording one begins with each event
//! `Session`, and ends when the rover stops driving; lost frames, or reports that the rover
//! dropped, end what can be replayed of it. Actions after such a gap belong to a session of which
//! only the actions are known.

use std::collections::BTreeSet;
use std::sync::Arc;

use rover_shared::contract::{self, Counters, Fault, Outcome, State};
use rover_shared::controller::StepRecord;
use rover_shared::learning::Mode;
use rover_shared::rover::interrupts;
use rover_shared::sensing::Sample;
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{self, ActionRecord, EventKind, Report};

use crate::arena::Arena;
use crate::error::ReadError;
use crate::log::{Entry, Log, Origin};
use crate::message::Step;
use crate::recording::{Recorded, Recording, Truth, What};
use rover_simulator::arena::Motion;
use rover_simulator::experiment::TaskKind;

/// All sessions of a log or recording.
#[derive(Clone, Debug)]
pub struct Sessions {
    /// Who wrote it: program and version.
    pub writer: String,
    /// In the order in which they were driven.
    pub sessions: Vec<Session>,
    /// Where an emulated rover drove; of a simulation's log the arenas are in [`Log`] only.
    pub arena: Option<Arena>,
    /// Whether the file ends before the log does.
    pub cut_off: bool,
}

/// What the controller did from one seed.
#[derive(Clone, Debug, Default)]
pub struct Session {
    /// What it started from; `None` if its beginning is not in the log.
    pub origin: Option<Beginning>,
    /// The messages it consists of, with their numbers in the log.
    pub entries: Vec<(usize, Entry)>,
    /// What was known at its end, if the log says so.
    pub after: Option<Knowledge>,
    /// The number of the message before which something is missing, and what.
    pub gap: Option<(usize, String)>,
    /// The rover stopped driving, or the log was finished.
    pub over: bool,
}

/// What a session started from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Beginning {
    /// The seed of the controller's generator.
    pub seed: u64,
    /// Whether the controller learned.
    pub mode: Mode,
    /// What was known.
    pub before: Knowledge,
}

/// What was known at some moment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// This, as bytes; sessions that start from the same share them.
    Bytes(Arc<[u8]>),
    /// What has this fingerprint, and is not in the log.
    Named(u32),
}

impl Sessions {
    /// Reads a log of a simulation, or a recording, which may have several files.
    ///
    /// # Errors
    /// If one of the files is neither, or damaged.
    pub fn read(files: &[impl AsRef<[u8]>]) -> Result<Self, ReadError> {
        match files {
            [file] if !Recording::is_one(file.as_ref()) => {
                Ok(Log::of_simulation(file.as_ref())?.into())
            }
            _ => Ok(Recording::read(files)?.into()),
        }
    }
}

impl Log {
    /// Reads a log from the contents of its file. A log that was cut off is read up to the cut. Of a
    /// rover's recording the sessions stand for the trials, from the first that begins in it.
    ///
    /// # Errors
    /// If it is no log that can be read, or damaged.
    pub fn read(file: &[u8]) -> Result<Self, ReadError> {
        Self::read_parts(&[file])
    }

    /// Reads a log, or a recording that has several files, in order.
    ///
    /// # Errors
    /// As [`read`](Self::read); also if there are several files and they are no recording's.
    pub fn read_parts(files: &[impl AsRef<[u8]>]) -> Result<Self, ReadError> {
        match files {
            [file] if !Recording::is_one(file.as_ref()) => Self::of_simulation(file.as_ref()),
            _ => Sessions::from(Recording::read(files)?).try_into(),
        }
    }
}

impl From<Log> for Sessions {
    fn from(log: Log) -> Self {
        let beginning = Beginning {
            seed: log.origin.seed,
            mode: log.origin.mode,
            before: Knowledge::Bytes(log.before.into()),
        };
        let whole = log.after.is_some() && !log.cut_off;
        let session = Session {
            origin: Some(beginning),
            entries: (1..).zip(log.entries).collect(),
            after: log
                .after
                .filter(|_| !log.cut_off)
                .map(|bytes| Knowledge::Bytes(bytes.into())),
            gap: None,
            over: whole,
        };
        Self {
            writer: log.origin.writer,
            sessions: vec![session],
            arena: None,
            cut_off: log.cut_off,
        }
    }
}

impl From<Recording> for Sessions {
    fn from(recording: Recording) -> Self {
        let mut assembler = Assembler {
            recording: &recording,
            sessions: Vec::new(),
            open: None,
            direction: None,
            interrupted: true,
            dropped: None,
            truth: None,
        };
        for message in &recording.messages {
            assembler.take(message);
        }
        assembler.close();
        let sessions = assembler.sessions;
        Self {
            sessions,
            arena: recording.arena,
            writer: recording.writer,
            cut_off: recording.cut_off,
        }
    }
}

/// A recording as if its sessions were the trials of one: for all that looks at what was done, and
/// does not calculate it again.
impl TryFrom<Sessions> for Log {
    type Error = ReadError;

    fn try_from(log: Sessions) -> Result<Self, ReadError> {
        let known = |session: &Session| match &session.origin {
            Some(Beginning {
                seed,
                mode,
                before: Knowledge::Bytes(before),
            }) => Some((*seed, *mode, before.to_vec())),
            _ => None,
        };
        let mut sessions = log.sessions.into_iter().skip_while(|s| known(s).is_none());
        let first = sessions.next().ok_or(ReadError::NoStart)?;
        let (seed, mode, before) = known(&first).ok_or(ReadError::NoStart)?;
        let (mut entries, mut after) = (Vec::new(), None);
        for session in std::iter::once(first).chain(sessions) {
            entries.extend(session.entries.into_iter().map(|(_, entry)| entry));
            after = match session.after {
                Some(Knowledge::Bytes(bytes)) => Some(bytes.to_vec()),
                Some(Knowledge::Named(_)) | None => None,
            };
        }
        let writer = log.writer;
        Ok(Self {
            origin: Origin { seed, mode, writer },
            before,
            after,
            arenas: log
                .arena
                .map_or_else(Vec::new, |arena| of_all(arena, &entries)),
            free_running: true,
            entries,
            cut_off: log.cut_off,
        })
    }
}

/// The one arena of all these trials.
fn of_all(arena: Arena, entries: &[Entry]) -> Vec<Arena> {
    let trials: BTreeSet<u32> = entries.iter().map(Entry::trial).collect();
    let mut place = arena.place;
    let (start, goal) = (arena.start, arena.goal);
    trials
        .into_iter()
        .map(|trial| Arena {
            trial,
            place: place.take(),
            start,
            goal,
        })
        .collect()
}

/// Makes sessions of messages.
struct Assembler<'a> {
    recording: &'a Recording,
    sessions: Vec<Session>,
    open: Option<Session>,
    /// The direction to follow, if it was reported.
    direction: Option<Microdegrees>,
    /// Something happened since the last action that keeps it from being learned from.
    interrupted: bool,
    /// Reports that the rover had dropped, by its last count.
    dropped: Option<u32>,
    /// Where it was, if that is known.
    truth: Option<Truth>,
}

impl Assembler<'_> {
    fn take(&mut self, message: &Recorded) {
        if message.lost > 0 {
            let what = match message.lost {
                1 => "a frame was lost".into(),
                lost => format!("{lost} frames were lost"),
            };
            self.gap(message.number, what);
        }
        match &message.what {
            What::Report(report) => {
                let anew = matches!(**report, Report::Hello(_)) && message.frame == Some(0);
                if anew && message.number > 1 {
                    self.gap(
                        message.number,
                        "the rover or its connection began anew".into(),
                    );
                }
                self.hear(message.number, report);
            }
            What::Knowledge(pulled) => self.known(pulled.fingerprint),
            What::Truth(truth) => self.truth = Some(*truth),
            // Whether it was obeyed follows from the reports.
            What::Command(_) => {}
            What::Gap(gap) => {
                self.dropped = None;
                self.gap(message.number, gap.reason.clone());
            }
        }
    }

    fn hear(&mut self, number: usize, report: &Report) {
        match report {
            Report::Action(action) => {
                self.count(number, &action.counters);
                self.act(number, action);
            }
            Report::Status(status) => {
                self.count(number, &status.counters);
                // A recording may begin in any state, and a change may have been lost.
                self.state(status.state);
            }
            Report::Fault(fault) if fault.fault == Fault::QueueFull => {
                self.count_dropped(number, fault.count);
            }
            Report::Event(message::Event { kind, .. }) => self.event(kind),
            // Counters start anew with it.
            Report::Hello(_) => self.dropped = None,
            _ => {}
        }
    }

    fn event(&mut self, kind: &EventKind) {
        match *kind {
            EventKind::Session {
                mode,
                seed,
                knowledge,
            } => {
                self.close();
                let mode = match mode {
                    contract::Mode::Run => Mode::Run,
                    _ => Mode::Learn,
                };
                self.open = Some(Session {
                    origin: Some(Beginning {
                        seed,
                        mode,
                        before: self.knowledge(knowledge),
                    }),
                    ..Session::default()
                });
                self.direction = None;
                self.interrupted = true;
            }
            EventKind::Direction(direction) => {
                self.direction = Some(direction);
                self.interrupted = true;
            }
            EventKind::State(state) => self.state(state),
            EventKind::KnowledgeStored { fingerprint } => self.known(fingerprint),
            EventKind::MoveEnded(_) | EventKind::Range { .. } | EventKind::Compass(_) => {}
        }
    }

    fn state(&mut self, state: State) {
        let drives = matches!(
            state,
            State::Driving(contract::Mode::Learn | contract::Mode::Run)
        );
        if let Some(session) = &mut self.open
            && !drives
        {
            session.over = true;
        }
    }

    fn act(&mut self, number: usize, action: &ActionRecord) {
        let direction = self
            .direction
            .or_else(|| followed(&action.sample, &action.step))
            .unwrap_or_default();
        let interrupted = std::mem::replace(&mut self.interrupted, interrupts(action.outcome));
        let trial = self.sessions.len() as u32 + 1;
        let session = self.open.get_or_insert_default();
        if action.outcome != Outcome::Stopped {
            // It drives after all: it was asked to stop and to go on before it noticed.
            session.over = false;
            session.after = None;
        }
        let step = Step {
            trial,
            interrupted,
            task: TaskKind::FollowDirection {
                direction_udeg: direction,
            },
            sample: action.sample,
            record: action.step,
            motion: motion(action.outcome),
            pose: self
                .truth
                .filter(|truth| truth.time == action.time)
                .map(|truth| truth.pose),
        };
        session.entries.push((number, Entry::Step(Box::new(step))));
    }

    /// Something is missing before this message.
    fn gap(&mut self, number: usize, what: String) {
        match &mut self.open {
            Some(session) if session.over => self.close(),
            Some(session) => {
                session.gap.get_or_insert((number, what));
                self.close();
            }
            None => {}
        }
        self.direction = None;
        self.interrupted = true;
    }

    fn count(&mut self, number: usize, counters: &Counters) {
        self.count_dropped(number, counters.of(Fault::QueueFull));
    }

    /// Reports that found no room in the rover's queue are no frames, and leave no gap in numbers.
    fn count_dropped(&mut self, number: usize, dropped: u32) {
        if let Some(before) = self.dropped.replace(dropped)
            && dropped > before
        {
            let count = dropped - before;
            self.gap(number, format!("the rover dropped {count} reports"));
        }
    }

    /// This is known now. It is what a session ended with, if nothing else happened since.
    fn known(&mut self, fingerprint: u32) {
        let knowledge = self.knowledge(fingerprint);
        if let Some(session) = &mut self.open
            && session.over
        {
            // A first word may only name it, a second hold it.
            session.after = Some(knowledge);
        }
    }

    fn knowledge(&self, fingerprint: u32) -> Knowledge {
        match self.recording.knowledge.get(&fingerprint) {
            Some(bytes) => Knowledge::Bytes(Arc::clone(bytes)),
            None => Knowledge::Named(fingerprint),
        }
    }

    fn close(&mut self) {
        if let Some(session) = self.open.take() {
            self.sessions.push(session);
        }
    }
}

/// The direction that a step followed, worked out from what it sensed.
fn followed(sample: &Sample, step: &StepRecord) -> Option<Microdegrees> {
    let angle = step.sensed?.target_angle;
    Some(sample.heading.turned(angle))
}

/// What became of an action, as simulations put it.
fn motion(outcome: Outcome) -> Option<Motion> {
    match outcome {
        Outcome::Completed => Some(Motion::Moved),
        Outcome::Obstacle | Outcome::NoProgress => Some(Motion::Blocked),
        Outcome::TurnTimeout | Outcome::CompassLost | Outcome::Late | Outcome::Stopped => None,
    }
}
