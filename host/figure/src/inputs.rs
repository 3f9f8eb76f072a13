//! What figures are made from: sessions that were just learned, or logs.

use rover_shared::parameters::Coefficients;
use rover_shared::sensing::neuron::SensingNeuron;

use super::drive::{Drive, first_trial, test_drives};
use super::figure::{Moment, NoSuchMoment};
use super::from_log::{LoggedSession, PART};
use super::page::{self, Fact};
use super::situations::Setting;
use rover_log::knowledge::followed::Followed;
use rover_simulator::arena::Side;
use rover_simulator::experiment::{Exam, History, LearnedSession, SessionPlan, Trial};

/// Drives from which scenes are chosen and in which the patterns in use are counted.
const DRIVES: u32 = 40;
/// Actions of all test drives together, at most: drives are kept in memory, and a trial may be
/// allowed a million actions. Forty drives of the paper's 500 actions (III-B).
const TEST_ACTIONS: u32 = 20_000;

/// What the figures of one source are made from.
pub(super) struct Inputs {
    pub coefficients: Coefficients,
    /// What the figures say they are about.
    pub about: About,
    pub setting: Setting,
    /// What a session consists of: "trial", "part".
    pub unit: &'static str,
    /// Whether a rover's true places are known, by an emulation.
    pub emulated: bool,
    /// At the end.
    pub lessons: Followed,
    pub history: History,
    /// Whether nothing was learned during the drives: all were driven with [`Self::lessons`].
    pub frozen: bool,
    /// The first trial, from nothing.
    pub first: Option<Drive>,
    /// Whether nothing was known before the first trial.
    pub from_nothing: bool,
    /// The drives from which scenes are chosen.
    pub drives: Vec<Drive>,
    /// All drives in which a moment can be asked for.
    all: Vec<Drive>,
    /// The trials of each session.
    pub sessions: Vec<Vec<Trial>>,
    pub facts: Vec<Fact>,
}

/// What the figures say they are about.
pub(super) struct About {
    /// The session or the log.
    pub source: String,
    /// The sessions or logs, of which there may be several.
    pub sources: String,
    /// The drives in which patterns are counted.
    pub drives: String,
}

/// One action of a drive.
pub(super) struct Place {
    pub drive: Drive,
    /// Its number in `drive`, from 0.
    pub at: usize,
}

impl Inputs {
    pub fn of_sessions(
        sessions: &[&LearnedSession],
        plan: &SessionPlan,
        exam: &Exam,
        coefficients: &Coefficients,
    ) -> Option<Self> {
        let session = sessions.first()?;
        let arenas = (TEST_ACTIONS / exam.steps.max(1)).clamp(1, DRIVES);
        let exam = Exam {
            arenas,
            steps: exam.steps.min(TEST_ACTIONS),
            ..exam.clone()
        };
        let bounded = SessionPlan {
            steps: plan.steps.min(TEST_ACTIONS),
            ..plan.clone()
        };
        let count = session.trials.len();
        let trials = format!(
            "{} of at most {} actions",
            counted(count, "trial"),
            plan.steps
        );
        let source = format!("Session with seed {}, {trials}", session.seed);
        let sources = match sessions.len() {
            1 => source.clone(),
            n => format!(
                "{n} sessions with seeds from {}, each of {trials}",
                session.seed
            ),
        };
        let drives = test_drives(&exam, coefficients, &session.knowledge);
        Some(Self {
            coefficients: coefficients.clone(),
            about: About {
                drives: format!(
                    "{} in arenas never met before",
                    counted(drives.len(), "drive")
                ),
                source,
                sources,
            },
            setting: Setting {
                state: "trained",
                unit: "arena",
                follow_direction: plan.follow_direction,
            },
            unit: "trial",
            emulated: false,
            lessons: Followed::of(&session.knowledge, coefficients.learning.amplitude_limit),
            history: session.history.clone(),
            frozen: true,
            first: first_trial(&bounded, coefficients),
            from_nothing: true,
            facts: page::facts(
                &sessions
                    .iter()
                    .map(|s| s.trials.as_slice())
                    .collect::<Vec<_>>(),
                &drives.iter().map(|d| d.trial.clone()).collect::<Vec<_>>(),
                "trial",
                &counted(drives.len(), "test drive"),
                session.knowledge.patterns.elements().len(),
                plan.follow_direction,
            ),
            all: drives.clone(),
            drives,
            sessions: sessions.iter().map(|s| s.trials.clone()).collect(),
        })
    }

