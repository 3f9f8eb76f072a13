//! `rover replay`

use std::path::{Path, PathBuf};

use rover_shared::units::Microdegrees;

use super::input::{listed, read_all};
use super::output::{Failure, answer, print, print_json};
use rover_log::files::write_whole;
use rover_log::knowledge;
use rover_log::recorded_drive::{DriveReport, drive};
use rover_log::replay::{self, Difference, Replayed};
use rover_log::replayable::Sessions;
use rover_log::table::{Columns, Drive};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A log (.mcap), all files of a recording in order, or a drive recorded by others (.csv)
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// With a log: compare every recorded output bit by bit
    #[arg(long)]
    verify: bool,
    /// With a CSV file: what was learned
    #[arg(long, value_name = "FILE")]
    knowledge: Option<PathBuf>,
    /// With a CSV file whose columns have other names: ROLE=COLUMN,... where ROLE is time, front,
    /// front_left, front_right, left, right or heading, and the ending of COLUMN its unit
    #[arg(long, value_name = "ROLE=COLUMN,...")]
    columns: Option<Columns>,
    /// With a CSV file: the compass direction to follow, in degrees clockwise [default: 0]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    direction: Option<f64>,
    /// With a CSV file: seed of the noise that layer 2 starts from [default: 1]
    #[arg(long)]
    seed: Option<u64>,
    /// With a CSV file: write what was made of every sample to this table
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let ends = |file: &PathBuf, ending: &str| {
        let extension = file.extension().and_then(|e| e.to_str());
        extension.is_some_and(|e| e.eq_ignore_ascii_case(ending))
    };
    match &arguments.files[..] {
        [file] if ends(file, "csv") => run_drive(arguments, file),
        files if files.iter().all(|file| ends(file, "mcap")) => run_log(arguments),
        [file] => Err(Failure::Usage(format!(
            "{}: expected a file that ends in .mcap or .csv",
            file.display()
        ))),
        _ => Err(Failure::Usage(
            "several files: expected those of one recording, which end in .mcap".into(),
        )),
    }
}

fn run_log(arguments: &Arguments) -> Result<(), Failure> {
    let only_csv = [
        ("--knowledge", arguments.knowledge.is_some()),
        ("--columns", arguments.columns.is_some()),
        ("--out", arguments.out.is_some()),
        ("--direction", arguments.direction.is_some()),
        ("--seed", arguments.seed.is_some()),
    ];
    if let Some((name, _)) = only_csv.iter().find(|(_, given)| *given) {
        return Err(Failure::Usage(format!(
            "{name} is for CSV files; a log has its own"
        )));
    }
    let name = listed(&arguments.files, ", ");
    let fail = |error: &dyn std::fmt::Display| Failure::of(&name, error);
    let files = read_all(&arguments.files)?;
    let log = Sessions::read(&files).map_err(|error| fail(&error))?;
    let replayed = replay::verify_sessions(&log).map_err(|error| fail(&error))?;
    if arguments.verify && replayed.steps == 0 && replayed.difference.is_none() {
        let why = replayed.unverified.first().map(ToString::to_string);
        return Err(fail(
            &why.as_deref()
                .unwrap_or("has no actions, so that there is nothing to verify"),
        ));
    }
    if log.cut_off {
        eprintln!("rover: {name} is cut off; replayed what is there");
    }
    if arguments.json {
        print_json(&replayed)?;
    }
    match &replayed.difference {
        Some(difference) if arguments.verify => Err(fail(difference)),
        _ if arguments.json => Ok(()),
        difference => print(&described(&log, &replayed, difference.as_ref())),
    }
}

fn described(log: &Sessions, replayed: &Replayed, difference: Option<&Difference>) -> String {
    let verdict = match difference {
        Some(difference) => format!("first difference: {difference}"),
        None if replayed.complete => {
            "every output and the final knowledge are equal, bit by bit".into()
        }
        None if log.cut_off && log.sessions.len() == 1 => {
            "every output is equal, bit by bit; the log has no end to compare".into()
        }
        None => "every output that can be replayed is equal, bit by bit".into(),
    };
    let seeds = log
        .sessions
        .iter()
        .filter_map(|session| session.origin.as_ref());
    let seeds: Vec<_> = seeds.map(|origin| origin.seed.to_string()).collect();
    let grouped = match (replayed.trials, replayed.sessions) {
        (0, 1) => "1 session".into(),
        (0, sessions) => format!("{sessions} sessions"),
        (trials, _) => format!("{trials} trials"),
    };
    let seeds = match &seeds[..] {
        [seed] => format!("seed {seed}"),
        seeds => format!("seeds {}", seeds.join(" ")),
    };
    let mut text = format!(
        "{} actions in {grouped}, {seeds}, written by {}\n{verdict}\n",
        replayed.steps, log.writer
    );
    for unverified in &replayed.unverified {
        if !(log.cut_off && log.sessions.len() == 1) {
            text += &format!("  {unverified}\n");
        }
    }
    text
}

fn run_drive(arguments: &Arguments, file: &Path) -> Result<(), Failure> {
    if arguments.verify {
        return Err(Failure::Usage(
            "--verify is for logs (.mcap): a CSV file has nothing to compare with".into(),
        ));
    }
    let Some(path) = &arguments.knowledge else {
        return Err(Failure::Usage(
            "a CSV file needs --knowledge FILE; `rover learn --task direction` writes one".into(),
        ));
    };
    let direction = arguments.direction.unwrap_or(0.0);
    if !(-360.0..=360.0).contains(&direction) {
        return Err(Failure::Usage(format!(
            "--direction is {direction}, expected -360 to 360 degrees"
        )));
    }
    let loaded = knowledge::load(path)?;
    let columns = arguments.columns.clone().unwrap_or_default();
    let recorded = Drive::read(file, &columns)?;
    let direction = Microdegrees::wrapped(-(direction * 1e6).round() as i64);
    let report = drive(&recorded, &loaded, direction, arguments.seed.unwrap_or(1));
    if let Some(out) = &arguments.out {
        save(out, &report)?;
    }
    answer(arguments.json, &report, &report)
}

fn save(path: &Path, report: &DriveReport) -> Result<(), Failure> {
    let mut table = csv::Writer::from_writer(Vec::new());
    for sample in &report.samples {
        table.serialize(sample)?;
    }
    let bytes = table.into_inner().map_err(|error| error.into_error())?;
    Ok(write_whole(path, &bytes)?)
}
