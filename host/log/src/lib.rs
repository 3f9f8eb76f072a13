//! Logs: every sample the core was given and all it made of it, as integers, so that a log and
//! the knowledge it started from replay to the same bits.
//!
//! Logs are MCAP files, which Foxglove, Rerun and PlotJuggler open. One has
//!
//! | part | holds |
//! |---|---|
//! | metadata `turing-rover` | [`Origin`]: format version, program version, seed, mode |
//! | attachment `knowledge.rover` | what was known at the start, with its parameters |
//! | channel `/arena` | one [`arena::Arena`] per trial, where there is one |
//! | channel `/step` | one [`message::Step`] per action |
//! | channel `/end` | one [`message::End`] per trial |
//! | attachment `knowledge-after.rover` | what was known at the end |
//!
//! Log times count actions: one second each, from 0. Messages are JSON with a JSON Schema; units
//! are in the names of the fields.
//!
//! | file | holds |
//! |---|---|
//! | `arena` | the message that says where a trial takes place |
//! | `arena_file` | arenas from their files |
//! | `message` | all other messages, their schemas and the checksum that chains them |
//! | `writer`, `reader` | whole logs |
//! | `lengths` | whether the lengths that a file claims can be true |
//! | `recording` | logs of a rover, as it was heard over its port |
//! | `recorder` | records what a rover says |
//! | `replayable` | what both kinds of logs have in common, and replays start from |
//! | `replay` | logs through the core once more, compared bit by bit |
//! | `recorded_drive` | what the core makes of a drive recorded by others |
//! | `knowledge` | knowledge files |
//! | `files` | writing files whole or not at all |
//! | `results` | results as text |
//! | `table` | drives recorded by others, as CSV |

pub mod arena;
pub mod arena_file;
pub mod files;
pub mod knowledge;
mod lengths;
pub mod message;
mod reader;
pub mod recorded_drive;
pub mod recorder;
pub mod recording;
pub mod replay;
pub mod replayable;
pub mod results;
pub mod table;
mod writer;

pub use reader::{Entry, Log, ReadError};
pub use writer::LogWriter;

use rover_shared::learning::Mode;
use serde::{Deserialize, Serialize};

/// Version of the layout described above.
pub const FORMAT: u32 = 1;

const METADATA: &str = "turing-rover";
const BEFORE: &str = "knowledge.rover";
const AFTER: &str = "knowledge-after.rover";
const ARENA_TOPIC: &str = "/arena";
const STEP_TOPIC: &str = "/step";
const END_TOPIC: &str = "/end";

/// What a log started from, besides the knowledge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The seed of the controller's generator.
    pub seed: u64,
    /// Whether the controller learned.
    pub mode: Mode,
    /// Who wrote the log: program and version.
    pub writer: String,
}
