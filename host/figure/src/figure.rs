//! What is drawn: figures, and the moment that is shown closely.

use std::path::Path;

use rover_log::files::{WriteError, write_whole};

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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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