    pub fn of_recordings(recordings: &[(String, LoggedSession)]) -> Option<Self> {
        let (name, recording) = recordings.first()?;
        let follow_direction = recording.follows_direction();
        let count = recording.drives.len();
        let actions: u64 = recording.history.actions();
        let cut = if recording.cut_off { ", cut off" } else { "" };
        let actions = counted(actions as usize, "action");
        let (unit, contents) = if recording.free_running {
            ("part", format!("{actions} in parts of {PART}"))
        } else {
            ("trial", format!("{}, {actions}", counted(count, "trial")))
        };
        let source = format!("Log {name} (seed {}): {contents}{cut}", recording.seed);
        let sources = match recordings.len() {
            1 => source.clone(),
            n => {
                let names = recordings.iter().take(4).map(|(name, _)| name.as_str());
                let more = if n > 4 { ", ..." } else { "" };
                format!("{n} logs: {}{more}", names.collect::<Vec<_>>().join(", "))
            }
        };
        // While learning, the last trials show best what was learned.
        let learning = recording.learning && count > 1;
        let from = if learning {
            count.saturating_sub(DRIVES as usize).max(count / 2)
        } else {
            0
        };
        let drives = recording.drives[from..].to_vec();
        let trials = |recording: &LoggedSession| -> Vec<Trial> {
            recording.drives.iter().map(|d| d.trial.clone()).collect()
        };
        let sessions: Vec<Vec<Trial>> = recordings.iter().map(|(_, r)| trials(r)).collect();
        let shown: Vec<Trial> = drives.iter().map(|d| d.trial.clone()).collect();
        let which = match (learning, drives.len()) {
            (true, n) => format!("last {}", counted(n, unit)),
            (false, n) => format!("all {}", counted(n, unit)),
        };
        Some(Self {
            coefficients: recording.coefficients.clone(),
            about: About {
                drives: match (learning, drives.len()) {
                    (true, 1) => format!("the last {unit}"),
                    (true, n) => format!("the last {}", counted(n, unit)),
                    (false, n) => format!("all {}", counted(n, unit)),
                },
                source,
                sources,
            },
            setting: Setting {
                state: if learning { "late in learning" } else { "" },
                unit,
                follow_direction,
            },
            unit,
            emulated: recording.free_running && drives.iter().all(|drive| drive.arena_known),
            lessons: recording.lessons.clone(),
            history: recording.history.clone(),
            frozen: !recording.learning,
            first: learning.then(|| recording.drives[0].clone()),
            from_nothing: recording.from_nothing,
            facts: page::facts(
                &sessions.iter().map(Vec::as_slice).collect::<Vec<_>>(),
                &shown,
                unit,
                &which,
                recording.lessons.patterns().len(),
                follow_direction,
            ),
            drives,
            all: recording.drives.clone(),
            sessions,
        })
    }

    /// The moment that was asked for.
    pub fn moment(&self, moment: Moment) -> Result<Place, NoSuchMoment> {
        let usual = self.usual_moment();
        if moment == Moment::default() {
            return Ok(usual);
        }
        let drive = match moment.trial {
            None => self
                .all
                .iter()
                .find(|drive| drive.number == usual.drive.number),
            Some(number) => self.all.iter().find(|drive| drive.number == number),
        };
        let Some(drive) = drive else {
            let numbers = || self.all.iter().map(|drive| drive.number);
            let [first, last] = [numbers().min(), numbers().max()].map(Option::unwrap_or_default);
            return Err(NoSuchMoment::Trial(moment.trial.unwrap_or(0), first, last));
        };
        let at = moment.at.unwrap_or_else(|| telling_action(drive));
        if at >= drive.events.len() {
            return Err(NoSuchMoment::At(drive.number, at, drive.events.len()));
        }
        Ok(Place {
            drive: drive.clone(),
            at,
        })
    }

    /// The moment shown unless another is asked for: where an obstacle comes into sight.
    pub fn usual_moment(&self) -> Place {
        let scenes = self.setting.scenes(&self.drives);
        let sees = |drive: &Drive| drive.events.iter().any(|e| drive.saw(e, Side::Front));
        let in_front = scenes.iter().find(|scene| scene.title.contains("in front"));
        let scene = in_front
            .or_else(|| scenes.iter().find(|scene| sees(&scene.drive)))
            .or(scenes.last());
        let number = scene.map(|scene| scene.drive.number);
        let from = scene.map_or(0, |scene| scene.drive.from);
        let drive = self.all.iter().find(|drive| Some(drive.number) == number);
        match (scene, drive.or(self.all.first())) {
            (Some(scene), Some(drive)) => Place {
                at: from + telling_action(&scene.drive),
                drive: drive.clone(),
            },
            (_, Some(drive)) => Place {
                at: telling_action(drive),
                drive: drive.clone(),
            },
            (_, None) => unreachable!("there are no inputs without drives"),
        }
    }

    /// The staircases by which an action was chosen.
    pub fn neurons_at(&self, drive: &Drive, at: usize) -> [SensingNeuron; 4] {
        if self.frozen {
            *self.lessons.neurons()
        } else {
            self.history.at(drive.first_action + at as u64)
        }
    }
}

/// The first action at which the front sensor sees something and another pattern arises than
/// before; or at which any sensor sees something; or the first of all.
fn telling_action(drive: &Drive) -> usize {
    let codes: Vec<_> = drive.codes().collect();
    let ahead = |i: &usize| drive.saw(&drive.events[*i], Side::Front);
    let beside = |i: &usize| {
        let sides = [Side::Left, Side::Right];
        sides.iter().any(|side| drive.saw(&drive.events[*i], *side))
    };
    let all = 0..drive.events.len();
    all.clone()
        .find(|i| *i > 0 && ahead(i) && codes[*i] != codes[*i - 1])
        .or_else(|| all.clone().find(ahead))
        .or_else(|| all.clone().find(beside))
        .unwrap_or(0)
}

/// A number of things, in words.
pub(super) fn counted(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}
