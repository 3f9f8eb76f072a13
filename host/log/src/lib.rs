//! Logs of simulations and recordings of rovers, replayed bit by bit; knowledge files; drives
//! recorded by others.
//!
//! A log holds every sample that the core was given and all that it made of it, as integers, with the
//! knowledge and the seed that it started from. So the core can be run again on the samples, and has
//! to come to the same bits:
//!
//! ```
//! use rover_log::replay;
//! use rover_log::replayable::Sessions;
//!
//! let file = std::fs::read("../../tests/data/formats/target.mcap")?;
//! let log = Sessions::read(&[file])?;
//! let replayed = replay::verify_sessions(&log)?;
//! assert_eq!(replayed.difference, None);
//! assert!(replayed.complete && replayed.steps > 10);
//! # Ok::<_, Box<dyn std::error::Error>>(())
//! ```
//!
//! Logs are MCAP files, which Foxglove, Rerun and PlotJuggler open, with messages in JSON and their
//! JSON Schemas. That of a simulation has
//!
//! | part | holds |
//! |---|---|
//! | metadata `turing-rover` | [`FORMAT`] and [`Origin`]: version of the format, program and its version, seed, mode |
//! | attachment `knowledge.rover` | what was known at the start, with its parameters |
//! | channel `/arena` | one [`arena::Arena`] per trial, where there is one |
//! | channel `/step` | one [`message::Step`] per action |
//! | channel `/end` | one [`message::End`] per trial |
//! | attachment `knowledge-after.rover` | what was known at the end |
//!
//! Log times count actions: one second each, from 0. Units are in the names of the fields. A rover's
//! log is a [`recording`].
//!
//! Damage is found by MCAP's own checksums, and what was changed on purpose by replaying, as far as
//! an output depends on it. Other tools may leave out channels, compress chunks (zstd, lz4) and leave
//! out checksums; attachments and metadata have to stay.
//!
//! | file | holds |
//! |---|---|
//! | `arena_file` | arenas from their files |
//! | `replay` | logs through the core once more, compared bit by bit |
//! | `replayable` | what both kinds of logs have in common, and replays start from |
//! | `recorder` | records what a rover says |
//! | `recording` | the layout, reading and writing of recordings |
//! | `log`, `writer` | the layout and reading, and the writing of simulations' logs |
//! | `message`, `arena` | the messages of simulations' logs |
//! | `schema` | JSON Schemas of messages, from their types |
//! | `container` | MCAP files |
//! | `format`, `error` | versions of the layout; why a file cannot be read |
//! | `recorded_drive`, `table` | what the core makes of a drive recorded by others; such drives as CSV |
//! | `knowledge` | knowledge files, their summary and difference, and what a robot knows as its log goes on |
//! | `results` | results as text |
//! | `files` | writing files whole or not at all |

pub mod arena;
pub mod arena_file;
mod container;
mod error;
pub mod files;
mod format;
pub mod knowledge;
mod log;
pub mod message;
pub mod recorded_drive;
pub mod recorder;
pub mod recording;
pub mod replay;
pub mod replayable;
pub mod results;
mod schema;
pub mod table;
mod writer;

pub use error::ReadError;
pub use format::FORMAT;
pub use log::{Entry, Log, Origin};
pub use writer::LogWriter;
