//! A log as a source: played, paused, wound.

use std::time::Duration;

use rover_shared::wire::message::Command;

use super::happening::{Connection, Happening, Origin, Playback};
use super::source::{Control, Source};
use rover_link::Counters;
use rover_log::recording::What;
use rover_log::{self, Log};

/// How long an entry of a simulation's log is shown: it has no times of its own.
const ENTRY: Duration = Duration::from_millis(250);
/// The slowest and the fastest playing.
const SPEEDS: (f64, f64) = (1.0 / 64.0, 1_024.0);
/// Happenings given by one poll at most, so that keys are heard even while winding.
const MOST: usize = 1_000;

/// A log that is shown.
pub struct Recording {
    name: String,
    begin: Happening,
    entries: Vec<(Duration, Happening)>,
    /// For each action, the number of the entry after it.
    actions: Vec<usize>,
    cut_off: bool,
    /// The next entry.
    at: usize,
    /// Where in the log's time the showing is.
    position: Duration,
    playing: bool,
    speed: f64,
    /// An entry to be reached at once.
    goal: usize,
    begun: bool,
    /// What is shown of the playing itself.
    told: Option<Playback>,
    now: Duration,
}

impl Recording {
    /// A simulation's log.
    pub fn of_simulation(name: String, log: Log) -> Self {
        let begin = Happening::Begin(Some(Origin {
            seed: log.origin.seed,
            knowledge: log.before,
        }));
        let times = (0u32..).map(|i| ENTRY.saturating_mul(i));
        let entries = times.zip(log.entries.into_iter().map(Happening::Logged));
        Self::new(name, begin, entries.collect(), log.cut_off)
    }

    /// What was recorded of a rover.
    pub fn of_rover(name: String, recorded: rover_log::recording::Recording) -> Self {
        let start = recorded.messages.first().map_or(0, |m| m.log_time_ns);
        let mut entries = Vec::new();
        let mut frames = Counters::default();
        let mut latest = Duration::ZERO;
        for message in recorded.messages {
            let time = Duration::from_nanos(message.log_time_ns.saturating_sub(start));
            // A clock that was set back does not stop the showing.
            latest = latest.max(time);
            if message.lost > 0 {
                frames.lost = frames.lost.saturating_add(message.lost.into());
                entries.push((latest, Happening::Frames(frames)));
            }
            let happening = match message.what {
                What::Report(report) => Happening::Report(report),
                What::Gap(gap) => Happening::Gap(gap.reason),
                What::Command(_) | What::Truth(_) => continue,
                What::Knowledge(pulled) => match recorded.knowledge.get(&pulled.fingerprint) {
                    Some(bytes) => Happening::Knowledge(bytes.to_vec()),
                    None => continue,
                },
            };
            entries.push((latest, happening));
        }
        Self::new(name, Happening::Begin(None), entries, recorded.cut_off)
    }

    /// What happened at times that do not fall, from `begin` on.
    pub fn new(
        name: String,
        begin: Happening,
        entries: Vec<(Duration, Happening)>,
        cut_off: bool,
    ) -> Self {
        let mut actions: Vec<_> = (1..)
            .zip(&entries)
            .filter(|(_, (_, happening))| happening.is_action())
            .map(|(after, _)| after)
            .collect();
        if actions.is_empty() {
            actions = (1..=entries.len()).collect();
        }
        Self {
            name,
            begin,
            entries,
            actions,
            cut_off,
            at: 0,
            position: Duration::ZERO,
            playing: true,
            speed: 1.0,
            goal: 0,
            begun: false,
            told: None,
            now: Duration::ZERO,
        }
    }

    fn playback(&self) -> Playback {
        Playback {
            playing: self.playing,
            speed: self.speed,
            at: self.at,
            of: self.entries.len(),
            cut_off: self.cut_off,
        }
    }

    /// Shows the log up to this entry, from the start if it lies before what is shown.
    fn wind(&mut self, goal: usize) {
        self.goal = goal.min(self.entries.len());
        self.playing = false;
        if self.goal < self.at {
            self.begun = false;
        }
    }

    /// Shows the log up to the action that lies so many after the one shown last, or before it.
    fn step(&mut self, by: i32) {
        // Keys may come faster than the log is wound.
        let winding = !self.playing && (self.goal > self.at || !self.begun);
        let from = if winding { self.goal } else { self.at };
        let shown = self.actions.partition_point(|after| *after <= from);
        let goal = shown.saturating_add_signed(by as isize);
        let goal = match goal.checked_sub(1) {
            None => 0,
            Some(last) => *self.actions.get(last).unwrap_or(&self.entries.len()),
        };
        self.wind(goal);
    }

    fn start(&mut self, happened: &mut Vec<Happening>) {
        self.begun = true;
        self.at = 0;
        self.position = Duration::ZERO;
        happened.push(Happening::Connection(Connection::Log(self.name.clone())));
        happened.push(self.begin.clone());
    }
}

