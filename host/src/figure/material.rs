//! What figures are made from: sessions that were just learned, or logs.

use rover_shared::parameters::Coefficients;
use rover_shared::sensing::neuron::SensingNeuron;

use super::drive::{Drive, first_trial, test_drives};
use super::lattice::Growth;
use super::lessons::Lessons;
use super::page::{self, Fact};
use super::palette::Palette;
use super::recording::Recording;
use super::scenes::{Scene, Setting};
use super::shape::Heading;
use super::{
    Figure, Figures, Moment, NoSuchMoment, lattice, learning, neuron, overview, patterns, position,
    sequence, staircases, trajectories,
};
use crate::arena::Side;
use crate::experiment::{Exam, History, LearnedSession, SessionPlan, Trial};

/// Drives from which scenes are chosen and in which the patterns in use are counted.
const DRIVES: u32 = 40;
/// Actions of all test drives together, at most: drives are kept in memory, and a trial may be
/// allowed a million actions. Forty drives of the paper's 500 actions (III-B).
const TEST_ACTIONS: u32 = 20_000;

/// What the figures of one source are made from.
pub(super) struct Material {
    coefficients: Coefficients,
    /// What the figures say they are about.
    about: About,
    setting: Setting,
    /// At the end.
    lessons: Lessons,
    history: History,
    /// Whether nothing was learned during the drives: all were driven with [`Self::lessons`].
    frozen: bool,
    /// The first trial, from nothing.
    first: Option<Drive>,
    /// Whether nothing was known before the first trial.
    from_nothing: bool,
    /// The drives from which scenes are chosen.
    drives: Vec<Drive>,
    /// All drives in which a moment can be asked for.
    all: Vec<Drive>,
    /// The trials of each session.
    sessions: Vec<Vec<Trial>>,
    facts: Vec<Fact>,
}

/// What the figures say they are about.
struct About {
    /// The session or the log.
    source: String,
    /// The sessions or logs, of which there may be several.
    sources: String,
    /// The drives in which patterns are counted.
    drives: String,
}

/// One action of a drive.
pub(super) struct Place {
    pub drive: Drive,
    /// Its number in `drive`, from 0.
    pub at: usize,
}

