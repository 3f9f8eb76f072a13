//! `rover perceive`

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::perception::{Corners, Noise};
use rover_shared::random::Generator;
use serde::Serialize;

use super::input::read_parameters;
use super::output::{Failure, print, print_json};
use rover_log::results::{drawing, time_units};
use rover_simulator::reference::Reference;

#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("input").required(true)))]
pub struct Arguments {
    /// Initial states of the corners: front, left, right, target
    #[arg(
        long,
        value_name = "F,L,R,T",
        group = "input",
        allow_hyphen_values = true
    )]
    #[arg(value_delimiter = ',', num_args = 1)]
    corners: Option<Vec<f64>>,
    /// Table of initial states with the columns f,l,r,t,n0..n15 (corners, noise of layer 2)
    #[arg(long, value_name = "FILE.csv", group = "input")]
    from: Option<PathBuf>,
    /// Seed of the noise that layer 2 starts from
    #[arg(long, default_value_t = 1, conflicts_with = "from")]
    noise_seed: u64,
    /// Fixed point as on the board, or the paper's Euler integration in floating point
    #[arg(long, value_enum, default_value_t = Engine::Fixed)]
    engine: Engine,
    /// Parameters of the network (TOML, section [lattice]); what it leaves out is the paper's
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
enum Engine {
    /// The exponential integrator in fixed point that runs on the board
    Fixed,
    /// Explicit Euler in f64, dt = 0.001, N = 100,000: the paper to the letter, some 400 times slower
    Reference,
}

/// Where the network starts from.
#[derive(Clone, Copy, Debug)]
struct Start {
    corners: [f64; 4],
    noise: [f64; 16],
}

/// Where it went: no code if it did not settle.
#[derive(Clone, Copy, Debug, Serialize)]
struct Grown {
    code: Option<u16>,
    settle_time: Option<f64>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = read_parameters(arguments.parameters.as_deref(), Parameters::PAPER)?;
    let coefficients = Coefficients::new(&parameters)?;
    match (&arguments.from, &arguments.corners) {
        (Some(path), _) => table(arguments, path, &coefficients),
        (None, corners) => single(
            arguments,
            corners.as_deref().unwrap_or_default(),
            &coefficients,
        ),
    }
}

fn single(arguments: &Arguments, corners: &[f64], c: &Coefficients) -> Result<(), Failure> {
    let corners = <[f64; 4]>::try_from(corners).map_err(|_| {
        let found = corners.len();
        Failure::Usage(format!(
            "--corners has {found} values, expected 4: front,left,right,target"
        ))
    })?;
    let noise = Noise::draw(&mut Generator::new(arguments.noise_seed));
    let noise = noise.0.map(|raw| f64::from(raw) / NOISE_ONE);
    let start = Start { corners, noise };
    check(&start).map_err(|problem| Failure::Usage(format!("--corners: {problem}")))?;
    let grown = grow(arguments.engine, &start, c);
    if arguments.json {
        return print_json(&grown);
    }
    let Some((code, time)) = grown.code.zip(grown.settle_time) else {
        return Err(Failure::Failed(
            "the network did not settle; another --noise-seed decides".into(),
        ));
    };
    let picture = drawing(rover_shared::perception::PatternCode(code)).join("\n");
    print(&format!(
        "{picture}\ncode {code}, settled at t = {time:.1}\n"
    ))
}

fn table(arguments: &Arguments, path: &Path, c: &Coefficients) -> Result<(), Failure> {
    let (header, starts) = read(path)?;
    let grown: Vec<Grown> = starts
        .par_iter()
        .map(|(_, start)| grow(arguments.engine, start, c))
        .collect();
    if arguments.json {
        return print_json(&grown);
    }
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record(header.iter().chain(["code", "settle_time"]))?;
    for ((input, _), grown) in starts.iter().zip(&grown) {
        let code = grown.code.map_or(String::new(), |code| code.to_string());
        let time = grown
            .settle_time
            .map_or(String::new(), |time| time.to_string());
        out.write_record(input.iter().chain([code.as_str(), time.as_str()]))?;
    }
    let bytes = out.into_inner().map_err(|error| error.into_error())?;
    print(&String::from_utf8_lossy(&bytes))
}

type Inputs = (csv::StringRecord, Vec<(csv::StringRecord, Start)>);

fn read(path: &Path) -> Result<Inputs, Failure> {
    let fail = |what: String| Failure::of(path.display(), what);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| fail(format!("cannot be read: {error}")))?;
    let header = reader
        .headers()
        .map_err(|error| fail(format!("line 1: {error}")))?
        .clone();
    let names = ["f", "l", "r", "t"].map(String::from).into_iter();
    let names: Vec<_> = names.chain((0..16).map(|i| format!("n{i}"))).collect();
    let place = |name: &String| header.iter().position(|column| column == name);
    let missing: Vec<_> = names
        .iter()
        .filter(|name| place(name).is_none())
        .cloned()
        .collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        return Err(fail(format!(
            "line 1: column {missing} is missing, expected f,l,r,t,n0..n15"
        )));
    }
    let places: Vec<usize> = names.iter().filter_map(place).collect();
    let mut starts = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| fail(error.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |i: usize| {
            let text = record.get(places[i]).unwrap_or_default();
            let wrong = |error| format!("line {line}: column {}: \"{text}\": {error}", names[i]);
            text.parse::<f64>().map_err(|error| fail(wrong(error)))
        };
        let mut start = Start {
            corners: [0.0; 4],
            noise: [0.0; 16],
        };
        for (i, value) in start.corners.iter_mut().chain(&mut start.noise).enumerate() {
            *value = number(i)?;
        }
        check(&start).map_err(|problem| fail(format!("line {line}: {problem}")))?;
        starts.push((record, start));
    }
    if starts.is_empty() {
        return Err(fail("has no lines below the column names".into()));
    }
    Ok((header, starts))
}

/// What stands for 1 in [`Corners`] and in [`Noise`].
const CORNER_ONE: f64 = (1u32 << Corners::FRACTION_BITS) as f64;
const NOISE_ONE: f64 = (1u32 << Noise::FRACTION_BITS) as f64;
/// Noise that layer 2 can start from.
const LARGEST_NOISE: f64 = Noise::MAX as f64 / NOISE_ONE;

fn check(start: &Start) -> Result<(), String> {
    let largest = f64::from(Corners::MAX) / CORNER_ONE;
    within("corner", &start.corners, largest)?;
    within("noise", &start.noise, LARGEST_NOISE)
}

fn within(what: &str, values: &[f64], largest: f64) -> Result<(), String> {
    match values
        .iter()
        .find(|value| value.is_nan() || value.abs() > largest)
    {
        Some(bad) => Err(format!(
            "{what} {bad}, expected a number from -{largest} to {largest}"
        )),
        None => Ok(()),
    }
}

fn grow(engine: Engine, start: &Start, c: &Coefficients) -> Grown {
    match engine {
        Engine::Fixed => {
            let corners = Corners(start.corners.map(|x| (x * CORNER_ONE).round() as i32));
            let noise = Noise(start.noise.map(|x| (x * NOISE_ONE).round() as i32));
            let settled = c.lattice.settle(&corners, &noise).ok();
            Grown {
                code: settled.as_ref().map(|settled| settled.code.0),
                settle_time: settled.map(|settled| time_units(settled.time)),
            }
        }
        Engine::Reference => {
            let reference = Reference::new(c.parameters().lattice);
            let pattern = reference.settle(start.corners, start.noise);
            Grown {
                code: pattern.saturated.then_some(pattern.code.0),
                settle_time: pattern.settle_time,
            }
        }
    }
}
