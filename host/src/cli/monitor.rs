//! `rover monitor`

use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use super::Failure;
use super::interrupt::Interrupt;
use super::port::PortArguments;
use crate::log::Log;
use crate::monitor::Source;
use crate::monitor::live::Live;
use crate::monitor::plain::Plain;
use crate::monitor::recording::Recording;
use crate::monitor::terminal::{Input, Pacer, next_key, show, tell};
use crate::monitor::view::Look;

/// Lines typed ahead that are kept.
const TYPED_AHEAD: usize = 16;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Show this log (.mcap) instead of a rover
    #[arg(value_name = "FILE.mcap", conflicts_with = "port")]
    file: Option<PathBuf>,
    #[command(flatten)]
    port: PortArguments,
    /// Lines of text instead of a dashboard, for screen readers and pipes; commands are typed
    #[arg(long)]
    plain: bool,
    /// With --plain: tell of at most one action in so many seconds
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
    let mut source = open(arguments)?;
    let source = &mut *source;
    if arguments.plain || !std::io::stdout().is_terminal() || is_dumb() {
        return run_plain(source, Plain::new(every));
    }
    let look = Look {
        colour: !is_set("NO_COLOR"),
        ascii: arguments.ascii || !shows_unicode(|name| std::env::var(name).ok()),
    };
    let mut terminal = ratatui::try_init().map_err(|error| {
        Failure::Failed(format!("the terminal cannot be used ({error}): try --plain"))
    })?;
    let mut pacer = Pacer::new(source.now());
    let shown = show(
        &mut terminal,
        source,
        &mut |now| {
            pacer.wait(now);
            next_key()
        },
        look,
    );
    ratatui::restore();
    Ok(shown?)
}

fn open(arguments: &Arguments) -> Result<Box<dyn Source>, Failure> {
    match &arguments.file {
        Some(path) => Ok(Box::new(open_log(path)?)),
        None => Ok(Box::new(Live::new(arguments.port.connect()?))),
    }
}

fn open_log(path: &Path) -> Result<Recording, Failure> {
    let name = path.display().to_string();
    let fail = |error: &dyn std::fmt::Display| Failure::Failed(format!("{name}: {error}"));
    let bytes = std::fs::read(path).map_err(|error| fail(&format!("cannot be read: {error}")))?;
    let log = Log::read(&bytes).map_err(|error| fail(&error))?;
    Ok(Recording::of_simulation(name, log))
}

fn run_plain(source: &mut dyn Source, plain: Plain) -> Result<(), Failure> {
    let (interrupt, mut interrupted) = (Interrupt::listen()?, false);
    let lines = typed_lines();
    let mut pacer = Pacer::new(source.now());
    let waits = !source.is_log();
    let mut typed = |now| {
        if waits {
            pacer.wait(now);
        }
        if interrupt.is_set() && !std::mem::replace(&mut interrupted, true) {
            return Some(Input::Interrupt);
        }
        lines.try_recv().ok().map(Input::Line)
    };
    let mut failure = None;
    let mut write = |line: &str| {
        match writeln!(std::io::stdout().lock(), "{line}") {
            Ok(()) => true,
            // A reader that has seen enough is no failure, but nobody watches any more.
            Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => false,
            Err(error) => {
                failure = Some(Failure::from(error));
                false
            }
        }
    };
    tell(source, plain, &mut typed, &mut write)?;
    failure.map_or(Ok(()), Err)
}

/// Lines from stdin, read beside everything else.
fn typed_lines() -> Receiver<String> {
    let (sender, receiver) = sync_channel(TYPED_AHEAD);
    // It ends with the process: nothing can wake a thread that waits for a line.
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { break };
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    receiver
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
