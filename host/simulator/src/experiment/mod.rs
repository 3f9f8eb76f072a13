//! Learning and testing in the simulator.
//!
//! | file | holds |
//! |---|---|
//! | `trial` | one robot in one arena until it arrives or gives up: [`run_trial`] |
//! | `pilot` | what steers a robot: the [`Pilot`] trait |
//! | `turing`, `baseline_pilot` | the paper's architecture and the baselines as pilots |
//! | `learning` | learning from nothing over many trials: [`learn`] |
//! | `exam` | a frozen controller in arenas it has never met: [`examine_knowledge`] |
//! | `history` | how the staircases changed while learning: [`History`] |
//! | `measures` | directedness (8), means and confidence intervals |
//! | `seeds` | what is drawn from one seed: [`Stream`], [`generator`] |

mod baseline_pilot;
mod exam;
mod history;
mod learning;
mod measures;
mod pilot;
mod seeds;
mod trial;
mod turing;

pub use baseline_pilot::{BaselinePilot, teach};
pub use exam::{Exam, ExamResult, examine, examine_knowledge};
pub use history::{History, Staircases};
pub use learning::{LearnedSession, SessionPlan, learn};
pub use measures::{Estimate, directedness, mean, proportion};
pub use pilot::{Ending, Pilot, TaskKind};
pub use seeds::{Stream, generator, numbered};
pub use trial::{Conduct, FreeHeading, Trial, run_trial};
pub use turing::{Event, Known, Turing, Witness};
