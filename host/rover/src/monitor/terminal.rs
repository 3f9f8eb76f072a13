//! The dashboard on a terminal, and as lines: the loops that keep it going.

use std::io::{self, IsTerminal as _};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::Duration;

use ratatui::Terminal;
use ratatui::backend::Backend;
use ratatui::crossterm::event::{self, Event, KeyEvent};
use rover_shared::wire::message::Command;

use super::app::App;
use super::feed::Feed;
use super::feed::FeedEvent;
use super::json;
use super::keys::Meaning;
use super::model::Dashboard;
use super::plain::{Asked, Plain, understand};
use super::view::{self, Look};

/// How long the feed is polled between two looks at the keys.
pub const TICK: Duration = Duration::from_millis(50);
/// Ticks to wait for the acknowledgement of the last disarming.
const FAREWELL: u32 = 40;

/// The disarming sent on quitting was not acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the rover did not acknowledge that it was disarmed, and may still drive: run `rover disarm`, \
     or switch it off"
)]
pub struct StillArmed;

/// Why the dashboard ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShowError {
    /// The terminal failed.
    #[error("the terminal cannot be used ({0}): try --plain")]
    Terminal(String),
    /// The rover may still drive.
    #[error(transparent)]
    StillArmed(#[from] StillArmed),
}

/// Keeps a feed's time from running ahead of the wall clock, so that people can follow an emulated
/// rover or a log.
pub struct Pacer {
    wall: std::time::Instant,
    own: Duration,
}

impl Pacer {
    /// Both clocks start now.
    pub fn new(own: Duration) -> Self {
        Self {
            wall: std::time::Instant::now(),
            own,
        }
    }

    /// Waits until the wall clock has come as far as `own`.
    pub fn wait(&mut self, own: Duration) {
        let passed = own.saturating_sub(self.own);
        let wall = self.wall.elapsed();
        match passed.checked_sub(wall) {
            Some(ahead) => std::thread::sleep(ahead),
            // A feed that cannot keep up does not hurry later.
            None if wall - passed > TICK => *self = Self::new(own),
            None => {}
        }
    }
}

/// Shows a feed on a terminal until the user quits. `keys` takes the feed's time and returns the
/// next key that waits.
///
/// # Errors
/// [`ShowError`].
pub fn show<B: Backend>(
    terminal: &mut Terminal<B>,
    feed: &mut dyn Feed,
    keys: &mut dyn FnMut(Duration) -> io::Result<Option<KeyEvent>>,
    look: Look,
) -> Result<(), ShowError> {
    let mut app = App::default();
    let shown = show_until_over(terminal, feed, keys, look, &mut app);
    if shown.is_err() && !app.is_over() {
        // The rover can neither be seen nor stopped any more.
        app.act(Meaning::Quit, feed);
    }
    farewell(&mut app, feed)?;
    shown
}

fn show_until_over<B: Backend>(
    terminal: &mut Terminal<B>,
    feed: &mut dyn Feed,
    keys: &mut dyn FnMut(Duration) -> io::Result<Option<KeyEvent>>,
    look: Look,
    app: &mut App,
) -> Result<(), ShowError> {
    while !app.is_over() {
        let log = feed.is_log();
        let drawn = terminal.draw(|frame| {
            view::draw(frame.area(), frame.buffer_mut(), app, log, look);
        });
        drawn.map_err(|error| ShowError::Terminal(error.to_string()))?;
        for event in feed.poll(TICK) {
            app.take(feed.now(), &event);
        }
        app.ask(feed);
        while let Some(key) = keys(feed.now()).map_err(failed)? {
            app.key(key, feed);
        }
    }
    Ok(())
}

fn failed(error: io::Error) -> ShowError {
    ShowError::Terminal(error.to_string())
}

/// The keys of the process's own terminal.
///
/// They are read in a thread of their own: crossterm 0.29 reads for ever from a terminal that has
/// gone, and the rover has to be told to stop then.
pub struct Keyboard(Receiver<io::Result<KeyEvent>>);

/// Keys pressed ahead that are kept.
const PRESSED_AHEAD: usize = 64;

