//! Replaying: logged samples once more through the very core that met them first.

use rover_shared::checksum::fingerprint;
use rover_shared::controller::Controller;
use rover_shared::knowledge::KnowledgeError;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::parameters::Coefficients;
use rover_shared::random::Generator;
use rover_shared::range_check::ParameterError;
use serde_json::Value;

use crate::knowledge;
use crate::log::{Entry, Log};
use crate::replayable::{Beginning, Knowledge, Session, Sessions};

/// What a replay found.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Replayed {
    /// Sessions in the log.
    pub sessions: usize,
    /// Actions replayed.
    pub steps: usize,
    /// Trials that ended.
    pub trials: usize,
    /// Whether everything was replayed to the end, and the final knowledge compared.
    pub complete: bool,
    /// What could not be replayed, and why.
    pub unverified: Vec<Unverified>,
    /// The first difference.
    pub difference: Option<Difference>,
}

/// Actions that could not be replayed.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Unverified {
    /// The session they belong to, from 1.
    pub session: usize,
    /// How many.
    pub steps: usize,
    /// The number of the message at which it became so, if there is one.
    pub message: Option<usize>,
    /// Why.
    pub reason: String,
}

/// Where a log and its replay part.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Difference {
    /// The number of the message, from 1; one past the last for the knowledge at the end.
    pub message: usize,
    /// The trial, or the session of a recording, that it belongs to, from 1.
    pub trial: u32,
    /// The field that differs, as a path.
    pub field: String,
    /// What the log says.
    pub recorded: Value,
    /// What the core says.
    pub replayed: Value,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            message,
            trial,
            field,
            recorded,
            replayed,
        } = self;
        write!(
            f,
            "message {message} (trial {trial}): {field} was recorded as {recorded}, the core gives {replayed}"
        )
    }
}

impl std::fmt::Display for Unverified {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            session,
            steps,
            reason,
            ..
        } = self;
        write!(f, "session {session}: ")?;
        match steps {
            0 => write!(f, "its end could not be compared")?,
            1 => write!(f, "1 action could not be verified")?,
            _ => write!(f, "{steps} actions could not be verified")?,
        }
        write!(f, ": {reason}")?;
        match self.message {
            Some(message) => write!(f, " (message {message})"),
            None => Ok(()),
        }
    }
}

