//! `rover figures`

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Failure, print, print_json};
use crate::figure::{self, Moment, REPORT, Recording};
use crate::files::writable_folder;
use crate::log::Log;

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
    let recordings = arguments
        .logs
        .iter()
        .map(|path| Ok((path.display().to_string(), read(path)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let moment = Moment {
        trial: arguments.trial,
        at: arguments.at,
    };
    let drawn = figure::of_recordings(&recordings, moment)
        .map_err(|error| Failure::Failed(format!("{}: {error}", arguments.logs[0].display())))?;
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
    if arguments.json {
        return print_json(&drawn);
    }
    let mut text = String::new();
    for DrawnFigure { file, paper } in &drawn.figures {
        let paper = paper.unwrap_or("our own");
        text += &format!("  {file:<32} {paper}\n");
    }
    text += &format!("\nAll of them on one page: {}\n", drawn.report);
    print(&text)
}

fn read(path: &Path) -> Result<Recording, Failure> {
    let fail =
        |what: &dyn std::fmt::Display| Failure::Failed(format!("{}: {what}", path.display()));
    let file = std::fs::read(path).map_err(|error| fail(&format!("cannot be read: {error}")))?;
    let log = Log::read(&file).map_err(|error| fail(&error))?;
    if log.cut_off {
        eprintln!(
            "rover: {}: ends before the log does; drawn up to there",
            path.display()
        );
    }
    Recording::new(&log).map_err(|error| fail(&error))
}
