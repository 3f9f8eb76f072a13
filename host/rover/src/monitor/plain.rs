//! The dashboard as lines, for screen readers, pipes and simple terminals: no colour, no cursor
//! movement, a line an event, and their rate limited.

use std::time::Duration;

use ratatui::crossterm::event::KeyCode;
use rover_shared::controller::Familiarity;
use rover_shared::sensing::Stimulus;
use rover_shared::sensing::neuron::Activation;
use rover_shared::wire::message::Command;

use super::feed::FeedEvent;
use super::keys::{Meaning, direction, meaning};
use super::model::{Action, Dashboard, Knowledge};
use crate::lines;
use rover_link::{names, text};

/// Lines that may come at once, and the time until another one may.
const BURST: u32 = 10;
const REFILL: Duration = Duration::from_millis(500);
/// Patterns that are listed.
const PATTERNS: usize = 10;

/// What may be typed.
pub const HELP: &str = "type: arm, disarm (or an empty line), learn, run, idle, direction DEGREES, \
    fixed, wander, store, status, patterns, staircases, help, quit, leave";

/// Turns events into lines.
pub struct Plain {
    /// Time between two actions that are shown.
    every: Duration,
    told: Option<Duration>,
    untold: u32,
    noted: u64,
    /// Lines that may still come, and when another one was last allowed.
    allowed: u32,
    refilled: Duration,
    left_out: u32,
}

impl Plain {
    /// Shows one action in `every`, and all other events.
    pub fn new(every: Duration) -> Self {
        Self {
            every,
            told: None,
            untold: 0,
            noted: 0,
            allowed: BURST,
            refilled: Duration::ZERO,
            left_out: 0,
        }
    }

    /// The lines for an event at `now`, which the dashboard has already taken.
    pub fn lines(
        &mut self,
        now: Duration,
        event: &FeedEvent,
        dashboard: &Dashboard,
    ) -> Vec<String> {
        self.refill(now);
        let mut lines = Vec::new();
        let fresh = dashboard.noted.saturating_sub(self.noted);
        self.noted = dashboard.noted;
        let kept = dashboard.notes.len();
        let skipped = kept.saturating_sub(usize::try_from(fresh).unwrap_or(kept));
        for note in dashboard.notes.iter().skip(skipped) {
            if self.allowed == 0 {
                self.left_out += 1;
                continue;
            }
            self.allowed -= 1;
            if self.left_out > 0 {
                lines.push(format!("{} lines were left out", self.left_out));
                self.left_out = 0;
            }
            let time = note.time.map(text::clock);
            let text = text::printable(&note.line.text, false);
            lines.push(time.map_or(text.clone(), |time| format!("{time} {text}")));
        }
        if let FeedEvent::Playback(playback) = event
            && playback.cut_off
            && playback.at == playback.of
        {
            lines.push("the log is cut off here".into());
        }
        if let (true, Some(action)) = (event.is_action(), &dashboard.action) {
            lines.extend(self.action(now, action, dashboard));
        }
        lines
    }

    fn refill(&mut self, now: Duration) {
        let passed = now.saturating_sub(self.refilled);
        let more = (passed.as_millis() / REFILL.as_millis()).min(u128::from(BURST)) as u32;
        if more > 0 {
            self.allowed = (self.allowed + more).min(BURST);
            self.refilled = now;
        }
    }

    fn action(&mut self, now: Duration, action: &Action, dashboard: &Dashboard) -> Option<String> {
        let early = |told: Duration| now.saturating_sub(told) < self.every;
        if self.told.is_some_and(early) {
            self.untold += 1;
            return None;
        }
        self.told = Some(now);
        let time = dashboard.time.map(text::clock);
        let mut line = time.map_or(String::new(), |time| format!("{time} "));
        line.push_str(&sentence(action));
        if self.untold > 0 {
            let actions = if self.untold == 1 {
                "action"
            } else {
                "actions"
            };
            line.push_str(&format!("; {} {actions} before it not told", self.untold));
            self.untold = 0;
        }
        Some(line)
    }
}

