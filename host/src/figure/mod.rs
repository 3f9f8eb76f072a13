//! The paper's figures from our own data, as SVG.
//!
//! Drawn with the crate `svg`, which has no dependencies, writes attributes in a fixed order and
//! leaves every coordinate to us; plotting libraries know no arenas, and place text by font files.
//!
//! | file | figure of the paper | shows |
//! |---|---|---|
//! | `staircases.svg` | 4 | the learned functions of the sensing neurons |
//! | `trajectories.svg` | 5 to 9 | drives before and after learning |
//! | `sequence.svg` | 10 | the patterns along one drive |
//! | `patterns.svg` | 10b, 15 | the patterns in use and their actions |
//! | `learning.svg` | | how trials went |
//!
//! | module | holds |
//! |---|---|
//! | `drive` | drives kept action by action |
//! | `palette` | which pattern has which colour |
//! | `view` | an arena from above |
//! | `axes`, `shape` | scales, ticks; lines, text, the sheet itself |

mod axes;
mod drive;
mod learning;
mod palette;
mod patterns;
mod sequence;
mod shape;
mod staircases;
mod trajectories;
mod view;

use std::path::Path;

use rover_shared::parameters::Coefficients;

use crate::experiment::{Exam, LearnedSession, SessionPlan};
use crate::files::{WriteError, write_whole};
pub use drive::{Drive, first_trial, test_drives};
use palette::Palette;
use trajectories::{SHOWN_AIMING, SHOWN_FOLLOWING, Scene};

/// Test drives from which scenes are chosen and in which the patterns in use are counted.
const TEST_DRIVES: u32 = 40;
/// Actions of all test drives together, at most: drives are kept in memory, and a trial may be
/// allowed a million actions. Forty drives of the paper's 500 actions (III-B).
const TEST_ACTIONS: u32 = 20_000;

/// A figure's file name and contents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name of the file.
    pub name: &'static str,
    /// The SVG document.
    pub svg: String,
}

/// Draws and writes all figures of one or more sessions; all but the learning curves are about the
/// first. `plan` and `exam` are the first session's. However many arenas the test had, the figures
/// are about its first 40, or fewer if trials are longer than the paper's.
///
/// # Errors
/// If one cannot be written.
pub fn write_all(
    out: &Path,
    sessions: &[&LearnedSession],
    plan: &SessionPlan,
    exam: &Exam,
    coefficients: &Coefficients,
) -> Result<(), WriteError> {
    for figure in draw_all(sessions, plan, exam, coefficients) {
        write_whole(&out.join(figure.name), figure.svg.as_bytes())?;
    }
    Ok(())
}

/// Draws what [`write_all`] writes: nothing without a session.
pub fn draw_all(
    sessions: &[&LearnedSession],
    plan: &SessionPlan,
    exam: &Exam,
    coefficients: &Coefficients,
) -> Vec<Figure> {
    let Some(session) = sessions.first() else {
        return Vec::new();
    };
    let arenas = (TEST_ACTIONS / exam.steps.max(1)).clamp(1, TEST_DRIVES);
    let exam = Exam {
        arenas,
        steps: exam.steps.min(TEST_ACTIONS),
        ..exam.clone()
    };
    let drives = test_drives(&exam, coefficients, &session.knowledge);
    let palette = Palette::new(&drives, &session.knowledge);
    let shown = if plan.follow_direction {
        SHOWN_FOLLOWING
    } else {
        SHOWN_AIMING
    };
    let drives: Vec<Drive> = drives.into_iter().map(|drive| drive.first(shown)).collect();
    let bounded = SessionPlan {
        steps: plan.steps.min(TEST_ACTIONS),
        ..plan.clone()
    };
    let first = first_trial(&bounded, coefficients).map(|drive| drive.first(shown));
    let about = About::new(session, plan);
    let trained = trajectories::scenes(&drives, plan.follow_direction);
    let mut figures = vec![
        Figure {
            name: "staircases.svg",
            svg: staircases::draw(&session.knowledge, &coefficients.ranges, &about.learned),
        },
        Figure {
            name: "patterns.svg",
            svg: patterns::draw(
                &palette,
                coefficients.parameters().learning.phase_limit_deg,
                "Patterns in use after learning",
                &format!(
                    "{}; {arenas} drives in arenas never met before",
                    about.learned
                ),
            ),
        },
        Figure {
            name: "learning.svg",
            svg: learning::draw(
                sessions,
                plan.follow_direction,
                &about.sessions(sessions.len()),
            ),
        },
    ];
    // The last scene is the one with most obstacles.
    if let Some(scene) = trained.last() {
        let title = "The sequence of patterns along a drive after learning";
        let subtitle = format!("{}. {}", about.learned, scene.title);
        let svg = sequence::draw(scene, &palette, title, &subtitle);
        figures.push(Figure {
            name: "sequence.svg",
            svg,
        });
    }
    let untrained = first.as_ref().map(|drive| Scene {
        title: "First trial, nothing learned yet".into(),
        drive,
    });
    let scenes: Vec<Scene> = untrained.into_iter().chain(trained).collect();
    let title = "Trajectories before and after learning";
    let svg = trajectories::draw(&scenes, &palette, title, &about.learned);
    figures.push(Figure {
        name: "trajectories.svg",
        svg,
    });
    figures
}

/// What figures say of the session they are about.
struct About {
    learned: String,
    seed: u64,
    trials: String,
}

impl About {
    fn new(session: &LearnedSession, plan: &SessionPlan) -> Self {
        let count = session.trials.len();
        let plural = if count == 1 { "" } else { "s" };
        let trials = format!("{count} trial{plural} of at most {} actions", plan.steps);
        let learned = format!("Session with seed {}, {trials}", session.seed);
        Self {
            learned,
            seed: session.seed,
            trials,
        }
    }

    fn sessions(&self, count: usize) -> String {
        match count {
            1 => self.learned.clone(),
            _ => format!(
                "{count} sessions with seeds from {}, each of {}",
                self.seed, self.trials
            ),
        }
    }
}
