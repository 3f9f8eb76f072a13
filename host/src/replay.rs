//! Replaying: logged samples once more through the very core that met them first.

use rover_shared::action::motor_map::PaperRule;
use rover_shared::controller::Controller;
use rover_shared::knowledge::KnowledgeError;
use rover_shared::parameters::{Coefficients, ParameterError};
use rover_shared::random::Generator;
use serde_json::Value;

use crate::experiment::Known;
use crate::knowledge;
use crate::log::{Entry, Log};

/// What a replay found.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Replayed {
    /// Actions replayed.
    pub steps: usize,
    /// Trials that ended.
    pub trials: usize,
    /// Whether the log goes to the end: only then is the final knowledge compared.
    pub complete: bool,
    /// The first difference.
    pub difference: Option<Difference>,
}

/// Where a log and its replay part.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Difference {
    /// The number of the message, from 1; one past the last for the knowledge at the end.
    pub message: usize,
    /// The trial it belongs to, from 1.
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

/// Replays a log and compares every recorded output with the core's, bit by bit.
///
/// The replay stops at the first difference: what follows would differ for that reason alone.
/// Values that no output depends on are covered by the checksum in each message.
///
/// # Errors
/// If the knowledge that the log starts from cannot be used.
pub fn verify(log: &Log) -> Result<Replayed, ReplayError> {
    let (mut known, parameters) = knowledge::from_bytes(&log.before)?;
    let coefficients = Coefficients::new(&parameters)?;
    let rng = Generator::new(log.origin.seed);
    let mut controller =
        Controller::new(&coefficients, PaperRule, &mut known, rng, log.origin.mode);
    let mut replayed = Replayed {
        steps: 0,
        trials: 0,
        complete: false,
        difference: None,
    };
    for (number, entry) in (1..).zip(&log.entries) {
        let (trial, found) = match entry {
            Entry::Step(step) => {
                replayed.steps += 1;
                if step.interrupted {
                    controller.interrupt();
                }
                let record = controller.step(&step.sample, &step.task);
                (step.trial, compare("record", &step.record, &record))
            }
            Entry::End(end) => {
                replayed.trials += 1;
                let learned = controller.conclude(&end.sample, &end.task);
                (end.trial, compare("learned", &end.learned, &learned))
            }
        };
        let found = found.or_else(|| broken_chain(log, number));
        if let Some((field, recorded, core)) = found {
            let message = number;
            replayed.difference = Some(Difference {
                message,
                trial,
                field,
                recorded,
                replayed: core,
            });
            return Ok(replayed);
        }
    }
    replayed.complete = log.after.is_some() && !log.cut_off;
    replayed.difference = final_difference(log, &known, &parameters, &replayed);
    Ok(replayed)
}

fn final_difference(
    log: &Log,
    known: &Known,
    parameters: &rover_shared::parameters::Parameters,
    replayed: &Replayed,
) -> Option<Difference> {
    let recorded = log.after.as_ref().filter(|_| replayed.complete)?;
    let core = knowledge::to_bytes(known, parameters);
    let at = (0..recorded.len().max(core.len())).find(|&i| recorded.get(i) != core.get(i))?;
    Some(Difference {
        message: log.entries.len() + 1,
        trial: replayed.trials as u32,
        field: format!("byte {at} of the knowledge at the end"),
        recorded: recorded.get(at).copied().into(),
        replayed: core.get(at).copied().into(),
    })
}

fn broken_chain(log: &Log, number: usize) -> Option<(String, Value, Value)> {
    (log.broken_at == Some(number)).then(|| {
        let text = "a value that no output depends on (its checksum does not match)";
        ("chain".into(), text.into(), "the same outputs".into())
    })
}

fn compare(
    name: &str,
    recorded: &(impl serde::Serialize + PartialEq),
    core: &(impl serde::Serialize + PartialEq),
) -> Option<(String, Value, Value)> {
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