/// An action as one sentence.
fn sentence(action: &Action) -> String {
    let step = &action.step;
    let mut parts = vec![match step.perceived {
        Some(perceived) => {
            let familiarity = match perceived.familiarity {
                Familiarity::Known => "known",
                Familiarity::New | Familiarity::Replaced(_) => "new",
            };
            format!(
                "action {}: pattern {} {familiarity}",
                step.step, perceived.code
            )
        }
        None if step.unsettled() => format!("action {}: no pattern settled", step.step),
        None => format!("action {}: no target sensed", step.step),
    }];
    let turn = text::turn(step.action.phase);
    let ahead = text::centimetres(step.action.module);
    parts.push(format!("turn {turn}, ahead {ahead} cm"));
    if let Some(outcome) = action.outcome {
        parts.push(names::outcome(outcome).into());
    }
    let [front, left, right] =
        [action.sample.front, action.sample.left, action.sample.right].map(text::centimetres);
    parts.push(format!("front {front}, left {left}, right {right} cm"));
    if let Some(sensed) = step.sensed {
        parts.push(format!("to go {}", text::turn(sensed.target_angle)));
        parts.push(format!(
            "reward {:.2}",
            f64::from(sensed.reward.total()) / 1e6
        ));
    }
    parts.join("; ")
}

/// Everything at this moment, in sentences.
pub fn status(dashboard: &Dashboard) -> Vec<String> {
    let mut lines = vec![super::view::connection(dashboard)];
    if let Some(rover) = &dashboard.rover {
        let name = format!("rover {} {}", rover.board, rover.firmware);
        lines.push(text::printable(&name, false));
    }
    if let Some(state) = dashboard.state {
        let state = names::loud_state(state);
        let motors = dashboard.motors_enabled.map(lines::motors);
        lines.push(match motors {
            Some(motors) => format!("state {state}, {motors}"),
            None => format!("state {state}"),
        });
    }
    if let Some(task) = dashboard.task {
        lines.push(format!("task {}", lines::task(task, dashboard.direction)));
    }
    if let Some(session) = dashboard.session {
        let (seed, knowledge) = (session.seed, lines::knowledge(Some(session.knowledge)));
        lines.push(format!("session seed {seed}, from {knowledge}"));
    }
    lines.extend(sensors(dashboard));
    if let Some(action) = &dashboard.action {
        lines.push(sentence(action));
    }
    lines.push(knowledge(dashboard));
    if let Some((command, refusal)) = &dashboard.refused {
        lines.push(lines::refused(command, *refusal));
    }
    lines.push(counters(dashboard));
    lines
}

fn sensors(dashboard: &Dashboard) -> Vec<String> {
    let mut lines = Vec::new();
    let readings = dashboard.readings;
    for (i, name) in names::CHANNELS.iter().enumerate() {
        let distance = readings.and_then(|readings| readings.distances[i]);
        let counts = readings.and_then(|readings| readings.counts).map(|c| c[i]);
        let health = dashboard.ranges.map(|ranges| ranges[i]);
        let parts: Vec<String> = [
            distance.map(|d| format!("{} cm", text::centimetres(d))),
            counts.map(|counts| format!("{counts} counts")),
            health.map(|health| names::channel_health(health).into()),
        ]
        .into_iter()
        .flatten()
        .collect();
        if !parts.is_empty() {
            lines.push(format!("range sensor {name}: {}", parts.join(", ")));
        }
    }
    if let Some(health) = dashboard.compass {
        let heading = readings.and_then(|readings| readings.heading);
        let heading = heading.map_or(String::new(), |h| format!("{}, ", text::compass(h)));
        lines.push(format!(
            "compass: {heading}{}",
            names::compass_health(health)
        ));
    }
    lines
}

fn knowledge(dashboard: &Dashboard) -> String {
    match &dashboard.knowledge {
        Knowledge::Known(mirror) => {
            let (patterns, steps) = (mirror.patterns().len(), mirror.steps());
            format!("knowledge of {patterns} patterns after {steps} actions")
        }
        Knowledge::Unknown(why) => format!("knowledge not known: {why}"),
    }
}

