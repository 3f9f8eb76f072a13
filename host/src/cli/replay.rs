//! `rover replay`

use std::path::{Path, PathBuf};

use rover_shared::units::Microdegrees;

use super::{Failure, print, print_json};
use crate::drive_report::{DriveReport, drive};
use crate::files::write_whole;
use crate::log::Log;
use crate::log::table::{Columns, Drive};
use crate::{knowledge, replay};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A log (.mcap), or a drive recorded by others (.csv)
    #[arg(value_name = "FILE")]
    file: PathBuf,
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
    let extension = arguments
        .file
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "mcap" => run_log(arguments),
        "csv" => run_drive(arguments),
        _ => Err(Failure::Usage(format!(
            "{}: expected a file that ends in .mcap or .csv",
            arguments.file.display()
        ))),
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
    let name = arguments.file.display().to_string();
    let fail = |error: &dyn std::fmt::Display| Failure::Failed(format!("{name}: {error}"));
    let bytes = std::fs::read(&arguments.file)
        .map_err(|error| fail(&format!("cannot be read: {error}")))?;
    let log = Log::read(&bytes).map_err(|error| fail(&error))?;
    let replayed = replay::verify(&log).map_err(|error| fail(&error))?;
    if arguments.verify && replayed.steps == 0 {
        return Err(fail(&"has no actions, so that there is nothing to verify"));
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
        difference => {
            let verdict = match difference {
                Some(difference) => format!("first difference: {difference}"),
                None if replayed.complete => {
                    "every output and the final knowledge are equal, bit by bit".into()
                }
                None => "every output is equal, bit by bit; the log has no end to compare".into(),
            };
            print(&format!(
                "{} actions in {} trials, seed {}, written by {}\n{verdict}\n",
                replayed.steps, replayed.trials, log.origin.seed, log.origin.writer
            ))
        }
    }
}

fn run_drive(arguments: &Arguments) -> Result<(), Failure> {
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
    let recorded = Drive::read(&arguments.file, &columns)?;
    let direction = Microdegrees::wrapped(-(direction * 1e6).round() as i64);
    let report = drive(&recorded, &loaded, direction, arguments.seed.unwrap_or(1));
    if let Some(out) = &arguments.out {
        save(out, &report)?;
    }
    if arguments.json {
        return print_json(&report);
    }
    print(&report.to_string())
}

fn save(path: &Path, report: &DriveReport) -> Result<(), Failure> {
    let mut table = csv::Writer::from_writer(Vec::new());
    for sample in &report.samples {
        table.serialize(sample)?;
    }
    let bytes = table.into_inner().map_err(|error| error.into_error())?;
    Ok(write_whole(path, &bytes)?)
}
