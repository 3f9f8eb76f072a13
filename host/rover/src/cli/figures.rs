//! `rover figures`

use std::path::PathBuf;

use serde::Serialize;

use super::input;
use super::output::{Failure, answer};
use rover_figure::{self, LoggedSession, Moment, REPORT};
use rover_log::Log;
use rover_log::files::writable_folder;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Logs (.mcap) of `rover learn` or of a rover. All are in the learning curves; the other
    /// figures are about the first
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Folder for the figures (.svg) and report.html
    #[arg(long, value_name = "DIR", default_value = "figures")]
    out: PathBuf,
    /// The trial (of a rover's log: the part of 100 actions) of the first log whose place is shown
    /// closely (position.svg) [default: the one in which an obstacle comes into sight]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    trial: Option<u32>,
    /// Actions of that trial before the place [default: until something comes into sight]
    #[arg(long, value_name = "N")]
    at: Option<usize>,
    /// Print what was drawn as JSON
    #[arg(long)]
    json: bool,
}

/// What the command prints for machines.
#[derive(Serialize)]
struct Drawn {
    figures: Vec<DrawnFigure>,
    report: String,
}

#[derive(Serialize)]
struct DrawnFigure {
    file: String,
    /// Which figures of the paper it answers to; `null` if it is our own.
    paper: Option<&'static str>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let recordings = together(&arguments.logs)?
        .iter()
        .map(|parts| Ok((parts.name(), parts.read()?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    comparable(&recordings)?;
    let moment = Moment {
        trial: arguments.trial,
        at: arguments.at,
    };
    let drawn = rover_figure::of_recordings(&recordings, moment)
        .map_err(|error| Failure::of(arguments.logs[0].display(), error))?;
    writable_folder(&arguments.out)?;
    drawn.write(&arguments.out)?;
    let path = |name: &str| arguments.out.join(name).display().to_string();
    let figures = drawn.figures.iter().map(|figure| DrawnFigure {
        file: path(figure.name),
        paper: Some(figure.paper).filter(|paper| !paper.is_empty()),
    });
    let drawn = Drawn {
        figures: figures.collect(),
        report: path(REPORT),
    };
    let mut text = String::new();
    for DrawnFigure { file, paper } in &drawn.figures {
        let paper = paper.unwrap_or("our own");
        text += &format!("  {file:<32} {paper}\n");
    }
    text += &format!("\nAll of them on one page: {}\n", drawn.report);
    answer(arguments.json, &drawn, text)
}

/// The files of one log: a recording may have several.
struct Parts {
    paths: Vec<PathBuf>,
    files: Vec<Vec<u8>>,
}

impl Parts {
    fn name(&self) -> String {
        input::listed(&self.paths, ", ")
    }

    fn fail(&self, what: &dyn std::fmt::Display) -> Failure {
        Failure::of(self.name(), what)
    }

    fn read(&self) -> Result<LoggedSession, Failure> {
        let log = Log::read_parts(&self.files).map_err(|error| self.fail(&error))?;
        if log.cut_off {
            eprintln!(
                "rover: {}: ends before the log does; drawn up to there",
                self.name()
            );
        }
        LoggedSession::new(&log).map_err(|error| self.fail(&error))
    }
}

/// Reads the files, the later ones of a recording with those before them.
fn together(paths: &[PathBuf]) -> Result<Vec<Parts>, Failure> {
    let mut logs: Vec<Parts> = Vec::new();
    for path in paths {
        let file = input::read(path)?;
        let later = rover_log::recording::Recording::part_of(&file).is_some_and(|part| part > 1);
        match logs.last_mut() {
            Some(log) if later => {
                log.paths.push(path.clone());
                log.files.push(file);
            }
            _ => logs.push(Parts {
                paths: vec![path.clone()],
                files: vec![file],
            }),
        }
    }
    Ok(logs)
}

/// Refuses to put into one figure what does not measure the same.
fn comparable(recordings: &[(String, LoggedSession)]) -> Result<(), Failure> {
    let kind = |recording: &LoggedSession| (recording.follows_direction(), recording.free_running);
    let Some(((first, of_first), others)) = recordings.split_first() else {
        return Ok(());
    };
    match others
        .iter()
        .find(|(_, other)| kind(other) != kind(of_first))
    {
        Some((other, _)) => Err(Failure::Failed(format!(
            "{first} and {other} are of different tasks, or one of a simulation and one of a rover: \
             draw them apart"
        ))),
        None => Ok(()),
    }
}