/// Why a log cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The knowledge it starts from cannot be read.
    #[error("the log's knowledge cannot be read: {0}")]
    Knowledge(#[from] KnowledgeError),
    /// Its parameters cannot be used.
    #[error("the log's parameters cannot be used: {0}")]
    Parameters(#[from] ParameterError),
}

/// Replays a simulation's log; see [`verify_sessions`].
///
/// # Errors
/// If the knowledge that the log starts from cannot be used.
pub fn verify(log: &Log) -> Result<Replayed, ReplayError> {
    verify_sessions(&log.clone().into())
}

/// Replays all sessions and compares every recorded output with the core's, bit by bit.
///
/// The replay stops at the first difference: what follows would differ for that reason alone.
/// Values that no output depends on (poses, sensor counts) are not compared. A session that begins
/// with knowledge that is not in the log is replayed if the session before ended with it.
///
/// # Errors
/// If knowledge that the log starts from cannot be used.
pub fn verify_sessions(log: &Sessions) -> Result<Replayed, ReplayError> {
    let mut replay = Replay {
        known: None,
        replayed: Replayed {
            sessions: log.sessions.len(),
            steps: 0,
            trials: 0,
            complete: false,
            unverified: Vec::new(),
            difference: None,
        },
    };
    for (number, session) in (1..).zip(&log.sessions) {
        replay.session(number, session)?;
        if replay.replayed.difference.is_some() {
            return Ok(replay.replayed);
        }
    }
    let mut replayed = replay.replayed;
    replayed.complete = !log.cut_off && replayed.unverified.is_empty();
    Ok(replayed)
}

/// A replay under way.
struct Replay {
    /// What the last session that was replayed to its end ended with.
    known: Option<Vec<u8>>,
    replayed: Replayed,
}

impl Replay {
    fn session(&mut self, number: usize, session: &Session) -> Result<(), ReplayError> {
        let steps = session.entries.len();
        let Some(beginning) = &session.origin else {
            self.give_up(number, steps, session, "its beginning is not in the log");
            return Ok(());
        };
        let Some(before) = self.before(beginning) else {
            let reason = "the knowledge it started from is not in the log";
            self.give_up(number, steps, session, reason);
            return Ok(());
        };
        let (mut known, parameters) = knowledge::from_bytes(&before)?;
        let coefficients = Coefficients::new(&parameters)?;
        let rng = Generator::new(beginning.seed);
        let mut controller =
            Controller::new(&coefficients, PaperRule, &mut known, rng, beginning.mode);
        for (message, entry) in &session.entries {
            if let Some(difference) = self.entry(*message, entry, &mut controller) {
                self.replayed.difference = Some(difference);
                return Ok(());
            }
        }
        let after = knowledge::to_bytes(&known, &parameters);
        match (&session.after, &session.gap) {
            (_, Some((message, reason))) => self.replayed.unverified.push(Unverified {
                session: number,
                steps: 0,
                message: Some(*message),
                reason: reason.clone(),
            }),
            (Some(recorded), None) => {
                self.replayed.difference = end_differs(number, session, recorded, &after);
            }
            (None, None) => self.replayed.unverified.push(Unverified {
                session: number,
                steps: 0,
                message: None,
                reason: "the log does not say what was known at its end".into(),
            }),
        }
        self.known = (session.over && session.gap.is_none()).then_some(after);
        Ok(())
    }

    fn give_up(&mut self, number: usize, steps: usize, session: &Session, reason: &str) {
        // What comes after does not follow from what was replayed before.
        self.known = None;
        self.replayed.unverified.push(Unverified {
            session: number,
            steps,
            message: session.entries.first().map(|(message, _)| *message),
            reason: reason.into(),
        });
    }

    fn before(&mut self, beginning: &Beginning) -> Option<Vec<u8>> {
        match &beginning.before {
            Knowledge::Bytes(bytes) => Some(bytes.to_vec()),
            Knowledge::Named(print) => {
                let known = self.known.take();
                known.filter(|known| fingerprint(known) == *print)
            }
        }
    }

    fn entry(
        &mut self,
        message: usize,
        entry: &Entry,
        controller: &mut Controller<'_, PaperRule>,
    ) -> Option<Difference> {
        let (field, recorded, replayed) = match entry {
            Entry::Step(step) => {
                self.replayed.steps += 1;
                if step.interrupted {
                    controller.interrupt();
                }
                let record = controller.step(&step.sample, &step.task);
                compare("record", &step.record, &record)?
            }
            Entry::End(end) => {
                self.replayed.trials += 1;
                let learned = controller.conclude(&end.sample, &end.task);
                compare("learned", &end.learned, &learned)?
            }
        };
        Some(Difference {
            message,
            trial: entry.trial(),
            field,
            recorded,
            replayed,
        })
    }
}

/// The knowledge at a session's end against the core's.
fn end_differs(
    number: usize,
    session: &Session,
    recorded: &Knowledge,
    core: &[u8],
) -> Option<Difference> {
    let (field, recorded, replayed): (String, Value, Value) = match recorded {
        Knowledge::Bytes(recorded) => {
            let longer = recorded.len().max(core.len());
            let at = (0..longer).find(|&i| recorded.get(i) != core.get(i))?;
            (
                format!("byte {at} of the knowledge at the end"),
                recorded.get(at).copied().into(),
                core.get(at).copied().into(),
            )
        }
        Knowledge::Named(print) => {
            let ours = fingerprint(core);
            if ours == *print {
                return None;
            }
            let hex = |print: u32| format!("{print:08x}").into();
            let field = "the fingerprint of the knowledge at the end".into();
            (field, hex(*print), hex(ours))
        }
    };
    let trial = session
        .entries
        .last()
        .map_or(number as u32, |(_, entry)| entry.trial());
    Some(Difference {
        message: session.entries.last().map_or(1, |(message, _)| message + 1),
        trial,
        field,
        recorded,
        replayed,
    })
}

fn compare<T: serde::Serialize + PartialEq>(
    name: &str,
    recorded: &T,
    core: &T,
) -> Option<(String, Value, Value)> {
    if recorded == core {
        return None;
    }
    // Values of plain structs always become JSON; comparing JSON finds the name of the field.
    let json = |value: Result<Value, _>| value.unwrap_or(Value::Null);
    let recorded = json(serde_json::to_value(recorded));
    let core = json(serde_json::to_value(core));
    first_difference(name, &recorded, &core)
}

/// The path, and both values, of the first leaf in which two JSON values differ.
fn first_difference(path: &str, a: &Value, b: &Value) -> Option<(String, Value, Value)> {
    match (a, b) {
        (Value::Object(x), Value::Object(y)) if x.keys().eq(y.keys()) => x
            .iter()
            .zip(y.values())
            .find_map(|((key, a), b)| first_difference(&format!("{path}.{key}"), a, b)),
        (Value::Array(x), Value::Array(y)) if x.len() == y.len() => x
            .iter()
            .zip(y)
            .enumerate()
            .find_map(|(i, (a, b))| first_difference(&format!("{path}[{i}]"), a, b)),
        _ => (a != b).then(|| (path.to_owned(), a.clone(), b.clone())),
    }
}