/// Reads inputs in a thread of its own, at most `ahead` in advance. The thread ends with the process:
/// nothing can wake one that waits for a key or a line.
pub fn read_ahead<T: Send + 'static>(
    ahead: usize,
    mut read: impl FnMut() -> io::Result<T> + Send + 'static,
) -> Receiver<io::Result<T>> {
    let (sender, inputs) = sync_channel(ahead);
    std::thread::spawn(move || {
        loop {
            let input = read();
            let failed = input.is_err();
            if sender.send(input).is_err() || failed {
                break;
            }
        }
    });
    inputs
}

impl Keyboard {
    /// Begins to read keys.
    pub fn listen() -> Self {
        Self(read_ahead(PRESSED_AHEAD, || {
            loop {
                if let Event::Key(key) = event::read()? {
                    return Ok(key);
                }
            }
        }))
    }

    /// The next key; `None` if none waits.
    ///
    /// # Errors
    /// If the terminal is gone.
    pub fn next_key(&self) -> io::Result<Option<KeyEvent>> {
        // Keys may come from elsewhere than stdin; what is drawn goes to stdout.
        if !io::stdout().is_terminal() {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        match self.0.try_recv() {
            Ok(key) => key.map(Some),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }
}

/// What was typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A line.
    Line(String),
    /// Ctrl-C.
    Interrupt,
}

/// The format of lines.
pub enum Lines {
    /// For people.
    Plain(Plain),
    /// For programs: one JSON object a line.
    Json,
}

impl Lines {
    fn of(&mut self, now: Duration, event: &FeedEvent, dashboard: &Dashboard) -> Vec<String> {
        match self {
            Self::Plain(plain) => plain.lines(now, event, dashboard),
            Self::Json => json::line(now, event).into_iter().collect(),
        }
    }

    fn said(&self, now: Duration, text: String) -> String {
        match self {
            Self::Plain(_) => text,
            Self::Json => json::said(now, &text),
        }
    }
}

/// Shows a feed as lines until its end. `typed` returns the next input that waits; `print` takes
/// lines, and returns false when they are not read any more.
///
/// # Errors
/// The rover may still drive.
pub fn tell(
    feed: &mut dyn Feed,
    mut lines: Lines,
    typed: &mut dyn FnMut(Duration) -> Option<Input>,
    print: &mut dyn FnMut(&str) -> bool,
) -> Result<(), StillArmed> {
    let mut app = App::default();
    while !app.is_over() {
        for event in feed.poll(TICK) {
            let now = feed.now();
            app.take(now, &event);
            for line in lines.of(now, &event, &app.dashboard) {
                if !print(&line) && !app.is_over() {
                    app.act(Meaning::Quit, feed);
                }
            }
        }
        app.ask(feed);
        while let Some(input) = typed(feed.now()) {
            let asked = match input {
                Input::Line(line) => understand(&line),
                Input::Interrupt => Ok(Asked::Do(Meaning::Quit)),
            };
            match asked {
                Ok(Asked::Do(meaning)) => app.act(meaning, feed),
                Ok(Asked::Tell(topic)) => {
                    for line in topic.lines(&app.dashboard) {
                        print(&lines.said(feed.now(), line));
                    }
                }
                Err(sentence) => {
                    print(&lines.said(feed.now(), sentence));
                }
            }
        }
        if feed.ended() {
            break;
        }
    }
    farewell(&mut app, feed)
}

/// Waits for the acknowledgement of the disarming, if one was sent.
fn farewell(app: &mut App, feed: &mut dyn Feed) -> Result<(), StillArmed> {
    if feed.is_log() || !app.disarms() || app.dashboard.rover.is_none() {
        return Ok(());
    }
    for _ in 0..FAREWELL {
        for event in feed.poll(TICK) {
            app.take(feed.now(), &event);
            match event {
                FeedEvent::Answer {
                    command: Command::Disarm,
                    result: Ok(()),
                } => return Ok(()),
                FeedEvent::Unanswered {
                    command: Command::Disarm,
                    ..
                } => return Err(StillArmed),
                _ => {}
            }
        }
    }
    Err(StillArmed)
}
