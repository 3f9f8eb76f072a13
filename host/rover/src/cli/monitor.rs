//! `rover monitor`

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::time::Duration;

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::input::{listed, read_all};
use super::interrupt::Interrupt;
use super::output::Failure;
use super::port::PortArguments;
use crate::monitor::Feed;
use crate::monitor::plain::Plain;
use crate::monitor::player::Player;
use crate::monitor::rover_feed::RoverFeed;
use crate::monitor::terminal::{Input, Keyboard, Lines, Pacer, read_ahead, show, tell};
use crate::monitor::view::Look;
use rover_log::Log;
use rover_log::recording::Recording;

/// Lines typed ahead that are kept.
const TYPED_AHEAD: usize = 16;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Show this log, or all files of a recording in order, instead of a rover
    #[arg(value_name = "FILE.mcap", conflicts_with_all = ["port", "emulate"])]
    files: Vec<PathBuf>,
    #[command(flatten)]
    port: PortArguments,
    /// Lines of text instead of a dashboard, for screen readers and pipes; commands are typed
    #[arg(long)]
    plain: bool,
    /// Lines of JSON for programs: one object for everything that happens
    #[arg(long, conflicts_with = "plain")]
    json: bool,
    /// With --plain: show at most one action in this many seconds
    #[arg(long, value_name = "SECONDS", default_value = "2")]
    every: f64,
    /// Draw with ASCII characters only
    #[arg(long)]
    ascii: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Ok(every) = Duration::try_from_secs_f64(arguments.every) else {
        return Err(Failure::Usage(format!(
            "--every is {}, expected seconds, 0 or more",
            arguments.every
        )));
    };
    let mut feed = open(arguments)?;
    let feed = &mut *feed;
    if arguments.json {
        return run_lines(feed, Lines::Json);
    }
    if arguments.plain || !io::stdout().is_terminal() || is_dumb() {
        return run_lines(feed, Lines::Plain(Plain::new(every)));
    }
    let look = Look {
        colour: !is_set("NO_COLOR"),
        ascii: arguments.ascii || !shows_unicode(|name| std::env::var(name).ok()),
    };
    // The keyboard's Ctrl-C is a key here, but others may ask the program to end.
    let (interrupt, mut interrupted) = (Interrupt::listen()?, false);
    let mut terminal = ratatui::try_init().map_err(|error| {
        Failure::Failed(format!(
            "the terminal cannot be used ({error}): try --plain"
        ))
    })?;
    let keyboard = Keyboard::listen();
    let mut pacer = Pacer::new(feed.now());
    let ctrl_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    let mut keys = |now| {
        pacer.wait(now);
        match interrupt.is_set() && !std::mem::replace(&mut interrupted, true) {
            true => Ok(Some(ctrl_c)),
            false => keyboard.next_key(),
        }
    };
    let shown = show(&mut terminal, feed, &mut keys, look);
    ratatui::restore();
    Ok(shown?)
}

fn open(arguments: &Arguments) -> Result<Box<dyn Feed>, Failure> {
    match &arguments.files[..] {
        [] => Ok(Box::new(RoverFeed::new(arguments.port.connect()?))),
        files => Ok(Box::new(open_log(files)?)),
    }
}

fn open_log(paths: &[PathBuf]) -> Result<Player, Failure> {
    let name = listed(paths, ", ");
    let fail = |error: &dyn std::fmt::Display| Failure::of(&name, error);
    let files = read_all(paths)?;
    // The folder matters less on the screen than how far the showing is.
    let title = paths[0].file_name().unwrap_or_default().to_string_lossy();
    match &files[..] {
        [file] if !Recording::is_one(file) => {
            let log = Log::read(file).map_err(|error| fail(&error))?;
            Ok(Player::of_simulation(title.into(), log))
        }
        files => {
            let recorded = Recording::read(files).map_err(|error| fail(&error))?;
            Ok(Player::of_rover(title.into(), recorded))
        }
    }
}

fn run_lines(feed: &mut dyn Feed, made: Lines) -> Result<(), Failure> {
    let (interrupt, mut interrupted) = (Interrupt::listen()?, false);
    let typed_ahead = read_ahead(TYPED_AHEAD, read_line);
    let mut pacer = Pacer::new(feed.now());
    let waits = !feed.is_log();
    let mut typed = |now| {
        if waits {
            pacer.wait(now);
        }
        if interrupt.is_set() && !std::mem::replace(&mut interrupted, true) {
            return Some(Input::Interrupt);
        }
        typed_ahead.try_recv().ok()?.ok().map(Input::Line)
    };
    let mut failure = None;
    let mut write = |line: &str| {
        match writeln!(io::stdout().lock(), "{line}") {
            Ok(()) => true,
            // A closed pipe is no failure, but ends the watching.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => false,
            Err(error) => {
                failure = Some(Failure::from(error));
                false
            }
        }
    };
    tell(feed, made, &mut typed, &mut write)?;
    failure.map_or(Ok(()), Err)
}

/// The next line of stdin.
fn read_line() -> io::Result<String> {
    let mut line = String::new();
    match io::stdin().read_line(&mut line)? {
        0 => Err(io::ErrorKind::UnexpectedEof.into()),
        _ => Ok(line),
    }
}

fn is_set(name: &str) -> bool {
    std::env::var_os(name).is_some_and(|value| !value.is_empty())
}

fn is_dumb() -> bool {
    std::env::var("TERM").is_ok_and(|term| term == "dumb")
}

/// Whether the locale's characters are Unicode's.
fn shows_unicode(variable: impl Fn(&str) -> Option<String>) -> bool {
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"]
        .into_iter()
        .filter_map(variable)
        .find(|value| !value.is_empty());
    locale.is_some_and(|locale| {
        let locale = locale.to_ascii_lowercase();
        locale.contains("utf-8") || locale.contains("utf8")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_locale_that_is_set_counts() {
        let of = |set: &'static [(&str, &str)]| {
            shows_unicode(|name| {
                let found = set.iter().find(|(key, _)| *key == name);
                found.map(|(_, value)| (*value).to_owned())
            })
        };
        assert!(of(&[("LANG", "en_GB.UTF-8")]));
        assert!(of(&[("LC_ALL", ""), ("LC_CTYPE", "C.utf8"), ("LANG", "C")]));
        assert!(!of(&[("LC_ALL", "C"), ("LANG", "en_GB.UTF-8")]));
        assert!(!of(&[]));
    }
}