impl Material {
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
            lessons: Lessons::of(&session.knowledge),
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
                &counted(drives.len(), "test drive"),
                session.knowledge.patterns.elements().len(),
                plan.follow_direction,
            ),
            all: drives.clone(),
            drives,
            sessions: sessions.iter().map(|s| s.trials.clone()).collect(),
        })
    }

    pub fn of_recordings(recordings: &[(String, Recording)]) -> Option<Self> {
        let (name, recording) = recordings.first()?;
        let follow_direction = recording.follows_direction();
        let count = recording.drives.len();
        let actions: u64 = recording.history.actions();
        let cut = if recording.cut_off { ", cut off" } else { "" };
        let source = format!(
            "Log {name} (seed {}): {}, {}{cut}",
            recording.seed,
            counted(count, "trial"),
            counted(actions as usize, "action"),
        );
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
            count.saturating_sub(DRIVES as usize).max(1)
        } else {
            0
        };
        let drives = recording.drives[from..].to_vec();
        let trials = |recording: &Recording| -> Vec<Trial> {
            recording.drives.iter().map(|d| d.trial.clone()).collect()
        };
        let sessions: Vec<Vec<Trial>> = recordings.iter().map(|(_, r)| trials(r)).collect();
        let shown: Vec<Trial> = drives.iter().map(|d| d.trial.clone()).collect();
        let which = match (learning, drives.len()) {
            (true, n) => format!("last {}", counted(n, "trial")),
            (false, n) => format!("all {}", counted(n, "trial")),
        };
        Some(Self {
            coefficients: recording.coefficients.clone(),
            about: About {
                drives: match (learning, drives.len()) {
                    (true, 1) => "the last trial".into(),
                    (true, n) => format!("the last {n} trials"),
                    (false, n) => format!("all {}", counted(n, "trial")),
                },
                source,
                sources,
            },
            setting: Setting {
                state: if learning { "late in learning" } else { "" },
                unit: "trial",
                follow_direction,
            },
            lessons: recording.lessons.clone(),
            history: recording.history.clone(),
            frozen: !recording.learning,
            first: learning.then(|| recording.drives[0].clone()),
            from_nothing: recording.from_nothing,
            facts: page::facts(
                &sessions.iter().map(Vec::as_slice).collect::<Vec<_>>(),
                &shown,
                &which,
                recording.lessons.patterns(),
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
            (_, None) => unreachable!("there is no material without drives"),
        }
    }

    /// The staircases by which an action was chosen.
    fn neurons_at(&self, drive: &Drive, at: usize) -> [SensingNeuron; 4] {
        if self.frozen {
            self.lessons.neurons
        } else {
            self.history.at(drive.first_action + at as u64)
        }
    }

    /// Draws all figures and the page.
    pub fn draw(&self, place: &Place) -> Figures {
        let palette = Palette::new(&self.drives, &self.lessons);
        let scenes = self.setting.scenes(&self.drives);
        let growths = lattice::chosen(&self.drives, &palette, &self.coefficients.lattice);
        let mut figures = vec![
            self.overview(&scenes, &growths, &palette),
            self.lattice(&growths, &palette),
            self.neuron(),
            self.staircases(),
            self.trajectories(&scenes, &palette),
            self.position(place, &palette),
        ];
        figures.extend(scenes.last().map(|scene| self.sequence(scene, &palette)));
        figures.push(self.patterns(&palette));
        figures.push(self.learning());
        let report = page::page(&self.about.sources, &self.facts, &figures);
        Figures { figures, report }
    }

    /// The first trial as a scene, if there is one worth comparing.
    fn untrained(&self) -> Option<Scene> {
        let drive = self.first.as_ref()?;
        Some(Scene {
            title: if self.from_nothing {
                "First trial, nothing learned yet".into()
            } else {
                "First trial".into()
            },
            place: "trial 1".into(),
            drive: self.setting.shown(drive),
        })
    }

    fn overview(&self, scenes: &[Scene], growths: &[Growth], palette: &Palette) -> Figure {
        let untrained = self.untrained();
        let shown: Vec<&Scene> = untrained.iter().chain(scenes.last()).collect();
        let heading = Heading {
            title: "What the robot does, and what it perceives by".into(),
            subtitle: self.about.source.clone(),
            description: format!(
                "{} {}",
                trajectories::described(&shown),
                lattice::described(overview::chosen(growths))
            ),
        };
        Figure {
            name: "overview.svg",
            paper: "",
            caption:
                "Above, a drive at the start of learning and one after it; every move has the \
                colour of the pattern that chose it. Below, how two of these patterns grow from \
                what was sensed."
                    .into(),
            svg: overview::draw(&shown, &overview::chosen(growths), palette, &heading),
        }
    }

    fn lattice(&self, growths: &[Growth], palette: &Palette) -> Figure {
        let heading = Heading {
            title: "How patterns grow in the network".into(),
            subtitle: format!("{}; percepts of {}", self.about.source, self.about.drives),
            description: lattice::described(growths),
        };
        Figure {
            name: "lattice.svg",
            paper: "Fig. 2b, equations 1 and 3",
            caption: "Layer 1 of the reaction-diffusion network from the four corners that were \
                sensed until every cell has left the range from \u{2212}1 to 1: the pattern. Drawn \
                by the fixed-point network that drives the robot; layer 2 starts at 0 here, where \
                the robot adds noise of \u{b1}0.005. On the right, all 16 cells over time."
                .into(),
            svg: lattice::draw(growths, palette, &heading),
        }
    }

    fn neuron(&self) -> Figure {
        let lesson = neuron::Lesson::new(&self.history);
        let heading = Heading {
            title: "How a sensing neuron learns".into(),
            subtitle: self.about.source.clone(),
            description: lesson.described(),
        };
        Figure {
            name: "neuron.svg",
            paper: "Fig. 3, equations 5 and 6",
            caption: "The function of one sensing neuron, which turns a scaled reading into the \
                initial state of a corner cell. After an action that made things worse, a random \
                amount is added to the step in use and to all above it (5), or taken from it and \
                from all below it (6): the staircase never falls."
                .into(),
            svg: lesson.draw(&heading),
        }
    }

    fn staircases(&self) -> Figure {
        let heading = Heading {
            title: "What the sensing neurons learned".into(),
            subtitle: self.about.source.clone(),
            description: staircases::described(&self.lessons.neurons),
        };
        let ranges = &self.coefficients.ranges;
        Figure {
            name: "staircases.svg",
            paper: "Fig. 4",
            caption: "The four learned functions. Their values are the initial states of the \
                network's corner cells; all were 0 before learning."
                .into(),
            svg: staircases::draw(&self.lessons.neurons, ranges, &heading),
        }
    }

    fn trajectories(&self, scenes: &[Scene], palette: &Palette) -> Figure {
        let untrained = self.untrained();
        let compared = untrained.is_some();
        let scenes: Vec<&Scene> = untrained.iter().chain(scenes).collect();
        let heading = Heading {
            title: if compared {
                "Trajectories before and after learning".into()
            } else {
                "Trajectories".into()
            },
            subtitle: self.about.source.clone(),
            description: trajectories::described(&scenes),
        };
        let known = self.drives.iter().all(|drive| drive.arena_known);
        let mut caption = String::from(
            "Every move has the colour of the pattern that chose it. Triangles show where the \
             robot is headed. Scenes are the first ones in which a situation occurs, whatever the \
             robot made of it.",
        );
        if !known {
            caption += " The log does not say where walls and obstacles are: positions are by dead \
                reckoning from compass and moves, and grey dots are what the distance sensors saw.";
        }
        Figure {
            name: "trajectories.svg",
            paper: if self.setting.follow_direction {
                "Fig. 12 to 14"
            } else {
                "Fig. 5, 6, 8 and 9"
            },
            caption,
            svg: trajectories::draw(&scenes, palette, &heading),
        }
    }

    fn position(&self, place: &Place, palette: &Palette) -> Figure {
        let Place { drive, at } = place;
        let neurons = self.neurons_at(drive, *at);
        let numbered = format!(
            "{} {}, after {} actions",
            self.setting.unit, drive.number, at
        );
        let heading = Heading {
            title: "What the robot makes of one place".into(),
            subtitle: format!("{}; {numbered}", self.about.source),
            description: position::described(drive, *at),
        };
        let closeup = position::Closeup {
            drive,
            at: *at,
            neurons: &neurons,
            ranges: &self.coefficients.ranges,
        };
        Figure {
            name: "position.svg",
            paper: "Fig. 7",
            caption: "At A, each reading lies in one step of its sensing neuron (bold). The four \
                values of these steps are put into the corners of the network, which grows the \
                pattern, which stands for the turn. Grey sectors: what the distance sensors see. \
                Choose another place with rover figures LOG --trial N --at N."
                .into(),
            svg: position::draw(&closeup, palette, &heading),
        }
    }

    fn sequence(&self, scene: &Scene, palette: &Palette) -> Figure {
        let heading = Heading {
            title: "The sequence of patterns along a drive".into(),
            subtitle: format!("{}. {} ({})", self.about.source, scene.title, scene.place),
            description: sequence::described(&scene.drive, palette),
        };
        Figure {
            name: "sequence.svg",
            paper: if self.setting.follow_direction {
                "Fig. 14 and 15"
            } else {
                "Fig. 10"
            },
            caption: "Each dot is an action, in the row of the pattern that chose it; above, what \
                the sensors had in range. On the left the pattern, its code, how often it occurred \
                on this drive, and the turn it stands for."
                .into(),
            svg: sequence::draw(scene, palette, &heading),
        }
    }

    fn patterns(&self, palette: &Palette) -> Figure {
        let heading = Heading {
            title: if self.frozen && self.first.is_none() {
                "Patterns in use".into()
            } else {
                "Patterns in use after learning".into()
            },
            subtitle: format!("{}; {}", self.about.source, self.about.drives),
            description: patterns::described(palette),
        };
        let limit = self.coefficients.parameters().learning.phase_limit_deg;
        Figure {
            name: "patterns.svg",
            paper: "Fig. 10 and 15",
            caption:
                "How often each pattern chose an action, the pattern itself (filled cells are \
                at +1), its code (3), and the turn that was learned for it."
                    .into(),
            svg: patterns::draw(palette, limit, &heading),
        }
    }

    fn learning(&self) -> Figure {
        let sessions: Vec<&[Trial]> = self.sessions.iter().map(Vec::as_slice).collect();
        let follow_direction = self.setting.follow_direction;
        let heading = Heading {
            title: if self.frozen && self.first.is_none() {
                "Trial by trial".into()
            } else {
                "Learning, trial by trial".into()
            },
            subtitle: self.about.sources.clone(),
            description: learning::described(&sessions, follow_direction),
        };
        let caption = if sessions.len() > 1 {
            "How trials went from the first to the last, over all sessions. The band holds the \
             middle 80 % of them."
        } else {
            "How trials went from the first to the last. More sessions (rover learn --sessions 20, \
             or several logs) show how far they scatter."
        };
        Figure {
            name: "learning.svg",
            paper: "",
            caption: caption.into(),
            svg: learning::draw(&sessions, follow_direction, &heading),
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