impl Source for Recording {
    fn now(&self) -> Duration {
        self.now
    }

    fn poll(&mut self, timeout: Duration) -> Vec<Happening> {
        self.now = self.now.saturating_add(timeout);
        let mut happened = Vec::new();
        if !self.begun {
            self.start(&mut happened);
        }
        if self.playing {
            let passed = Duration::try_from_secs_f64(timeout.as_secs_f64() * self.speed);
            self.position = self.position.saturating_add(passed.unwrap_or_default());
        }
        while let Some((time, happening)) = self.entries.get(self.at) {
            let wound = self.at < self.goal;
            let due = wound || (self.playing && *time <= self.position);
            if !due || happened.len() >= MOST {
                break;
            }
            if wound {
                self.position = *time;
            }
            happened.push(happening.clone());
            self.at += 1;
        }
        if self.at == self.entries.len() {
            self.playing = false;
        }
        let playback = self.playback();
        if self.told != Some(playback) {
            self.told = Some(playback);
            happened.push(Happening::Playback(playback));
        }
        happened
    }

    fn send(&mut self, _command: &Command) {}

    fn control(&mut self, control: Control) {
        match control {
            Control::PlayOrPause => {
                self.goal = 0;
                if self.at == self.entries.len() {
                    self.begun = false;
                }
                self.playing = !self.playing;
            }
            Control::Faster => self.speed = (self.speed * 2.0).min(SPEEDS.1),
            Control::Slower => self.speed = (self.speed / 2.0).max(SPEEDS.0),
            Control::Actions(by) => self.step(by),
            Control::Start => self.wind(0),
            Control::End => self.wind(self.entries.len()),
        }
    }

    fn is_log(&self) -> bool {
        true
    }

    fn ended(&self) -> bool {
        self.begun && self.at == self.entries.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: Duration = Duration::from_millis(100);

    fn recording(entries: u64) -> Recording {
        let begin = Happening::Begin(None);
        let command = Command::Ping;
        let entry = Happening::Answer {
            command,
            result: Ok(()),
        };
        let entries = (0..entries).map(|i| (TICK * i as u32, entry.clone()));
        Recording::new("a.mcap".into(), begin, entries.collect(), false)
    }

    fn shown(happened: &[Happening]) -> usize {
        let entry = |h: &&Happening| matches!(h, Happening::Answer { .. });
        happened.iter().filter(entry).count()
    }

    fn begins(happened: &[Happening]) -> bool {
        happened.iter().any(|h| matches!(h, Happening::Begin(_)))
    }

    #[test]
    fn entries_come_at_their_times() {
        let mut recording = recording(10);
        let first = recording.poll(Duration::ZERO);
        assert!(begins(&first));
        assert_eq!(shown(&first), 1);
        assert_eq!(shown(&recording.poll(TICK)), 1);
        assert_eq!(shown(&recording.poll(TICK / 2)), 0);
        recording.control(Control::Faster);
        assert_eq!(shown(&recording.poll(TICK)), 2);
        recording.control(Control::PlayOrPause);
        assert_eq!(shown(&recording.poll(TICK * 100)), 0);
        recording.control(Control::PlayOrPause);
        assert_eq!(shown(&recording.poll(TICK * 100)), 6);
        assert!(recording.ended());
    }

    #[test]
    fn winding_back_shows_it_from_the_start() {
        let mut recording = recording(10);
        recording.control(Control::End);
        assert_eq!(shown(&recording.poll(TICK)), 10);
        recording.control(Control::Actions(-1));
        let happened = recording.poll(TICK);
        assert!(begins(&happened));
        assert_eq!(shown(&happened), 9);
        recording.control(Control::Actions(1));
        assert_eq!(shown(&recording.poll(TICK)), 1);
        recording.control(Control::Actions(-4));
        assert_eq!(shown(&recording.poll(TICK)), 6);
        recording.control(Control::Actions(-20));
        assert_eq!(shown(&recording.poll(TICK)), 0);
        recording.control(Control::Actions(20));
        assert_eq!(shown(&recording.poll(TICK)), 10);
        recording.control(Control::Start);
        assert_eq!(shown(&recording.poll(TICK)), 0);
        recording.control(Control::PlayOrPause);
        assert_eq!(shown(&recording.poll(TICK)), 2, "it plays from the start");
    }

    #[test]
    fn playing_at_the_end_starts_anew() {
        let mut recording = recording(3);
        recording.control(Control::End);
        recording.poll(TICK);
        recording.control(Control::PlayOrPause);
        let happened = recording.poll(Duration::ZERO);
        assert!(begins(&happened));
        assert_eq!(shown(&happened), 1);
    }

    #[test]
    fn a_long_log_is_wound_in_parts() {
        let mut recording = recording(2 * MOST as u64);
        recording.control(Control::End);
        let polls = (1..).find(|_| {
            assert!(recording.poll(TICK).len() <= MOST + 2);
            recording.ended()
        });
        assert_eq!(polls, Some(3));
    }
}
