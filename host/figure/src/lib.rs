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
//! | `figure` | what is drawn: [`Figure`], [`Figures`], [`Moment`] |
//! | `drive` | drives kept action by action |
//! | `from_log` | the same, and what was learned, from a log |
//! | `inputs` | what the figures of one kind of source are made from |
//! | `gallery` | all figures of one source, with titles and captions |
//! | `situations` | which drives are worth showing |
//! | `palette` | which pattern has which colour |
//! | `view` | an arena from above |
//! | `axes`, `shape` | scales, ticks; lines, text, the sheet itself |
//! | `page` | the report |

mod axes;
mod drive;
mod figure;
mod from_log;
mod gallery;
mod inputs;
mod lattice;
mod learning;
mod neuron;
mod overview;
mod page;
mod palette;
mod patterns;
mod position;
mod sequence;
mod shape;
mod situations;
mod staircases;
mod trajectories;
mod view;

use rover_shared::parameters::Coefficients;
use rover_simulator::experiment::{Exam, LearnedSession, SessionPlan};

pub use drive::{Drive, Reading, first_trial, test_drives};
pub use figure::{Figure, Figures, Moment, NoSuchMoment, REPORT};
pub use from_log::{LoggedSession, LoggedSessionError};

use inputs::Inputs;

/// Draws all figures of one or more sessions; all but the learning curves are about the first.
/// `plan` and `exam` are the first session's. However many arenas the test had, the figures are
/// about its first 40, or fewer if trials are longer than the paper's. Nothing without a session.
pub fn of_sessions(
    sessions: &[&LearnedSession],
    plan: &SessionPlan,
    exam: &Exam,
    coefficients: &Coefficients,
) -> Figures {
    match Inputs::of_sessions(sessions, plan, exam, coefficients) {
        None => Figures::default(),
        Some(inputs) => inputs.draw(&inputs.usual_moment()),
    }
}

/// Draws all figures of one or more logs, whose names are given; all but the learning curves are
/// about the first.
///
/// # Errors
/// If there is no such moment in the first log.
pub fn of_recordings(
    recordings: &[(String, LoggedSession)],
    moment: Moment,
) -> Result<Figures, NoSuchMoment> {
    let Some(inputs) = Inputs::of_recordings(recordings) else {
        return Ok(Figures::default());
    };
    Ok(inputs.draw(&inputs.moment(moment)?))
}
