//! The paper's figures from our own data, as SVG and as one page of HTML.
//!
//! Drawn with the crate `svg`, which has no dependencies, writes attributes in a fixed order and
//! leaves every coordinate to us; plotting libraries know no arenas, and place text by font files.
//!
//! | file | figure of the paper | shows |
//! |---|---|---|
//! | `overview.svg` | | all of it in one picture |
//! | `lattice.svg` | (2b) | how patterns grow in the network |
//! | `neuron.svg` | 3 | how one sensing neuron learns |
//! | `staircases.svg` | 4 | the learned functions of the sensing neurons |
//! | `trajectories.svg` | 5 to 9, 12 to 14 | drives before and after learning |
//! | `position.svg` | 7 | the steps, the pattern and the action at one place |
//! | `sequence.svg` | 10, 14, 15 | the patterns along one drive |
//! | `patterns.svg` | 10, 15 | the patterns in use and their actions |
//! | `learning.svg` | | how trials went |
//! | `report.html` | | all of them, with numbers |
//!
//! | module | holds |
//! |---|---|
//! | `drive` | drives kept action by action |
//! | `recording` | both, from a log |
//! | `material` | what the figures of one kind of source are made from |
//! | `gallery` | all figures of one source, with titles and captions |
//! | `scenes` | which drives are worth showing |
//! | `palette` | which pattern has which colour |
//! | `view` | an arena from above |
//! | `axes`, `shape` | scales, ticks; lines, text, the sheet itself |
//! | `page` | the report |

mod axes;
mod drive;
mod gallery;
mod lattice;
mod learning;
mod material;
mod neuron;
mod overview;
mod page;
mod palette;
mod patterns;
mod position;
mod recording;
mod scenes;
mod sequence;
mod shape;
mod staircases;
mod trajectories;
mod view;

use std::path::Path;

use rover_shared::parameters::Coefficients;

pub use drive::{Drive, Reading, first_trial, test_drives};
use material::Material;
pub use recording::{Recording, RecordingError};
use rover_log::files::{WriteError, write_whole};
use rover_simulator::experiment::{Exam, LearnedSession, SessionPlan};

/// A figure's file name and contents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name of the file.
    pub name: &'static str,
    /// Which figures of the paper it answers to; empty if it is our own.
    pub paper: &'static str,
    /// How to read it.
    pub caption: String,
    /// The SVG document.
    pub svg: String,
}

/// All figures of one source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figures {
    /// The figures, in the order of the paper.
    pub figures: Vec<Figure>,
    /// All of them on a page of HTML that needs no other file.
    pub report: String,
}

/// Name of the page.
pub const REPORT: &str = "report.html";

/// Which moment is shown closely.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// The trial (of a log) or the arena (of a test), from 1; `None` for the one with most to see.
    pub trial: Option<u32>,
    /// Actions of it before that moment; `None` for when something comes into sight.
    pub at: Option<usize>,
}

/// Why a moment cannot be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoSuchMoment {
    /// There is no such trial.
    #[error("there is no trial {0}, expected one from {1} to {2}")]
    Trial(u32, u32, u32),
    /// It was over by then.
    #[error("trial {0} has {2} actions, so --at {1} is beyond its end; expected 0 to {last}", last = .2.saturating_sub(1))]
    At(u32, usize, usize),
}

impl Figures {
    /// Writes every figure and the page to a folder.
    ///
    /// # Errors
    /// If one cannot be written.
    pub fn write(&self, out: &Path) -> Result<(), WriteError> {
        for figure in &self.figures {
            write_whole(&out.join(figure.name), figure.svg.as_bytes())?;
        }
        if !self.figures.is_empty() {
            write_whole(&out.join(REPORT), self.report.as_bytes())?;
        }
        Ok(())
    }
}

/// Draws all figures of one or more sessions; all but the learning curves are about the first.
/// `plan` and `exam` are the first session's. However many arenas the test had, the figures are
/// about its first 40, or fewer if trials are longer than the paper's. Nothing without a session.
pub fn of_sessions(
    sessions: &[&LearnedSession],
    plan: &SessionPlan,
    exam: &Exam,
    coefficients: &Coefficients,
) -> Figures {
    match Material::of_sessions(sessions, plan, exam, coefficients) {
        None => Figures {
            figures: Vec::new(),
            report: String::new(),
        },
        Some(material) => material.draw(&material.usual_moment()),
    }
}

/// Draws all figures of one or more logs, whose names are given; all but the learning curves are
/// about the first.
///
/// # Errors
/// If there is no such moment in the first log.
pub fn of_recordings(
    recordings: &[(String, Recording)],
    moment: Moment,
) -> Result<Figures, NoSuchMoment> {
    let Some(material) = Material::of_recordings(recordings) else {
        return Ok(Figures {
            figures: Vec::new(),
            report: String::new(),
        });
    };
    Ok(material.draw(&material.moment(moment)?))
}
