//! Results and failures of commands.

use std::fmt::Display;
use std::io::{ErrorKind, Write as _};

use rover_simulator::experiment::Estimate;
use serde::Serialize;

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// The arguments are wrong: exit status 2.
    Usage(String),
    /// It could not be done: exit status 1.
    Failed(String),
}

impl Failure {
    /// Something about a file, a port or another named thing.
    pub fn of(name: impl Display, what: impl Display) -> Self {
        Self::Failed(format!("{name}: {what}"))
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Writes text to stdout. A reader that has seen enough (`rover ... | head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Writes a result for machines to stdout.
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    print(&format!("{}\n", serde_json::to_string_pretty(value)?))
}

/// Writes a result to stdout: for machines if `json`, else as lines for people.
pub fn answer(json: bool, value: &impl Serialize, lines: impl Display) -> Result<(), Failure> {
    if json {
        return print_json(value);
    }
    let lines = lines.to_string();
    print(&format!("{}\n", lines.trim_end_matches('\n')))
}

/// An estimate as text, or a dash.
pub fn shown(estimate: Option<Estimate>, digits: usize) -> String {
    estimate.map_or("-".into(), |e| {
        format!(
            "{:.digits$} [{:.digits$}, {:.digits$}]",
            e.value, e.low, e.high
        )
    })
}