fn counters(dashboard: &Dashboard) -> String {
    let frames = &dashboard.frames;
    let mut text = format!(
        "{} frames lost, {} damaged, {} reports unread, {} actions missed, {} reconnections",
        frames.lost, frames.damaged, frames.unread, dashboard.missed, frames.reconnected
    );
    for (fault, count) in lines::counted(&dashboard.counters) {
        text.push_str(&format!(", {} {count}", names::fault(fault)));
    }
    text
}

/// The patterns used most.
pub fn patterns(dashboard: &Dashboard) -> Vec<String> {
    let Some(mirror) = dashboard.mirror() else {
        return vec![knowledge(dashboard)];
    };
    let told = mirror.by_use().into_iter().take(PATTERNS).map(|pattern| {
        let turn = pattern.phase.map_or("turn unknown".into(), text::turn);
        let drawing = text::pattern(pattern.code, [".", "#"]).join(" ");
        format!(
            "pattern {}, {} times, {turn}, rows {drawing}",
            pattern.code, pattern.occurrences
        )
    });
    std::iter::once(knowledge(dashboard)).chain(told).collect()
}

/// The staircases.
pub fn staircases(dashboard: &Dashboard) -> Vec<String> {
    let Some(mirror) = dashboard.mirror() else {
        return vec![knowledge(dashboard)];
    };
    let sensed = dashboard.action.and_then(|action| action.step.sensed);
    let each = Stimulus::ALL.into_iter().zip(mirror.neurons()).enumerate();
    each.map(|(i, (stimulus, neuron))| {
        let amplitudes = neuron.amplitudes();
        let texts =
            amplitudes.map(|a| format!("{:.2}", f64::from(a.0) / f64::from(Activation::ONE)));
        let active = sensed.map_or(String::new(), |sensed| {
            format!(", step {} active", sensed.percept.steps()[i].index())
        });
        format!(
            "{} steps {}{active}",
            names::stimulus(stimulus),
            texts.join(" ")
        )
    })
    .collect()
}

/// What a typed line asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// To do this.
    Do(Meaning),
    /// To show this.
    Tell(Topic),
}

/// What can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// A summary of everything.
    Status,
    /// The patterns used most.
    Patterns,
    /// The staircases.
    Staircases,
    /// What may be typed.
    Help,
}

impl Topic {
    /// Its lines.
    pub fn lines(self, dashboard: &Dashboard) -> Vec<String> {
        match self {
            Self::Status => status(dashboard),
            Self::Patterns => patterns(dashboard),
            Self::Staircases => staircases(dashboard),
            Self::Help => vec![HELP.into()],
        }
    }
}

/// Words that may be typed for the keys that are their first letters.
const WORDS: [&str; 9] = [
    "arm", "disarm", "learn", "run", "idle", "fixed", "wander", "store", "quit",
];

/// Parses a typed line.
///
/// # Errors
/// A sentence that says what may be typed.
pub fn understand(line: &str) -> Result<Asked, String> {
    let words: Vec<_> = line.split_whitespace().collect();
    let meant = |key: char| meaning(KeyCode::Char(key).into(), false).map(Asked::Do);
    let asked = match words[..] {
        [] => meant('d'),
        ["leave" | "Q"] => meant('Q'),
        ["direction" | "g", degrees] => {
            let command = Command::SetDirection(direction(degrees)?);
            Some(Asked::Do(Meaning::Command(command)))
        }
        ["status"] => Some(Asked::Tell(Topic::Status)),
        ["patterns"] => Some(Asked::Tell(Topic::Patterns)),
        ["staircases"] => Some(Asked::Tell(Topic::Staircases)),
        ["help" | "?"] => Some(Asked::Tell(Topic::Help)),
        [typed] => WORDS
            .iter()
            .find(|word| typed == **word || typed == &word[..1])
            .and_then(|word| word.chars().next())
            .and_then(meant),
        _ => None,
    };
    asked.ok_or_else(|| format!("not understood; {HELP}"))
}
