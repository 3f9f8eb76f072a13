//! A log as a feed: played, paused, wound.

use std::time::Duration;

use rover_shared::wire::message::Command;

use super::feed::{Connection, Control, Feed, FeedEvent, Origin, Playback};
use rover_link::Counters;
use rover_log::Log;
use rover_log::recording::What;

/// How long an entry of a simulation's log is shown: it has no times of its own.
const ENTRY: Duration = Duration::from_millis(250);
/// The slowest and the fastest playing.
const SPEEDS: (f64, f64) = (1.0 / 64.0, 1_024.0);
/// Events that one poll returns at most, so that keys are read even while winding.
const MOST: usize = 1_000;

/// A log that is shown.
pub struct Player {
    name: String,
    begin: FeedEvent,
    entries: Vec<(Duration, FeedEvent)>,
    /// For each action, the number of the entry after it.
    actions: Vec<usize>,
    cut_off: bool,
    /// The next entry.
    at: usize,
    /// The time within the log.
    position: Duration,
    playing: bool,
    speed: f64,
    /// An entry to be reached at once.
    goal: usize,
    begun: bool,
    /// The playback that was last reported.
    told: Option<Playback>,
    now: Duration,
}

impl Player {
    /// A simulation's log.
    pub fn of_simulation(name: String, log: Log) -> Self {
        let begin = FeedEvent::Begin(Some(Origin {
            seed: log.origin.seed,
            knowledge: log.before,
        }));
        let times = (0u32..).map(|i| ENTRY.saturating_mul(i));
        let entries = times.zip(log.entries.into_iter().map(FeedEvent::Logged));
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
            // A clock that was set back does not stop the playing.
            latest = latest.max(time);
            if message.lost > 0 {
                frames.lost = frames.lost.saturating_add(message.lost.into());
                entries.push((latest, FeedEvent::Frames(frames)));
            }
            let event = match message.what {
                What::Report(report) => FeedEvent::Report(report),
                What::Gap(gap) => FeedEvent::Gap(gap.reason),
                What::Command(_) | What::Truth(_) => continue,
                What::Knowledge(pulled) => match recorded.knowledge.get(&pulled.fingerprint) {
                    Some(bytes) => FeedEvent::Knowledge(bytes.to_vec()),
                    None => continue,
                },
            };
            entries.push((latest, event));
        }
        Self::new(name, FeedEvent::Begin(None), entries, recorded.cut_off)
    }

    /// Events at times that do not decrease, from `begin` on.
    pub fn new(
        name: String,
        begin: FeedEvent,
        entries: Vec<(Duration, FeedEvent)>,
        cut_off: bool,
    ) -> Self {
        let mut actions: Vec<_> = (1..)
            .zip(&entries)
            .filter(|(_, (_, event))| event.is_action())
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

    /// Moves by a number of actions from the one shown last, backwards if negative.
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

    fn start(&mut self, events: &mut Vec<FeedEvent>) {
        self.begun = true;
        self.at = 0;
        self.position = Duration::ZERO;
        events.push(FeedEvent::Connection(Connection::Log(self.name.clone())));
        events.push(self.begin.clone());
    }
}

impl Feed for Player {
    fn now(&self) -> Duration {
        self.now
    }

    fn poll(&mut self, timeout: Duration) -> Vec<FeedEvent> {
        self.now = self.now.saturating_add(timeout);
        let mut events = Vec::new();
        if !self.begun {
            self.start(&mut events);
        }
        if self.playing {
            let passed = Duration::try_from_secs_f64(timeout.as_secs_f64() * self.speed);
            self.position = self.position.saturating_add(passed.unwrap_or_default());
        }
        while let Some((time, event)) = self.entries.get(self.at) {
            let wound = self.at < self.goal;
            let due = wound || (self.playing && *time <= self.position);
            if !due || events.len() >= MOST {
                break;
            }
            if wound {
                self.position = *time;
            }
            events.push(event.clone());
            self.at += 1;
        }
        if self.at == self.entries.len() {
            self.playing = false;
        }
        let playback = self.playback();
        if self.told != Some(playback) {
            self.told = Some(playback);
            events.push(FeedEvent::Playback(playback));
        }
        events
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

    fn player(entries: u64) -> Player {
        let begin = FeedEvent::Begin(None);
        let command = Command::Ping;
        let entry = FeedEvent::Answer {
            command,
            result: Ok(()),
        };
        let entries = (0..entries).map(|i| (TICK * i as u32, entry.clone()));
        Player::new("a.mcap".into(), begin, entries.collect(), false)
    }

    fn shown(events: &[FeedEvent]) -> usize {
        let entry = |h: &&FeedEvent| matches!(h, FeedEvent::Answer { .. });
        events.iter().filter(entry).count()
    }

    fn begins(events: &[FeedEvent]) -> bool {
        events.iter().any(|h| matches!(h, FeedEvent::Begin(_)))
    }

    #[test]
    fn entries_come_at_their_times() {
        let mut player = player(10);
        let first = player.poll(Duration::ZERO);
        assert!(begins(&first));
        assert_eq!(shown(&first), 1);
        assert_eq!(shown(&player.poll(TICK)), 1);
        assert_eq!(shown(&player.poll(TICK / 2)), 0);
        player.control(Control::Faster);
        assert_eq!(shown(&player.poll(TICK)), 2);
        player.control(Control::PlayOrPause);
        assert_eq!(shown(&player.poll(TICK * 100)), 0);
        player.control(Control::PlayOrPause);
        assert_eq!(shown(&player.poll(TICK * 100)), 6);
        assert!(player.ended());
    }

    #[test]
    fn winding_back_shows_it_from_the_start() {
        let mut player = player(10);
        player.control(Control::End);
        assert_eq!(shown(&player.poll(TICK)), 10);
        player.control(Control::Actions(-1));
        let events = player.poll(TICK);
        assert!(begins(&events));
        assert_eq!(shown(&events), 9);
        player.control(Control::Actions(1));
        assert_eq!(shown(&player.poll(TICK)), 1);
        player.control(Control::Actions(-4));
        assert_eq!(shown(&player.poll(TICK)), 6);
        player.control(Control::Actions(-20));
        assert_eq!(shown(&player.poll(TICK)), 0);
        player.control(Control::Actions(20));
        assert_eq!(shown(&player.poll(TICK)), 10);
        player.control(Control::Start);
        assert_eq!(shown(&player.poll(TICK)), 0);
        player.control(Control::PlayOrPause);
        assert_eq!(shown(&player.poll(TICK)), 2, "it plays from the start");
    }

    #[test]
    fn playing_at_the_end_starts_anew() {
        let mut player = player(3);
        player.control(Control::End);
        player.poll(TICK);
        player.control(Control::PlayOrPause);
        let events = player.poll(Duration::ZERO);
        assert!(begins(&events));
        assert_eq!(shown(&events), 1);
    }

    #[test]
    fn a_long_log_is_wound_in_parts() {
        let mut player = player(2 * MOST as u64);
        player.control(Control::End);
        let polls = (1..).find(|_| {
            assert!(player.poll(TICK).len() <= MOST + 2);
            player.ended()
        });
        assert_eq!(polls, Some(3));
    }
}
